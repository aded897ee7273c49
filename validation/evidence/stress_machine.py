"""The machine at extremes: sweeps of keys, slow motion, edges of the map, runs in time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.tmm.generator.equilibrium import AxialForces, axial_forces, settled_place
from tactgen.tmm.generator.transient.time_integration import output_at, simulate
from tactgen.tmm.generator.transient.waveform import Sine, Sources, Step
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.tmm.reluctance.network import DirectForce
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.coverage_actuator import map_errors
from tactgen.validation.evidence.stress import Families, Family, PartRequest, Row, Stress
from tactgen.validation.evidence.stress_driven import MACHINE, MACHINE_PAIR, families
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.small_signal import CELLS_AT_REST
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

_STATEMENT = (
    "Responses by the transfer matrix and by beam elements agree within the bars of both, of a "
    "family and of a response 19 of 20 and none by three bars; the slow motion per ampere is the "
    "derivative of where the rod rests; the map meets the network that it was made from; runs in "
    "time agree with ten times finer ones within the bars of both, and keep their energy. Where "
    "the rod rests nowhere, or a head is tipped over, that is said."
)


def run(asked: PartRequest) -> Stress:
    """Run all families: seconds if quick, else a minute."""
    sweeps = families("machine", ((MACHINE_PAIR, MACHINE),))
    others: Families = {
        "slow motion against rest": slow_row,
        "edges of the co-energy map": edge_row,
        "in time": motion_rows,
    }
    return asked.part("machine", _STATEMENT, {**sweeps, **others})


#: Currents (mA) and how they are reached.
_SLOW = ((20, "rising"), (60, "rising"), (100, "rising"), (60, "falling"))


def slow_row(quick: bool) -> Row:
    """Hold the motion per ampere at almost 0 Hz against the derivative of the place of rest.

    The derivative is extrapolated from two central differences, whose distance is its bar.
    """
    family = Family()
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
    return family.row("machine: slow motion per ampere", "1 µHz, 20 to 100 mA, on either stop")


def _slope(scene: Scene, forces: AxialForces, step: float) -> float:
    """Central difference of the place of rest over the current (m/A)."""
    assert scene.rest is not None, "the generator stands on its contact"
    places = []
    for at in (scene.coil.current - step, scene.coil.current + step):
        place = settled_place(forces, at, scene.rest[0])
        assert place is not None, "near where the map has it"
        places.append(place.lift)
    return (places[1] - places[0]) / (2.0 * step)


def edge_row(quick: bool) -> Row:
    """Ask the co-energy map in its corners and on its edges, and beyond them."""
    surface = network_map(Device())
    (near, far), most = surface.gap_limits, surface.current_limit
    family = Family()
    currents, gaps = np.array([1e-9, 0.5, 1.0]) * most, np.array([near, 0.5 * (near + far), far])
    errors = map_errors(Device(), surface, currents, gaps)
    for (i, current), (j, gap) in product(enumerate(currents), enumerate(gaps)):
        for name, symbol in (("flux_linkage", "λ"), ("force", "F")):
            bar = getattr(surface.interpolation_error, name)
            where = f"{current:.3g} A, {1e6 * gap:.3g} µm, {symbol}"
            family.add(where, errors[name][i, j], bar)
    for current, gap in ((1.01 * most, near), (most, 1.01 * far), (most, near - 1e-6)):
        with family.attempt():
            surface.force(current, gap)
            family.add(f"{current:.3g} A, {1e6 * gap:.4g} µm, outside", np.inf, 0.0)
    what = "corners, edges and middle of currents and gaps; just outside it refuses"
    return family.row("machine: edges of the co-energy map", what)


#: Accuracy of the runs that are judged, and what their witness's is of it.
_ACCURACY, _FINER = 0.05, 0.1
#: What the energy balance may miss, of all that was exchanged.
_BALANCE = 1e-10
_FREE = "load.kind=none"
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


#: By row: what is run.
_MOTIONS = {
    "machine: blows on its stop": ("the rod at 1 cm/s to 2 m/s", _BLOWS),
    "machine: without damping": ("no loss in contact, guide, bimorph", _LOSSLESS),
    "machine: stiff circuits": ("10 ohm to 1 Mohm in series", _CIRCUITS),
}


def motion_rows(quick: bool) -> list[Row]:
    """Rows: seconds if `quick`, else a minute."""
    rows = []
    for name, (what, runs) in _MOTIONS.items():
        family = Family()
        for run in runs[-1:] if quick else runs:
            with family.attempt():
                _judge(family, run)
        rows.append(family.row(name, what))
    return rows


def _judge(family: Family, run: _Run) -> None:
    """Compare every output at its worst time, and the energy."""
    scene, _ = load_scene("generator", list(run.overrides))
    by_voltage = run.volts is not None
    found = scene_machine(scene, coil="voltage" if by_voltage else "current", volts=10.0)
    velocity = np.zeros(found.rest.size)
    velocity[0] = run.speed
    judged, finer = (
        simulate(
            found.system, Sources(Sine(10.0, 200.0), Step(run.volts or 0.0)), run.until,
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
    if by_voltage:
        bar = judged.bars["current"][-1] + finer.bars["current"][-1]
        last, known = (answer.run.current[-1] for answer in (judged, finer))
        family.compare(f"{run.where}, current at the end", float(last), float(known), float(bar))
    family.add(f"{run.where}, energy", judged.run.worst_imbalance, _BALANCE)
