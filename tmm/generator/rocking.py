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
from tactgen.tmm.generator.moving_mass import moving_rod
from tactgen.tmm.generator.positions import AxialForces, RestingPlace, pressed_support
from tactgen.tmm.generator.stops import Stops, tilt_guide
from tactgen.tmm.harmonic_balance.balance import LawPoint, Orbit, Oscillator
from tactgen.tmm.harmonic_balance.tabulated import Tabulated
from tactgen.tmm.ports.elements import tip_stiffness
from tactgen.tmm.ports.multiport import Multiport, Response, eliminated, terminate

#: What is given, and what follows, of the bimorph's ports.
_DRIVEN, _FREE = ("psi_base", "voltage"), ("w_base", "w_tip", "psi_tip")


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
    attached : Tabulated
        From frequencies (n,) in Hz to what the bimorph with load, lateral support and the head's
        inertia, but not what resists the tilt, does when tilt and voltage are given, (n, 10): the
        efforts there, then the other motions, see :func:`_seen`.
    """

    place: RestingPlace
    support: Support
    oscillator: Oscillator
    stops: Stops
    attached: Tabulated

    def response(self, orbit: Orbit) -> Response:
        """Return all motions and the charge at the harmonics (H + 1,) of an orbit."""
        n = np.arange(orbit.harmonics + 1)
        drive = np.stack([orbit.spectrum[:, 1], orbit.level * (n == 1)], axis=-1)
        answers = self.attached(n * orbit.frequency).reshape(-1, 5, 2) @ drive[..., None]
        given = dict(zip(_DRIVEN, drive.T, strict=True))
        effort, motion = answers[:, :2, 0].T, answers[:, 2:, 0].T
        return Response(
            {**given, **dict(zip(_FREE, motion, strict=True))},
            dict(zip(_DRIVEN, effort, strict=True)),
        )

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

    def seen(frequencies: Floats) -> Complex:
        omega = 2.0 * np.pi * frequencies
        tilting = bore.at_rest - omega**2 * support.rotational_inertia
        loads = {
            "w_base": support.lateral_stiffness,
            "psi_base": tilting,
            "w_tip": tip_stiffness(tip, frequencies),
        }
        return _seen(terminate(bimorph(frequencies), loads))

    attached = Tabulated(seen)

    def linear(omega: Floats) -> Complex:
        d = np.zeros((omega.size, 2, 3), dtype=complex)
        d[:, 0, 0] = 1j * omega * device.guide.axial_damping - omega**2 * mass
        d[:, 1, 1:] = attached(omega / (2.0 * np.pi), slice(2))
        return d

    def acting(motion: Floats, rate: Floats) -> LawPoint:
        lift, tilt = place.lift + motion[:, 0], motion[:, 1]
        effort, tangent, damping, change = forces.stops.moving(lift, tilt, rate)
        effort += np.einsum("nij,nj->ni", damping, rate)
        effort[:, 0] += forces.pressed - forces.finger_force(current, lift)
        by_motion = tangent + change
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


def _seen(port: Multiport) -> Complex:
    """Return efforts at tilt and voltage, then the free motions, per tilt and per volt (n, 10)."""
    seen, follows = eliminated(port, _DRIVEN)
    parts = (seen.stiffness, follows)
    return np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1)
