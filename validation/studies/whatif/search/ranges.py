"""Ranges of keys in which values are searched."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.studies.whatif.asked.scene_field import scene_field
from tactgen.validation.studies.whatif.asked.statement import Statement

#: Two ends, perhaps with their spacing, and no count.
_RANGE = re.compile(r"[^:]+:[^:]+(:\s*(log|lin)\s*)?")


@dataclass(frozen=True)
class Range:
    """A key that may lie anywhere between two values (SI), spaced by ratio if `logarithmic`."""

    key: str
    low: float
    high: float
    logarithmic: bool = False

    def at(self, share: float) -> float:
        """Return the value at a share from 0 to 1 of the range."""
        share = min(max(share, 0.0), 1.0)
        if share in (0.0, 1.0):  # to the last bit
            return self.high if share else self.low
        if self.logarithmic:
            return float(self.low * (self.high / self.low) ** share)
        return float(self.low + share * (self.high - self.low))

    def share(self, value: float) -> float:
        """Return the share of the range at which a value lies, or its nearer end."""
        if self.logarithmic:
            found = math.log(max(value, self.low) / self.low) / math.log(self.high / self.low)
        else:
            found = (value - self.low) / (self.high - self.low)
        return min(max(found, 0.0), 1.0)


def ranges_of(statement: Statement) -> tuple[Range, ...]:
    """Return the ranges that a statement's axes state.

    Raises
    ------
    InputError
        For an axis that is no range of a number.
    """

    def no_range(text: str) -> InputError:
        return InputError(
            f"--vary {quoted(text)} is no range to search; write KEY=LOW:HIGH, for example --vary "
            "bimorph.length=14mm:22mm"
        )

    for text in statement.vary:
        _, equals, stated = text.partition("=")
        if equals and not _RANGE.fullmatch(stated):
            raise no_range(text)
    found = []
    for axis in statement.axes:
        drawn = axis.drawn
        if drawn is None:  # words may hold a colon
            raise no_range(f"{axis.key}={axis.text}")
        if scene_field(axis.key).whole:
            raise InputError(
                f"--vary {axis.key}: whole numbers are not searched; try each with tactgen whatif"
            )
        found.append(Range(axis.key, drawn.first, drawn.second, drawn.kind == "loguniform"))
    return tuple(found)
