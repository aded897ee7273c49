"""Columns of a CSV file by name and unit, in SI.

A heading is a name with its unit in brackets, such as ``frequency (Hz)``.  Nothing is repaired or
guessed; which columns there may be is the readers' business.
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import read_text, written_whole
from tactgen.geometry.units import NUMBER, Unit, quoted

#: Line number in the file, and the cells of that line.
Row: TypeAlias = tuple[int, list[str]]

T = TypeVar("T")

#: A number as other programs write it; Python's float also takes 1_0, nan and other digits.
_NUMBER = re.compile(NUMBER, re.IGNORECASE | re.ASCII)


def csv_rows(path: str | Path, name: str, remedy: str) -> list[Row]:
    """Lines that are not empty, the header first, each split into stripped cells.

    Separated by comma, semicolon or tab, whichever the first line has most of; comments go
    from ``#`` to the end of the line; a byte order mark is skipped.  Messages call the file, UTF-8
    text, `name`, and `remedy` is what to give instead of one that cannot be read or is empty.

    Raises InputError if the file cannot be read, is empty, or a line is not CSV.
    """
    try:
        text = read_text(path)  # spreadsheets begin with a byte order mark
    except UnicodeDecodeError:
        raise InputError(
            f"{name} is not UTF-8 text; save the table as CSV with UTF-8 encoding"
        ) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{name} cannot be read ({reason.lower()}); {remedy}") from None
    lines = [
        (number, line)
        for number, line in enumerate(map(_without_comment, text.split("\n")), start=1)
        if line.strip(" \t\r,;")
    ]
    if not lines:
        raise InputError(f"{name} is empty; {remedy}")
    counts = Counter(c for c in lines[0][1] if c in ",;\t")
    separator = counts.most_common(1)[0][0] if counts else ","
    # each line by itself: what quotes leave open would join lines and shift their numbers
    return [(number, _cells(line, separator, f"{name} line {number}")) for number, line in lines]


def plain_number(cell: str) -> float | None:
    """Finite number that a cell holds, None if it holds anything else."""
    value = float(cell) if _NUMBER.fullmatch(cell) else math.nan
    return value if math.isfinite(value) else None


def _without_comment(line: str) -> str:
    """Line up to the first ``#`` outside quotes."""
    for at, character in enumerate(line):
        if character == "#" and line.count('"', 0, at) % 2 == 0:
            return line[:at]
    return line


def _cells(line: str, separator: str, where: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, strict=True))]
    except csv.Error as error:
        raise InputError(f"{where} is not CSV ({error}); save the table as plain CSV") from None


def write_csv(path: Path, head: Iterable[str], rows: Iterable[Iterable[Any]]) -> Path:
    """Write a table with its column names, whole or not at all, and return its path."""
    with written_whole(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as f:
        writer = csv.writer(f)
        writer.writerow(head)
        writer.writerows(rows)
    return path


_HEADING = re.compile(r"(?P<name>[^()\[\]]*)(?:[(\[](?P<unit>.*)[)\]])?\s*")


def heading(text: str) -> tuple[str, str]:
    """Name, in small letters with underscores, and unit of a column heading.

    Both may be empty; no name if it is unreadable.
    """
    parts = _HEADING.fullmatch(text)
    if parts is None:
        return "", ""
    name = parts["name"].strip().lower().replace(" ", "_")
    return name, (parts["unit"] or "").strip()


def _scale_to_si(name: str, text: str, unit: Unit, where: str) -> float:
    """Factor from the unit that a heading states to SI.

    Raises InputError if the unit is missing or not one of that kind.
    """
    if not unit.si:
        if text not in ("", "1", "-"):
            raise InputError(
                f'{where}: column "{name}" has the unit {quoted(text)}, but a {unit.kind} has '
                f'none; name the column "{name}"'
            )
        return 1.0
    example = unit.example.split(" ", 1)[-1]
    if not text:
        raise InputError(
            f'{where}: column "{name}" has no unit; write for example "{name} ({example})"'
        )
    try:
        return unit.parse(f"1 {text}")
    except ValueError:
        raise InputError(
            f'{where}: column "{name}" has the unit {quoted(text)}, which is not that of '
            f'{unit.a_kind}; write for example "{name} ({example})"'
        ) from None


def _value(text: str, scale: float, unit: Unit, where: str) -> float:
    """Cell's number in SI units, `scale` being the factor to them.

    Raises InputError if it is no possible number.
    """
    if not text:
        raise InputError(f"{where} the cell is empty; fill it or remove the line")
    number = plain_number(text)
    if number is None:
        remedy = "write decimals with a point" if "," in text else "correct it or remove the line"
        raise InputError(f"{where} {quoted(text)} is not a finite number; {remedy}")
    value = number * scale
    low, high = unit.limits or (0.0, np.inf)
    if value and not low <= abs(value) <= high:
        raise InputError(
            f"{where} {quoted(text)} is not a possible {unit.kind} (magnitude {unit.show(low)} to "
            f"{unit.show(high)}); check the value and the unit in the header"
        )
    return value


def remembered(read: Callable[[Path], T], file: str) -> T:
    """What a reader makes of a file, read again only when it has changed; refused as by it."""
    path = Path(file)
    try:
        state = path.stat()
    except (OSError, ValueError):
        return read(path)  # which says what is wrong
    found: T = _read(read, path, state.st_mtime_ns, state.st_size)
    return found


@lru_cache(maxsize=32)
def _read(read: Callable[[Path], Any], path: Path, _changed: int, _size: int) -> Any:
    return read(path)


class Table(NamedTuple):
    """Numbers of a file in SI units by column name, and the line that each row is on."""

    columns: dict[str, Floats]
    lines: list[int]


def read_columns(
    path: str | Path,
    name: str,
    known: Mapping[str, Unit],
    example: str,
    needed: Iterable[str],
    *,
    remedy: str = "",
    others: bool = False,
) -> Table:
    """Columns of a CSV file with a header (:func:`csv_rows`), by name and unit.

    Messages call the file `name`, and name `example`, a header that would do, and `remedy`, what to
    give instead of a file that cannot be read.  `known` says what a column of each name measures,
    `needed` which must be there; `others` are ignored, or refused.

    Raises InputError in one sentence with file, line, column, value and remedy.
    """
    remedy = remedy or f"give a CSV file with the columns {example}"
    (number, names), *rows = csv_rows(path, name, remedy)
    where = f"{name} line {number}"
    columns: dict[str, tuple[int, float]] = {}  # place, factor to SI
    for at, text in enumerate(names):
        column, unit = heading(text)
        if column not in known:
            if others:
                continue
            raise InputError(
                f"{where}: column {at + 1} {quoted(text)} is unknown; name the columns like "
                f"{example} and remove those that are not needed"
            )
        if column in columns:
            raise InputError(f"{where}: column {quoted(text)} is there twice; keep one of them")
        columns[column] = at, _scale_to_si(column, unit, known[column], where)
    for column in needed:
        if column not in columns:
            raise InputError(
                f"{where}: there is no {column} column; name the columns like {example}"
            )
    for line, cells in rows:
        if len(cells) > len(names) or (len(cells) < len(names) and not others):
            raise InputError(
                f"{name} line {line} has {len(cells)} cells where the header has {len(names)} "
                "columns; fill or remove that line, and write decimals with a point"
            )
        cells += [""] * (len(names) - len(cells))
    found: dict[str, Floats] = {}
    for column, (at, scale) in columns.items():
        place = f"column {quoted(names[at])}:"
        found[column] = np.array(
            [_value(row[at], scale, known[column], f"{name} line {n}, {place}") for n, row in rows]
        )
    return Table(found, [line for line, _ in rows])


def read_table(path: str | Path, name: str, known: Mapping[str, Unit], example: str) -> Table:
    """Columns of a file over ascending frequencies; as :func:`read_columns`, and refused alike."""
    table = read_columns(path, name, known, example, ("frequency",))
    before, line_before = 0.0, 0
    for f, line in zip(table.columns["frequency"], table.lines, strict=True):
        if f <= 0.0:
            wrong = "is not above 0; remove the line"
        elif f == before:
            wrong = f"repeats that of line {line_before}; keep one of the two, or their mean"
        elif f < before:
            wrong = f"follows {before:g} Hz; sort the lines by frequency"
        else:
            before, line_before = f, line
            continue
        raise InputError(f"{name} line {line}: frequency {f:g} Hz {wrong}")
    return table
