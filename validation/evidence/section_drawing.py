"""Section through a body of boxes: materials, supports, given potentials and loads."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from tactgen.validation.evidence.boxes import Box

#: Arrows along a load; a section longer than this is stretched.
_ARROWS, _LONG = 5, 5.0
#: Length of an arrow (points).
_ARROW = 26.0


def section(
    make: Callable[..., Box],
    *arguments: Any,
    unit: str = "mm",
    plane: tuple[str, str] = ("z", "x"),
    **named: Any,
) -> Callable[[], str]:
    """Drawing of the box that `make` returns, as a function that gives the SVG.

    `plane` names the axes of the section; boxes are in metres where `unit` is mm, else in `unit`.
    """
    return lambda: _drawn(make(*arguments, **named), unit, plane)


def _drawn(box: Box, unit: str, plane: tuple[str, str]) -> str:
    from matplotlib.patches import Patch, Rectangle

    from tactgen.validation.show.figures import AMBER, DARK, GREEN, GREY, SKY, new_figure, svg

    scale = 1e3 if unit == "mm" else 1.0
    h, v = (np.asarray(getattr(box, axis).breaks) * scale for axis in plane)
    equal = 1.0 / _LONG < np.ptp(h) / np.ptp(v) < _LONG
    figure = new_figure(6.4, 3.6 if equal else 2.6)
    axis = figure.add_subplot()
    fills: dict[str, str] = {}
    for slab, _ in box.parts:
        # regions of one material that differ by a number look alike
        name = slab.region.rstrip(" 0123456789")
        color = fills.setdefault(name, (SKY, AMBER, GREY, GREEN)[len(fills) % 4])
        spans = {"x": slab.x, "y": (0, -1), "z": slab.z}
        (h0, h1), (v0, v1) = (at[list(spans[a])] for at, a in zip((h, v), plane, strict=True))
        axis.add_patch(
            Rectangle((h0, v0), h1 - h0, v1 - v0, facecolor=color, edgecolor=DARK, alpha=0.55)
        )
    axis.vlines(h, v[0], v[-1], color=DARK, linewidth=0.4)
    axis.hlines(v, h[0], h[-1], color=DARK, linewidth=0.4)
    for held in box.held:
        _support(axis, held, (h, v), plane, scale)
    for load in box.loads:
        if load.component in plane:
            _arrows(axis, load, (h, v), plane, scale)
    axis.margins(0.12, 0.12 if equal else 0.3)
    if equal:
        axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel(f"{plane[0]} ({unit})")
    axis.set_ylabel(f"{plane[1]} ({unit})")
    axis.spines[:].set_visible(False)
    handles = [Patch(facecolor=c, alpha=0.55, label=name) for name, c in fills.items()]
    axis.legend(
        handles=handles, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False
    )
    return svg(figure)


def _support(axis: Any, held: Any, breaks: Any, plane: tuple[str, str], scale: float) -> None:
    """Draw a side of the section that is held or given a potential, or a hinge at its corner."""
    from tactgen.validation.show.figures import BLUE, ORANGE

    at = {name: getattr(held.where, name) for name in "xyz"}
    beyond = set("xyz") - set(plane)
    places = [at[name] for name in plane]
    if any(at[name] is not None for name in beyond) or any(isinstance(p, tuple) for p in places):
        return
    h, v = (None if place is None else place * scale for place in places)
    color, width = (ORANGE, 3.0) if held.components == ("phi",) else (BLUE, 2.0)
    if h is not None and v is not None:
        axis.plot(h, v, "^", color=color, markersize=11, clip_on=False)
    elif h is not None:
        axis.vlines(h, breaks[1][0], breaks[1][-1], color=color, linewidth=width)
    elif v is not None:
        axis.hlines(v, breaks[0][0], breaks[0][-1], color=color, linewidth=width)


def _arrows(axis: Any, load: Any, breaks: Any, plane: tuple[str, str], scale: float) -> None:
    """Draw a load that acts in the plane of the section as arrows that end where it acts."""
    from tactgen.validation.show.figures import ORANGE

    along = plane.index(load.component)
    places = []
    for name, ends in zip(plane, breaks, strict=True):
        where = getattr(load.where, name)
        if isinstance(where, float):
            places.append(np.array([where * scale]))
        else:
            low, high = (ends[0], ends[-1]) if where is None else np.multiply(where, scale)
            places.append(np.linspace(low, high, _ARROWS))
    for point in np.stack(np.meshgrid(*places), axis=-1).reshape(-1, 2):
        grid = dict(zip(plane, point / scale, strict=True))
        x, y, z = (np.array(grid.get(name, 0.0)) for name in "xyz")
        value = float(load.value(x, y, z) if callable(load.value) else load.value)
        if value:
            tail = np.zeros(2)
            tail[along] = -np.sign(value) * _ARROW
            axis.annotate(
                "", point, tail, textcoords="offset points", annotation_clip=False,
                arrowprops={"arrowstyle": "-|>", "color": ORANGE, "shrinkA": 0.0, "shrinkB": 0.0},
            )  # fmt: skip
