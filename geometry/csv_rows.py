"""CSV files: what a user wrote, by lines and cells, or a sentence why not; and tables for others.

What the columns mean is the readers' business.
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeAlias

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import read_text, written_whole

#: Line number in the file, and the cells of that line.
Row: TypeAlias = tuple[int, list[str]]

#: A number as other programs write it; Python's float also takes 1_0, nan and other digits.
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d{1,4})?", re.IGNORECASE | re.ASCII)


def csv_rows(path: str | Path, name: str, remedy: str) -> list[Row]:
    """Return the lines that are not empty, the header first, each split into stripped cells.

    Separated by comma, semicolon or tab, whichever the first line has most of; comments go
    from ``#`` to the end of the line; a byte order mark is skipped.

    Parameters
    ----------
    path : path
        The file, UTF-8 text.
    name : str
        What messages call it.
    remedy : str
        What to give instead of a file that cannot be read or is empty.

    Raises
    ------
    InputError
        If the file cannot be read, is empty, or a line is not CSV.
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
    """Return the finite number that a cell holds, None if it holds anything else."""
    value = float(cell) if _NUMBER.fullmatch(cell) else math.nan
    return value if math.isfinite(value) else None


def check_widths(rows: list[Row], name: str, *, short: bool = False) -> None:
    """Refuse lines with more cells than the header, such as those of a decimal comma.

    `short` lines, with fewer, are let pass where the last columns are not needed.

    Raises
    ------
    InputError
        Naming the line.
    """
    (_, header), *others = rows
    for number, cells in others:
        if len(cells) > len(header) or (len(cells) < len(header) and not short):
            raise InputError(
                f"{name} line {number} has {len(cells)} cells where the header has {len(header)} "
                "columns; fill or remove that line, and write decimals with a point"
            )


def _without_comment(line: str) -> str:
    """Return a line up to the first ``#`` outside quotes."""
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
