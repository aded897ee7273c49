"""What is compared: a scene or a study as its input and its numbers, each number by what it is."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.answers import COLUMNS, quantity_rows
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.scene import Scene, checked_scene, load_scene, scene_values
from tactgen.validation.studies.whatif.asked.choice import chosen
from tactgen.validation.studies.whatif.asked.statement import FILE, Statement, read_statement
from tactgen.validation.studies.whatif.shown.files import TABLE

#: Longest list of frequencies that is shown whole.
_LISTED = 6


class Key(NamedTuple):
    """What a number is: the point it is at, quantity, model, frequency (Hz), index there."""

    point: tuple[tuple[str, str], ...]
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


@dataclass(frozen=True)
class Side:
    """One of the two.

    Attributes
    ----------
    name : str
        As it was given.
    inputs : dict of str to str
        Scene keys with their values, and of a study its axes.
    numbers : dict
        By what they are.
    missing : dict of Key to str
        Answers that are missing, and why.
    scene : Scene
        The scene; of a study without its axes.
    axes : tuple of str
        Headings of the axes' columns.
    """

    name: str
    inputs: dict[str, str]
    numbers: dict[Key, Number]
    missing: dict[Key, str]
    scene: Scene
    axes: tuple[str, ...]


def read_sides(
    names: Sequence[str],
    overrides: Sequence[str],
    models: Sequence[str] | None,
    quantities: Sequence[str] | None,
    announce: Callable[[str], None],
) -> tuple[Side, ...]:
    """Return both sides; scenes are solved, studies are read as they were written.

    Raises
    ------
    InputError
        If one cannot be read, a scene is held against a study, or models are named for studies.
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
            "--frequency are for scenes; leave them out"
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
    which = chosen(values, models, quantities, Statement("", {}, (), (), ()))
    scene, origins = load_scene(name, [*overrides, f"models={','.join(which[0])}"])
    announce(f"scene {name}")
    solution = solve(scene, *which, announce)
    rows = (row for q in solution.quantities for row in quantity_rows(q))
    numbers, missing = _numbered(
        ["" if cell is None else str(cell) for cell in row] for row in rows
    )
    return Side(name, _inputs(scene, origins), numbers, missing, scene, ())


def _study(folder: Path) -> Side:
    statement = read_statement(folder)
    scene = checked_scene({**statement.values, "models": list(statement.models)})
    path = folder / TABLE
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        head, axes = rows[0], len(statement.axes)
        if tuple(head[axes:]) != COLUMNS:
            raise ValueError("other columns")
        numbers, missing = _numbered(
            (tuple(zip(head[:axes], row[:axes], strict=True)), *row[axes:]) for row in rows[1:]
        )
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(
            f"{path} cannot be read ({reason}); finish the study with tactgen whatif --resume "
            f"--out {folder}"
        ) from None
    except (ValueError, IndexError, csv.Error) as error:
        raise InputError(
            f"{path} is not the table of a study ({error}); write it again with tactgen whatif "
            f"--resume --out {folder}"
        ) from None
    varied = {f"axis {axis.key}": axis.text for axis in statement.axes}
    inputs = {k: v for k, v in _inputs(scene, {}).items() if f"axis {k}" not in varied}
    return Side(str(folder), inputs | varied, numbers, missing, scene, tuple(head[:axes]))


def _inputs(scene: Scene, origins: dict[str, str]) -> dict[str, str]:
    rows = parameter_rows(scene, origins)
    found = {row.key: row.written for row in rows if row.key not in ("name", "description")}
    for key in ("models", "quantities"):
        names = getattr(scene, key)
        if len(names) > _LISTED:
            found[key] = f"{', '.join(names[:2])} and {len(names) - 2} more"
    stated = scene.frequency
    if len(stated) > _LISTED:
        ends = f"{stated[0]:g}, {stated[1]:g} … {stated[-1]:g} Hz"  # the second tells the spacing
        found["frequency"] = f"{len(stated)} values: {ends}"
    return found


def _numbered(
    rows: Iterable[Sequence[object]],
) -> tuple[dict[Key, Number], dict[Key, str]]:
    """Return numbers and what is missing from rows of the tidy table; the point may lead them."""
    numbers: dict[Key, Number] = {}
    missing: dict[Key, str] = {}
    for row in rows:
        point: tuple[tuple[str, str], ...] = ()
        if row and isinstance(row[0], tuple):
            point, row = row[0], row[1:]
        cells = dict(zip(COLUMNS, (str(cell) for cell in row), strict=True))
        key = Key(point, cells["quantity"], cells["model"], cells["frequency"], cells["index"])
        if cells["value"] == "":
            missing[key] = cells["reason"]
            continue
        value = complex(float(cells["value"]), float(cells["value_im"] or 0.0))
        numbers[key] = Number(value, float(cells["uncertainty"] or "nan"), cells["unit"])
    return numbers, missing
