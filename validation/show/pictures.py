"""Pictures by VTK off screen: one stage, pictures of geometry and mesh (PNG bytes), films."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.solids import colour_of
from tactgen.geometry.cad.system_libraries import require_library, require_room
from tactgen.geometry.device.parts import MM
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.geometry.meshing.mesh import Mesh

if TYPE_CHECKING:
    from PIL.Image import Image

#: What VTK, its software renderer and its buffers take (bytes of address space): 0.6 GB was seen.
_ROOM = 800_000_000
#: Direction from the object to the viewer, and white pixels round a cropped picture.
_VIEW, _PAD = (3.0, -2.2, 1.1), 12
_VTK_CELL = {"tetra": 10, "tetra10": 24, "hexahedron": 12}
INK, DIM = (29, 39, 51), (91, 103, 118)


@dataclass(frozen=True)
class Part:
    """One distinct part as triangles (mm), and the places where it stands."""

    name: str
    colour: tuple[float, float, float]  #: Red, green, blue; 0 to 1
    points: Floats  #: (n, 3) in its own frame
    triangles: Ints  #: (m, 3)
    places: Floats  #: (k, 3) of its frame
    moves: bool  #: Whether it swings with its unit's tip


def off_screen() -> Any:
    """Import PyVista with VTK's software renderer, or name the missing library.

    VTK crashes the process when it finds no OpenGL library or no room for its buffers, so this
    looks first.
    """
    if sys.platform == "linux":
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    require_library("libOSMesa.so.8", "pictures")
    require_library("libGL.so.1", "pictures")
    require_room(_ROOM, "pictures")
    import pyvista as pv

    pv.OFF_SCREEN = True
    return pv


def as_grid(mesh: Mesh) -> Any:
    """Mesh as PyVista's grid in m, with the cell array ``region``."""
    import pyvista as pv

    count, corners = mesh.cells.shape
    cells = np.column_stack([np.full(count, corners), mesh.cells])
    grid = pv.UnstructuredGrid(cells.ravel(), np.full(count, _VTK_CELL[mesh.kind]), mesh.points)
    grid.cell_data["region"] = mesh.region_of_cell
    return grid


class Stage:
    """An off-screen scene seen by parallel rays; lengths in mm."""

    def __init__(self, width: int, height: int) -> None:
        self.pv = off_screen()
        self.plotter = self.pv.Plotter(
            off_screen=True, window_size=(width, height), lighting="three lights"
        )
        self.plotter.set_background("white")
        self.plotter.enable_anti_aliasing("ssaa")

    def surface(self, points: Floats, triangles: Ints) -> Any:
        """Triangles (m, 3) of points (n, 3)."""
        faces = np.column_stack([np.full(len(triangles), 3), triangles])
        return self.pv.PolyData(points.copy(), faces.ravel())

    def copies(self, part: Part) -> tuple[Any, Floats]:
        """Surface of a part at all its places, and the points (k, n, 3)."""
        points = np.asarray(part.places[:, None, :] + part.points[None], dtype=float)
        starts = len(part.points) * np.arange(len(part.places))
        triangles = (part.triangles[None] + starts[:, None, None]).reshape(-1, 3)
        return self.surface(points.reshape(-1, 3), triangles), points

    def look_from(self, eye: tuple[float, float, float]) -> None:
        """Look at the middle of everything, z up."""
        self.plotter.camera_position = [eye, (0.0, 0.0, 0.0), (0, 0, 1)]
        self.plotter.camera.parallel_projection = True
        self.plotter.reset_camera()

    def look_at(
        self, middle: Floats, away: Floats, up: tuple[float, float, float], scale: float
    ) -> None:
        """Look at a point from `away` of it; `scale` is half the picture's height."""
        camera = self.plotter.camera
        camera.focal_point, camera.position = tuple(middle), tuple(middle + away)
        camera.up = up
        camera.parallel_projection = True
        camera.parallel_scale = scale
        self.plotter.renderer.ResetCameraClippingRange()

    def shift(self, by: Floats) -> None:
        """Move eye and focus."""
        camera = self.plotter.camera
        for name in ("focal_point", "position"):
            setattr(camera, name, tuple(np.array(getattr(camera, name)) + by))

    def image(self) -> Image:
        """The scene as it is now."""
        from PIL import Image as Images

        self.plotter.render()
        return Images.fromarray(self.plotter.screenshot(return_img=True))

    def images(
        self, frames: Sequence[Any], draw: Callable[[Any], Image], announce: Callable[[str], None]
    ) -> list[Image]:
        """Image of each frame; the scene is closed after them."""
        made = []
        for number, frame in enumerate(frames, start=1):
            announce(f"picture {number} of {len(frames)}")
            made.append(draw(frame))
        self.plotter.close()
        return made

    def cropped(self, height: float, focus: float | None = None) -> bytes:
        """PNG from the front right, slightly from above, without white margins.

        `height` is the extent (mm) that fills the picture; `focus` the height z (mm) looked at.
        """
        from PIL import Image as Images
        from PIL import ImageChops

        self.look_from(_VIEW)
        camera = self.plotter.camera
        camera.parallel_scale = 0.5 * height
        if focus is not None:
            self.shift(np.array([0.0, 0.0, focus - camera.focal_point[2]]))
        image = self.image()
        self.plotter.close()
        box = ImageChops.difference(image, Images.new("RGB", image.size, "white")).getbbox()
        if box is not None:
            (left, top, right, bottom), (wide, high) = box, image.size
            image = image.crop((
                max(left - _PAD, 0), max(top - _PAD, 0),
                min(right + _PAD, wide), min(bottom + _PAD, high),
            ))  # fmt: skip
        return as_png(image)


def as_png(image: Image) -> bytes:
    """Bytes of an image."""
    buffer = io.BytesIO()
    image.save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()


def fonts(*sizes: float) -> list[Any]:
    """Typeface with ×, − and µ in sizes of so many pixels: matplotlib brings it."""
    import matplotlib as mpl
    from PIL import ImageFont

    file = Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    return [ImageFont.truetype(str(file), size) for size in sizes]


def mesh_picture(mesh: Mesh) -> bytes:
    """Picture of the mesh at its held end, one colour per region."""
    stage = Stage(840, 840)
    grid = as_grid(mesh)
    grid.points = mesh.points * MM
    for number, region in enumerate(mesh.regions):
        part = grid.extract_cells(np.flatnonzero(mesh.region_of_cell == number))
        surface = part.extract_surface(nonlinear_subdivision=0, algorithm=None)
        stage.plotter.add_mesh(
            surface, color=colour_of(region), show_edges=True, edge_color="#333333"
        )
    z = mesh.points[:, 2] * MM
    reach = 0.22 * float(np.ptp(z))
    return stage.cropped(reach, focus=float(z.min()) + 0.42 * reach)


def solids_picture(solids: dict[str, Any]) -> bytes:
    """Picture of CAD solids (mm), the front half of coil and sleeve cut away."""
    return solids_pictures([solids])[0]


def solids_pictures(devices: Sequence[dict[str, Any]]) -> list[bytes]:
    """Such pictures of devices at one scale."""
    boxes = [[solid.BoundingBox() for solid in solids.values()] for solids in devices]
    height = max(max(b.zmax for b in own) - min(b.zmin for b in own) for own in boxes)
    return [_solids_picture(solids, 1.12 * height) for solids in devices]


def _solids_picture(solids: dict[str, Any], height: float) -> bytes:
    stage = Stage(840, 1800)
    for name, solid in solids.items():
        vertices, triangles = solid.tessellate(0.01, 0.2)
        surface = stage.surface(np.array([v.toTuple() for v in vertices]), np.array(triangles))
        if name in ("coil", "sleeve"):
            surface = surface.clip(normal=(_VIEW[0], _VIEW[1], 0.0), origin=(0.0, 0.0, 0.0))
        stage.plotter.add_mesh(surface, color=colour_of(name), smooth_shading=False)
    return stage.cropped(height)


def assembly_picture(parts: Sequence[Part], cut: float | None = None) -> bytes:
    """Picture of parts at all their places; `cut` (mm) takes away the x beyond it."""
    stage = Stage(1240, 1240)
    size = 0.0
    for part in parts:
        surface, points = stage.copies(part)
        size = max(size, float(np.linalg.norm(np.ptp(points.reshape(-1, 3), axis=0))))
        if cut is not None:
            surface = surface.clip(normal=(1.0, 0.0, 0.0), origin=(cut, 0.0, 0.0))
        if surface.n_cells:
            stage.plotter.add_mesh(surface, color=part.colour, smooth_shading=False)
    return stage.cropped(1.1 * size)


def check_ffmpeg(path: Path) -> None:
    """Refuse an .mp4 where there is no ffmpeg."""
    if path.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise InputError(
            f"--mp4 {path} needs the program ffmpeg, which is not on this machine; install it "
            "(apt-get install ffmpeg), or write --gif"
        )


def save_film(path: Path, images: Sequence[Image], milliseconds: int, repeats: int = 1) -> None:
    """Write pictures of one size as a film, .gif or .mp4, whole or not at all.

    An .mp4 holds them all `repeats` times; a .gif starts again by itself.
    """
    from PIL.Image import Dither

    check_ffmpeg(path)
    with written_whole(path) as temporary:
        if path.suffix == ".gif":
            # one palette for all pictures, so that nothing flickers
            palette = images[0].quantize(colors=255)
            indexed = [image.quantize(palette=palette, dither=Dither.NONE) for image in images]
            indexed[0].save(
                temporary, save_all=True, append_images=indexed[1:], duration=milliseconds, loop=0
            )
            return
        raw = b"".join(image.tobytes() for image in images) * repeats
        size = "{}x{}".format(*images[0].size)
        command = [
            "ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", size, "-r", f"{1000.0 / milliseconds:g}", "-i", "-", "-pix_fmt", "yuv420p",
            "-movflags", "+faststart", "-fflags", "+bitexact", str(temporary),
        ]  # fmt: skip
        done = subprocess.run(command, input=raw, capture_output=True, check=False)
        if done.returncode != 0:
            reason = done.stderr.decode(errors="replace").strip().splitlines() or ["no reason"]
            raise InputError(f"{path} was not made: ffmpeg says: {reason[-1]}; write --gif")
