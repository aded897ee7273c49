"""One key of a scene driven over many decades: what a model says, held against a second one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np

from tactgen.tmm.ports.finger import FINGER_RANGE
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.coverage import PROMISED
from tactgen.validation.evidence.random_devices import between
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

#: What a scene may say of a key: from, to and unit, even on a logarithmic scale; or a choice.
_Says = tuple[float, float, str] | tuple[str, ...]
_SIZES: dict[str, _Says] = {
    "bimorph.length": (2.0, 80.0, "mm"),
    "bimorph.piezo_thickness": (0.01, 1.0, "mm"),
    "bimorph.shim_thickness": (0.01, 1.0, "mm"),
}
_BIMORPH: dict[str, _Says] = {
    "bimorph.width": (0.2, 10.0, "mm"),
    "bimorph.tab_length": (0.05, 5.0, "mm"),
    "bimorph.bare_below": (0.01, 2.0, "mm"),
    "bimorph.bare_above": (0.01, 2.0, "mm"),
    "bimorph.glue_thickness": (1e-3, 0.1, "mm"),
    "bimorph.wiring": ("parallel", "series"),
    "piezo.material": ("M1876", "PZT-5H", "PZT-5A"),
    "piezo.quality_factor": (5.0, 1e3, ""),
    "shim.material": ("brass", "titanium"),
    "load.kind": ("none", "mass", "spring_damper", "finger"),
    "load.mass": (1e-2, 1e4, "mg"),
    "load.stiffness": (1e-1, 1e6, "N/m"),
    "load.damping": (1e-5, 1e1, "N*s/m"),
    "drive.voltage": (1e-3, 50.0, "V"),
    "modes": ("1", "3", "6"),
}
_SUPPORT: dict[str, _Says] = {
    "support.kind": ("clamped", "spring"),
    "support.rotational_stiffness": (1e-3, 1e3, "N*m/rad"),
    "support.rotational_damping": (1e-9, 1e-3, "N*m*s/rad"),
}
_ROD: dict[str, _Says] = {
    "coil.current": (1e-3, 1e3, "mA"),
    "coil.history": ("rising", "falling"),
    "coil.supply": ("current", "voltage"),
    "coil.source_resistance": (1e-3, 1e6, "ohm"),
    "coil.turns": ("10", "200", "560", "2000"),
    "gap": (60.0, 600.0, "um"),
    "spring.preload": (1e-3, 1e3, "mN"),
    "spring.stiffness": (1.0, 1e6, "N/m"),
    "spring.eccentricity": (1e-3, 1.0, "mm"),
    "spring.stop_gap": (1.0, 100.0, "um"),
    "contact.shape": ("ring", "disc"),
    "contact.decay_length": (1e-3, 100.0, "um"),
    "contact.relaxation_time": (1e-3, 1e3, "us"),
    "contact.lower_decay_ratio": (1e-2, 1e2, ""),
    "contact.tangential_ratio": (1e-1, 1.0, ""),
    "contact.friction": (1e-3, 1.0, ""),
    "guide.axial_damping": (1e-6, 1e2, "N*s/m"),
    "guide.lateral_stiffness": (1.0, 1e9, "N/m"),
    "guide.rotational_stiffness": (1e-6, 1e3, "N*m/rad"),
    "guide.clearance": (1e-3, 1e2, "um"),
    "load.normal_force": (1e-3, 1e3, "mN"),
    "steel.curve": ("team20", "linear"),
    "rod.head_thickness": (0.1, 2.0, "mm"),
    "sleeve.collar_thickness": (0.05, 2.0, "mm"),
}
#: Frequencies (Hz) of a scene; share of those that a finger presses which stay within its law.
_FREQUENCIES, _WITHIN = (1.0, 2e4), 0.9
#: Scenes of a run, and of a quick one; most keys of one beside its sizes; share of machines.
_SCENES, _QUICK, _MOST_KEYS, _MACHINES = 2000, 16, 6, 0.3


def draw(rng: np.random.Generator) -> tuple[str, list[str]]:
    """Return a scene's name and random overrides: a bimorph on springs, or the whole machine."""
    machine = rng.random() < _MACHINES
    keys = _BIMORPH | (_ROD if machine else _SUPPORT)
    some = rng.choice(sorted(keys), size=int(rng.integers(_MOST_KEYS + 1)), replace=False)
    said = {} if machine and rng.random() < 0.5 else {k: _said(rng, v) for k, v in _SIZES.items()}
    said |= {str(key): _said(rng, keys[str(key)]) for key in some}
    pressed = said.get("load.kind", "finger" if machine else "none") == "finger"
    band = FINGER_RANGE if pressed and rng.random() < _WITHIN else _FREQUENCIES
    at = (f"{between(rng, *band):.5g} Hz" for _ in range(int(rng.integers(1, 4))))
    said["frequency"] = ", ".join(at)
    return "generator" if machine else "prototype", [f"{key}={v}" for key, v in said.items()]


def _said(rng: np.random.Generator, says: _Says) -> str:
    low, high, unit = (*says, "", "")[:3]
    if isinstance(low, str):
        return str(rng.choice(says))
    assert isinstance(high, float), says
    return f"{between(rng, low, high):.5g} {unit}".strip()


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
        name, overrides = draw(np.random.default_rng([seed, number]))
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
