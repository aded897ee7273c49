"""Pictures of a study: values over one axis, maps over two, points by what the aims say of them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import prefixed
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
    svg,
)
from tactgen.validation.studies.whatif.aim_evaluation import Judged, Verdict
from tactgen.validation.studies.whatif.axes import Axis, scene_field, shown_point
from tactgen.validation.studies.whatif.output_files import column, heading
from tactgen.validation.studies.whatif.study import Study

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = (BLUE, ORANGE, GREEN, AMBER, SKY, DARK)
_STYLES = ("-", "--", ":", "-.")
_MARKS = "os^Dv"
#: Values of an axis that span more than this factor are drawn logarithmically.
_WIDE = 20.0


def study_picture(study: Study) -> str:
    """Picture as an SVG element.

    Over one number, and over each number that is drawn, values with bars; over several a map of the
    first two, the others in their middle.  Each choice, as of ``load.kind``, is a line or a panel.

    Raises InputError if nothing was answered, or no axis is a number.
    """
    if all(answer.status != "ok" for _, _, answer in study.rows):
        raise InputError("no point has an answer, so there is nothing to draw")
    axes = _numeric(study)
    drawn = [axis for axis in axes if axis.drawn is not None]
    if drawn or len(axes) == 1 or study.statement.zipped:
        return svg(_lines(study, drawn or axes[:1]))
    return svg(_maps(study, axes))


def _numeric(study: Study) -> list[Axis]:
    found = [axis for axis in study.statement.axes if axis.numeric]
    if not found:
        raise InputError(
            "no axis is a number, so there is nothing to draw it over; add one such as --vary "
            "bimorph.length=14mm:22mm:5"
        )
    return found


def _by_choices(study: Study, places: Sequence[int]) -> dict[str, list[int]]:
    """Places of points by their values of the axes that are no numbers."""
    words = [axis.key for axis in study.statement.axes if not axis.numeric]
    groups: dict[str, list[int]] = {}
    for place in places:
        groups.setdefault(" ".join(study.points[place][key] for key in words), []).append(place)
    return groups


def _along(axis: Axis, points: Sequence[dict[str, Any]]) -> tuple[Floats, str]:
    """Points' values of an axis in the unit that people write them in, and its label."""
    scale = scene_field(axis.key).scale
    unit = (scale.shown or scale.si) if scale else ""
    factor = scale.per_si if scale else 1.0
    values = np.array([float(point[axis.key]) for point in points]) * factor
    return values, f"{axis.key} ({unit})" if unit else axis.key


def _quantities(study: Study) -> dict[str, list[tuple[str, Floats, Floats]]]:
    """Values and bars (points,) of answered quantities by label, of each model; nan for none."""
    found: dict[str, list[tuple[str, Floats, Floats]]] = {}
    for name in study.statement.quantities:
        columns = {model: column(study, model, name) for model in study.statement.models}
        known = [shown for each in columns.values() for shown in each if shown]
        if not known:
            continue
        largest = np.nanmax([0.0, *(abs(shown.value) for shown in known)])
        scale, unit = prefixed(float(largest), known[0].unit)
        label = f"{heading(study, name).replace('_', ' ')} ({unit})"
        for model, each in columns.items():
            if any(each):
                both = np.array([(s.value, s.error) if s else (np.nan, np.nan) for s in each])
                found.setdefault(label, []).append((model, scale * both[:, 0], scale * both[:, 1]))
    return found


def _lines(study: Study, axes: Sequence[Axis]) -> Figure:
    """Values with bars over each axis, joined unless they are drawn."""
    zipped = study.statement.zipped
    every = range(len(study.points))
    groups = {"": list(every)} if zipped else _by_choices(study, every)
    rows = _quantities(study)
    figure, grid = panels(
        max(6.4, 3.2 * len(axes)), 3.2 * len(rows), nrows=len(rows), ncols=len(axes),
        squeeze=False, sharex="col", sharey="row",
    )  # fmt: skip
    for sides, (label, row) in zip(grid, rows.items(), strict=True):
        for side, axis in zip(sides, axes, strict=True):
            x, x_label = _along(axis, study.points)
            colours = itertools.cycle(_COLOURS)
            styles = dict(zip(study.statement.models, itertools.cycle(_STYLES), strict=False))
            for (model, y, bar), (at, places) in itertools.product(row, groups.items()):
                order = np.array(places)[np.argsort(x[places])]
                side.errorbar(
                    x[order], y[order], np.nan_to_num(bar[order]), color=next(colours), marker="o",
                    linestyle="none" if axis.drawn else styles[model], markersize=3, capsize=2,
                    label=f"{model} {at}".strip(),
                )  # fmt: skip
            _scale(side, x)
            side.set_xlabel(x_label)
        sides[0].set_ylabel(label)
        sides[0].legend(fontsize=8)
    return figure


def _scale(side: Any, x: Floats, y: Floats | None = None) -> None:
    """Draw axes whose values span much logarithmically."""
    for values, scale in ((x, side.set_xscale), (y, side.set_yscale)):
        if values is None or values.size < 3 or values.min() <= 0.0:
            continue
        if values.max() > _WIDE * values.min():
            scale("log")
    plain_numbers(side.xaxis, side.yaxis)


def _maps(study: Study, axes: Sequence[Axis]) -> Figure:
    """Filled contours over the first two axes, a row for each quantity."""
    first, second, *others = axes
    middle = {axis.key: axis.values[len(axis.values) // 2] for axis in others}
    shown = [n for n, point in enumerate(study.points) if middle.items() <= point.items()]
    groups, rows = _by_choices(study, shown), _quantities(study)
    columns = max(map(len, rows.values())) * len(groups)
    figure, grid = panels(
        5.0 * columns, 4.0 * len(rows), nrows=len(rows), ncols=columns, squeeze=False
    )
    fixed = shown_point(middle)
    for sides, (label, row) in zip(grid, rows.items(), strict=True):
        maps = list(itertools.product(row, groups.items()))
        for side in sides[len(maps) :]:
            side.remove()
        for side, ((model, values, _), (at, places)) in zip(sides, maps, strict=False):
            x, x_label = _along(first, [study.points[n] for n in places])
            y, y_label = _along(second, [study.points[n] for n in places])
            side.set_title(f"{model} {at} {fixed}".strip(), fontsize=9)
            side.set_xlabel(x_label)
            side.set_ylabel(y_label)
            order = np.lexsort((x, y))
            shape = len(second.values), len(first.values)
            table = values[places][order].reshape(shape)
            if min(shape) > 1 and np.isfinite(table).sum() > 3:
                place = (x[order].reshape(shape), y[order].reshape(shape))
                filled = side.contourf(*place, np.ma.masked_invalid(table), levels=12)
                figure.colorbar(filled, ax=side, label=label)
            side.plot(x, y, ".", color=GREY, markersize=2)
            _scale(side, x, y)
    return figure


#: Values, bars and label of judged points in one direction of a picture.
_Direction = Callable[[Sequence[Judged]], tuple[Floats, Any, str]]


def aim_picture(study: Study, found: Sequence[Verdict]) -> str:
    """Picture as an SVG element: what meets the aims, what does not, and what is best.

    Of two goals one over the other; else the plane of two axes, or every aim over each axis.  Each
    model has panels of its own: side by side if they are one column, else below each other.  Each
    choice, as of ``load.kind``, has a mark of its own.

    Raises InputError if no axis is a number.
    """
    blocks = [[[(one, *of) for of in row] for row in _directions(study, one)] for one in found]
    if len(blocks[0][0]) == 1:
        rows = [list(itertools.chain(*row)) for row in zip(*blocks, strict=True)]
    else:
        rows = list(itertools.chain(*blocks))
    columns = len(rows[0])
    figure, grid = panels(
        max(6.4, 3.6 * columns), 3.6 * len(rows), nrows=len(rows), ncols=columns, squeeze=False
    )
    named: dict[str, Any] = {}
    choices = _by_choices(study, range(len(study.points)))
    marks = dict(zip(choices, itertools.cycle(_MARKS), strict=False))
    for side, (one, across, up) in zip(grid.flat, itertools.chain(*rows), strict=True):
        best = one.best if sum(aim.kind == "goal" for aim in one.aims) == 2 else one.best[:1]
        groups = [
            (f"{name} {at}".strip(), colour, marks[at], [j for j in which if j.number in places])
            for name, colour, which in _sorted(one) for at, places in choices.items()
        ]  # fmt: skip
        for name, colour, mark, which in (*groups, ("best", "none", "o", best)):
            if not which:
                continue
            x, x_bar, x_label = across(which)
            y, y_bar, y_label = up(which)
            named[name] = side.errorbar(
                x, y, y_bar, x_bar, fmt=mark, markersize=9 if name == "best" else 4, capsize=2,
                color=colour, markeredgecolor=DARK if name == "best" else colour, label=name,
            )  # fmt: skip
            side.set_title(f"by {one.models}", fontsize=9)
            side.set_xlabel(x_label, fontsize=8)
            side.set_ylabel(y_label, fontsize=8)
    figure.legend(named.values(), named, loc="outside upper center", ncols=len(named), fontsize=8)
    return svg(figure)


def _directions(study: Study, found: Verdict) -> list[list[tuple[_Direction, _Direction]]]:
    """What a verdict's panels show, across and up, by rows."""
    goals = [n for n, aim in enumerate(found.aims) if aim.kind == "goal"]
    axes = _numeric(study) if len(goals) < 2 else []
    if len(goals) == 2:
        return [[(_of_aim(found, goals[0]), _of_aim(found, goals[1]))]]
    if len(axes) == 2:
        return [[(_of_axis(study, axes[0]), _of_axis(study, axes[1]))]]
    return [
        [(_of_axis(study, axis), _of_aim(found, n)) for axis in axes]
        for n in range(len(found.aims))
    ]


def _of_axis(study: Study, axis: Axis) -> _Direction:
    def direction(which: Sequence[Judged]) -> tuple[Floats, None, str]:
        values, label = _along(axis, [study.points[one.number] for one in which])
        return values, None, label

    return direction


def _of_aim(found: Verdict, n: int) -> _Direction:
    """Values of a goal, or margins of a condition."""
    aim = found.aims[n]
    sign, what = (aim.sign, aim.text) if aim.kind == "goal" else (1.0, f"margin of {aim.text}")
    largest = max(abs(one.margins[n].value) for one in found.judged)
    scale, unit = prefixed(largest, aim.unit) if aim.takes_prefix else (1.0, aim.unit)

    def direction(which: Sequence[Judged]) -> tuple[Floats, Floats, str]:
        both = np.array([(one.margins[n].value, one.margins[n].bar) for one in which])
        label = f"{what} ({unit})" if unit not in ("", "1") else what
        return sign * scale * both[:, 0], scale * both[:, 1], label

    return direction


def _sorted(found: Verdict) -> list[tuple[str, str, list[Judged]]]:
    """Points as met, not met, and too near to the edge to say, with a colour each."""
    near = set(found.undecided)
    met = set(found.met) - near
    rest = set(found.judged) - met - near
    every = "met" if any(aim.kind == "condition" for aim in found.aims) else "point"
    groups = (
        (every, GREEN, [one for one in found.judged if one in met]),
        ("not met", ORANGE, [one for one in found.judged if one in rest]),
        ("nearer than its bar", AMBER, [one for one in found.judged if one in near]),
    )
    return [group for group in groups if group[2]]
