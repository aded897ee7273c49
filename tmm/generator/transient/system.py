"""Dynamic system: linear structure, nonlinear springs and stops, coil.

    M x'' + C x' + K x = f + θ U − Σ d_e f_e(δ_e, δ_e') − b F(i, g),
    δ_e = s_e + d_e·x,   g = g_0 + b·x,   λ' = v − R i,   Q = θ·x + C_p U.

The coordinates x are whatever the structure is made of: modes, rigid motions, the rod's height.
Nothing here knows the device; :mod:`tmm.generator.transient.time_integration` moves it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, expm1
from typing import ClassVar, Literal, TypeAlias

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.reluctance.coenergy_map import Coenergy

#: Below this change over a step, in decay lengths, a slope is its limit for small steps: what is
#: left out is of the same size, and the difference would be made of rounding.
_SMALL_CHANGE = 1e-6
#: Exponents beyond which rough surfaces are taken to be apart (1e-26 of the load), and at which a
#: stray guess of an iteration is cut off.
_APART, _LARGEST = -60.0, 500.0
#: Of each spring: force over a step, its slope by the deformation after it, its elastic part
#: (N, N/m, N), which times the change of the deformation is that of the energy, to rounding.
Means: TypeAlias = tuple[Sequence[float], Sequence[float], Sequence[float]]


@dataclass(frozen=True)
class Stop:
    """A spring that pushes only: its stiffness k acts while δ > 0."""

    stiffness: float  #: N/m
    apart: ClassVar[float] = 0.0

    def energy(self, deformation: Floats) -> Floats:
        """K δ²/2 in contact (J)."""
        return np.asarray(0.5 * self.stiffness * np.maximum(deformation, 0.0) ** 2)

    def means(self, before: Sequence[float], moved: Sequence[float], step: float) -> Means:
        """Mean forces over a step of so many seconds that changes deformations by `moved`."""
        forces, slopes = [], []
        for b, m in zip(before, moved, strict=True):
            p0, p1 = max(b, 0.0), max(b + m, 0.0)
            half = 0.5 * self.stiffness * (p0 + p1)
            now = 1.0 if p1 > 0.0 else 0.0
            touching, bend = now, 0.0
            if (p0 > 0.0) != (p1 > 0.0):
                # share of the way that is gone in contact; `m` is not 0 here
                touching = (p1 - p0) / m
                bend = half * (now - touching) / m
            forces.append(half * touching)
            slopes.append(0.5 * self.stiffness * now * touching + bend)
        return forces, slopes, forces


@dataclass(frozen=True)
class RoughPoint:
    """A share of two rough surfaces in contact: force P e^{δ/u₀}, which pushes only.

    The law of :mod:`tmm.generator.contact` at one place of the head; damping is the relaxation
    time times the rate of the force, cut off where the sum would pull.
    """

    load: float  #: P, the force at δ = 0 (N)
    decay_length: float  #: u₀ (m)
    relaxation_time: float = 0.0  #: s

    @property
    def apart(self) -> float:
        """Deformation (m) up to which nothing acts."""
        return _APART * self.decay_length

    def energy(self, deformation: Floats) -> Floats:
        """P u₀ e^{δ/u₀} (J), 0 far apart."""
        return np.asarray(self.decay_length * self._force(deformation / self.decay_length))

    def force(self, deformation: Floats, rate: Floats) -> Floats:
        """Force (N) at a deformation (m) and its rate (m/s)."""
        growth = 1.0 + self.relaxation_time * rate / self.decay_length
        return np.asarray(self._force(deformation / self.decay_length) * np.maximum(growth, 0.0))

    def means(self, before: Sequence[float], moved: Sequence[float], step: float) -> Means:
        """Mean forces over a step."""
        u0, load, rate = self.decay_length, self.load, self.relaxation_time / step
        forces, slopes, parts = [], [], []
        for b, m in zip(before, moved, strict=True):
            at, change = b / u0, m / u0
            after = at + change
            begin = load * exp(min(_LARGEST, at)) if at > _APART else 0.0
            if after <= _APART:
                rise = -begin
            elif begin == 0.0:
                rise = load * exp(min(_LARGEST, after))
            else:
                # needs no difference of two large forces
                rise = begin * expm1(min(_LARGEST, change))
            end = begin + rise
            elastic = end if change == 0.0 else rise / change
            force = elastic + rate * rise
            if force > 0.0:
                small = -_SMALL_CHANGE < change < _SMALL_CHANGE
                slope = 0.5 * end if small else (end - elastic) / change
                forces.append(force)
                slopes.append((slope + rate * end) / u0)
            else:
                forces.append(0.0)
                slopes.append(0.0)
            parts.append(elastic)
        return forces, slopes, parts

    def _force(self, exponent: Floats) -> Floats:
        near = self.load * np.exp(np.minimum(exponent, _LARGEST))
        return np.asarray(np.where(exponent > _APART, near, 0.0))


@dataclass(frozen=True)
class CubicSpring:
    """f = k δ + k₃ δ³ (N), in both directions."""

    linear: float
    cubic: float = 0.0
    apart: ClassVar[float] = -math.inf

    def energy(self, deformation: Floats) -> Floats:
        """K δ²/2 + k₃ δ⁴/4 (J)."""
        square = np.square(deformation)
        return np.asarray(0.5 * self.linear * square + 0.25 * self.cubic * square * square)

    def means(self, before: Sequence[float], moved: Sequence[float], step: float) -> Means:
        """Mean forces over a step."""
        forces, slopes = [], []
        for b, m in zip(before, moved, strict=True):
            after = b + m
            squares, total = b * b + after * after, b + after
            forces.append(0.5 * self.linear * total + 0.25 * self.cubic * total * squares)
            bend = squares + 2.0 * total * after
            slopes.append(0.5 * self.linear + 0.25 * self.cubic * bend)
        return forces, slopes, forces


#: A spring's law over its deformation δ (m).  Up to `apart` (m) nothing acts and nothing is stored.
Law: TypeAlias = Stop | RoughPoint | CubicSpring


@dataclass(frozen=True)
class Element:
    """One spring or p of one kind, side by side: δ = `offset` + `direction` · x."""

    name: str  #:
    law: Law  #: Its parameters are numbers or (p,) arrays
    direction: Floats  #: (p, n)
    offset: Floats | float = 0.0  #: m


@dataclass(frozen=True)
class Friction:
    """Coulomb friction under an element's force, or a constant one, smoothed at small speeds.

    T = −µ N v/√(v² + v_s²) along `direction` · x: it creeps where a rough surface would stick,
    and takes energy at any speed.
    """

    element: int | None  #: Which of the system's elements pushes with N; None: N is constant
    direction: Floats  #: (n,)
    coefficient: float  #: µ
    speed: float = 1e-4  #: v_s (m/s)
    load: float = 0.0  #: The constant N (N)


@dataclass(frozen=True)
class Coil:
    """Winding with its magnetic force."""

    coenergy: Coenergy  #: W'(i, g)
    direction: Floats  #: (n,) b: how the gap opens with the coordinates
    gap: float  #: g_0 at x = 0 (m)
    resistance: float  #: Of the circuit (Ω)
    source: Literal["current", "voltage"] = "current"  #: What the waveform prescribes
    width: float = 1e-4  #: A change of the gap that counts as large (m)
    #: Where the co-energy is known (A, m); a run that leaves this range ends
    largest_current: float = np.inf
    gaps: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True)
class Output:
    """A linear output `row` · x in `unit`.

    `scale` is the size at which its error is judged, `step_scale` the size at which each step's is:
    what is not judged itself may carry errors into what is.
    """

    row: Floats
    unit: str
    scale: float
    meaning: str = ""
    step_scale: float | None = None


@dataclass(frozen=True)
class System:
    """A structure with its springs, its stops and its coil, in SI units."""

    #: (n, n) Symmetric and positive semidefinite; what has no mass is held by a damper or a spring
    mass: Floats
    damping: Floats
    stiffness: Floats
    load: Floats  #: (n,) Constant forces: preload and weight
    coupling: Floats  #: (n,) θ: force per volt across the bimorph, and its charge per coordinate
    capacitance: float = 0.0  #: C_p at x = 0 (F)
    elements: tuple[Element, ...] = ()  #: Springs and stops
    frictions: tuple[Friction, ...] = ()  #: Under elements that push
    coil: Coil | None = None  #: The normal actuator's winding
    #: What is recorded of x, and judged
    outputs: Mapping[str, Output] = field(default_factory=dict)
