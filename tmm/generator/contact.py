"""The law of two rough surfaces pressed together: the rod's head on one of its stops.

The pressure of rough surfaces grows exponentially as they approach, p = p₀ e^{δ/u₀}, with one
length u₀, a few tenths of their height of roughness, as long as only a small part touches
(B.N.J. Persson, Phys. Rev. Lett. 99 (2007) 125502).  So stiffness is proportional to load.
Over a flat head of radius R, whose section lifts by x ψ when it tilts, the pressure integrates
to a potential in approach δ and tilt ψ,

    V(δ, ψ) = P u₀ e^{δ/u₀} S(R ψ / u₀),    S = I₀(a) of a ring, 2 I₁(a)/a of a disc,

with the modified Bessel functions I_n, P the load at δ = 0.  Load N = ∂V/∂δ and moment
M = ∂V/∂ψ follow.  At a constant load M = N R S'/S: first a rotational spring N R²/(2 u₀) of a
ring or N R²/(4 u₀) of a disc, then ever softer as one side unloads, at last the N R at which the
head stands on its edge.

No friction, no adhesion; nothing is said about speed but the relaxation time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.parts import MM, moving_rings
from tactgen.geometry.errors import InputError

#: Largest exponent of a pressure: a solver's stray guess gives a huge number, not an overflow.
_LARGEST = 500.0
#: Exponent of a pressure that is nothing.
_APART = -92.0
#: S and its first three derivatives, each a sum of I₀, I₁, … with these weights: of a ring S = I₀,
#: of a disc S = 2 I₁/a = I₀ − I₂, and I_n' = (I_{n−1} + I_{n+1})/2.
_WEIGHTS = {
    "ring": np.array([[8, 0, 0, 0], [0, 8, 0, 0], [4, 0, 4, 0], [0, 6, 0, 2]]) / 8.0,
    "disc": np.array(
        [[8, 0, -8, 0, 0, 0], [0, 4, 0, -4, 0, 0], [2, 0, 0, 0, -2, 0], [0, 2, 0, -1, 0, -1]]
    ) / 8.0,
}  # fmt: skip


@dataclass(frozen=True)
class RoughContact:
    """A flat round head on a flat stop.

    All methods take approach δ (m, growing presses) and tilt ψ (rad), or load N (N) and tilt,
    arrays that broadcast.
    """

    radius: float  #: Of the head, R (m)
    decay_length: float  #: Approach over which the pressure grows by e, u₀ (m)
    shape: Literal["ring", "disc"] = "ring"  #: What of the head touches: its rim or all of it
    relaxation_time: float = 0.0  #: Viscous damping over stiffness (s)
    tangential_ratio: float = 0.82  #: Stiffness along the surfaces over that across them
    #: Load at δ = ψ = 0 (N).  It says where δ is counted from and nothing else: twice as much moves
    #: all positions by u₀ ln 2
    reference_load: float = 0.1

    def load(self, approach: Floats | float, tilt: Floats | float) -> Floats:
        """Load N = ∂V/∂δ (N), with which the surfaces push each other apart."""
        return np.asarray(self._derivatives(approach, tilt, 1)[0])

    def moment(self, approach: Floats | float, tilt: Floats | float) -> Floats:
        """Moment M = ∂V/∂ψ (N m) that tilts the head by ψ at this approach."""
        return np.asarray(self._derivatives(approach, tilt, 2)[1])

    def efforts(self, approach: Floats | float, tilt: Floats | float) -> Floats:
        """Load and moment (..., 2)."""
        return np.moveaxis(self._derivatives(approach, tilt, 2), 0, -1)

    def tangent(self, approach: Floats | float, tilt: Floats | float) -> Floats:
        """Stiffness (..., 2, 2), ∂(N, M)/∂(δ, ψ): symmetric, positive definite."""
        return _symmetric(self._derivatives(approach, tilt, 3) / self.decay_length)

    def moving(self, approach: Floats, tilt: Floats, rate: Floats) -> tuple[Floats, Floats, Floats]:
        """Efforts, stiffness and their derivatives at n instants.

        Parameters
        ----------
        approach, tilt : (n,) array
        rate : (n, 2) array
            Of approach and tilt (m/s, rad/s).

        Returns
        -------
        efforts : (n, 2) array
            Load and moment.
        stiffness : (n, 2, 2) array
            As :meth:`tangent`.
        change : (n, 2, 2) array
            The stiffness's rate in time.
        """
        found, u0 = self._derivatives(approach, tilt, 4), self.decay_length
        nearer, turning = rate.T
        change = (found[:3] * nearer + found[1:] * turning) / u0**2
        return found[:2].T, _symmetric(found[:3] / u0), _symmetric(change)

    def is_apart(self, approach: Floats, tilt: Floats) -> bool:
        """Whether at all of these places less than 1e-40 of the reference load acts."""
        at = np.max(np.asarray(approach) / self.decay_length + np.abs(self._relative(tilt)))
        return bool(at < _APART)

    def approach(self, load: Floats | float, tilt: Floats | float = 0.0) -> Floats:
        """Approach (m) at which the tilted head carries a load above 0."""
        growth = np.asarray(load) / (self.reference_load * self._shape(tilt, 1)[0])
        return np.asarray(self.decay_length * (np.log(growth) - np.abs(self._relative(tilt))))

    def moment_under(self, load: Floats | float, tilt: Floats | float) -> Floats:
        """Moment (N m) that tilts the head while the load stays: N R S'/S."""
        value, slope = self._shape(tilt, 2)
        return np.asarray(np.asarray(load) * self.radius * slope / value)

    def stiffness_under(self, load: Floats | float, tilt: Floats | float = 0.0) -> Floats:
        """Slope ∂M/∂ψ (N m/rad) while the load stays."""
        value, slope, bend = self._shape(tilt, 3)
        factor = bend / value - (slope / value) ** 2
        return np.asarray(np.asarray(load) * self.radius**2 / self.decay_length * factor)

    def tangential_stiffness(self, load: Floats | float) -> Floats:
        """Stiffness along the surfaces (N/m), the head upright."""
        return np.asarray(self.tangential_ratio * np.asarray(load) / self.decay_length)

    def uplift_moment(self, load: Floats | float) -> Floats:
        """Moment (N m) at which a bed of linear springs would begin to lift.

        N R/2 of a ring and N R/4 of a disc: a measure of where softening counts, since rough
        surfaces unload gradually.
        """
        upright_bend = _WEIGHTS[self.shape][2, 0]  # S'' of the upright head
        return np.asarray(np.asarray(load) * self.radius * upright_bend)

    def tipping_moment(self, load: Floats | float) -> Floats:
        """Moment (N m) at which the head stands on its edge, N R: the most it bears."""
        return np.asarray(np.asarray(load) * self.radius)

    def _relative(self, tilt: Floats | float) -> Floats:
        return np.asarray(self.radius * np.asarray(tilt, dtype=float) / self.decay_length)

    def _derivatives(self, approach: Floats | float, tilt: Floats | float, count: int) -> Floats:
        """P e^{δ/u₀} Rⁿ S⁽ⁿ⁾ (count, ...): V differentiated by ψ n times.

        The first is by δ instead; one more by either divides by u₀.
        """
        exponent = np.asarray(approach, dtype=float) / self.decay_length
        exponent = exponent + np.abs(self._relative(tilt))
        scale = self.reference_load * np.exp(np.minimum(exponent, _LARGEST))
        shape = self._shape(tilt, count)
        return np.stack([scale * self.radius**n * part for n, part in enumerate(shape)])

    def _shape(self, tilt: Floats | float, count: int) -> Floats:
        """S, S', … (count, ...) at a = R ψ/u₀, times e^{-|a|}: no overflow on a tilted head."""
        from scipy.special import i0e, i1e, ive

        a, weights = self._relative(tilt), _WEIGHTS[self.shape][:count]
        used = np.flatnonzero(weights.any(axis=0))
        # the first two have functions of their own, which cost a tenth
        parts = [i0e(a) if n == 0 else i1e(a) if n == 1 else ive(n, a) for n in used]
        return np.tensordot(weights[:, used], parts, 1)


def _symmetric(entries: Floats) -> Floats:
    """Matrices (..., 2, 2) of their entries (3, ...)."""
    return np.moveaxis(entries[[[0, 1], [1, 2]]], (0, 1), (-2, -1))


@dataclass(frozen=True)
class Stops:
    """Both stops and the way between them.

    All methods take lift u (m) and tilt ψ (rad) of the head, arrays that broadcast.  Whatever
    they return acts along u and ψ as the gradient of one energy, so nothing is created on a
    closed way.
    """

    #: The laws
    upper: RoughContact
    lower: RoughContact
    stroke: float  #: Way of the upright head from one stop to the other (m)

    def forces(self, lift: Floats | float, tilt: Floats | float) -> Floats:
        """Energy's gradient (..., 2): N along u, N m along ψ.

        What must act on the head from elsewhere, upwards and turning, to hold it there.
        """
        return np.asarray(sum(law.efforts(at, tilt) * sign for law, sign, at in self._sides(lift)))

    def tangent(self, lift: Floats | float, tilt: Floats | float) -> Floats:
        """Stiffness (..., 2, 2) over (u, ψ): symmetric, positive definite."""
        sides = self._sides(lift)
        return np.asarray(sum(law.tangent(at, tilt) * np.outer(s, s) for law, s, at in sides))

    def moving(
        self, lift: Floats, tilt: Floats, rate: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        """Stop forces on a moving head at n instants.

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
        for law, sign, at in self._sides(lift):
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
        """Law of the nearer stop, which carries a head at rest."""
        return self.lower if self.is_below(lift) else self.upper

    def is_below(self, lift: float) -> bool:
        """Whether the lower stop is the nearer one."""
        return lift < -0.5 * self.stroke

    def loads(self, lift: Floats | float, tilt: Floats | float = 0.0) -> tuple[Floats, Floats]:
        """Loads of the upper and the lower stop (N), both positive."""
        upper, lower = (law.load(at, tilt) for law, _, at in self._sides(lift))
        return upper, lower

    def _sides(self, lift: Floats | float) -> tuple[tuple[RoughContact, Floats, Floats], ...]:
        """Laws of both stops, their approach and tilt per lift and tilt, and the approach (m)."""
        up, down = np.array([1.0, 1.0]), np.array([-1.0, 1.0])
        at = np.asarray(lift, dtype=float)
        return (self.upper, up, at), (self.lower, down, -at - self.stroke)


def stops_of(device: Device) -> Stops:
    """Stops of a device.

    Raises InputError if there is nothing between them.
    """
    stroke = device.gap - device.spring.stop_gap
    if not stroke > 0.0:
        raise InputError(
            f"spring.stop_gap = {device.spring.stop_gap * 1e3:g} mm leaves no stroke below gap = "
            f"{device.gap * 1e3:g} mm; use a smaller one"
        )
    return Stops(contact_of(device, "upper"), contact_of(device, "lower"), stroke)


def sprung_board(device: Device, lift: float, load: float) -> Callable[[Floats], Complex] | None:
    """Lateral dynamic stiffness (n,) in N/m over frequency (Hz) of contact and upper board.

    Contact and board in series, the board a mass on its springs.  None where the board is rigid, or
    the rod at a lift (m) where the lower stop holds it, whose sleeve stands in the lower board; the
    stop carries `load` (N).
    """
    contact, stops = device.contact, stops_of(device)
    if not contact.board_stiffness or stops.is_below(lift):
        return None
    law = stops.holding(lift)
    along = float(law.tangential_stiffness(load))

    def stiffness(frequencies: Floats) -> Complex:
        omega = 2.0 * np.pi * np.asarray(frequencies, dtype=float)
        held = along * (1.0 + 1j * omega * law.relaxation_time)
        board = contact.board_stiffness * (1.0 + 1j * contact.board_loss_factor)
        board = board - omega**2 * contact.board_mass
        return np.asarray(held * board / (held + board))

    return stiffness


def contact_of(device: Device, stop: Literal["upper", "lower"]) -> RoughContact:
    """Law of the head on one of its stops."""
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
        """Force or moment against a motion (m or rad), of any shape."""
        motion = np.asarray(motion, dtype=float)
        return np.asarray(self.stiffness * (motion - np.clip(motion, -self.play, self.play)))

    def slope(self, motion: Floats | float = 0.0) -> Floats:
        """Force's derivative: the stiffness from the play's edge on, inside it 0."""
        return np.asarray(np.where(np.abs(motion) >= self.play, self.stiffness, 0.0))

    @property
    def at_rest(self) -> float:
        """Stiffness to small motions about the middle: 0 with any play."""
        return float(self.slope(0.0))


def lateral_guide(device: Device) -> Play:
    """Lateral guide of the rod."""
    return Play(device.guide.lateral_stiffness, 0.5 * device.guide.clearance)


def tilt_guide(device: Device) -> Play:
    """Tilt guide of the rod."""
    guide = device.guide
    return Play(guide.rotational_stiffness, guide.clearance / guide.guided_length)


@dataclass(frozen=True)
class RigidBody:
    """A rigid body of revolution about the z axis."""

    mass: float  #: kg
    centre: float  #: Height of its centre of mass (m), 0 at the rod's top face: usually negative
    inertia: float  #: About a transverse axis through the centre of mass (kg m²)

    @property
    def mass_matrix(self) -> Floats:
        """Over lateral motion and tilt at the rod's top face (2, 2), in kg, kg m and kg m²."""
        lever = -self.mass * self.centre
        return np.array([[self.mass, lever], [lever, self.inertia + self.mass * self.centre**2]])


def moving_rod(device: Device) -> RigidBody:
    """Rod and coil as one body; the bimorph on top is not in it."""
    density = {
        "rod": device.rod.density,
        "coil": device.coil.copper_density * device.coil.fill_factor,
    }
    rings = [
        (density[name], ring.inner, ring.outer, ring.low, ring.high)
        for name, rings in moving_rings(device).items()
        for ring in rings
    ]
    rho, inner, outer, low, high = np.array(rings).T * np.array([[1.0], *[[1.0 / MM]] * 4])
    masses = rho * np.pi * (outer**2 - inner**2) * (high - low)
    middle = 0.5 * (low + high)
    mass = float(masses.sum())
    centre = float(masses @ middle) / mass
    # each about a transverse axis through its own centre, then through that of all
    own = (3.0 * (inner**2 + outer**2) + (high - low) ** 2) / 12.0
    return RigidBody(mass, centre, float(masses @ (own + (middle - centre) ** 2)))
