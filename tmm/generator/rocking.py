"""The bimorph on a head that may rock and lift off its stop, however large the motion.

All that is linear, bimorph and load, is seen at the tilt ψ of the head; the head's lift u has
the rod's and the bimorph's mass.  On both acts the contact of the stops by its own law, not its
slope, with the return spring and the magnetic pull.  Along the surfaces the contact stays the
spring that it is at rest.  The coil is driven by a current that stays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Law as TipLaw
from tactgen.geometry.bimorph.ends import TipLoad
from tactgen.geometry.device.parameters import Support
from tactgen.tmm.generator.contact import RoughContact
from tactgen.tmm.generator.guide import tilt_guide
from tactgen.tmm.generator.held_base import pressed_support
from tactgen.tmm.generator.moving_mass import moving_rod
from tactgen.tmm.generator.positions import AxialForces, RestingPlace
from tactgen.tmm.generator.stops import Stops
from tactgen.tmm.harmonic_balance.oscillator import LawPoint, Orbit, Oscillator
from tactgen.tmm.ports.multiport import Multiport, Response, reduce, respond, terminate
from tactgen.tmm.ports.terminations import tip_stiffness

#: Over this share of the contact's decay length its stiffness is differentiated along a motion;
#: the error goes with its square.
_STEP = 1e-4


@dataclass(frozen=True)
class RockingHead:
    """The bimorph on its head, as harmonic balance takes it.

    Attributes
    ----------
    place : RestingPlace
        Where the rod rests.
    support : Support
        What the contact is to small motions there.
    oscillator : Oscillator
        In lift from that place (m) and tilt (rad) of the head; the drive is the voltage (V).
    stops : Stops
        What the head touches.
    attached : callable
        From frequencies (n,) in Hz to the bimorph's ports with load, lateral support and the
        head's inertia, but not what resists the tilt.
    """

    place: RestingPlace
    support: Support
    oscillator: Oscillator
    stops: Stops
    attached: Callable[[Floats], Multiport]

    def response(self, orbit: Orbit) -> Response:
        """Return all motions and the charge at the harmonics (H + 1,) of an orbit."""
        n = np.arange(orbit.harmonics + 1)
        drive = {"psi_base": orbit.spectrum[:, 1], "voltage": orbit.level * (n == 1)}
        return respond(self.attached(n * orbit.frequency), drive)

    def contact(self, orbit: Orbit, samples: int) -> tuple[Floats, Floats]:
        """Return what the stops do to the head over a period, without their damping.

        Returns
        -------
        load : (samples,) array
            Force of both stops together (N), 0 where the head flies.
        moment : (samples,) array
            Moment against the tilt (N m).
        """
        motion = orbit.motion(samples)
        lift, tilt = self.place.lift + motion[:, 0], motion[:, 1]
        upper, lower = self.stops.loads(lift, tilt)
        return upper + lower, self.stops.forces(lift, tilt)[:, 1]


def rocking_head(
    bimorph: Callable[[Floats], Multiport],
    tip: TipLoad | TipLaw,
    forces: AxialForces,
    place: RestingPlace,
    current: float,
    bimorph_mass: float,
) -> RockingHead:
    """Return the bimorph on a head that rests on a stop.

    Parameters
    ----------
    bimorph : callable
        From frequencies (n,) in Hz, 0 among them, to the bimorph's five ports, wired as it is.
    tip : TipLoad or law
        What the tip moves laterally; at harmonics, too.
    forces : AxialForces
        What acts along the axis.
    place : RestingPlace
        Where the rod rests under these.
    current : float
        In the coil (A).
    bimorph_mass : float
        kg, carried along the axis by the rod.
    """
    device = forces.device
    law = forces.stops.holding(place.lift)
    support = pressed_support(device, law, place.contact_force)
    body = moving_rod(device)
    bore = tilt_guide(device)
    mass = body.mass + bimorph_mass

    def attached(frequencies: Floats) -> Multiport:
        omega = 2.0 * np.pi * frequencies
        tilting = bore.at_rest - omega**2 * support.rotational_inertia
        loads = {
            "w_base": support.lateral_stiffness,
            "psi_base": tilting,
            "w_tip": tip_stiffness(tip, frequencies),
        }
        return terminate(bimorph(frequencies), loads)

    def linear(omega: Floats) -> Complex:
        port = reduce(attached(omega / (2.0 * np.pi)), ("psi_base", "voltage")).stiffness
        d = np.zeros((omega.size, 2, 3), dtype=complex)
        d[:, 0, 0] = 1j * omega * device.guide.axial_damping - omega**2 * mass
        d[:, 1, 1:] = port[:, 0]
        return d

    def acting(motion: Floats, rate: Floats) -> LawPoint:
        lift, tilt = place.lift + motion[:, 0], motion[:, 1]
        effort = forces.stops.forces(lift, tilt)
        tangent, damping = forces.stops.stiffness_and_damping(lift, tilt)
        effort = effort + np.einsum("nij,nj->ni", damping, rate)
        effort[:, 0] += forces.pressed - forces.finger_force(current, lift)
        by_motion = tangent + _along(forces.stops, law, np.stack([lift, tilt], axis=-1), rate)
        by_motion[:, 0, 0] += device.spring.stiffness
        if forces.pull is not None:
            by_motion[:, 0, 0] += forces.pull.force_gradient(current, forces.gap(lift))
        if bore.play:  # without play it is linear
            effort[:, 1] += bore.force(tilt)
            by_motion[:, 1, 1] += bore.slope(tilt)
        return LawPoint(effort, by_motion, damping)

    scales = law.decay_length * np.array([1.0, 1.0 / law.radius])
    oscillator = Oscillator(linear, acting, np.zeros(2), scales)
    return RockingHead(place, support, oscillator, forces.stops, attached)


def _along(stops: Stops, law: RoughContact, place: Floats, rate: Floats) -> Floats:
    """Return ∂(C·rate)/∂(u, ψ) (n, 2, 2): as third derivatives commute, C's change along rate.

    `place` (n, 2) are lift and tilt, C the stops' damping; `law` sets the step.
    """
    size = np.maximum(np.abs(rate[:, 0]), law.radius * np.abs(rate[:, 1]))
    step = _STEP * law.decay_length / np.where(size > 0.0, size, 1.0)
    moved = step[:, None] * rate
    (_, after), (_, before) = (
        stops.stiffness_and_damping(*at.T) for at in (place + moved, place - moved)
    )
    return np.asarray((after - before) / (2.0 * step[:, None, None]))
