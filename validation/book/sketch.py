"""The set-up of a case as a figure: areas by material, what holds them, what acts on them."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.checks.case import Case
from tactgen.validation.checks.drawings.drawing import Drawing, Line, Mark
from tactgen.validation.view.figures import (
    AMBER,
    BLUE,
    DARK,
    GREEN,
    GREY,
    ORANGE,
    SKY,
    new_figure,
    svg,
)

_FILLS = (SKY, AMBER, GREY, GREEN, ORANGE)
#: What each kind of line looks like.
_LINES: dict[str, dict[str, Any]] = {
    "division": {"color": DARK, "linewidth": 0.4},
    "held": {"color": BLUE, "linewidth": 2.0},
    "potential": {"color": ORANGE, "linewidth": 3.0, "alpha": 0.8},
    "axis": {"color": GREY, "linewidth": 1.0, "linestyle": "-."},
    "spring": {"color": DARK, "linewidth": 1.2},
    "damper": {"color": DARK, "linewidth": 1.2},
    "flux": {"color": GREEN, "linewidth": 1.2},
}
#: What the legend says of lines that need it.
_MEANINGS = {"held": "held", "potential": "potential given", "flux": "field far away"}
#: Turns of a spring, and half its width as a share of its length.
_TURNS, _SLIM = 6, 0.09
#: Length of an arrow and distance of words from what they name (points).
_ARROW, _BESIDE = 26.0, 9.0


def sketched(case: Case) -> str:
    """Return the drawing of a case's set-up as SVG; empty where it has none."""
    return "" if case.setup is None else svg(_drawn(case.setup()))


def _drawn(drawing: Drawing) -> Any:
    from matplotlib.patches import Polygon

    figure = new_figure(6.4, 3.6 if drawing.equal else 2.6)
    axis = figure.add_subplot()
    names = list(dict.fromkeys(area.material for area in drawing.areas))
    for area in drawing.areas:
        fill = _FILLS[names.index(area.material) % len(_FILLS)]
        axis.add_patch(Polygon(area.outline, facecolor=fill, edgecolor=DARK, alpha=0.55))
    for line in drawing.lines:
        _line(axis, line)
    for mark in drawing.marks:
        _mark(axis, mark)
    axis.autoscale_view()
    axis.margins(0.12, 0.12 if drawing.equal else 0.3)
    if drawing.equal:
        axis.set_aspect("equal", adjustable="datalim")
    _named(axis, drawing.labels)
    _legend(axis, names, {line.kind for line in drawing.lines})
    return figure


def _line(axis: Any, line: Line) -> None:
    from matplotlib.patheffects import Normal, withTickedStroke

    points = np.array(line.points)
    if line.kind in ("spring", "damper"):
        points = _between(points, line.kind)
    style = dict(_LINES[line.kind])
    if line.kind == "held":
        style["path_effects"] = [Normal(), withTickedStroke(angle=135, spacing=6, length=0.7)]
    axis.plot(*points.T, solid_capstyle="butt", **style)
    if line.kind == "flux":
        axis.annotate("", points[1], points[0], arrowprops={"arrowstyle": "->", "color": GREEN})


def _between(ends: Floats, kind: str) -> Floats:
    """Return the points (n, 2) of a spring or damper between two ends."""
    along = ends[1] - ends[0]
    across = _SLIM * np.array([-along[1], along[0]])
    if kind == "spring":
        side = np.concatenate([[0.0, 0.0], np.tile([1.0, -1.0], _TURNS), [0.0, 0.0]])
        share = np.concatenate([[0.0], np.linspace(0.2, 0.8, side.size - 2), [1.0]])
    else:  # a piston in a cup that is open to the right
        share = np.array([0.0, 0.4, 0.4, 0.6, 0.4, 0.4, 0.6, 0.4, 0.4, np.nan, 0.5, 0.5, 0.5, 1.0])
        side = np.array([0.0, 0.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, 0.0, np.nan, 0.7, -0.7, 0, 0])
    return np.asarray(ends[0] + share[:, None] * along + side[:, None] * across)


def _mark(axis: Any, mark: Mark) -> None:
    axis.plot(*mark.at, alpha=0.0)  # the view reaches this far
    if mark.kind == "force":
        _arrow(axis, mark)
        return
    shapes = {"hinge": "^", "mass": "s", "turning spring": r"$\circlearrowleft$"}
    if mark.kind in shapes:
        drop = -6.0 if mark.kind == "hinge" else 0.0
        size = 15 if mark.kind == "turning spring" else 11
        axis.plot(
            *mark.at, marker=shapes[mark.kind], markersize=size, color=BLUE if drop else DARK,
            transform=_shifted(axis, drop), clip_on=False,
        )  # fmt: skip
    turn = np.deg2rad(mark.direction)
    right = mark.kind in ("mass", "text") and abs(np.cos(turn)) > 0.5
    beside = (_BESIDE + 2.0, 0.0) if right else (0.0, -22.0 if mark.kind == "hinge" else _BESIDE)
    axis.annotate(
        mark.text, mark.at, beside, textcoords="offset points", fontsize=8,
        ha="left" if right else "center", va="center" if right else "bottom",
    )  # fmt: skip


def _arrow(axis: Any, mark: Mark) -> None:
    """Draw a force whose arrow ends at the point, its words at the tail."""
    turn = np.deg2rad(mark.direction)
    tail = (-_ARROW * np.cos(turn), -_ARROW * np.sin(turn))
    # words beside the tail of an arrow that lies, and not under it
    side = "center" if abs(np.cos(turn)) < 0.5 else "right" if np.cos(turn) > 0.0 else "left"
    axis.annotate(
        mark.text, mark.at, tail, textcoords="offset points", fontsize=8, ha=side, va="center",
        arrowprops={"arrowstyle": "-|>", "color": ORANGE, "shrinkA": 0.0, "shrinkB": 0.0},
        annotation_clip=False,
    )  # fmt: skip


def _shifted(axis: Any, points: float) -> Any:
    """Return the axis' own transform, so many points higher."""
    from matplotlib.transforms import ScaledTranslation

    return axis.transData + ScaledTranslation(0.0, points / 72.0, axis.figure.dpi_scale_trans)


def _named(axis: Any, labels: tuple[str, str]) -> None:
    """Name the axes; one without a unit has no numbers."""
    for side, label in zip((axis.xaxis, axis.yaxis), labels, strict=True):
        side.set_label_text(label)
        if "(" not in label:
            side.set_ticks([])
    axis.spines[:].set_visible(False)


def _legend(axis: Any, materials: list[str], kinds: set[str]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(facecolor=_FILLS[i % len(_FILLS)], edgecolor=DARK, alpha=0.55, label=name)
        for i, name in enumerate(materials)
    ]
    handles += [
        Line2D([], [], label=_MEANINGS[kind], **_LINES[kind])
        for kind in sorted(kinds & {*_MEANINGS})
    ]
    axis.legend(
        handles=handles, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False
    )
