"""The machine driven to extremes: contact, bore, springs, circuit, currents, the map's edges."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.tmm.generator.positions import AxialForces, axial_forces, settled_place
from tactgen.tmm.generator.transient.march import simulate
from tactgen.tmm.generator.transient.record import output_at
from tactgen.tmm.generator.transient.waveform import Constant, Sine, Sources, Waveform
from tactgen.tmm.reluctance.map_range import network_pull
from tactgen.tmm.reluctance.network import DirectPull, network_samples
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.stress import (
    REFUSALS,
    Asked,
    Families,
    Family,
    Row,
    Stress,
    answered,
)
from tactgen.validation.evidence.stress_driven import Pair, Sweep, decades, driven
from tactgen.validation.models.generator.judged_rod import CELLS_AT_REST
from tactgen.validation.models.generator.transient import scene_machine
from tactgen.validation.scene.scene import Scene, load_scene

_AT_HOLDING = ("load.kind=none", "frequency=10 Hz,500 Hz,2000 Hz")
_BELOW = (*_AT_HOLDING, "coil.current=50 mA", "coil.history=falling")
#: A finger presses the tip down; its own law is asked for inside its range.
_PRESSED = ("frequency=10 Hz,500 Hz,1000 Hz",)
_TILTED = (*_AT_HOLDING, "spring.eccentricity=0.3 mm")

#: The contact of the lower stop, on a rod held down; the bore's play and springs, the head upright
#: and tilted; springs down to those that cannot hold the rod up.
HELD: tuple[Sweep, ...] = (
    Sweep(
        "the lower stop's own stiffness", "eight decades of decay length: a ratio of 1e-3 to 1e3 "
        "of 0.1 um, then of 10 um",
        (
            *decades("contact.lower_decay_ratio", "", -3, 3, *_BELOW, "contact.decay_length=0.1um"),
            *decades("contact.lower_decay_ratio", "", 2, 3, *_BELOW, "contact.decay_length=10um"),
        ),
    ),
    Sweep(
        "the lower stop's own damping", "ratios of 1e-3 to 1e3, and no damping at all",
        (
            *decades("contact.lower_relaxation_ratio", "", -3, 3, *_BELOW, step=2),
            ("none", (*_BELOW, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m")),
        ),
    ),
    Sweep(
        "clearance of the bore", "none, 1 nm to 10 m, upright and tilted",
        (
            ("none", (*_AT_HOLDING, "guide.clearance=0 m")),
            *decades("guide.clearance", "m", -9, 1, *_AT_HOLDING, step=5),
            *decades("guide.clearance", "m", -9, 1, *_TILTED, step=2),
        ),
    ),
    Sweep(
        "springs of the bore", "1e-12 to 1e9 N m/rad, with play and a tilted head",
        tuple(decades("guide.rotational_stiffness", "N*m/rad", -12, 9, *_TILTED,
                      "guide.clearance=0.1 um", step=3)),
    ),
    Sweep(
        "a finger that the spring cannot hold", "1 uN to 1 kN on the tip against 110 mN",
        tuple(decades("load.normal_force", "N", -6, 3, *_PRESSED)), quick=(0, 5, -1),
    ),
    Sweep(
        "return spring", "0, then 1e-6 to 1e6 N/m",
        (
            ("none", (*_AT_HOLDING, "spring.stiffness=0 N/m")),
            *decades("spring.stiffness", "N/m", -6, 6, *_AT_HOLDING, step=2),
        ),
    ),
)  # fmt: skip

_CIRCUIT = (*_BELOW, "coil.supply=voltage")
#: The coil's circuit, driven by a voltage: time constants over more than eight decades.
DRIVEN: tuple[Sweep, ...] = (
    Sweep(
        "stiff circuit: resistance", "1e-9 to 1e9 ohm in the leads",
        tuple(decades("coil.source_resistance", "ohm", -9, 9, *_CIRCUIT, step=3)),
    ),
    Sweep(
        "stiff circuit: turns", "1 to 1e4 turns at the same ampere-turns, which is eight decades "
        "of inductance",
        tuple(
            (f"{10**n} turns", (*_AT_HOLDING, "coil.supply=voltage", f"coil.turns={10**n}",
                                f"coil.current={28 / 10**n:g} A", "coil.history=falling"))
            for n in range(5)
        ),
    ),
)  # fmt: skip
CIRCUIT_PAIR = Pair(
    "tmm", "beam",
    ("axial_tip_per_coil_voltage", "coil_impedance", "lateral_tip_per_voltage"), "generator",
)  # fmt: skip


#: Accuracy of the runs that are judged, and what their witness's is of it.
_ACCURACY, _FINER = 0.05, 0.1
#: What the energy balance may miss, of all that was exchanged.
_BALANCE = 1e-10
_FREE = "load.kind=none"
_UNDAMPED = (
    _FREE, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m",
    "piezo.quality_factor=1e9", "contact.friction=0.001",
)  # fmt: skip
_OFF = Constant(0.0)


@dataclass(frozen=True)
class _Run:
    """One run: where it is, for people; what the scene sets; speed of the rod at the start (m/s).

    `coil` is what drives the winding, by current unless `by_voltage`.
    """

    where: str
    overrides: tuple[str, ...]
    until: float
    speed: float = 0.0
    coil: Waveform = _OFF
    by_voltage: bool = False


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
        coil=Constant(0.05 * ohms), by_voltage=True,
    )
    for ohms in (1e1, 1e2, 1e3, 1e4, 1e5, 1e6)
)  # fmt: skip


def motion_rows(quick: bool) -> list[Row]:
    """Return the rows: seconds if `quick`, else a minute."""
    return [
        _row("machine: blows on its stop", "the rod at 1 cm/s to 2 m/s", _BLOWS, quick),
        _row("machine: without damping", "no loss in contact, guide, bimorph", _LOSSLESS, quick),
        _row("machine: stiff circuits", "10 ohm to 1 Mohm in series", _CIRCUITS, quick),
    ]


def _row(name: str, what: str, runs: tuple[_Run, ...], quick: bool) -> Row:
    family = Family()
    for run in runs[-1:] if quick else runs:
        try:
            _judge(family, run)
        except REFUSALS as error:
            family.refuse(error)
    return answered(name, what, family.points, family.refusals)


def _judge(family: Family, run: _Run) -> None:
    """Compare every output at its worst time, and the energy."""
    scene, _ = load_scene("generator", list(run.overrides))
    found = scene_machine(scene, coil="voltage" if run.by_voltage else "current", volts=10.0)
    velocity = np.zeros(found.rest.size)
    velocity[0] = run.speed
    judged, finer = (
        simulate(
            found.system, Sources(Sine(10.0, 200.0), run.coil), run.until,
            position=found.rest, velocity=velocity, accuracy=_ACCURACY * share,
        )
        for share in (1.0, _FINER)
    )  # fmt: skip
    for name, output in found.system.outputs.items():
        values, bar = judged.outputs[name], judged.bars[name] + finer.bars[name][-1]
        off = np.abs(values - output_at(finer.run, output.row, judged.run.time))
        size = float(np.abs(values).max()) or 1.0
        at = int(np.argmax(off / np.maximum(bar, np.finfo(float).tiny)))
        family.add(f"{run.where}, {name}", off[at] / size, bar[at] / size)
    if run.by_voltage:
        bar = judged.bars["current"][-1] + finer.bars["current"][-1]
        last, known = (answer.run.current[-1] for answer in (judged, finer))
        family.compare(f"{run.where}, current at the end", float(last), float(known), float(bar))
    family.add(f"{run.where}, energy", judged.run.worst_imbalance, _BALANCE)


_STATEMENT = (
    "Responses by the transfer matrix and by beam elements agree within the bars of both, of a "
    "family and of a response 19 of 20 and none by three bars; the slow motion per ampere is the "
    "derivative of where the rod rests; the map meets the network that it was made from; runs in "
    "time agree with ten times finer ones within the bars of both, and keep their energy. Where "
    "the rod rests nowhere, or a head is tipped over, that is said."
)
_MOTIONS = (
    "lateral_tip_per_voltage", "axial_tip_per_current", "coil_impedance", "tip_displacement",
)  # fmt: skip
_AT = ("load.kind=none", "frequency=10 Hz,500 Hz,2000 Hz")
_PAIR = Pair("tmm", "beam", _MOTIONS, "generator")
_CONTACT = Sweep(
    "contact stiffness", "decay length of its roughness 0.1 nm to 1 mm, and beyond",
    tuple(decades("contact.decay_length", "m", -10, -1, *_AT)),
)  # fmt: skip
_DAMPING = Sweep(
    "damping", "none at all to a thousand times the usual",
    (
        ("none", (*_AT, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m",
                  "piezo.quality_factor=1e9", "piezo.loss_tangent=0")),
        *((f"relaxation {t:g} s", (*_AT, f"contact.relaxation_time={t:g} s"))
          for t in (1e-9, 1e-6, 1e-3, 1.0)),
    ),
)  # fmt: skip
_CURRENT = Sweep(
    "current, up to instability", "0 to 10 A, rising and falling",
    tuple(
        (f"{current:g} mA {history}",
         (*_AT, f"coil.current={current:g} mA", f"coil.history={history}"))
        for history in ("rising", "falling")
        for current in (0.0, 1e-6, 50.0, 100.0, 130.0, 300.0, 1e4)
    ),
    quick=(1, 4, -4, -1),
)  # fmt: skip
_PRELOAD = Sweep(
    "preload", "1 µN to 1 kN",
    tuple(decades("spring.preload", "N", -6, 3, *_AT)), quick=(0, 5, -1),
)  # fmt: skip


def run(asked: Asked) -> Stress:
    """Run all families: seconds if quick, else a minute."""
    started = time.perf_counter()
    rows = asked.rows("machine", _families())
    return Stress("machine", _STATEMENT, rows, (), (), time.perf_counter() - started)


def _families() -> Families:
    sweeps = [(_PAIR, sweep) for sweep in (_CONTACT, _DAMPING, _CURRENT, _PRELOAD, *HELD)]
    sweeps += [(CIRCUIT_PAIR, sweep) for sweep in DRIVEN]
    return {
        **{sweep.family: partial(pair.row, sweep) for pair, sweep in sweeps},
        "slow motion against rest": slow_row,
        "edges of the co-energy map": edge_row,
        "in time": motion_rows,
    }


def slow_row(quick: bool) -> Row:
    """Hold the motion per ampere at almost 0 Hz against the derivative of the place of rest.

    The derivative is extrapolated from two central differences, whose distance is its bar.
    """

    def add(family: Family, where: str, scene: Scene) -> None:
        slow = solve(scene, ("tmm",), ("axial_tip_per_current",))
        moved = complex(slow.get("axial_tip_per_current", "tmm").value[0])
        current, at_rest = scene.coil.current, _network_forces(scene)
        wide, near = (_slope(scene, at_rest, share * current) for share in (2e-3, 1e-3))
        slope = near + (near - wide) / 3.0
        bar = abs(near - wide) + 1e-6 * abs(slope)
        family.compare(where, abs(moved), abs(slope), bar)

    sweep = Sweep(
        "slow motion per ampere", "1 µHz, 20 to 100 mA, on either stop",
        tuple(
            (f"{current} mA {history}",
             ("load.kind=none", "frequency=1e-6 Hz", f"coil.current={current} mA",
              f"coil.history={history}"))
            for current, history in (
                (20, "rising"), (60, "rising"), (100, "rising"), (60, "falling")
            )
        ),
    )  # fmt: skip
    return driven(f"machine: {sweep.family}", sweep, "generator", add, quick)


def _network_forces(scene: Scene) -> AxialForces:
    """Return what acts on the rod, the pull by the network that small motions are read off."""
    exact = DirectPull(scene.device, CELLS_AT_REST, scene.pull.gap_limits)
    return axial_forces(scene.device, exact, scene.load.normal_force)


def _slope(scene: Scene, forces: AxialForces, step: float) -> float:
    """Return the central difference of the place of rest over the current (m/A)."""
    assert scene.rest is not None, "the generator stands on its contact"
    places = []
    for at in (scene.coil.current - step, scene.coil.current + step):
        place = settled_place(forces, at, scene.rest[0])
        assert place is not None, "near where the map has it"
        places.append(place.lift)
    return (places[1] - places[0]) / (2.0 * step)


def edge_row(quick: bool) -> Row:
    """Ask the co-energy map in its corners and on its edges, and beyond them."""
    device = Device()
    surface = network_pull(device)
    (near, far), most = surface.gap_limits, surface.current_limit
    family = Family()
    for current in (1e-9 * most, 0.5 * most, most):
        for gap in (near, 0.5 * (near + far), far):
            exact = network_samples(device, np.array([0.0, current]), np.array([gap]))
            linkage, force = float(exact.flux_linkage[1, 0]), float(exact.force[1, 0])
            bar_of = surface.interpolation_error
            where = f"{current:.3g} A, {1e6 * gap:.3g} µm"
            # relative to a tenth of the largest at that gap, where less: so the map states it
            largest = network_samples(device, np.array([0.0, most]), np.array([gap]))
            for name, value, known, top, bar in (
                ("λ", surface.flux_linkage(current, gap), linkage, largest.flux_linkage[1, 0],
                 bar_of.flux_linkage),
                ("F", surface.force(current, gap), force, largest.force[1, 0],
                 bar_of.force),
            ):  # fmt: skip
                size = max(abs(known), 0.1 * abs(float(top)))
                family.add(f"{where}, {name}", abs(float(value) - known) / size, bar)
    for current, gap in ((1.01 * most, near), (most, 1.01 * far), (most, near - 1e-6)):
        try:
            surface.force(current, gap)
            family.add(f"{current:.3g} A, {1e6 * gap:.4g} µm, outside", np.inf, 0.0)
        except REFUSALS as error:
            family.refuse(error)
    what = "corners, edges and middle of currents and gaps; just outside it refuses"
    return answered("machine: edges of the co-energy map", what, family.points, family.refusals)
