"""Pictures of geometry and mesh (PyVista, off screen), as PNG bytes."""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.solids import COLOURS
from tactgen.geometry.cad.system_libraries import require_library, require_room
from tactgen.geometry.meshing.mesh import Mesh


class Assembled(Protocol):
    """A part as triangles (mm) and the places at which it stands, (k, 3)."""

    @property
    def colour(self) -> tuple[float, float, float]:
        """Red, green, blue."""

    @property
    def points(self) -> Floats:
        """Corners (n, 3)."""

    @property
    def triangles(self) -> Ints:
        """Of corners (m, 3)."""

    @property
    def places(self) -> Floats:
        """Where its frame stands (k, 3)."""


#: What VTK, its software renderer and its buffers take (bytes of address space): 0.6 GB was seen.
_ROOM = 800_000_000
#: Direction from the object to the viewer.
_VIEW = (3.0, -2.2, 1.1)
_VTK_CELL = {"tetra": 10, "tetra10": 24, "hexahedron": 12}


def off_screen() -> Any:
    """Import PyVista with VTK's software renderer, or say what is missing.

    VTK crashes the process when it finds no OpenGL library or no room for its buffers, so this
    looks first.
    """
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    require_library("libOSMesa.so.8", "pictures")
    require_library("libGL.so.1", "pictures")
    require_room(_ROOM, "pictures")
    import pyvista as pv

    pv.OFF_SCREEN = True
    return pv


def mesh_picture(mesh: Mesh, *, close_up: bool = False) -> bytes:
    """Picture of the mesh, one colour per region; `close_up` shows the held end."""
    pv = off_screen()
    plotter = _plotter(pv, 420, 420 if close_up else 900)
    grid = _grid(pv, mesh)
    for number, region in enumerate(mesh.regions):
        part = grid.extract_cells(np.flatnonzero(mesh.region_of_cell == number))
        surface = part.extract_surface(nonlinear_subdivision=0, algorithm=None)
        plotter.add_mesh(surface, color=COLOURS[region], show_edges=True, edge_color="#333333")
    z = mesh.points[:, 2] * 1e3
    if close_up:
        reach = 0.22 * float(np.ptp(z))
        return _shoot(plotter, reach, focus=float(z.min()) + 0.42 * reach)
    return _shoot(plotter, 1.12 * float(np.ptp(z)))


def solids_picture(solids: dict[str, Any]) -> bytes:
    """Picture of CAD solids (mm), the front half of coil and sleeve cut away."""
    return solids_pictures([solids])[0]


def solids_pictures(devices: Sequence[dict[str, Any]]) -> list[bytes]:
    """Such a picture of each device, all at one scale: as many pixels a millimetre."""
    height = max(_height(solids) for solids in devices)
    return [_solids_picture(solids, 1.12 * height) for solids in devices]


def _height(solids: dict[str, Any]) -> float:
    boxes = [solid.BoundingBox() for solid in solids.values()]
    return float(max(box.zmax for box in boxes) - min(box.zmin for box in boxes))


def _solids_picture(solids: dict[str, Any], height: float) -> bytes:
    pv = off_screen()
    plotter = _plotter(pv, 420, 900)
    for name, solid in solids.items():
        vertices, triangles = solid.tessellate(0.01, 0.2)
        points = np.array([v.toTuple() for v in vertices])
        faces = np.column_stack([np.full(len(triangles), 3), np.array(triangles)])
        surface = pv.PolyData(points, faces.ravel())
        if name in ("coil", "sleeve"):
            surface = surface.clip(normal=(_VIEW[0], _VIEW[1], 0.0), origin=(0.0, 0.0, 0.0))
        plotter.add_mesh(surface, color=COLOURS[name], smooth_shading=False)
    return _shoot(plotter, height)


def assembly_picture(parts: Sequence[Assembled], cut: float | None = None) -> bytes:
    """Picture of parts that stand at several places; `cut` takes away what has x beyond.

    Parameters
    ----------
    parts : sequence of Assembled
        Triangles in mm with their places.
    cut : float, optional
        mm.
    """
    pv = off_screen()
    plotter = _plotter(pv, 620, 620)
    size = 0.0
    for part in parts:
        count, copies = len(part.points), len(part.places)
        points = (part.places[:, None, :] + part.points[None]).reshape(-1, 3)
        numbers = (part.triangles[None] + count * np.arange(copies)[:, None, None]).reshape(-1, 3)
        faces = np.column_stack([np.full(len(numbers), 3), numbers])
        surface = pv.PolyData(points, faces.ravel())
        size = max(size, float(np.linalg.norm(np.ptp(points, axis=0))))
        if cut is not None:
            surface = surface.clip(normal=(1.0, 0.0, 0.0), origin=(cut, 0.0, 0.0))
        if surface.n_cells:
            plotter.add_mesh(surface, color=part.colour, smooth_shading=False)
    return _shoot(plotter, 1.1 * size)


def _grid(pv: Any, mesh: Mesh) -> Any:
    n, corners = mesh.cells.shape
    cells = np.column_stack([np.full(n, corners), mesh.cells])
    return pv.UnstructuredGrid(cells.ravel(), np.full(n, _VTK_CELL[mesh.kind]), mesh.points * 1e3)


def _plotter(pv: Any, width: int, height: int) -> Any:
    plotter = pv.Plotter(
        off_screen=True, window_size=(2 * width, 2 * height), lighting="three lights"
    )
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    return plotter


def _shoot(plotter: Any, height: float, focus: float | None = None) -> bytes:
    """Look from the front right, slightly from above, z up, and crop to what is there.

    `height` is the extent (mm) that fills the picture; `focus` the height z (mm) looked at.
    """
    from PIL import Image, ImageChops

    plotter.camera_position = [_VIEW, (0.0, 0.0, 0.0), (0, 0, 1)]
    plotter.camera.parallel_projection = True
    plotter.reset_camera()
    plotter.camera.parallel_scale = 0.5 * height
    if focus is not None:
        shift = focus - plotter.camera.focal_point[2]
        for point in ("focal_point", "position"):
            x, y, z = getattr(plotter.camera, point)
            setattr(plotter.camera, point, (x, y, z + shift))
    image = Image.fromarray(plotter.screenshot(return_img=True))
    plotter.close()
    box = ImageChops.difference(image, Image.new("RGB", image.size, "white")).getbbox()
    if box is not None:
        pad = 12
        left, top, right, bottom = box
        width, height_px = image.size
        image = image.crop(
            (
                max(left - pad, 0),
                max(top - pad, 0),
                min(right + pad, width),
                min(bottom + pad, height_px),
            )
        )
    buffer = io.BytesIO()
    image.save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()
