"""The run behind ``tactgen coverage``: parts, their devices, and what came out."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.validation.checks.coverage import PARTS
from tactgen.validation.checks.coverage.result import Judged, Row, rows


@dataclass(frozen=True)
class Part:
    """One model's bars: what was drawn and what came out.

    Attributes
    ----------
    name, what : str
        The part, and what it holds against what.
    seed, devices : int
        How to draw the same devices again, and how many.
    """

    name: str
    what: str
    seed: int
    devices: int
    answers: tuple[Judged, ...]

    @property
    def rows(self) -> list[Row]:
        """One row a quantity, the last of all of them."""
        return rows(self.answers)

    @property
    def holds(self) -> bool:
        """Whether every row does."""
        return all(row.holds for row in self.rows)


def run_parts(
    names: Sequence[str], devices: int | None, seed: int, announce: Callable[[str], None]
) -> list[Part]:
    """Judge as many random devices for each part; each device has a stream of its own.

    So more devices of a seed are the same ones and others besides.
    """
    found = []
    for name in names:
        module, usual, what = PARTS[name]
        judge: Callable[[np.random.Generator], list[Judged]] = importlib.import_module(module).judge
        count = usual if devices is None else devices
        answers: list[Judged] = []
        for number in range(count):
            announce(f"{name}: device {number + 1} of {count}")
            answers += judge(np.random.default_rng([seed, number]))
        found.append(Part(name, what, seed, count, tuple(answers)))
    return found
