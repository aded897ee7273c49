"""The rod in its bore: two springs, lateral and against tilting, that act beyond a play.

A bore wider than what slides in it by the clearance c (of diameters) touches nothing while the
rod is off its axis by less than c/2, or tilted by less than c/L over the guided length L, when
it touches at both ends.  Beyond that

    F = k (x − clip(x, −p, p)),     p = c/2 or c/L,

so that a clearance of 0 is a plain spring and a large one is no guide.  Each of the two motions
is taken by itself, without friction, and the bore does not hinder the motion along the axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device


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
