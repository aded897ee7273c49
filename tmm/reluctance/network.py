"""The lumped reluctance network of the normal actuator, and the one-gap formula as its floor.

Gives the samples from which a co-energy map is made, and the bridge: what each refinement
of the formula is worth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device, Limits
from tactgen.geometry.device.winding import winding
from tactgen.geometry.formats import engineering
from tactgen.tmm.reluctance.coenergy_map import Samples
from tactgen.tmm.reluctance.flux_ladder import LadderSolution, solve
from tactgen.tmm.reluctance.magnetic_circuit import CELLS, FULL, ONE_GAP, Refinements, circuit


def network_samples(
    device: Device,
    currents: Floats,
    gaps: Floats,
    refinements: Refinements = FULL,
    cells: int = CELLS,
) -> Samples:
    """Network's flux linkage, force, co-energy and inductance.

    Parameters
    ----------
    device : Device
        Rod, coil, sleeve and steel are read.
    currents : (c,) float
        In the winding (A).
    gaps : (m,) float
        Working gaps (m), above 0.

    Raises InputError if the parts cannot form the circuit at one of the gaps.
    """
    currents = np.atleast_1d(np.asarray(currents, dtype=float))
    gaps = np.atleast_1d(np.asarray(gaps, dtype=float))
    found, coarse = fine_and_coarse(device, currents, gaps, refinements, cells)
    return Samples(
        currents, gaps, found.flux_linkage, found.force, found.coenergy,
        found.incremental_inductance, force_error(found, coarse), "network",
    )  # fmt: skip


def fine_and_coarse(
    device: Device,
    currents: Floats,
    gaps: Floats,
    refinements: Refinements = FULL,
    cells: int = CELLS,
) -> tuple[LadderSolution, LadderSolution]:
    """Network's state with `cells` and with half as many; arguments as above."""
    fine, coarse = (
        solve(circuit(device, gaps, refinements, n), currents) for n in (cells, max(cells // 2, 1))
    )
    return fine, coarse


def force_error(fine: LadderSolution, coarse: LadderSolution) -> Floats:
    """Error bar (c, m) of the force (N): the difference between two ladders.

    In relation no less than the co-energy's, whose difference has one sign: that of the force
    passes through zero between currents.
    """
    total = fine.coenergy
    share = np.abs(total - coarse.coenergy) / np.where(total == 0.0, 1.0, total)
    return np.asarray(np.maximum(np.abs(fine.force - coarse.force), share * np.abs(fine.force)))


def iron_beyond_table(device: Device, current: float, gap: float) -> float:
    """Share of the iron's volume beyond the end of a curve that ends early.

    Zero for a curve that goes on until the steel is saturated.
    """
    ladder = circuit(device, np.array([gap]), FULL, CELLS)
    if not ladder.curve.ends_early:
        return 0.0
    flux = solve(ladder, np.array([current])).flux[0, 0]
    b, volumes = np.abs(flux[ladder.cell]) / ladder.area[0], ladder.area[0] * ladder.length[0]
    return ladder.curve.volume_beyond(b, volumes) / float(volumes.sum())


@dataclass(frozen=True)
class RefinementRow:
    """One step from the one-gap formula to the full network."""

    step: str  #: What this row adds
    #: With it (N, Wb)
    force: float
    flux_linkage: float
    force_change: float  #: Relative to the row before; 0 in the first


def network_refinements(device: Device, current: float, gap: float) -> tuple[RefinementRow, ...]:
    """Contribution of each network refinement to force and flux linkage."""
    at = np.array([current]), np.array([gap])
    # one switch at a time
    fringing = replace(ONE_GAP, fringing=True)
    parasitic = replace(fringing, parasitic_gap=True)
    leakage = replace(parasitic, leakage=True)
    rows: list[RefinementRow] = []
    for step, stage in (
        ("one straight gap, perfect iron", ONE_GAP),
        ("fringing beside the pole faces", fringing),
        ("parasitic gap at the flange", parasitic),
        ("leakage across the coil", leakage),
        ("iron at its highest permeability", replace(leakage, iron="linear")),
        ("saturation", replace(leakage, iron="saturating")),
    ):
        found = network_samples(device, *at, stage)
        force, linkage = float(found.force[0, 0]), float(found.flux_linkage[0, 0])
        before = rows[-1].force if rows else force
        rows.append(RefinementRow(step, force, linkage, force / before - 1.0))
    return tuple(rows)


#: Step of differences, relative; with those of order four they keep some eight digits.
STEP = 2e-3
#: Where they are taken, in steps.
_PLACES = np.array([-2.0, -1.0, 1.0, 2.0])


@dataclass(frozen=True)
class DirectForce:
    """Co-energy solved directly at each point; currents (A) above 0, gaps in m."""

    device: Device
    cells: int  #: Of the network's ladder
    gap_limits: tuple[float, float]  #: (float, float) Gaps (m) that are asked for, such as a map's
    step: float = STEP  #: Of the differences that the slopes are, relative to the gap

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Pull (N)."""
        return self._at(current, gap, "force")

    def incremental_inductance(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂i (H)."""
        return self._at(current, gap, "incremental_inductance")

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂F/∂g (N/m)."""
        place = np.broadcast_arrays(current, gap)[1]
        return _slope(lambda g: self.force(current, g), place, self.step)

    def motional_coefficient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂g = −∂F/∂i (N/A)."""
        place = np.broadcast_arrays(current, gap)[1]
        return _slope(lambda g: self._at(current, g, "flux_linkage"), place, self.step)

    def _at(self, current: Floats | float, gap: Floats | float, name: str) -> Floats:
        currents, gaps = np.broadcast_arrays(*np.atleast_1d(current, gap))
        some, which = np.unique(currents, return_inverse=True)
        places, where = np.unique(gaps, return_inverse=True)
        solved = solve(circuit(self.device, places, FULL, self.cells), some)
        found = getattr(solved, name)[which.ravel(), where.ravel()]
        return np.asarray(found.reshape(np.broadcast(current, gap).shape))


def _slope(of: Callable[[Floats], Floats], at: Floats | float, step: float) -> Floats:
    """Central difference of order four, all its points at once."""
    x = np.asarray(at, dtype=float)
    h = step * x
    further, before, after, furthest = of(x + np.multiply.outer(_PLACES, h))
    return np.asarray((8.0 * (after - before) - (furthest - further)) / (12.0 * h))


#: Heat transfer to still air (W/(m² K)), the most that free convection gives (Incropera and
#: DeWitt, Fundamentals of Heat and Mass Transfer, table 1.1: 2 to 25).
_TO_AIR = 25.0


def steady_temperature_rise(device: Device, current: float) -> float:
    """Least steady temperature rise (K) over still air.

    Free convection at its best from the sleeve's outside and the head's top; what the
    circuit board and the finger lead away is left out, and so is the wire's own rise.
    """
    return float(winding(device.coil).power(current) / (_TO_AIR * _surface(device)))


def largest_rms_current(device: Device, limits: Limits) -> float:
    """Effective current (A) that takes the winding to its temperature limit for good.

    From the sleeve's outside and the head's top to still air alone, the hot wire's resistance
    included.  A current switched much faster than the actuator warms (tens of seconds) with the
    share D of its time on may be 1/√D times as large.
    """
    rise = limits.winding_temperature - limits.ambient_temperature
    coil = device.coil.model_copy(update={"temperature": limits.winding_temperature})
    carried = limits.heat_transfer * _surface(device) * max(rise, 0.0)
    return math.sqrt(carried / winding(coil).resistance)


def _surface(device: Device) -> float:
    """Area of the sleeve's outside and the head's top (m²)."""
    sleeve, head = device.sleeve, device.rod.head_radius
    return float(2.0 * math.pi * sleeve.outer_radius * sleeve.length + math.pi * head**2)


def thermal_statement(device: Device, current: float) -> str:
    """Plain words on the current and the wire's temperature."""
    if current == 0.0:
        return "no current, no heat"
    wound = winding(device.coil)
    rise = steady_temperature_rise(device, current)
    seconds = 100.0 / wound.heating_rate(current)
    verdict = (
        "not plausible as a direct current unless the circuit board leads the heat away"
        if rise > 100.0
        else "plausible as a direct current"
    )
    wire = engineering(wound.wire_diameter, "m", 3)
    return (
        f"{engineering(abs(current), 'A', 3)} in {wire} wire is "
        f"{wound.current_density(current) * 1e-6:.3g} A/mm² and {wound.power(current):.3g} W; "
        f"uncooled, the wire would warm by 100 K in {seconds:.2g} s, and still air alone would "
        f"leave the actuator {rise:,.0f} K warmer: {verdict}"
    )
