"""Pictures of a study: lines, contours, scatter, parallel coordinates, tornado.

Which one follows from the axes.  Of modes the first is shown, of responses the largest magnitude.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import prefixed
from tactgen.validation.engine.answers import representative
from tactgen.validation.show.figures import (
    AMBER,
    BLUE,
    DARK,
    GREEN,
    GREY,
    ORANGE,
    SKY,
    panels,
    plain_numbers,
    shades,
    svg,
)
from tactgen.validation.studies.whatif.axes import Axis
from tactgen.validation.studies.whatif.key_values import scene_field
from tactgen.validation.studies.whatif.output_files import heading
from tactgen.validation.studies.whatif.study import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.studies.whatif.aim_evaluation import Judged, Verdict

_COLOURS = (BLUE, ORANGE, GREEN, AMBER, SKY, DARK)
_STYLES = ("-", "--", ":", "-.")
#: Values of an axis that span more than this factor with even ratios are drawn logarithmically.
_WIDE = 20.0
#: Axes up to which samples are shown as scatter, and not as parallel coordinates.
_FEW = 4


def study_picture(study: Study) -> str:
    """Picture as an SVG element.

    One numeric axis: lines with bars.  Two: contours.  More: a tornado, each axis from its first
    to its last value with the others in their middle.  Samples: scatter over what was drawn, or
    parallel coordinates if that is much.  Choices such as ``load.kind`` are a line, or for
    contours and tornado a panel, each.

    Raises InputError if nothing was answered, or no axis is a number.
    """
    if all(answer.status != "ok" for _, _, answer in study.rows):
        raise InputError("no point has an answer, so there is nothing to draw")
    stated = study.statement
    drawn = [axis for axis in stated.axes if axis.drawn is not None]
    stepped = [axis for axis in stated.axes if axis.drawn is None and axis.numeric]
    if drawn:
        figure = _scatter(study, drawn) if len(drawn) <= _FEW else _parallel(study, drawn)
    elif not stepped:
        raise InputError(
            "no axis is a number, so there is nothing to draw it over; add one such as --vary "
            "bimorph.length=14mm:22mm:5"
        )
    elif len(stepped) == 1 or stated.zipped:
        figure = _lines(study, stepped[0])
    elif len(stepped) == 2:
        figure = _contours(study, stepped)
    else:
        figure = _tornado(study, stepped)
    return svg(figure)


def _rows_of(study: Study, others: Sequence[Axis]) -> dict[tuple[str, ...], list[int]]:
    """Points grouped by the values of these axes."""
    groups: dict[tuple[str, ...], list[int]] = {}
    for number, point in enumerate(study.points):
        at = tuple(scene_field(axis.key).show(point[axis.key]) for axis in others)
        groups.setdefault(at, []).append(number)
    return groups


def _values(study: Study, name: str, model: str, numbers: Sequence[int]) -> tuple[Floats, Floats]:
    """Quantity and its bar at some points, in the unit of its label; nan for none."""
    found = np.full((2, len(numbers)), np.nan)
    for column, number in enumerate(numbers):
        for q in study.answers[number][model].quantities:
            if q.name == name:
                one = representative(q)
                found[:, column] = one.value, one.error
    scale, _ = _scale(study, name)
    return scale * found[0], scale * found[1]


def along(axis: Axis, values: Sequence[Any]) -> tuple[Floats, str]:
    """Axis' values in the unit that people write them in, and its label."""
    scale = scene_field(axis.key).scale
    factor = scale.per_si if scale else 1.0
    unit = (scale.shown or scale.si) if scale else ""
    label = f"{axis.key} ({unit})" if unit else axis.key
    return np.array(values, dtype=float) * factor, label


def _scale(study: Study, name: str) -> tuple[float, str]:
    """Unit that a quantity is drawn in, and how many of it make one SI unit."""
    sizes, unit = [0.0], ""
    for _, _, answer in study.rows:
        for q in answer.quantities:
            if q.name == name:
                sizes.append(abs(representative(q).value))
                unit = q.unit
    return prefixed(float(np.nanmax(sizes)), unit)


def _label(study: Study, name: str) -> str:
    return f"{heading(study, name).replace('_', ' ')} ({_scale(study, name)[1]})"


def _answered(study: Study) -> list[tuple[str, str]]:
    """Quantities with the models that answered somewhere."""
    found = {(q.name, model): None for _, model, a in study.rows for q in a.quantities}
    order = study.statement.quantities
    return sorted(found, key=lambda pair: order.index(pair[0]))


def _logarithmic(side: Any, values: Floats) -> bool:
    """Make a side logarithmic if its values are spread that way."""
    if values.size < 3 or values.min() <= 0.0 or values.max() < _WIDE * values.min():
        return False
    side.set_xscale("log")
    return True


def _lines(study: Study, axis: Axis) -> Figure:
    others = [a for a in study.statement.axes if a is not axis and not study.statement.zipped]
    groups = _rows_of(study, others)
    pairs = _answered(study)
    names = list(dict.fromkeys(name for name, _ in pairs))
    figure, grid = panels(6.4, 3.2 * len(names), nrows=len(names), squeeze=False, sharex=True)
    label = ""
    for side, name in zip(grid[:, 0], names, strict=True):
        models = [model for each, model in pairs if each == name]
        for (n, model), (m, (at, numbers)) in itertools.product(
            enumerate(models), enumerate(groups.items())
        ):
            x, label = along(axis, [study.points[number][axis.key] for number in numbers])
            y, bar = _values(study, name, model, numbers)
            colour = _COLOURS[n % len(_COLOURS)] if len(models) > 1 else _COLOURS[m % 6]
            style = _STYLES[m % len(_STYLES)] if len(models) > 1 else "-"
            order = np.argsort(x)
            side.errorbar(
                x[order], y[order], np.nan_to_num(bar[order]), color=colour, linestyle=style,
                marker="o", markersize=3, capsize=2, label=" ".join((model, *at)),
            )  # fmt: skip
            _logarithmic(side, x)
        side.set_ylabel(_label(study, name))
        side.legend(fontsize=8)
        plain_numbers(side.xaxis)
    grid[-1, 0].set_xlabel(label)
    return figure


def _contours(study: Study, axes: Sequence[Axis]) -> Figure:
    others = [a for a in study.statement.axes if a not in axes]
    groups, pairs = _rows_of(study, others), _answered(study)
    figure, grid = panels(
        5.0 * len(groups), 4.0 * len(pairs), nrows=len(pairs), ncols=len(groups), squeeze=False
    )
    first, second = axes
    for row, (name, model) in zip(grid, pairs, strict=True):
        for side, (at, numbers) in zip(row, groups.items(), strict=True):
            x, x_label = along(first, first.values)
            y, y_label = along(second, second.values)
            found, _ = _values(study, name, model, numbers)
            places = {
                (study.points[n][first.key], study.points[n][second.key]): value
                for n, value in zip(numbers, found, strict=True)
            }
            table = np.array([[places[a, b] for a in first.values] for b in second.values])
            side.set_title(" ".join((model, *at)), fontsize=9)
            side.set_xlabel(x_label)
            side.set_ylabel(y_label)
            if min(table.shape) > 1 and np.isfinite(table).sum() > 3:
                filled = side.contourf(x, y, np.ma.masked_invalid(table), levels=12)
                figure.colorbar(filled, ax=side, label=_label(study, name))
            side.plot(*(part.ravel() for part in np.meshgrid(x, y)), ".", color=GREY, markersize=2)
    return figure


def _tornado(study: Study, axes: Sequence[Axis]) -> Figure:
    others = [a for a in study.statement.axes if a not in axes]
    pairs = _answered(study)
    groups = _rows_of(study, others)
    figure, grid = panels(
        6.0 * len(groups), (0.8 + 0.35 * len(axes)) * len(pairs) + 0.4, nrows=len(pairs),
        ncols=len(groups), squeeze=False,
    )  # fmt: skip
    for row, (name, model) in zip(grid, pairs, strict=True):
        for side, (at, numbers) in zip(row, groups.items(), strict=True):
            found, _ = _values(study, name, model, numbers)
            by_place = {
                tuple(study.points[n][axis.key] for axis in axes): value
                for n, value in zip(numbers, found, strict=True)
            }
            spans = swings([axis.values for axis in axes], by_place)
            order = sorted(range(len(axes)), key=lambda n: np.ptp(spans[n]))
            middle = by_place[tuple(_middle(axis.values) for axis in axes)]
            for height, n in enumerate(order):
                for end, colour in zip(spans[n], (SKY, BLUE), strict=True):
                    side.barh(height, end - middle, left=middle, color=colour, height=0.6)
            shown = [scene_field(axis.key).show for axis in axes]
            side.set_yticks(range(len(axes)), [
                f"{axes[n].key}  {shown[n](axes[n].values[0])} to {shown[n](axes[n].values[-1])}"
                for n in order
            ])  # fmt: skip
            side.axvline(middle, color=DARK, linewidth=0.8)
            side.set_title(" ".join((model, *at)), fontsize=9)
            side.set_xlabel(_label(study, name))
    return figure


def _middle(values: Sequence[Any]) -> Any:
    return values[len(values) // 2]


def swings(
    values: Sequence[Sequence[Any]], by_place: dict[tuple[Any, ...], float]
) -> list[tuple[float, float]]:
    """Values at the ends of each axis, the others in their middle.

    Parameters
    ----------
    values : sequence of sequences
        Of each axis.
    by_place : dict
        The quantity by the values of all axes.
    """
    middle = [_middle(each) for each in values]
    found = []
    for n, each in enumerate(values):
        ends = [(*middle[:n], end, *middle[n + 1 :]) for end in (each[0], each[-1])]
        found.append((by_place[ends[0]], by_place[ends[1]]))
    return found


def _scatter(study: Study, drawn: Sequence[Axis]) -> Figure:
    names = list(dict.fromkeys(name for name, _ in _answered(study)))
    figure, grid = panels(
        3.2 * len(drawn), 2.8 * len(names), nrows=len(names), ncols=len(drawn), squeeze=False,
        sharey="row",
    )  # fmt: skip
    pairs = _answered(study)
    numbers = range(len(study.points))
    for row, name in zip(grid, names, strict=True):
        models = [model for each, model in pairs if each == name]
        for side, axis in zip(row, drawn, strict=True):
            x, label = along(axis, [point[axis.key] for point in study.points])
            for model, colour in zip(models, itertools.cycle(_COLOURS)):
                y, bar = _values(study, name, model, numbers)
                side.errorbar(
                    x, y, np.nan_to_num(bar), fmt="o", markersize=3, color=colour, label=model
                )
            side.set_xlabel(label)
        row[0].set_ylabel(_label(study, name))
        row[0].legend(fontsize=8)
    return figure


def _parallel(study: Study, drawn: Sequence[Axis]) -> Figure:
    """Parallel coordinates of inputs and results, each from 0 to 1."""
    pairs = _answered(study)
    figure, grid = panels(1.6 * (len(drawn) + len(pairs)), 4.0, squeeze=False)
    side = grid[0, 0]
    columns, labels = [], []
    for axis in drawn:
        values, label = along(axis, [point[axis.key] for point in study.points])
        columns.append(values)
        labels.append(label)
    for name, model in pairs:
        columns.append(_values(study, name, model, range(len(study.points)))[0])
        labels.append(f"{_label(study, name)}, {model}")
    table = np.array(columns)
    low, high = np.nanmin(table, 1, keepdims=True), np.nanmax(table, 1, keepdims=True)
    place = (table - low) / np.where(high > low, high - low, 1.0)
    order = np.argsort(np.argsort(np.nan_to_num(place[-1])))
    colours = shades(len(study.points))
    for number, line in enumerate(place.T):
        side.plot(range(len(labels)), line, color=colours[order[number]], linewidth=0.8)
    side.set_xticks(range(len(labels)), [
        f"{label}\n{bottom:.4g} to {top:.4g}"
        for label, bottom, top in zip(labels, low[:, 0], high[:, 0], strict=True)
    ], rotation=30, ha="right", fontsize=8)  # fmt: skip
    side.set_yticks((0.0, 1.0), ("least", "most"))
    side.set_xlabel("what was drawn, then what came of it")
    side.set_ylabel("of all samples")
    return figure


_HISTOGRAM = 25


def aim_picture(study: Study, found: Verdict) -> str:
    """Picture as an SVG element.

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
    """Values of a goal or margins of a condition, errors, and label."""
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
    """Points as met, not met, and too near to the edge to say, with a colour each."""
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
