"""What every model of the normal actuator says at one current and gap, with error bars."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactgen.geometry.store.values import storable
from tactgen.validation.engine.results import Estimate


@storable
@dataclass(frozen=True)
class MagneticPoint:
    """The actuator at one current (A) and gap (m).

    Attributes
    ----------
    force, flux_linkage, coenergy, incremental_inductance : Estimate
        SI units; the pull is positive when it closes the gap.
    method : str
        How the error bars come about.
    beyond_table : float
        Share of the iron's volume that lies beyond the end of a magnetisation curve that
        ends before the steel is saturated.
    force_by_stress : float
        The pull by the stress in the air (N), where the model's own is by virtual work; nan
        elsewhere.
    """

    current: float
    gap: float
    force: Estimate
    flux_linkage: Estimate
    coenergy: Estimate
    incremental_inductance: Estimate
    method: str
    beyond_table: float
    force_by_stress: float = math.nan

    @property
    def inductance(self) -> Estimate:
        """Apparent inductance λ/i (H), its limit ∂λ/∂i at zero current."""
        if self.current == 0.0:
            return self.incremental_inductance
        linkage = self.flux_linkage
        return Estimate(linkage.value / self.current, linkage.error / abs(self.current))
