"""One key of a scene driven over many decades: what a model says, held against a second one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.coverage import PROMISED
from tactgen.validation.evidence.random_devices import any_scene
from tactgen.validation.evidence.stress import (
    FAR,
    REFUSALS,
    Asked,
    Family,
    Point,
    Row,
    Stress,
    answered,
)
from tactgen.validation.scene.scene import Scene, load_scene

#: Overrides of one point of a sweep, with its name for people.
SweepPoint = tuple[str, tuple[str, ...]]


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
    points: tuple[SweepPoint, ...]
    quick: tuple[int, ...] = (0, -1)

    def chosen(self, quick: bool) -> Iterable[SweepPoint]:
        """Return the points of a run."""
        return [self.points[i] for i in self.quick] if quick else self.points


def decades(
    key: str, unit: str, low: int, high: int, *more: str, step: int = 1
) -> list[SweepPoint]:
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


_STATEMENT = (
    "Each answer agrees with the second model's within the bars of both, 19 of 20 and none by "
    "three bars; what cannot be answered is refused in one sentence. A point that ended otherwise, "
    "or not within {endless:g} s of processor time, fails; it names the overrides that repeat it."
)
#: Seconds of processor time after which a scene counts as endless: usual is a tenth of one.
_ENDLESS = 20.0

_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
# lumped takes the row element by element: 1e-6 for what rounding does to extremes
_LUMPED = Pair("lumped", "tmm", _STATIC, "prototype", form=1e-6)
_BEAM = Pair(
    "beam", "tmm",
    (*_STATIC, "short_circuit_frequencies", "coupling_factor", "tip_displacement", "admittance"),
    "prototype", form=1e-12,
)  # fmt: skip
_MACHINE = Pair(
    "beam", "tmm",
    ("lateral_tip_per_voltage", "axial_tip_per_voltage", "axial_tip_per_current",
     "lateral_tip_per_current", "axial_tip_per_coil_voltage", "coil_impedance", "axial_poles"),
    "generator", form=1e-12,
)  # fmt: skip

#: Scenes of a run, and of a quick one.
_SCENES, _QUICK = 2000, 16


def run(asked: Asked) -> Stress:
    """Run them: seconds if quick, else half an hour."""
    started = time.perf_counter()
    rows = random_rows(asked, _QUICK if asked.quick else _SCENES)
    statement = _STATEMENT.format(endless=_ENDLESS)
    return Stress("random", statement, rows, (), (), time.perf_counter() - started)


def random_rows(asked: Asked, count: int) -> tuple[Row, ...]:
    """Return the rows of so many scenes, each with a stream of its own: bimorphs, machines."""
    seed = asked.seed
    families = {"prototype": Family(), "generator": Family()}
    scenes = dict.fromkeys(families, 0)
    for number in range(count):
        asked.announce(f"random scene {number + 1} of {count}, seed {seed}")
        name, overrides = any_scene(np.random.default_rng([seed, number]))
        points, refusals = asked.keep((number,), partial(_judged, name, overrides))
        scenes[name] += 1
        families[name].points += points
        families[name].refusals += refusals
    return tuple(
        answered(
            f"random: {name}", f"{scenes[name]} scenes, seed {seed}", f.points, f.refusals,
            promised=PROMISED,
        )
        for name, f in families.items()
    )  # fmt: skip


def _judged(name: str, overrides: list[str]) -> tuple[list[Point], list[str]]:
    """Return points and refusals of one scene; what else it raises is one that fails."""
    family, where = Family(), f"{name} {'; '.join(overrides)}"
    started = time.process_time()
    try:
        scene, _ = load_scene(name, overrides)
        for pair in (_LUMPED, _BEAM) if name == "prototype" else (_MACHINE,):
            pair.add(family, where, scene)
    except REFUSALS as error:
        family.refuse(error)
    except Exception as error:  # noqa: BLE001 what a user would see as a traceback
        family.add(f"{where}: {type(error).__name__}: {error}", np.inf, 0.0)
    if time.process_time() - started > _ENDLESS:
        family.add(f"{where}: endless", np.inf, 0.0)
    return family.points, family.refusals
