"""Boundary conditions of the bimorph: support at the base, load at the tip."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from tactgen.geometry.arrays import Complex, Floats

#: Dynamic stiffness (n,) in N/m of a load that depends on the frequencies (n,) in Hz.
Law: TypeAlias = Callable[[Floats], Complex]


@dataclass(frozen=True)
class Springs:
    """Elastic support of the base, a stiffness c + jΩ d − Ω² θ."""

    lateral_stiffness: float  #: N/m
    rotational_stiffness: float  #: N m/rad
    rotational_damping: float = 0.0  #: N m s/rad
    rotational_inertia: float = 0.0  #: kg m²
    #: Of a measured support both dynamic stiffnesses (N/m, N m/rad) over frequency (Hz); the
    #: constants are what statics and undamped modes take
    law: Callable[[Floats], tuple[Complex, Complex]] | None = None


@dataclass(frozen=True)
class TipLoad:
    """Lateral tip load, a stiffness c + jΩ d − Ω² m (N/m, N s/m, kg), on a rigid arm."""

    stiffness: float = 0.0
    damping: float = 0.0
    mass: float = 0.0
    offset: float = 0.0  #: Length of the arm beyond the tip, along the axis (m)
    inertia: float = 0.0  #: Rotational inertia about y at the arm's end (kg m²)

    @property
    def has_size(self) -> bool:
        """Whether it turns with the tip."""
        return bool(np.any(self.offset) or np.any(self.inertia))

    @property
    def arm(self) -> Floats:
        """(2,) Lateral motion of the arm's end per motion [w, ψ] of the tip."""
        return np.array([1.0, -self.offset])

    @property
    def at_tip(self) -> tuple[Floats, Floats]:
        """Stiffness and mass (2, 2) over the tip's motions [w, ψ]."""
        arm = np.outer(self.arm, self.arm)
        return self.stiffness * arm, self.mass * arm + np.diag([0.0, self.inertia])


@dataclass(frozen=True)
class Ends:
    """Support and load of the lateral actuator; by default clamped and free.

    Where many parameter sets are worked on at once, each number is an array over them.
    """

    base: Springs | None = None  #: None holds the base rigidly
    #: Lateral load: constants, or a dynamic stiffness over frequency
    tip: TipLoad | Law = TipLoad()
    across: Springs | None = None  #: The base's in bending across the width; None holds it

    @property
    def conservative_tip(self) -> TipLoad:
        """The load without damping, as statics and undamped modes see it.

        A law of frequency has neither a constant stiffness nor a mass, and where it was
        measured may not include 0 Hz: to them it is a free tip.
        """
        return replace(self.tip, damping=0.0) if isinstance(self.tip, TipLoad) else TipLoad()

    @property
    def lossless(self) -> Ends:
        """The same without damping; see :attr:`conservative_tip`."""
        base = self.base and replace(self.base, rotational_damping=0.0, law=None)
        return Ends(base, self.conservative_tip, self.across)

    @property
    def rigid_motions(self) -> int:
        """Number of rigid-body motions that no spring resists."""
        if self.base is None:
            return 0
        springs = (
            self.base.lateral_stiffness,
            self.base.rotational_stiffness,
            self.conservative_tip.stiffness,
        )
        return max(0, 2 - sum(stiffness > 0.0 for stiffness in springs))
