"""Laws of springs and stops, over one step: forces that do exactly the work of their energy.

What a step takes for the force of a law is the change of its energy over the change of the
deformation, a discrete gradient, and a damping part whose work is never negative.  Parameters and
deformations are numbers, or arrays over many springs of one kind.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from tactgen.geometry.arrays import Floats

#: A number, or an array of them for many springs at once.
Value = Any

#: Below this change over a step, in decay lengths, a slope is its limit for small steps: what is
#: left out is of the same size, and the difference would be made of rounding.
_SMALL_CHANGE = 1e-6
#: Exponents beyond which rough surfaces are taken to be apart (1e-26 of the load), and at which a
#: stray guess of an iteration is cut off.
_APART, _LARGEST = -60.0, 500.0


class Mean(NamedTuple):
    """Force over a step, its slope by the deformation after it, its elastic part (N, N/m, N)."""

    force: Floats
    slope: Floats
    elastic: Floats


class Law(Protocol):
    """A spring's law over its deformation δ (m)."""

    def energy(self, deformation: Value) -> Floats:
        """Return the stored energy (J)."""
        ...

    def force(self, deformation: Value, rate: Value) -> Floats:
        """Return the force (N) at a deformation (m) and its rate (m/s)."""
        ...

    def apart(self, before: Floats, after: Floats) -> bool:
        """Return whether nothing acts and nothing is stored before and after a step."""
        ...

    def mean(self, before: Value, after: Value, step: float) -> Mean:
        """Return what acts over a step of so many seconds.

        The elastic part times after − before is the change of the energy, to rounding.
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

    stiffness: Value
    damping: Value = 0.0

    def energy(self, deformation: Value) -> Floats:
        """Return k δ²/2 in contact (J)."""
        return np.asarray(0.5 * self.stiffness * np.maximum(deformation, 0.0) ** 2)

    def force(self, deformation: Value, rate: Value) -> Floats:
        """Return the force (N) at a deformation (m) and its rate (m/s)."""
        pressed = np.maximum(deformation, 0.0)
        force = self.stiffness * pressed + self.damping * rate * (pressed > 0.0)
        return np.asarray(np.maximum(force, 0.0))

    def apart(self, before: Floats, after: Floats) -> bool:
        """Return whether nothing acts and nothing is stored before and after a step."""
        return bool(max(before.max(), after.max()) <= 0.0)

    def mean(self, before: Value, after: Value, step: float) -> Mean:
        """Return what acts over a step."""
        p0, p1 = np.maximum(before, 0.0), np.maximum(after, 0.0)
        now, change = (p1 > 0.0).astype(float), after - before
        mixed = (p0 > 0.0) != (p1 > 0.0)
        # share of the way that is gone in contact; `change` is no 0 where it is not 0 or 1
        way = np.where(mixed, change, 1.0)
        touching = np.where(mixed, (p1 - p0) / way, now)
        half = 0.5 * self.stiffness * (p0 + p1)
        elastic = half * touching
        force = elastic + self.damping * (p1 - p0) / step
        slope = 0.5 * self.stiffness * now * touching + self.damping * now / step
        slope = slope + np.where(mixed, half * (now - touching) / way, 0.0)
        return Mean(np.maximum(force, 0.0), np.where(force > 0.0, slope, 0.0), elastic)


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

    load: Value
    decay_length: Value
    relaxation_time: Value = 0.0

    def energy(self, deformation: Value) -> Floats:
        """Return P u₀ e^{δ/u₀} (J), 0 far apart."""
        return np.asarray(self.decay_length * self._force(deformation / self.decay_length))

    def force(self, deformation: Value, rate: Value) -> Floats:
        """Return the force (N) at a deformation (m) and its rate (m/s)."""
        growth = 1.0 + self.relaxation_time * rate / self.decay_length
        return np.asarray(self._force(deformation / self.decay_length) * np.maximum(growth, 0.0))

    def apart(self, before: Floats, after: Floats) -> bool:
        """Return whether nothing acts and nothing is stored before and after a step."""
        return bool(max(before.max(), after.max()) < _APART * self.decay_length)

    def mean(self, before: Value, after: Value, step: float) -> Mean:
        """Return what acts over a step."""
        u0 = self.decay_length
        begin, end = self._force(before / u0), self._force(after / u0)
        change = (after - before) / u0
        way = np.where(change == 0.0, 1.0, change)
        # begin (e^z − 1)/z needs no difference of two large forces; a begin of 0 was cut off
        grown = np.where(begin > 0.0, begin * np.expm1(np.minimum(change, _LARGEST)), end)
        elastic = np.where(change == 0.0, end, grown / way)
        steep = np.abs(change) > _SMALL_CHANGE
        slope = np.where(steep, (end - elastic) / way, 0.5 * end) / u0
        rate = self.relaxation_time / step
        force = elastic + rate * (end - begin)
        slope = np.where(force > 0.0, slope + rate * end / u0, 0.0)
        return Mean(np.maximum(force, 0.0), slope, elastic)

    def _force(self, exponent: Value) -> Floats:
        near = self.load * np.exp(np.minimum(exponent, _LARGEST))
        return np.asarray(np.where(exponent > _APART, near, 0.0))


@dataclass(frozen=True)
class CubicSpring:
    """f = k δ + k₃ δ³ (N), in both directions."""

    linear: Value
    cubic: Value = 0.0

    def energy(self, deformation: Value) -> Floats:
        """Return k δ²/2 + k₃ δ⁴/4 (J)."""
        square = deformation * deformation
        return np.asarray(0.5 * self.linear * square + 0.25 * self.cubic * square * square)

    def force(self, deformation: Value, rate: Value) -> Floats:
        """Return the force (N) at a deformation (m)."""
        return np.asarray(self.linear * deformation + self.cubic * deformation**3)

    def apart(self, before: Floats, after: Floats) -> bool:
        """Return whether nothing acts and nothing is stored before and after a step."""
        return False

    def mean(self, before: Value, after: Value, step: float) -> Mean:
        """Return what acts over a step."""
        squares, total = before * before + after * after, before + after
        force = 0.5 * self.linear * total + 0.25 * self.cubic * total * squares
        slope = 0.5 * self.linear + 0.25 * self.cubic * (squares + 2.0 * total * after)
        return Mean(force, slope, force)
