"""The machine at extremes: sweeps of keys, slow motion, and runs in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from tactgen.tmm.generator.equilibrium import AxialForces, axial_forces, settled_place
from tactgen.tmm.generator.transient.waveform import Sine, Sources, Step
from tactgen.tmm.reluctance.network import DirectForce
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.coverage_actuator import time_errors, two_runs
from tactgen.validation.evidence.judgement import Family
from tactgen.validation.evidence.stress_driven import MACHINE, Sweep, decades, each, families
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.small_signal import CELLS_AT_REST
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

_FREE = "load.kind=none"
_AT = (_FREE, "frequency=10 Hz,500 Hz,2000 Hz")
_BELOW = (*_AT, "coil.current=50 mA", "coil.history=falling")
_TILTED = (*_AT, "spring.eccentricity=0.3 mm")
#: A finger presses the tip down; its own law is asked for inside its range.
_PRESSED = "frequency=10 Hz,500 Hz,1000 Hz"
#: What drives the machine: contact, damping, current, springs, bore, and the coil's circuit, whose
#: time constants span more than eight decades.
_SWEEPS: dict[str, Sweep] = {
    "contact stiffness: decay length of its roughness 0.1 nm to 1 mm, and beyond":
        decades("contact.decay_length", "m", -10, -1, *_AT),
    "damping: none at all to a thousand times the usual": [
        (*_AT, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m",
         "piezo.quality_factor=1e9", "piezo.loss_tangent=0"),
        *decades("contact.relaxation_time", "s", -9, 0, *_AT, step=3),
    ],
    "current, up to instability: 0 to 10 A, rising and falling": [
        point for history in ("rising", "falling") for point in each(
            "coil.current", (0, 1e-6, 50, 100, 130, 300, 1e4), "mA", *_AT, f"coil.history={history}"
        )
    ],
    "preload: 1 µN to 1 kN": decades("spring.preload", "N", -6, 3, *_AT),
    "the lower stop's own stiffness: decay length 1e-3 to 1e3 times the upper's": [
        *decades("contact.lower_decay_ratio", "", -3, 3, *_BELOW, "contact.decay_length=0.1um"),
        *decades("contact.lower_decay_ratio", "", 2, 3, *_BELOW, "contact.decay_length=10um"),
    ],
    "the lower stop's own damping: ratios of 1e-3 to 1e3, and no damping at all": [
        *decades("contact.lower_relaxation_ratio", "", -3, 3, *_BELOW, step=2),
        (*_BELOW, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m"),
    ],
    "clearance of the bore: none, 1 nm to 10 m, upright and tilted": [
        (*_AT, "guide.clearance=0 m"),
        *decades("guide.clearance", "m", -9, 1, *_AT, step=5),
        *decades("guide.clearance", "m", -9, 1, *_TILTED, step=2),
    ],
    "springs of the bore: 1e-12 to 1e9 N m/rad, with play and a tilted head":
        decades("guide.rotational_stiffness", "N*m/rad", -12, 9, *_TILTED, "guide.clearance=0.1 um",
                step=3),
    "a finger that the spring cannot hold: 1 uN to 1 kN on the tip against 110 mN":
        decades("load.normal_force", "N", -6, 3, _PRESSED),
    "return spring: 0, then 1e-6 to 1e6 N/m": [
        (*_AT, "spring.stiffness=0 N/m"), *decades("spring.stiffness", "N/m", -6, 6, *_AT, step=2),
    ],
    "stiff circuit, resistance: 1e-9 to 1e9 ohm in the leads":
        decades("coil.source_resistance", "ohm", -9, 9, *_BELOW, "coil.supply=voltage", step=3),
    "stiff circuit, turns: 1 to 1e4 turns at the same ampere-turns, eight decades of inductance": [
        (*_AT, "coil.supply=voltage", f"coil.turns={10**n}", f"coil.current={28 / 10**n:g} A",
         "coil.history=falling")
        for n in range(5)
    ],
}  # fmt: skip

#: Currents (mA) and how they are reached.
_SLOW = ((20, "rising"), (60, "rising"), (100, "rising"), (60, "falling"))


def slow_motion(family: Family, quick: bool) -> None:
    """Hold the motion per ampere at almost 0 Hz against the derivative of the place of rest.

    The derivative is extrapolated from two central differences, whose distance is its bar.
    """
    for current, history in _SLOW[::3] if quick else _SLOW:
        with family.attempt():
            scene, _ = load_scene("generator", [
                "load.kind=none", "frequency=1e-6 Hz", f"coil.current={current} mA",
                f"coil.history={history}",
            ])  # fmt: skip
            slow = solve(scene, ("tmm",), ("axial_tip_per_current",)).quantities[0]
            exact = DirectForce(scene.device, CELLS_AT_REST, map_of(scene).gap_limits)
            forces = axial_forces(scene.device, exact, scene.load.normal_force)
            wide, near = (_slope(scene, forces, s * scene.coil.current) for s in (2e-3, 1e-3))
            slope = near + (near - wide) / 3.0
            bar = abs(near - wide) + 1e-6 * abs(slope)
            family.compare(f"{current} mA {history}", abs(complex(slow.value[0])), abs(slope), bar)


def _slope(scene: Scene, forces: AxialForces, step: float) -> float:
    """Central difference of the place of rest over the current (m/A)."""
    assert scene.rest is not None, "the generator stands on its contact"
    places = []
    for at in (scene.coil.current - step, scene.coil.current + step):
        place = settled_place(forces, at, scene.rest[0])
        assert place is not None, "near where the map has it"
        places.append(place.lift)
    return (places[1] - places[0]) / (2.0 * step)


#: Accuracy of the runs that are judged.
_ACCURACY = 0.05
#: What the energy balance may miss, of all that was exchanged.
_BALANCE = 1e-10
_UNDAMPED = (
    _FREE, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m",
    "piezo.quality_factor=1e9", "contact.friction=0.001",
)  # fmt: skip


@dataclass(frozen=True)
class _Run:
    """Run in time: label, overrides, speed of the rod at the start (m/s).

    `volts` drive the winding; without them it carries no current.
    """

    where: str
    overrides: tuple[str, ...]
    until: float
    speed: float = 0.0
    volts: float | None = None


_BLOWS = tuple(
    _Run(f"{speed:g} m/s", (_FREE,), 3e-4 / max(speed, 1.0), speed)
    for speed in (0.01, 0.1, 0.5, 1.0, 2.0)
)
_LOSSLESS = tuple(
    _Run(f"{speed:g} m/s, no damping", _UNDAMPED, 2e-4, speed) for speed in (0.0, 0.05, 0.4)
)
#: Circuits whose resistance answers in seconds to fractions of a nanosecond; 50 mA at the end.
_CIRCUITS = tuple(
    _Run(
        f"source of {ohms:g} ohm", (_FREE, f"coil.source_resistance={ohms:g} ohm"), 2e-4,
        volts=0.05 * ohms,
    )
    for ohms in (1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
)  # fmt: skip


def motions(runs: Sequence[_Run], family: Family, quick: bool) -> None:
    """Judge runs in time."""
    for run in runs[-1:] if quick else runs:
        with family.attempt():
            _judge(family, run)


def _judge(family: Family, run: _Run) -> None:
    """Compare every output until the end, and the energy."""
    scene, _ = load_scene("generator", list(run.overrides))
    machine = scene_machine(scene, coil="current" if run.volts is None else "voltage", volts=10.0)
    sources = Sources(Sine(10.0, 200.0), Step(run.volts or 0.0))
    judged, finer = two_runs(machine, sources, run.until, run.speed, _ACCURACY)
    errors = time_errors(machine.system, judged, finer, judged.run.time.size)
    for name, (error, bar) in errors.items():
        family.add(run.where, error, bar, which=name)
    family.add(run.where, judged.run.worst_imbalance, _BALANCE, which="energy")


#: By title, with the range.
FAMILIES: dict[str, Callable[[Family, bool], None]] = {
    **families(MACHINE, _SWEEPS),
    "slow motion per ampere: 1 µHz, 20 to 100 mA, on either stop": slow_motion,
    "blows on its stop: the rod at 1 cm/s to 2 m/s": partial(motions, _BLOWS),
    "without damping: no loss in contact, guide, bimorph": partial(motions, _LOSSLESS),
    "stiff circuits: 10 ohm to 1 Mohm in series": partial(motions, _CIRCUITS),
}  # fmt: skip
