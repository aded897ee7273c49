"""Compute a written report's numbers again, and compare them one by one."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.answers import quantity_from_json
from tactgen.validation.engine.origin import Origin, this_origin
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.report.provenance import checksums
from tactgen.validation.report.provenance.record import (
    Record,
    read_record,
    recorded_scene,
)

Verdict = Literal["identical", "within bars", "differs"]


@dataclass(frozen=True)
class Compared:
    """One quantity of one model, then and now.

    Attributes
    ----------
    difference : float
        Largest difference over the largest magnitude; nan where the two cannot be compared.
    over_bars : float
        Largest difference over the sum of the two error bars; infinite without bars.
    """

    name: str
    model: str
    verdict: Verdict
    difference: float
    over_bars: float


@dataclass(frozen=True)
class Reproduction:
    """A report that was computed again.

    Attributes
    ----------
    rows : tuple of Compared
        Every quantity of either run.
    elsewhere : tuple of str
        What of the machine and the libraries is another than then.
    """

    scene: str
    rows: tuple[Compared, ...]
    elsewhere: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether nothing differs beyond its bars."""
        return all(row.verdict != "differs" for row in self.rows)


def reproduce(path: Path, announce: Callable[[str], None]) -> Reproduction:
    """Compute the report at a path again, from nothing, and compare it.

    Parameters
    ----------
    path : Path
        The folder of a report, or a file in it.

    Raises
    ------
    InputError
        If there is no whole report, if it was altered, or if another version wrote it.
    """
    folder = path if path.is_dir() else path.parent
    if not path.exists():
        raise InputError(f"{path} does not exist; name the folder of a report or a file in it")
    checksums.check(folder)
    record = read_record(folder)
    here = this_origin()
    _check_version(record.made_by, here)
    scene = recorded_scene(record)
    with _own_store():
        again = solve(scene, announce=announce)
    then = [quantity_from_json(plain) for plain in record.quantities]
    return Reproduction(record.name, compared(then, again.quantities), _elsewhere(record, here))


def compared(then: Sequence[Quantity], now: Sequence[Quantity]) -> tuple[Compared, ...]:
    """Return every quantity of two runs with the verdict on it."""
    before = {(q.name, q.model): q for q in then}
    after = {(q.name, q.model): q for q in now}
    return tuple(
        _compared(key, before.get(key), after.get(key)) for key in dict.fromkeys([*before, *after])
    )


def _compared(key: tuple[str, str], then: Quantity | None, now: Quantity | None) -> Compared:
    if then is None or now is None or not _alike(then, now):
        return Compared(*key, "differs", np.nan, np.inf)
    known = ~np.isnan(then.value)
    apart = np.abs(now.value - then.value)[known]
    bars = np.broadcast_to(then.error + now.error, then.value.shape)[known]
    size = float(np.max(np.abs(then.value[known]), initial=0.0))
    largest = float(np.max(apart, initial=0.0))
    difference = largest / size if size else largest
    if largest == 0.0:
        return Compared(*key, "identical", 0.0, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(apart == 0.0, 0.0, np.where(bars > 0.0, apart / bars, np.inf))
    worst = float(np.max(shares))
    return Compared(*key, "within bars" if worst <= 1.0 else "differs", difference, worst)


def _alike(then: Quantity, now: Quantity) -> bool:
    """Return whether two answers are numbers about the same things."""
    return (
        then.value.shape == now.value.shape
        and then.classes == now.classes
        and then.frequency == now.frequency
        and bool(np.array_equal(np.isnan(then.value), np.isnan(now.value)))
    )


def _check_version(then: Origin, here: Origin) -> None:
    if (then.version, then.code) != (here.version, here.code):
        raise InputError(
            f"the report was written by tactgen {then.version} with code {then.code[:12]} (commit "
            f"{then.commit}), and this is {here.version} with code {here.code[:12]}; reproduce it "
            "with the version that wrote it"
        )


def _elsewhere(record: Record, here: Origin) -> tuple[str, ...]:
    then = record.made_by
    pairs = {
        **{name: (then.libraries.get(name, "none"), v) for name, v in here.libraries.items()},
        "linear solver": (then.solver, here.solver),
        "Python": (then.python, here.python),
        "machine": (then.machine, here.machine),
    }
    return tuple(f"{name}: {a} then, {b} now" for name, (a, b) in pairs.items() if a != b)


@contextmanager
def _own_store() -> Iterator[None]:
    """Let nothing that was kept answer: an empty store for as long as this lasts."""
    before = os.environ.get("TACTGEN_CACHE")
    with tempfile.TemporaryDirectory(prefix="tactgen-") as folder:
        os.environ["TACTGEN_CACHE"] = folder
        try:
            yield
        finally:
            if before is None:
                del os.environ["TACTGEN_CACHE"]
            else:
                os.environ["TACTGEN_CACHE"] = before
