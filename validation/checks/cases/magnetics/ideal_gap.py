"""All the ampere-turns across one straight gap: W' = C i²/(2 g), with C = µ0 N² A."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.tmm.reluctance.coenergy_map import CoenergyPoint


@dataclass(frozen=True)
class IdealGap:
    """It stands where a co-energy map does; the pull is positive when it closes the gap.

    Attributes
    ----------
    strength : float
        C = µ0 N² A (H m).
    """

    strength: float

    def at(self, current: float, gap: float) -> CoenergyPoint:
        """Return all that holds at a current (A) and gap (m)."""
        linkage = self.strength * current / gap
        force = float(self.force(current, gap))
        return CoenergyPoint(
            0.5 * linkage * current, linkage, force, self.strength / gap, -linkage / gap,
            -2.0 * force / gap,
        )  # fmt: skip

    def force(self, current: Any, gap: Any) -> Any:
        """Return the pull (N)."""
        return 0.5 * self.strength * (current / np.asarray(gap)) ** 2

    def force_gradient(self, current: Any, gap: Any) -> Any:
        """Return ∂F/∂g (N/m)."""
        return -2.0 * self.force(current, gap) / np.asarray(gap)
