"""The machine driven to extremes: contact, bore, springs, circuit, currents, the map's edges."""

from __future__ import annotations

import time
from functools import partial

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.tmm.generator.positions import AxialForces, axial_forces, settled_place
from tactgen.tmm.reluctance.map_range import network_pull
from tactgen.tmm.reluctance.network import DirectPull, network_samples
from tactgen.validation.checks.stress import Asked, Families
from tactgen.validation.checks.stress.answers import REFUSALS, Family
from tactgen.validation.checks.stress.driven.holding import CIRCUIT_PAIR, DRIVEN, HELD
from tactgen.validation.checks.stress.driven.motion import motion_rows
from tactgen.validation.checks.stress.driven.sweep import Pair, Sweep, decades, driven
from tactgen.validation.checks.stress.result import Row, Stress, answered
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.generator.judged_rod import CELLS_AT_REST
from tactgen.validation.scene.scene import Scene

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
