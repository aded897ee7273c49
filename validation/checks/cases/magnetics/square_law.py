"""A transformer core that saturates as B ∝ √H: energy and co-energy in closed form.

ANSYS verification manual VM213 (differential inductance of a transformer): at 0.2 A it
stores 0.0166 J and has 0.0333 J of co-energy, 1.25 H apparent and half of that
differential.  They follow from λ ∝ √i and a flux linkage of 0.25 Wb.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.steel_law import MagnetisationCurve
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap, Samples
from tactgen.tmm.reluctance.flux_ladder import Ladder, LadderSolution, solve

CURRENT, FLUX_LINKAGE = 0.2, 0.25
COENERGY, ENERGY = 2.0 / 3.0 * CURRENT * FLUX_LINKAGE, CURRENT * FLUX_LINKAGE / 3.0
#: Gap (m) at which the map has the transformer's flux linkage.
GAP = 0.2e-3


@dataclass(frozen=True)
class SquareLaw(MagnetisationCurve):
    """H = Hs (B/Bs)² through the last point (Bs, Hs); the ladder needs no more of a curve."""

    def field_strength(self, b: Floats) -> Floats:
        """Return H (A/m) at flux density `b` (T)."""
        return np.asarray(self.field[-1] * (b / self.flux_density[-1]) ** 2)

    def slope(self, b: Floats) -> Floats:
        """Return dH/dB (m/H) at flux density `b` (T)."""
        return np.asarray(2.0 * self.field[-1] * b / self.flux_density[-1] ** 2)

    def energy_density(self, b: Floats) -> Floats:
        """Return ∫ H dB (J/m³) at flux density `b` (T)."""
        return np.asarray(self.field_strength(b) * b / 3.0)


def one_loop(
    curve: MagnetisationCurve, area: float, length: float, turns: float, reluctance: float = 0.0
) -> Ladder:
    """Return one flux through one piece of iron and one gap."""
    none = np.zeros((1, 1))
    return Ladder(
        curve=curve,
        area=np.array([[area]]),
        length=np.array([[length]]),
        d_length=none,
        cell=np.array([0]),
        reluctance=np.array([[0.0, reluctance]]),
        d_reluctance=np.zeros((1, 2)),
        turns=np.array([[turns]]),
        d_turns=none,
    )


def by_ladder() -> LadderSolution:
    """Return the circuit's state at 0.2 A and −0.2 A."""
    field, flux_density, turns, area = 100.0, 2.0, 10.0, 0.01
    core = SquareLaw(np.array([0.0, flux_density]), np.array([0.0, field]))
    # the core's length for which λ(0.2 A) = N A Bs √(N i/(l Hs)) is 0.25 Wb
    length = turns * CURRENT / field * (turns * area * flux_density / FLUX_LINKAGE) ** 2
    return solve(one_loop(core, area, length, turns), np.array([CURRENT, -CURRENT]))


def by_map() -> CoenergyMap:
    """Return a map with the same square root at each gap: λ = 0.25 Wb √(i/0.2 A) · 0.2 mm/g."""
    i, g = 0.3 * (np.arange(25) / 24.0) ** 3, np.linspace(0.1e-3, 0.3e-3, 8)
    linkage = FLUX_LINKAGE * np.sqrt(i[:, None] / CURRENT) * GAP / g
    coenergy = 2.0 / 3.0 * i[:, None] * linkage
    return fit(Samples(i, g, linkage, coenergy / g, coenergy))
