"""A gap without iron, whose co-energy map is known in closed form."""

from dataclasses import dataclass

import numpy as np

from tactgen.tmm.reluctance.coenergy_map import CoenergyPoint


@dataclass(frozen=True)
class IdealGap:
    """It stands where a co-energy map does; the pull is positive when it closes the gap."""

    strength: float  #: C = µ0 N² A (H m)

    def at(self, current, gap):
        """All that holds at a current (A) and gap (m)."""
        linkage = self.strength * current / gap
        force = float(self.force(current, gap))
        return CoenergyPoint(
            0.5 * linkage * current, linkage, force, self.strength / gap, -linkage / gap,
            -2.0 * force / gap,
        )  # fmt: skip

    def force(self, current, gap):
        """Pull (N)."""
        return 0.5 * self.strength * (current / np.asarray(gap)) ** 2

    def force_gradient(self, current, gap):
        """∂F/∂g (N/m)."""
        return -2.0 * self.force(current, gap) / np.asarray(gap)
