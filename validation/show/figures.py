"""Line plots: figure, palette, axis numbers, inline SVG.

Matplotlib without a display and without global state.
"""

from __future__ import annotations

import html
import io
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure
import os
from collections.abc import Sequence
from typing import Protocol

from tactgen.geometry.arrays import Ints
from tactgen.geometry.cad.solids import COLOURS
from tactgen.geometry.cad.system_libraries import require_library, require_room
from tactgen.geometry.meshing.mesh import Mesh

#: The palette (Okabe and Ito), told apart by the colour-blind too.
BLUE, ORANGE, AMBER, GREEN, SKY = "#0072B2", "#D55E00", "#E69F00", "#009E73", "#56B4E9"
GREY, DARK = "#999999", "#1d2733"

#: A logarithmic axis that spans more than this factor has labels at whole decades only.
_WIDE = 30.0
#: One that spans more than this factor has no numbers between the decades (matplotlib's rule).
_NUMBERED = 10.0


def new_figure(width: float, height: float) -> Figure:
    """Empty figure of so many inches."""
    from matplotlib.figure import Figure as NewFigure

    return NewFigure(figsize=(width, height), layout="constrained")


def panels(width: float, height: float, **grid: Any) -> tuple[Figure, Any]:
    """Figure with a grid of axes, as matplotlib's `subplots` names it."""
    figure = new_figure(width, height)
    axes = figure.subplots(**grid)
    for axis in np.ravel(axes):
        axis.grid(visible=True, which="both", alpha=0.25)
    return figure, axes


def shades(count: int) -> Floats:
    """Colours (count, 4) for a family of curves, from dark to light."""
    import matplotlib as mpl

    return np.asarray(mpl.colormaps["viridis"](np.linspace(0.0, 0.9, count)))


def plain_numbers(*sides: Any) -> None:
    """Write plain numbers at logarithmic axes, at 1, 2 and 5 if they span little over a decade."""
    from matplotlib.ticker import LogLocator, NullFormatter

    for side in sides:
        low, high = side.get_view_interval()
        if side.get_scale() != "log":
            continue
        if high < _WIDE * low:
            side.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        side.set_major_formatter("{x:g}")
        side.set_minor_formatter(NullFormatter())


def svg(figure: Figure) -> str:
    """Figure as an SVG element that can stand inside a page.

    It is laid out once and drawn once; matplotlib's own way to a file draws it twice.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    buffer = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "tactgen"}):  # the same picture has the same ids
        lay_out(figure)
        canvas: Any = FigureCanvasSVG(figure)
        canvas.print_svg(buffer, metadata={"Date": None})
    text = buffer.getvalue()
    named = f'<svg role="img" aria-label="{html.escape(_in_words(figure))}"'
    return named + text[text.index("<svg") + len("<svg") :]


def _in_words(figure: Figure) -> str:
    """Text alternative of a figure, from its axis labels."""
    words: dict[str, None] = {}
    below = [axis.get_xlabel() for axis in figure.axes]
    for number, axis in enumerate(figure.axes):
        # one of several axes below each other has the name of what all run along
        along = next(filter(None, below[number:]), "")
        plotted = " over ".join(filter(None, (axis.get_ylabel(), along if axis.lines else "")))
        words |= dict.fromkeys(filter(None, (axis.get_title(), plotted)))
    return "; ".join(words).replace("\n", " ") or "drawing"


def lay_out(figure: Figure) -> None:
    """Give everything its place, for good.

    Marks without a number become lines of one collection, and titles stay where the layout has
    put them: matplotlib keeps six artists for every mark, and measures all of them once more for
    each title.
    """
    sides = ((axis, side) for axis in figure.axes for side in (axis.xaxis, axis.yaxis))
    # all before any is changed: axes that share a scale share what finds its marks
    for axis, side, marks in [(axis, side, _unnumbered(side)) for axis, side in sides]:
        if len(marks):
            _draw_marks(axis, side, marks)
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")
    for axis in figure.axes:
        title = axis.title
        axis.set_title(title.get_text(), y=title.get_position()[1], fontsize=title.get_fontsize())


def _unnumbered(side: Any) -> Floats:
    """Marks between the numbers of a logarithmic side; of any other none."""
    low, high = side.get_view_interval()
    if side.get_scale() != "log" or high <= _NUMBERED * low:
        return np.zeros(0)
    marks = np.asarray(side.get_minor_locator().tick_values(low, high))
    inside: Floats = marks[(marks > low) & (marks < high)]
    return inside


def _draw_marks(axis: Any, side: Any, marks: Floats) -> None:
    """Draw the grid at marks without a number, in place of them."""
    from matplotlib.collections import LineCollection
    from matplotlib.ticker import NullFormatter, NullLocator

    side.set_minor_formatter(NullFormatter())
    side.set_minor_locator(NullLocator())
    grid = next((line for line in side.get_gridlines() if line.get_visible()), None)
    if grid is None:
        return
    upright = side is axis.xaxis
    lines = [((m, 0.0), (m, 1.0)) if upright else ((0.0, m), (1.0, m)) for m in marks]
    drawn = LineCollection(
        lines,
        colors=grid.get_color(),
        linewidths=grid.get_linewidth(),
        alpha=grid.get_alpha(),
        zorder=side.get_zorder(),
        transform=axis.get_xaxis_transform() if upright else axis.get_yaxis_transform(),
    )
    axis.add_collection(drawn, autolim=False)


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
    """Import PyVista with VTK's software renderer, or name the missing library.

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
    """Pictures of devices at one scale."""
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
    """Look from the front right, slightly from above, z up, cropped.

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
