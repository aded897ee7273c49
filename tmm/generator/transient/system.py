"""What moves: a linear passive structure, springs and stops that are not linear, a coil.

    M x'' + C x' + K x = f + θ U − Σ d_e f_e(δ_e, δ_e') − b F(i, g),
    δ_e = s_e + d_e·x,   g = g_0 + b·x,   λ' = v − R i,   Q = θ·x + C_p U.

The coordinates x are whatever the structure is made of: modes, rigid motions, the rod's height.
Nothing here knows the device; :mod:`tmm.generator.transient.march` moves it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.reluctance.coenergy.cells import Coenergy

#: Below this change over a step, in decay lengths, the slope is its limit for small steps: what
#: is left out is of the same size, and the difference would be made of rounding.
_SMALL_CHANGE = 1e-6


class Law(Protocol):
    """A spring's law over its deformation δ (m or rad)."""

    def energy(self, deformation: float) -> float:
        """Return the stored energy (J)."""
        ...

    def mean(self, before: float, after: float, step: float) -> tuple[float, float, float]:
        """Return the force over a step, its slope by `after`, and its elastic part.

        The elastic part is a discrete gradient: times after − before it is the change of the
        energy, to rounding.  The rest does work that is never negative.
        """
        ...


@dataclass(frozen=True)
class Stop:
    """A spring that pushes only: stiffness k and damper c act while δ > 0, and never pull.

    A Kelvin-Voigt contact cut off where it would pull, so small motions in contact see k and c.

    Attributes
    ----------
    stiffness, damping : float
        N/m and N s/m.
    """

    stiffness: float
    damping: float = 0.0

    def energy(self, deformation: float) -> float:
        """Return k δ²/2 in contact (J)."""
        pressed = max(deformation, 0.0)
        return 0.5 * self.stiffness * pressed * pressed

    def mean(self, before: float, after: float, step: float) -> tuple[float, float, float]:
        """Return force, slope and elastic force over a step (N, N/m, N)."""
        if before > 0.0 and after > 0.0:
            p0, p1, touching, now = before, after, 1.0, 1.0
        elif before <= 0.0 and after <= 0.0:
            return 0.0, 0.0, 0.0
        else:
            p0, p1, now = max(before, 0.0), max(after, 0.0), float(after > 0.0)
            touching = (p1 - p0) / (after - before)
        half = 0.5 * self.stiffness * (p0 + p1)
        elastic = half * touching
        force = elastic + self.damping * (p1 - p0) / step
        if force < 0.0:
            return 0.0, 0.0, elastic
        bend = 0.0 if now == touching else half * (now - touching) / (after - before)
        slope = 0.5 * self.stiffness * now * touching + bend + self.damping * now / step
        return force, slope, elastic


@dataclass(frozen=True)
class RoughPoint:
    """A share of two rough surfaces in contact: force P e^{δ/u₀}, which pushes only.

    The law of :mod:`tmm.generator.contact` at one place of the head; damping is the relaxation
    time times the rate of the force, cut off where the sum would pull.

    Attributes
    ----------
    load : float
        P, the force at δ = 0 (N).
    decay_length : float
        u₀ (m).
    relaxation_time : float
        s.
    """

    load: float
    decay_length: float
    relaxation_time: float = 0.0

    def energy(self, deformation: float) -> float:
        """Return P u₀ e^{δ/u₀} (J), 0 far apart."""
        return self.decay_length * self._force(deformation)

    def mean(self, before: float, after: float, step: float) -> tuple[float, float, float]:
        """Return force, slope and elastic force over a step (N, N/m, N)."""
        begin, end = self._force(before), self._force(after)
        if begin == 0.0 and end == 0.0:
            return 0.0, 0.0, 0.0
        u0 = self.decay_length
        change = (after - before) / u0
        # begin (e^z − 1)/z, which needs no difference of two large forces
        elastic = begin * math.expm1(change) / change if begin and change else end
        if not begin:  # it was so far apart that nothing was counted
            elastic = end / change
        slope = (end - elastic) / (change * u0) if abs(change) > _SMALL_CHANGE else 0.5 * end / u0
        rate = self.relaxation_time / step
        force = elastic + rate * (end - begin)
        if force < 0.0:
            return 0.0, 0.0, elastic
        return force, slope + rate * end / u0, elastic

    def _force(self, deformation: float) -> float:
        exponent = deformation / self.decay_length
        # below, less than 1e-26 of P; above, a stray guess of an iteration
        return self.load * math.exp(min(exponent, 500.0)) if exponent > -60.0 else 0.0


@dataclass(frozen=True)
class CubicSpring:
    """f = k δ + k₃ δ³ (N), in both directions."""

    linear: float
    cubic: float = 0.0

    def energy(self, deformation: float) -> float:
        """Return k δ²/2 + k₃ δ⁴/4 (J)."""
        square = deformation * deformation
        return 0.5 * self.linear * square + 0.25 * self.cubic * square * square

    def mean(self, before: float, after: float, step: float) -> tuple[float, float, float]:
        """Return force, slope and elastic force over a step (N, N/m, N)."""
        squares = before * before + after * after
        total = before + after
        force = 0.5 * self.linear * total + 0.25 * self.cubic * total * squares
        slope = 0.5 * self.linear + 0.25 * self.cubic * (squares + 2.0 * total * after)
        return force, slope, force


@dataclass(frozen=True, eq=False)
class Element:
    """A law along a direction: δ = `offset` + `direction` · x, a name for its force."""

    name: str
    law: Law
    direction: Floats
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Coil:
    """The winding and what its field pulls at.

    Attributes
    ----------
    coenergy : Coenergy
        W'(i, g).
    direction : (n,) float
        b: how the gap opens with the coordinates.
    gap : float
        g_0 at x = 0 (m).
    resistance : float
        Of the circuit (Ω).
    source : {"current", "voltage"}
        What the waveform prescribes.
    width : float
        A change of the gap that counts as large (m).
    largest_current, gaps : float, (float, float)
        Where the co-energy is known (A, m); a run that leaves this range ends.
    """

    coenergy: Coenergy
    direction: Floats
    gap: float
    resistance: float
    source: Literal["current", "voltage"] = "current"
    width: float = 1e-4
    largest_current: float = np.inf
    gaps: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True, eq=False)
class Output:
    """A linear output `row` · x in `unit`, and the size at which its error is judged."""

    row: Floats
    unit: str
    scale: float
    meaning: str = ""


@dataclass(frozen=True, eq=False)
class System:
    """A structure with its springs, its stops and its coil, in SI units.

    Attributes
    ----------
    mass, damping, stiffness : (n, n) float
        Symmetric; mass positive definite, the others positive semidefinite.
    load : (n,) float
        Constant forces: preload and weight.
    coupling : (n,) float
        θ: force per volt across the bimorph, and its charge per coordinate.
    capacitance : float
        C_p at x = 0 (F).
    elements : tuple of Element
        Springs and stops.
    coil : Coil or None
        The normal actuator's winding.
    outputs : dict of str to Output
        What is recorded of x, and judged.
    """

    mass: Floats
    damping: Floats
    stiffness: Floats
    load: Floats
    coupling: Floats
    capacitance: float = 0.0
    elements: tuple[Element, ...] = ()
    coil: Coil | None = None
    outputs: Mapping[str, Output] = field(default_factory=dict)
