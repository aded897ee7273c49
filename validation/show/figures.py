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
