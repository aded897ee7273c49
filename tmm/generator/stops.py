"""The two stops between which the rod's head moves: one potential in its lift and tilt.

The lift u is 0 where the upper stop carries the contact's reference load, positive upwards; the
working gap is then the device's `gap`, else gap + u.  At u = −stroke the lower stop carries it.
What a stop loses over time: :mod:`tmm.generator.transient.system`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.contact import RoughContact

#: A stop's approach and tilt per lift and tilt of the head: of the upper one, of the lower one.
_AS_IS, _TURNED = np.array([1.0, 1.0]), np.array([-1.0, 1.0])


@dataclass(frozen=True)
class Stops:
    """Both stops and the way between them.

    All methods take lift u (m) and tilt ψ (rad) of the head, arrays that broadcast.  Whatever
    they return acts along u and ψ as the gradient of one energy, so nothing is created on a
    closed way.

    Attributes
    ----------
    upper, lower : RoughContact
        The laws.
    stroke : float
        Way of the upright head from one stop to the other (m).
    """

    upper: RoughContact
    lower: RoughContact
    stroke: float

    def energy(self, lift: Floats | float, tilt: Floats | float) -> Floats:
        """Return the energy stored in both contacts (J)."""
        low = self._lowered(lift)
        return np.asarray(self.upper.energy(lift, tilt) + self.lower.energy(low, tilt))

    def forces(self, lift: Floats | float, tilt: Floats | float) -> Floats:
        """Return the energy's gradient (..., 2): N along u, N m along ψ.

        What must act on the head from elsewhere, upwards and turning, to hold it there.
        """
        low = self._lowered(lift)
        along = self.upper.load(lift, tilt) - self.lower.load(low, tilt)
        turning = self.upper.moment(lift, tilt) + self.lower.moment(low, tilt)
        return np.stack(np.broadcast_arrays(along, turning), axis=-1)

    def tangent(self, lift: Floats | float, tilt: Floats | float) -> Floats:
        """Return the stiffness (..., 2, 2) over (u, ψ): symmetric, positive definite."""
        upper = self.upper.tangent(lift, tilt)
        lower = self.lower.tangent(self._lowered(lift), tilt)
        return np.asarray(upper + lower * np.outer(_TURNED, _TURNED))

    def moving(
        self, lift: Floats, tilt: Floats, rate: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Return what the stops do at n instants to a head that moves.

        Parameters
        ----------
        lift, tilt : (n,) array
        rate : (n, 2) array
            Of lift and tilt (m/s, rad/s).

        Returns
        -------
        forces : (n, 2) array
            As :meth:`forces`; the dampers' are damping times rate.
        stiffness, damping, change : (n, 2, 2) array
            :meth:`tangent`; what each stop's relaxation makes of its share; and the derivative of
            damping times rate by lift and tilt, the damping's rate in time, as third derivatives
            commute.
        """
        n = lift.size
        forces, each = np.zeros((n, 2)), np.zeros((3, n, 2, 2))
        for law, sign, at in (
            (self.upper, _AS_IS, lift),
            (self.lower, _TURNED, self._lowered(lift)),
        ):
            if law.is_apart(at, tilt):
                continue
            efforts, stiffness, change = law.moving(at, tilt, rate * sign)
            forces += efforts * sign
            time = law.relaxation_time
            for found, part in zip(each, (stiffness, time * stiffness, time * change), strict=True):
                found += part * np.outer(sign, sign)
        stiff, damping, alters = each
        return forces, stiff, damping, alters

    def holding(self, lift: float) -> RoughContact:
        """Return the law of the nearer stop, which carries a head at rest."""
        return self.lower if self.is_below(lift) else self.upper

    def is_below(self, lift: float) -> bool:
        """Return whether the lower stop is the nearer one."""
        return lift < -0.5 * self.stroke

    def loads(self, lift: Floats | float, tilt: Floats | float = 0.0) -> tuple[Floats, Floats]:
        """Return what the upper and the lower stop carry (N), both positive."""
        return self.upper.load(lift, tilt), self.lower.load(self._lowered(lift), tilt)

    def _lowered(self, lift: Floats | float) -> Floats:
        return np.asarray(-np.asarray(lift, dtype=float) - self.stroke)


def stops_of(device: Device) -> Stops:
    """Return the stops of a device.

    Raises
    ------
    InputError
        If there is nothing between them.
    """
    stroke = device.gap - device.spring.stop_gap
    if not stroke > 0.0:
        raise InputError(
            f"spring.stop_gap = {device.spring.stop_gap * 1e3:g} mm leaves no stroke below gap = "
            f"{device.gap * 1e3:g} mm; use a smaller one"
        )
    return Stops(contact_of(device, "upper"), contact_of(device, "lower"), stroke)


def contact_of(device: Device, stop: Literal["upper", "lower"]) -> RoughContact:
    """Return the law of the head on one of its stops."""
    c, lower = device.contact, stop == "lower"
    return RoughContact(
        radius=device.rod.head_radius,
        decay_length=c.decay_length * (c.lower_decay_ratio if lower else 1.0),
        shape=c.shape,
        relaxation_time=c.relaxation_time * (c.lower_relaxation_ratio if lower else 1.0),
        tangential_ratio=c.tangential_ratio,
    )


@dataclass(frozen=True)
class Play:
    """A spring of stiffness k (N/m or N m/rad) that acts beyond a play p (m or rad) either way."""

    stiffness: float
    play: float

    def force(self, motion: Floats | float) -> Floats:
        """Return the force or moment against a motion (m or rad), of any shape."""
        motion = np.asarray(motion, dtype=float)
        return np.asarray(self.stiffness * (motion - np.clip(motion, -self.play, self.play)))

    def slope(self, motion: Floats | float = 0.0) -> Floats:
        """Return the force's derivative: the stiffness from the play's edge on, inside it 0."""
        return np.asarray(np.where(np.abs(motion) >= self.play, self.stiffness, 0.0))

    @property
    def at_rest(self) -> float:
        """Stiffness to small motions about the middle: 0 with any play."""
        return float(self.slope(0.0))


def lateral_guide(device: Device) -> Play:
    """Return what holds the rod laterally."""
    return Play(device.guide.lateral_stiffness, 0.5 * device.guide.clearance)


def tilt_guide(device: Device) -> Play:
    """Return what holds the rod against tilting."""
    guide = device.guide
    return Play(guide.rotational_stiffness, guide.clearance / guide.guided_length)
