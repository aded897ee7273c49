"""The run behind ``tactgen coverage``: parts, their devices, and what came out."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.store.store import kept
from tactgen.validation.checks.coverage import PARTS
from tactgen.validation.checks.coverage.result import Judged, Row, rows
from tactgen.validation.scene.files import built_in_texts

#: What computes answers and is loaded by names in strings.
_CODE = ("tactgen.validation.models", "tactgen.fem", "tactgen.tmm")


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


def judged_once(kind: str, of: tuple[object, ...], module: str, work: Callable[[], Any]) -> Any:
    """Return what `work` gives, from the store if this code has judged the same before.

    A run that was stopped so goes on where it was.

    Parameters
    ----------
    kind : str
        What the store lists it as.
    of : tuple
        What is judged, with the seed that it is drawn by.  The built-in scenes count, too: all is
        made of them.
    module : str
        What judges.
    """
    return kept(kind, (*of, built_in_texts()), (module, *_CODE), work)


def run_parts(
    names: Sequence[str], devices: int | None, seed: int, announce: Callable[[str], None]
) -> list[Part]:
    """Judge as many random devices for each part; each device has a stream of its own.

    So more devices of a seed are the same ones and others besides.
    """
    found = []
    for name in names:
        module, function, usual, what = PARTS[name]
        count = usual if devices is None else devices
        answers: list[Judged] = []
        for number in range(count):
            announce(f"{name}: device {number + 1} of {count}")

            def work(module: str = module, function: str = function, number: int = number) -> Any:
                judge = getattr(importlib.import_module(module), function)
                return tuple(judge(np.random.default_rng([seed, number])))

            answers += judged_once("coverage", (name, seed, number), module, work)
        found.append(Part(name, what, seed, count, tuple(answers)))
    return found
