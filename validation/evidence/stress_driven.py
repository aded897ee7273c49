"""Scenes with one key driven over its range, and random ones: each model against a second one.

Lumped and beam elements are held against the exact spans of the transfer matrix, which is itself
held against 80 digits elsewhere; tetrahedra of the CAD solids against bricks.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.coverage import PROMISED
from tactgen.validation.evidence.random_devices import any_scene
from tactgen.validation.evidence.stress import (
    FAR,
    Families,
    Family,
    PartRequest,
    Point,
    Row,
    Stress,
)
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

#: A point of a sweep: its name for people, and the overrides of the scene there.
SweepPoint = tuple[str, tuple[str, ...]]


@dataclass(frozen=True)
class Sweep:
    """A key over its range."""

    #: Name and range, for people
    family: str
    what: str
    points: Sequence[SweepPoint]  #: Each with the scene's overrides there
    quick: tuple[int, ...] = (0, -1)  #: Which of them a quick run takes

    def chosen(self, quick: bool) -> Sequence[SweepPoint]:
        """Points of a run."""
        return [self.points[i] for i in self.quick] if quick else self.points


def each(key: str, values: Sequence[object], unit: str = "", *more: str) -> list[SweepPoint]:
    """Points of a key at these values, with other overrides that are the same."""
    said = [f"{key}={value} {unit}".strip() for value in values]
    return [(one, (one, *more)) for one in said]


def decades(
    key: str, unit: str, low: int, high: int, *more: str, step: int = 1
) -> list[SweepPoint]:
    """Points 10^low to 10^high of a key."""
    return each(key, [f"1e{power}" for power in range(low, high + 1, step)], unit, *more)


@dataclass(frozen=True)
class Pair:
    """Two models of the same numbers."""

    #: Whose bars are judged, and by whom
    judged: str
    witness: str
    quantities: tuple[str, ...]  #: What both give
    scene: str  #: What is driven
    form: float = 0.0  #: Relative difference that the two theories may have beside their bars

    def row(self, sweep: Sweep, quick: bool) -> Row:
        """Row of the compared model over a sweep."""
        family = Family(PROMISED)
        for where, overrides in sweep.chosen(quick):
            with family.attempt():
                self.add(family, where, load_scene(self.scene, list(overrides))[0])
        return family.row(f"{self.judged}: {sweep.family}", sweep.what)

    def add(self, family: Family, where: str, scene: Scene) -> None:
        """Solve a scene by both models, and take every quantity."""
        found = solve(scene, (self.judged, self.witness), self.quantities)
        for name in self.quantities:
            one, other = (found.get(name, model) for model in (self.judged, self.witness))
            error, bound = worst(one, other)
            family.add(f"{where}, {name}", error, bound + self.form)


def worst(one: Quantity, other: Quantity) -> tuple[float, float]:
    """Relative error and bar of the entry that misses its bar by most; nan for no number.

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


#: Seconds of processor time after which a scene counts as endless: usual is a tenth of one.
_ENDLESS = 20.0
_STATEMENT = (
    "Each answer agrees with the second model's within the bars of both, 19 of 20 and none by "
    "three bars; what cannot be answered is refused in one sentence. A random scene that ended "
    f"otherwise, or not within {_ENDLESS:g} s of processor time, fails; it names the overrides "
    "that repeat it."
)

_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
# lumped takes the row element by element: 1e-6 for what rounding does to extremes
_LUMPED = Pair("lumped", "tmm", _STATIC, "prototype", form=1e-6)
_BEAM = Pair(
    "beam", "tmm",
    (*_STATIC, "short_circuit_frequencies", "coupling_factor", "tip_displacement", "admittance"),
    "prototype", form=1e-12,
)  # fmt: skip
_CAD = Pair("cad", "solid", ("static_tip_displacement", "capacitance_free"), "j1")
_MACHINE = Pair(
    "beam", "tmm",
    ("lateral_tip_per_voltage", "axial_tip_per_voltage", "axial_tip_per_current",
     "lateral_tip_per_current", "axial_tip_per_coil_voltage", "coil_impedance", "axial_poles"),
    "generator", form=1e-12,
)  # fmt: skip


def _shim(power: float, *more: str) -> SweepPoint:
    """Shim 10^power times as thick as a layer of ceramic, 0.77 mm in all."""
    piezo = 0.77 / (2.0 + 10.0**power)
    return f"shim/piezo 1e{power:g}", (
        f"bimorph.piezo_thickness={piezo:.9g} mm",
        f"bimorph.shim_thickness={10.0**power * piezo:.9g} mm", *more,
    )  # fmt: skip


_FREE = "load.kind=none"
_GENERAL = (
    Sweep("length", "1 µm to 10 m", decades("bimorph.length", "m", -6, 1), (0, 3, 4, -1)),
    Sweep("shim over ceramic", "shim 1e-3 to 1e3 times as thick, at 0.77 mm in all",
          [_shim(power) for power in range(-3, 4)]),
    Sweep("support stiffness", "rotational spring 1e-9 to 1e6 N m/rad",
          decades("support.rotational_stiffness", "N*m/rad", -9, 6, "support.kind=spring", step=3)),
    Sweep("tip mass", "1 pg to 1 kg", decades("load.mass", "kg", -15, 0, "load.kind=mass", step=3)),
    Sweep("taper", "tip 1 to 1e-4 times as wide as the base",
          each("bimorph.width_profile", [f"0 mm: 2 mm, 14 mm: {2.0 * 10.0**-p:g} mm"
                                         for p in range(5)])),
)  # fmt: skip
FREQUENCY = Sweep("frequency", "1 µHz to 1 GHz", decades("frequency", "Hz", -6, 9, _FREE))
_QUALITY = Sweep(
    "quality factor", "10 to 1e9, tan δ its inverse",
    [(f"Q 1e{p}", (f"piezo.quality_factor=1e{p}", f"piezo.loss_tangent=1e-{p}", _FREE))
     for p in range(1, 10, 2)],
)  # fmt: skip
_LEVEL = "mesh.level=2"
#: What drives the lateral actuator, by the pair whose answers are compared.
LATERAL: tuple[tuple[Pair, tuple[Sweep, ...]], ...] = (
    (_LUMPED, _GENERAL),
    (_BEAM, (*_GENERAL, _QUALITY, FREQUENCY)),
    (_CAD, (
        Sweep("length", "0.5 to 100 mm", each("bimorph.length", (0.5, 5, 100), "mm", _LEVEL), (0,)),
        Sweep("shim over ceramic", "shim 1e-2 to 1e2 times as thick",
              [_shim(power, _LEVEL) for power in (-2, 0, 2)], ()),
    )),
)  # fmt: skip

_AT = (_FREE, "frequency=10 Hz,500 Hz,2000 Hz")
_BELOW = (*_AT, "coil.current=50 mA", "coil.history=falling")
_TILTED = (*_AT, "spring.eccentricity=0.3 mm")
#: A finger presses the tip down; its own law is asked for inside its range.
_PRESSED = "frequency=10 Hz,500 Hz,1000 Hz"
_CIRCUIT = (*_BELOW, "coil.supply=voltage")
#: What drives the machine: contact, damping, current, springs, bore, and the coil's circuit, whose
#: time constants span more than eight decades.
MACHINE: tuple[Sweep, ...] = (
    Sweep("contact stiffness", "decay length of its roughness 0.1 nm to 1 mm, and beyond",
          decades("contact.decay_length", "m", -10, -1, *_AT)),
    Sweep("damping", "none at all to a thousand times the usual", (
        ("none", (*_AT, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m",
                  "piezo.quality_factor=1e9", "piezo.loss_tangent=0")),
        *decades("contact.relaxation_time", "s", -9, 0, *_AT, step=3),
    )),
    Sweep("current, up to instability", "0 to 10 A, rising and falling", [
        point for history in ("rising", "falling") for point in each(
            "coil.current", (0, 1e-6, 50, 100, 130, 300, 1e4), "mA", *_AT, f"coil.history={history}"
        )
    ], (1, 4, -4, -1)),
    Sweep("preload", "1 µN to 1 kN", decades("spring.preload", "N", -6, 3, *_AT), (0, 5, -1)),
    Sweep("the lower stop's own stiffness", "decay length 1e-3 to 1e3 times the upper's", (
        *decades("contact.lower_decay_ratio", "", -3, 3, *_BELOW, "contact.decay_length=0.1um"),
        *decades("contact.lower_decay_ratio", "", 2, 3, *_BELOW, "contact.decay_length=10um"),
    )),
    Sweep("the lower stop's own damping", "ratios of 1e-3 to 1e3, and no damping at all", (
        *decades("contact.lower_relaxation_ratio", "", -3, 3, *_BELOW, step=2),
        ("none", (*_BELOW, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m")),
    )),
    Sweep("clearance of the bore", "none, 1 nm to 10 m, upright and tilted", (
        ("none", (*_AT, "guide.clearance=0 m")),
        *decades("guide.clearance", "m", -9, 1, *_AT, step=5),
        *decades("guide.clearance", "m", -9, 1, *_TILTED, step=2),
    )),
    Sweep("springs of the bore", "1e-12 to 1e9 N m/rad, with play and a tilted head",
          decades("guide.rotational_stiffness", "N*m/rad", -12, 9, *_TILTED,
                  "guide.clearance=0.1 um", step=3)),
    Sweep("a finger that the spring cannot hold", "1 uN to 1 kN on the tip against 110 mN",
          decades("load.normal_force", "N", -6, 3, _PRESSED), (0, 5, -1)),
    Sweep("return spring", "0, then 1e-6 to 1e6 N/m", (
        ("none", (*_AT, "spring.stiffness=0 N/m")),
        *decades("spring.stiffness", "N/m", -6, 6, *_AT, step=2),
    )),
    Sweep("stiff circuit: resistance", "1e-9 to 1e9 ohm in the leads",
          decades("coil.source_resistance", "ohm", -9, 9, *_CIRCUIT, step=3)),
    Sweep("stiff circuit: turns", "1 to 1e4 turns at the same ampere-turns: eight decades of "
          "inductance", [
        (f"{10**n} turns", (*_AT, "coil.supply=voltage", f"coil.turns={10**n}",
                            f"coil.current={28 / 10**n:g} A", "coil.history=falling"))
        for n in range(5)
    ]),
)  # fmt: skip
#: Of the machine's sweeps: what the transfer matrix and beam elements both give.
MACHINE_PAIR = Pair(
    "tmm", "beam",
    ("lateral_tip_per_voltage", "axial_tip_per_current", "axial_tip_per_coil_voltage",
     "coil_impedance", "tip_displacement"),
    "generator",
)  # fmt: skip


def families(part: str, pairs: Sequence[tuple[Pair, Sequence[Sweep]]]) -> Families:
    """Families of sweeps, each by the pair that answers it."""
    return {
        f"{part}: {pair.judged} against {pair.witness}, {sweep.family}": partial(pair.row, sweep)
        for pair, sweeps in pairs
        for sweep in sweeps
    }


def run_lateral(asked: PartRequest) -> Stress:
    """Run the lateral actuator's sweeps: seconds if quick, else some minutes."""
    return asked.part("lateral", _STATEMENT, families("lateral", LATERAL))


#: Scenes of a run, and of a quick one.
_SCENES, _QUICK = 2000, 16


def run_random(asked: PartRequest) -> Stress:
    """Run random scenes: seconds if quick, else half an hour."""
    rows = random_rows(asked, _QUICK if asked.quick else _SCENES)
    return Stress("random", _STATEMENT, rows)


def random_rows(asked: PartRequest, count: int) -> tuple[Row, ...]:
    """Rows of so many scenes, each with a stream of its own: bimorphs, machines."""
    seed = asked.seed
    families = {"prototype": Family(PROMISED), "generator": Family(PROMISED)}
    scenes = dict.fromkeys(families, 0)
    for number in range(count):
        asked.announce(f"random scene {number + 1} of {count}, seed {seed}")
        name, overrides = any_scene(np.random.default_rng([seed, number]))
        points, refusals = asked.keep((number,), partial(_judged, name, overrides))
        scenes[name] += 1
        families[name].points += points
        families[name].refusals += refusals
    return tuple(
        f.row(f"random: {name}", f"{scenes[name]} scenes, seed {seed}")
        for name, f in families.items()
    )


def _judged(name: str, overrides: list[str]) -> tuple[list[Point], list[str]]:
    """Points and refusals of one scene; any other exception is a failure."""
    family, where = Family(), f"{name} {'; '.join(overrides)}"
    started = time.process_time()
    try:
        with family.attempt():
            scene, _ = load_scene(name, overrides)
            for pair in (_LUMPED, _BEAM) if name == "prototype" else (_MACHINE,):
                pair.add(family, where, scene)
    except Exception as error:  # noqa: BLE001 what a user would see as a traceback
        family.add(f"{where}: {type(error).__name__}: {error}", np.inf, 0.0)
    if time.process_time() - started > _ENDLESS:
        family.add(f"{where}: endless", np.inf, 0.0)
    return family.points, family.refusals
