"""What a study's aims say of its points, drawn: where they are met, or one goal over the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.formats import prefixed
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.studies.whatif.aim.best import Judged, Verdict
from tactgen.validation.studies.whatif.run import Study
from tactgen.validation.studies.whatif.shown.pictures import along
from tactgen.validation.view.figures import AMBER, DARK, GREEN, GREY, ORANGE, panels, svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_HISTOGRAM = 25


def aim_picture(study: Study, found: Verdict) -> str:
    """Return the picture as an SVG element.

    Two goals: one over the other, the points that no other betters in both joined.  Else over the
    axes that are numbers: one, the aims over it; two, the plane of both with what is met where;
    others, how often each margin occurs.
    """
    goals = [n for n, aim in enumerate(found.aims) if aim.kind == "goal"]
    axes = [axis for axis in study.statement.axes if axis.numeric]
    if len(goals) == 2:
        figure = _front(found, goals)
    elif len(axes) == 1:
        figure = _over(study, found, axes[0])
    elif len(axes) == 2:
        figure = _plane(study, found, axes)
    else:
        figure = _counts(found)
    return svg(figure)


def _numbers(found: Verdict, which: Sequence[Judged], n: int) -> tuple[Floats, Floats, str]:
    """Return values of a goal or margins of a condition, their bars, and what they are called."""
    aim = found.aims[n]
    sign = aim.sign if aim.kind == "goal" else 1.0
    values = np.array([sign * one.margins[n][0] for one in which])
    bars = np.array([one.margins[n][1] for one in which])
    largest = max((abs(one.margins[n][0]) for one in found.judged), default=0.0)
    prefixes = aim.unit in {row.unit for row in QUANTITIES.values()}  # base units take none
    scale, unit = prefixed(largest, aim.unit) if prefixes else (1.0, aim.unit)
    label = "value" if aim.kind == "goal" else "margin"
    return scale * values, scale * bars, f"{label} ({unit})" if unit not in ("", "1") else label


def _sorted(found: Verdict) -> list[tuple[str, str, list[Judged]]]:
    """Return the points as met, not met, and too near to the edge to say, with a colour each."""
    near = [one for one in found.judged if one in found.undecided]
    met = [one for one in found.met if one not in near]
    rest = [one for one in found.judged if one not in near and one not in met]
    every = "met" if any(aim.kind == "condition" for aim in found.aims) else "point"
    groups = ((every, GREEN, met), ("not met", ORANGE, rest), ("nearer than its bar", AMBER, near))
    return [group for group in groups if group[2]]


def _front(found: Verdict, goals: Sequence[int]) -> Figure:
    figure, side = panels(6.4, 4.2)
    for name, colour, which in _sorted(found):
        (x, x_bar, x_label), (y, y_bar, y_label) = (_numbers(found, which, n) for n in goals)
        side.errorbar(x, y, y_bar, x_bar, fmt="o", markersize=3, color=colour, label=name)
        side.set_xlabel(f"{found.aims[goals[0]].text}: {x_label}")
        side.set_ylabel(f"{found.aims[goals[1]].text}: {y_label}")
    (x, *_), (y, *_) = (_numbers(found, found.best, n) for n in goals)
    side.plot(x, y, color=DARK, linewidth=1.0, label="not bettered in both")
    side.legend(fontsize=8)
    return figure


def _over(study: Study, found: Verdict, axis: Any) -> Figure:
    figure, grid = panels(
        6.4, 3.0 * len(found.aims), nrows=len(found.aims), squeeze=False, sharex=True
    )
    for n, (side, aim) in enumerate(zip(grid[:, 0], found.aims, strict=True)):
        for name, colour, which in _sorted(found):
            x, label = along(axis, [study.points[one.number][axis.key] for one in which])
            y, bar, y_label = _numbers(found, which, n)
            side.errorbar(x, y, bar, fmt="o", markersize=3, capsize=2, color=colour, label=name)
            side.set_xlabel(label)
            side.set_ylabel(y_label)
        side.set_title(aim.text, fontsize=9)
        if aim.kind == "condition":
            side.axhline(0.0, color=GREY, linewidth=1.0)
    grid[0, 0].legend(fontsize=8)
    return figure


def _plane(study: Study, found: Verdict, axes: Sequence[Any]) -> Figure:
    figure, side = panels(6.4, 4.2)
    for name, colour, which in _sorted(found):
        _points(study, side, axes, which, {"marker": "o", "color": colour, "label": name})
    ring = {"marker": "o", "facecolors": "none", "edgecolors": DARK, "s": 90, "label": "best"}
    _points(study, side, axes, found.best[:1], ring)
    side.set_title(" and ".join(aim.text for aim in found.aims), fontsize=9)
    side.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _points(
    study: Study, side: Any, axes: Sequence[Any], which: Sequence[Judged], style: dict[str, Any]
) -> None:
    """Draw points in the plane of two axes and name these."""
    if not which:
        return
    (x, x_label), (y, y_label) = (
        along(axis, [study.points[one.number][axis.key] for one in which]) for axis in axes
    )
    side.scatter(x, y, **{"s": 14, **style})
    side.set_xlabel(x_label)
    side.set_ylabel(y_label)


def _counts(found: Verdict) -> Figure:
    figure, grid = panels(6.4, 2.6 * len(found.aims), nrows=len(found.aims), squeeze=False)
    for n, (side, aim) in enumerate(zip(grid[:, 0], found.aims, strict=True)):
        values, _, label = _numbers(found, found.judged, n)
        side.hist(values, bins=_HISTOGRAM, color=GREEN)
        if aim.kind == "condition":
            side.axvline(0.0, color=DARK, linewidth=1.0)
        side.set_title(aim.text, fontsize=9)
        side.set_xlabel(label)
        side.set_ylabel("points")
    return figure
