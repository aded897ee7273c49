"""Comparison of two scenes or two studies: lines, JSON values, and a self-contained page."""

from __future__ import annotations

import csv
import html
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.geometry.formats import engineering, percent, prefixed, share, with_error
from tactgen.validation.engine.answers import COLUMNS, quantity_rows, representative
from tactgen.validation.scene.load import checked_scene, load_scene, scene_values
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.figures import BLUE, ORANGE, panels, plain_numbers, svg
from tactgen.validation.show.page import inline, plain_page, table
from tactgen.validation.studies.whatif.axes import scene_field, shown_value
from tactgen.validation.studies.whatif.defaults import chosen
from tactgen.validation.studies.whatif.definition import FILE, Statement, read_statement
from tactgen.validation.studies.whatif.output_files import TABLE, aligned

#: Longest list of frequencies that is shown whole.
_LISTED = 6


#: Values of a study's axes by key.
Point = tuple[tuple[str, str], ...]


class Key(NamedTuple):
    """Identity of a number: point, quantity, model, frequency (Hz), index."""

    point: Point
    quantity: str
    model: str
    frequency: str
    number: str


@dataclass(frozen=True)
class Number:
    """A number with its absolute bar, both SI; nan where there is no answer."""

    value: complex
    error: float
    unit: str
    modelling: float = 0.0  #: Modelling error, absolute; nan where it is not known

    @property
    def size(self) -> float:
        """Real value itself, of a complex one the magnitude."""
        return self.value.real if self.value.imag == 0.0 else abs(self.value)


@dataclass(frozen=True)
class Side:
    """One of the two."""

    name: str  #: As it was given
    inputs: dict[str, str]  #: Scene keys with their values, and of a study its axes
    numbers: dict[Key, Number]  #: By what they are
    missing: int  #: How many questions have no answer
    scene: Scene  #: The scene; of a study without its axes


def read_sides(
    names: Sequence[str],
    overrides: Sequence[str],
    models: Sequence[str] | None,
    quantities: Sequence[str] | None,
    announce: Callable[[str], None],
) -> tuple[Side, ...]:
    """Both sides; scenes are solved, studies are read as they were written.

    Raises InputError if one cannot be read, a scene is held against a study, or models are named
    for studies.
    """
    studies = [Path(name, FILE).exists() for name in names]
    if len(set(studies)) > 1:
        raise InputError(
            f"{names[0]} and {names[1]} are a scene and a study; compare two of one kind"
        )
    if not studies[0]:
        return tuple(_scene(name, overrides, models, quantities, announce) for name in names)
    if overrides or models or quantities:
        raise InputError(
            "studies are compared as they were written, so --set, --model, --quantity and "
            "--frequency are for scenes; remove them"
        )
    return tuple(_study(Path(name)) for name in names)


def _scene(
    name: str,
    overrides: Sequence[str],
    models: Sequence[str] | None,
    quantities: Sequence[str] | None,
    announce: Callable[[str], None],
) -> Side:
    from tactgen.validation.engine.solve import solve

    values, _ = scene_values(name, overrides)
    which = chosen(values, models, quantities, Statement())
    scene, origins = load_scene(name, [*overrides, f"models={','.join(which[0])}"])
    announce(f"scene {name}")
    solution = solve(scene, *which, announce)
    peaks = [
        replace(q.alone_at_extreme, name=f"{q.name}, {representative(q).what}")
        for q in solution.quantities if q.extreme is not None
    ]  # fmt: skip
    rows = (row for q in (*solution.quantities, *peaks) for row in quantity_rows(q))
    numbers, missing = _numbered(
        ((), ["" if cell is None else str(cell) for cell in row]) for row in rows
    )
    return Side(name, _inputs(scene, origins), numbers, missing, scene)


def _study(folder: Path) -> Side:
    statement = read_statement(folder)
    scene = checked_scene({**statement.values, "models": list(statement.models)})
    path, keys = folder / TABLE, [axis.key for axis in statement.axes]
    try:
        with path.open(newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        if tuple(head[len(keys) :]) != COLUMNS:
            raise ValueError("other columns")
        numbers, missing = _numbered(
            (tuple(zip(keys, row, strict=False)), row[len(keys) :]) for row in rows
        )
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(
            f"{path} is not the table of a study ({error}); write it again with tactgen whatif "
            f"--resume --out {folder}"
        ) from None
    inputs = _inputs(scene, {})
    for axis in statement.axes:
        inputs.pop(axis.key, None)
        inputs[f"axis {axis.key}"] = axis.text
    return Side(str(folder), inputs, numbers, missing, scene)


def _inputs(scene: Scene, origins: dict[str, str]) -> dict[str, str]:
    rows = parameter_rows(scene, origins)
    found = {row.key: row.written for row in rows if row.key not in ("name", "description")}
    for key in ("models", "quantities", "frequency"):
        stated = getattr(scene, key)
        if len(stated) > _LISTED:
            found[key] = f"{stated[0]}, {stated[1]} … {stated[-1]} ({len(stated)} values)"
    return found


def _numbered(rows: Iterable[tuple[Point, Sequence[str]]]) -> tuple[dict[Key, Number], int]:
    """Numbers from rows of the tidy table by their points, and how many have none."""
    numbers: dict[Key, Number] = {}
    missing = 0
    for point, row in rows:
        cells = dict(zip(COLUMNS, row, strict=True))
        if not cells["value"]:
            missing += 1
            continue
        key = Key(point, cells["quantity"], cells["model"], cells["frequency"], cells["index"])
        value = complex(float(cells["value"]), float(cells["value_im"] or 0.0))
        error, modelling = (float(cells[of] or "nan") for of in ("uncertainty", "modelling_error"))
        numbers[key] = Number(value, error, cells["unit"], modelling)
    return numbers, missing


#: Rounding of numbers that are written and read, and of one order of summation for another.
_ROUNDING = 1e-13
#: Share of a value below which its bar is in none of the seven digits that are shown.
_UNSEEN = 1e-7


@dataclass(frozen=True)
class AnswerDifference:
    """One quantity by one model on both sides."""

    quantity: str
    model: str
    #: How many numbers both have, and how many of them differ by more than both bars together
    count: int
    beyond: int
    only: tuple[int, int]  #: (int, int) How many numbers only the one and only the other has
    key: Key  #: Where the difference is largest, in bars beyond them or else relative to the value
    #: There
    first: Number
    second: Number

    @property
    def relative(self) -> float:
        """Change from the first to the second where it is largest, of the magnitudes."""
        return _relative(self.first, self.second)

    @property
    def verdict(self) -> str:
        """Verdict on the change, in words."""
        if not self.beyond:
            return "the same" if self.relative == 0.0 else "covered by the bars"
        of = "" if self.count == 1 else f" at {self.beyond} of {self.count} values"
        return f"beyond the bars{of}"

    @property
    def cells(self) -> tuple[str, ...]:
        """Its line of a table, under ANSWERS."""
        alone = [f"{n} only in {side}" for n, side in zip(self.only, "AB", strict=True) if n]
        return (
            self.quantity, self.model, place(self.key), _shown(self.first), _shown(self.second),
            percent(self.relative), self.verdict + (f" ({', '.join(alone)})" if alone else ""),
        )  # fmt: skip


#: Headings of the tables of inputs and of answers.
INPUTS = ("key", "A", "B")
ANSWERS = ("quantity", "model", "at", "A", "B", "change", "bars")


class Comparison(NamedTuple):
    """Two sides, and what differs between them."""

    first: Side
    second: Side

    @property
    def inputs(self) -> list[tuple[str, str, str]]:
        """Keys whose values differ with both, in the order of the scene; - where one has none."""
        first, second = self.first.inputs, self.second.inputs
        keys = dict.fromkeys((*first, *second))
        found = [(k, first.get(k, "") or "-", second.get(k, "") or "-") for k in keys]
        return [each for each in found if each[1] != each[2]]

    @property
    def answers(self) -> list[AnswerDifference]:
        """Largest difference of every quantity and model that both have."""
        first, second = self.first.numbers, self.second.numbers
        groups: dict[tuple[str, str], list[Key]] = {}
        for key in dict.fromkeys((*first, *second)):
            groups.setdefault((key.quantity, key.model), []).append(key)
        found = []
        for (quantity, model), keys in groups.items():
            only = sum(key not in second for key in keys), sum(key not in first for key in keys)
            pairs = {k: (first[k], second[k]) for k in keys if k in first and k in second}
            if pairs:
                beyond = {key: _beyond(*pair) for key, pair in pairs.items()}
                worst = max(pairs, key=lambda key: (beyond[key], abs(_relative(*pairs[key]))))
                found.append(AnswerDifference(
                    quantity, model, len(pairs), sum(beyond.values()), only, worst, *pairs[worst]
                ))  # fmt: skip
        return found


def _beyond(first: Number, second: Number) -> bool:
    """Whether two numbers differ by more than both bars together."""
    unknown = math.isnan(first.size), math.isnan(second.size)
    if any(unknown):
        return not all(unknown)
    rounding = _ROUNDING * max(abs(first.value), abs(second.value))
    bars = sum(0.0 if math.isnan(each.error) else each.error for each in (first, second))
    return bool(abs(first.value - second.value) > bars + rounding)


def _relative(first: Number, second: Number) -> float:
    before, after = first.size, second.size
    if math.isnan(before) or math.isnan(after):
        return 0.0
    if before == after:
        return abs(first.value - second.value) / abs(before) if before else 0.0
    return after / before - 1.0 if before else math.inf


#: Where no quantity of the one is one of the other by the same model.
NOTHING_SHARED = (
    "no answer is on both sides; ask both for one quantity by one model (of scenes with --quantity "
    "and --model, of studies where tactgen whatif makes them)"
)


def lines(of: Comparison) -> list[str]:
    """Lines of a comparison, input first."""
    found = [f"A: {of.first.name}", f"B: {of.second.name}", ""]
    if of.inputs:
        found += ["input that differs:", *aligned([INPUTS, *of.inputs])]
    else:
        found.append("the input is the same")
    rows = [d.cells for d in of.answers]
    if rows:
        found += ["", "answers, where they differ most:", *aligned([ANSWERS, *rows])]
    else:
        found += ["", NOTHING_SHARED]
    return found + [f"{s.name} has no answer to {s.missing} questions" for s in of if s.missing]


def place(key: Key) -> str:
    """Where a number is: the point, frequency, index."""
    parts = _axis_words(key.point)
    parts += [f"{float(key.frequency):.6g} Hz"] if key.frequency else []
    parts += [f"no. {key.number}"] if key.number else []
    return ", ".join(parts)


def _axis_words(point: Iterable[tuple[str, str]]) -> list[str]:
    """Values of axes by key, as people read them."""
    return [
        f"{key} {shown_value(key, float(value) if scene_field(key).numeric else value)}"
        for key, value in point
    ]


def _shown(number: Number) -> str:
    """Number with its bars, numerical unless that is beyond the digits; of complex ones the size.

    The modelling error, which both sides mostly share, stands in brackets.
    """
    value = number.size
    beside = " (?)"
    if not math.isnan(number.modelling):
        off = number.modelling / abs(value) if value else 0.0
        beside = f" (± {share(off)})" if off else ""
    if 0.0 < number.error < _UNSEEN * abs(value):
        return engineering(value, number.unit, 7) + beside
    return with_error(value, number.error, number.unit) + beside


def as_values(of: Comparison) -> dict[str, Any]:
    """Comparison as JSON values, SI units; those that are not finite are not known."""
    return {
        "a": of.first.name, "b": of.second.name,
        "inputs": [{"key": key, "a": a, "b": b} for key, a, b in of.inputs],
        "answers": [
            {"quantity": d.quantity, "model": d.model, "values": d.count,
             "beyond_bars": d.beyond, "only": list(d.only), "at": place(d.key),
             "a": _pair(d.first.value), "b": _pair(d.second.value),
             "uncertainty_a": d.first.error, "uncertainty_b": d.second.error,
             "modelling_error_a": d.first.modelling, "modelling_error_b": d.second.modelling,
             "unit": d.first.unit, "change": d.relative, "verdict": d.verdict}
            for d in of.answers
        ],
        "missing": [side.missing for side in of],
    }  # fmt: skip


def _pair(value: complex) -> Any:
    if value != value:
        return None
    return value.real if value.imag == 0.0 else [value.real, value.imag]


# -- the page --------------------------------------------------------------------------------------

#: File of the page.
PAGE = "compare.html"
#: Most curves of one quantity that are drawn.
_CURVES = 6
#: Height of the taller of two devices on the page (rem).
_TALLEST = 26.0


def write_page(folder: Path, of: Comparison) -> Path:
    """Write the page, whole or not at all."""
    first, second = of
    parts = [f"<p>A is {html.escape(first.name)}, B is {html.escape(second.name)}.</p>"]
    differ = table(INPUTS, of.inputs) if of.inputs else "<p>None.</p>"
    parts += ["<h2>Input that differs</h2>", differ, "<h2>Answers, where they differ most</h2>"]
    rows = [d.cells for d in of.answers]
    parts.append(table(ANSWERS, rows) if rows else f"<p>{NOTHING_SHARED}.</p>")
    parts.append(
        "<p>A change is covered if it is no larger than both error bars together. These are "
        "numerical, how far a number is from the same model solved exactly; in brackets stands the "
        "modelling error, how far it may be from the most detailed model.</p>"
    )
    if picture := _curves(of):
        parts += ["<h2>Curves</h2>", f"<figure>{picture}</figure>"]
    parts += _devices(of)
    title = f"Comparison of {first.name} and {second.name}"
    return write_text(folder / PAGE, plain_page(title, parts))


def _curves(sides: tuple[Side, ...]) -> str:
    """Curves over frequency, or over the first numeric axis; nothing if there are none."""
    found: dict[str, dict[str, tuple[list[tuple[float, float]], ...]]] = {}
    labels: dict[str, tuple[str, str]] = {}
    for number, side in enumerate(sides):
        for key, value in side.numbers.items():
            found_at = _abscissa(key)
            if found_at is not None and (key.frequency or not np.isnan(value.value)):
                along, x, curve = found_at
                labels[key.quantity] = along, value.unit
                both = found.setdefault(key.quantity, {}).setdefault(curve, ([], []))
                both[number].append((x, abs(value.value)))
    found = {q: {c: v for c, v in of.items() if max(map(len, v)) > 1} for q, of in found.items()}
    found = {q: of for q, of in found.items() if of}
    if not found:
        return ""
    figure, grid = panels(11.0, 3.0 * len(found), nrows=len(found), squeeze=False)
    for axis, (quantity, curves) in zip(grid[:, 0], found.items(), strict=True):
        sizes = np.array([y for both in curves.values() for line in both for _, y in line])
        along, unit = labels[quantity]
        scale, unit = prefixed(float(sizes.max()), unit)
        for curve, both in list(curves.items())[:_CURVES]:
            for points, colour, name in zip(both, (BLUE, ORANGE), "AB", strict=True):
                if points:
                    line = np.array(sorted(points))
                    axis.plot(line[:, 0], scale * line[:, 1], "--" if name == "B" else "-",
                              color=colour, linewidth=1.2, label=f"{name} {curve}")  # fmt: skip
        if len(curves) > _CURVES:
            axis.set_title(f"{_CURVES} of {len(curves)} curves", fontsize=9)
        axis.set_ylabel(f"{quantity.replace('_', ' ')} ({unit})")
        axis.set_xlabel(along)
        if sizes.min() > 0.0 and sizes.max() > 30.0 * sizes.min():
            axis.set_yscale("log")
            plain_numbers(axis.yaxis)
        axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return svg(figure)


def _abscissa(key: Key) -> tuple[str, float, str] | None:
    """Heading and value of a number's abscissa, and its curve: model, index, all other axes."""
    rest = dict(key.point)
    if key.frequency:
        along, x = "frequency (Hz)", float(key.frequency)
    else:
        axis = next((axis for axis in rest if scene_field(axis).numeric), None)
        if axis is None:
            return None
        along, x = scene_field(axis).label, float(rest.pop(axis))
    index = (f"no. {key.number}",) if key.number else ()
    return along, x, ", ".join((key.model, *index, *_axis_words(rest.items())))


def _devices(of: Comparison) -> list[str]:
    """Pictures of both devices, if a dimension of them differs and they can be drawn.

    They have one scale: what is longer looks longer.
    """
    from tactgen.validation.show.export import scene_solids
    from tactgen.validation.show.pictures import solids_pictures

    shapes = ("bimorph.", "rod.", "coil.", "sleeve.", "support.kind", "gap", "glue.")
    if not any(key.startswith(shapes) for key, *_ in of.inputs):
        return []
    try:
        pictures = solids_pictures([scene_solids(side.scene) for side in of])
    except InputError as error:  # not every bimorph has CAD solids; a library may be missing
        return [f"<p>No picture of the devices: {html.escape(str(error))}</p>"]
    heights = [int.from_bytes(png[20:24], "big") for png in pictures]  # as a PNG states it
    figures = "".join(
        f'<figure><img alt="device {name}" src="{inline(png)}" '
        f'style="height:{_TALLEST * height / max(heights):.2f}rem">'
        f"<figcaption>{name}: {html.escape(side.name)}</figcaption></figure>"
        for png, height, name, side in zip(pictures, heights, "AB", of, strict=True)
    )
    return ["<h2>Devices, at one scale</h2>", f'<div class="pair">{figures}</div>']
