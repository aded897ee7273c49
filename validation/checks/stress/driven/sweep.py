"""One key of a scene driven over many decades: what a model says, held against a second one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from tactgen.validation.checks.coverage.result import PROMISED
from tactgen.validation.checks.stress.answers import REFUSALS, Family
from tactgen.validation.checks.stress.result import FAR, Row, answered
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import Scene, load_scene

#: Overrides of one point of a sweep, with its name for people.
Point = tuple[str, tuple[str, ...]]


@dataclass(frozen=True)
class Sweep:
    """A key over its range.

    Attributes
    ----------
    family, what : str
        Name and range, for people.
    points : tuple of (str, tuple of str)
        Each with the scene's overrides there.
    quick : tuple of int
        Which of them a quick run takes.
    """

    family: str
    what: str
    points: tuple[Point, ...]
    quick: tuple[int, ...] = (0, -1)

    def chosen(self, quick: bool) -> Iterable[Point]:
        """Return the points of a run."""
        return [self.points[i] for i in self.quick] if quick else self.points


def decades(key: str, unit: str, low: int, high: int, *more: str, step: int = 1) -> list[Point]:
    """Return the points 10^low to 10^high of a key, with other overrides that are the same."""
    return [
        (f"{key} = 1e{power} {unit}".rstrip(), (f"{key}=1e{power} {unit}".rstrip(), *more))
        for power in range(low, high + 1, step)
    ]


@dataclass(frozen=True)
class Pair:
    """Two models of the same numbers.

    Attributes
    ----------
    judged, witness : str
        Whose bars are judged, and by whom.
    quantities : tuple of str
        What both give.
    scene : str
        What is driven.
    form : float
        Relative difference that the two theories may have beside their bars.
    """

    judged: str
    witness: str
    quantities: tuple[str, ...]
    scene: str
    form: float = 0.0

    def row(self, sweep: Sweep, quick: bool) -> Row:
        """Return what the judged model says over a sweep."""
        name = f"{self.judged}: {sweep.family}"
        return driven(name, sweep, self.scene, self.add, quick, promised=PROMISED)

    def add(self, family: Family, where: str, scene: Scene) -> None:
        """Solve a scene by both models, and take every quantity."""
        found = solve(scene, (self.judged, self.witness), self.quantities)
        for name in self.quantities:
            one, other = (found.get(name, model) for model in (self.judged, self.witness))
            error, bound = worst(one, other)
            family.add(f"{where}, {name}", error, bound + self.form)


def driven(
    name: str,
    sweep: Sweep,
    scene: str,
    add: Callable[[Family, str, Scene], None],
    quick: bool,
    promised: float = 1.0,
) -> Row:
    """Return the row of a sweep whose points `add` judges; what refuses is quoted.

    `promised` is the share of answers that their bars promise to hold.
    """
    family = Family()
    for where, overrides in sweep.chosen(quick):
        try:
            add(family, where, load_scene(scene, list(overrides))[0])
        except REFUSALS as error:
            family.refuse(error)
    return answered(name, sweep.what, family.points, family.refusals, promised=promised)


def worst(one: Quantity, other: Quantity) -> tuple[float, float]:
    """Return relative error and bar of the entry that misses its bar by most; nan for no number.

    Of a curve's many entries as many are passed over as their bars do not promise to hold, unless
    one is far off.  Entries of which the list is about are compared as far as both go; a value of
    0 counts in units of the list's largest.
    """
    values, right = np.ravel(one.value), np.ravel(other.value)
    both = min(values.size, right.size)
    values, right = values[:both], right[:both]
    bars = np.ravel(one.error)[:both] + np.ravel(other.error)[:both]
    if not np.isfinite(values).all() or not np.isfinite(bars).all():
        return np.nan, 0.0
    size = np.abs(right)
    size = np.where(size > 0.0, size, max(float(size.max(initial=0.0)), np.finfo(float).tiny))
    errors, bars = np.abs(values - right) / size, bars / size
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(errors == 0.0, 0.0, errors / bars)
    by_ratio = np.argsort(ratio)
    at = by_ratio[-1]
    if ratio[at] <= FAR:
        at = by_ratio[-1 - int((1.0 - PROMISED) * both)]
    return float(errors[at]), float(bars[at])
