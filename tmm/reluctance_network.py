"""The lumped reluctance network of the normal actuator, and the one-gap formula as its floor.

Gives the samples from which a co-energy map is made, and the bridge: what each refinement
of the formula is worth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Floats
from geometry.parameters import Device
from geometry.steel import MU0
from tmm.coenergy import Samples
from tmm.flux_ladder import solve
from tmm.gap_permeance import pole_area
from tmm.reluctance_circuit import CELLS, FULL, ONE_GAP, Refinements, circuit


def textbook_force(device: Device, current: float, gap: float) -> float:
    """Return F = µ0 N² i² A / (2 g²) (N): all the winding's mmf across one straight gap."""
    return float(MU0 * (device.coil.turns * current / gap) ** 2 * pole_area(device) / 2.0)


def network_samples(
    device: Device,
    currents: Floats,
    gaps: Floats,
    refinements: Refinements = FULL,
    cells: int = CELLS,
) -> Samples:
    """Return the network's flux linkage, force, co-energy and inductance.

    The force's error bar is the difference from half as many cells.

    Parameters
    ----------
    device : Device
        Rod, coil, sleeve and steel are read.
    currents : (c,) float
        In the winding (A).
    gaps : (m,) float
        Working gaps (m), above 0.

    Raises
    ------
    InputError
        If the parts cannot form the circuit at one of the gaps.
    """
    currents = np.atleast_1d(np.asarray(currents, dtype=float))
    gaps = np.atleast_1d(np.asarray(gaps, dtype=float))
    found = solve(circuit(device, gaps, refinements, cells), currents)
    coarse = solve(circuit(device, gaps, refinements, max(cells // 2, 1)), currents)
    return Samples(
        current=currents,
        gap=gaps,
        flux_linkage=found.flux_linkage,
        force=found.force,
        coenergy=found.coenergy,
        incremental_inductance=found.incremental_inductance,
        force_error=np.abs(found.force - coarse.force),
        model="network",
    )


@dataclass(frozen=True)
class BridgeRow:
    """One step from the one-gap formula to the full network.

    Attributes
    ----------
    step : str
        What this row adds.
    force, flux_linkage : float
        With it (N, Wb).
    force_change, flux_linkage_change : float
        Relative to the row before; 0 in the first.
    """

    step: str
    force: float
    flux_linkage: float
    force_change: float
    flux_linkage_change: float


def network_bridge(device: Device, current: float, gap: float) -> tuple[BridgeRow, ...]:
    """Return what each refinement does to force and flux linkage, one after the other."""
    at = np.array([current]), np.array([gap])
    rows: list[BridgeRow] = []
    for step, stage in _stages():
        found = network_samples(device, *at, stage)
        force, linkage = float(found.force[0, 0]), float(found.flux_linkage[0, 0])
        before = rows[-1] if rows else BridgeRow("", force, linkage, 0.0, 0.0)
        changes = force / before.force - 1.0, linkage / before.flux_linkage - 1.0
        rows.append(BridgeRow(step, force, linkage, *changes))
    return tuple(rows)


def _stages() -> tuple[tuple[str, Refinements], ...]:
    """Return the way from the one-gap formula to the full network, one switch at a time."""
    fringing = replace(ONE_GAP, fringing=True)
    parasitic = replace(fringing, parasitic_gap=True)
    leakage = replace(parasitic, leakage=True)
    return (
        ("one straight gap, perfect iron", ONE_GAP),
        ("fringing beside the pole faces", fringing),
        ("parasitic gap at the flange", parasitic),
        ("leakage across the coil", leakage),
        ("iron at its highest permeability", replace(leakage, iron="linear")),
        ("saturation", replace(leakage, iron="saturating")),
    )
