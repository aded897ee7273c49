"""What differs between two sides, and whether the error bars cover it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tactgen.validation.studies.whatif.compare.sides import Key, Number, Side

#: Rounding of numbers that are written and read, and of one order of summation for another.
_ROUNDING = 1e-13


@dataclass(frozen=True)
class InputDifference:
    """A key with its value on both sides; empty where one has none."""

    key: str
    first: str
    second: str


@dataclass(frozen=True)
class AnswerDifference:
    """One quantity by one model on both sides.

    Attributes
    ----------
    count, beyond : int
        How many numbers both have, and how many of them differ by more than both bars together.
    only : (int, int)
        How many numbers only the one and only the other has.
    key : Key
        Where the difference is largest, in bars beyond them or else relative to the value.
    first, second : Number
        There.
    """

    quantity: str
    model: str
    count: int
    beyond: int
    only: tuple[int, int]
    key: Key
    first: Number
    second: Number

    @property
    def relative(self) -> float:
        """Change from the first to the second where it is largest, of the magnitudes."""
        return _relative(self.first, self.second)

    @property
    def verdict(self) -> str:
        """What the bars say of the change, in words."""
        if not self.beyond:
            return "the same" if self.relative == 0.0 else "covered by the bars"
        of = "" if self.count == 1 else f" at {self.beyond} of {self.count} values"
        return f"beyond the bars{of}"


def input_differences(first: Side, second: Side) -> list[InputDifference]:
    """Return the keys whose values differ, in the order of the scene."""
    keys = dict.fromkeys((*first.inputs, *second.inputs))
    found = [InputDifference(k, first.inputs.get(k, ""), second.inputs.get(k, "")) for k in keys]
    return [each for each in found if each.first != each.second]


def answer_differences(first: Side, second: Side) -> list[AnswerDifference]:
    """Return every quantity and model that both have, with what differs most."""
    return list(_differences(first, second))


def _differences(first: Side, second: Side) -> Iterator[AnswerDifference]:
    groups: dict[tuple[str, str], list[Key]] = {}
    for key in dict.fromkeys((*first.numbers, *second.numbers)):
        groups.setdefault((key.quantity, key.model), []).append(key)
    for (quantity, model), keys in groups.items():
        both = [key for key in keys if key in first.numbers and key in second.numbers]
        only = (
            sum(key not in second.numbers for key in keys),
            sum(key not in first.numbers for key in keys),
        )
        if not both:
            continue
        pairs = [(first.numbers[key], second.numbers[key]) for key in both]
        beyond = [_beyond(*pair) for pair in pairs]
        weight = [(out, abs(_relative(*pair))) for out, pair in zip(beyond, pairs, strict=True)]
        worst = max(range(len(both)), key=weight.__getitem__)
        yield AnswerDifference(
            quantity, model, len(both), sum(beyond), only, both[worst], *pairs[worst]
        )


def _beyond(first: Number, second: Number) -> bool:
    """Return whether two numbers differ by more than both bars together."""
    if _unknown(first) or _unknown(second):
        return _unknown(first) != _unknown(second)
    rounding = _ROUNDING * max(abs(first.value), abs(second.value))
    bars = sum(0.0 if math.isnan(each.error) else each.error for each in (first, second))
    return bool(abs(first.value - second.value) > bars + rounding)


def _unknown(number: Number) -> bool:
    return bool(np.isnan(number.value))


def _relative(first: Number, second: Number) -> float:
    if _unknown(first) or _unknown(second):
        return 0.0
    before, after = (
        (each.value.real if each.value.imag == 0.0 else abs(each.value)) for each in (first, second)
    )
    if before == after:
        return abs(first.value - second.value) / abs(before) if before else 0.0
    return after / before - 1.0 if before else math.inf
