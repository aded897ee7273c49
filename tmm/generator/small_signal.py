"""Small motions of the whole machine about a place where the rod rests.

The rod is rigid and moves in three ways: laterally (w, at its top face), rocking (ψ, a point at
height z moves by w − z ψ) and along its axis (u).  It carries the bimorph, which any model gives
over its ports, and its coil.  On it act the contact with the stop it rests on, the return spring,
the guide, and the magnetic field; all of them are slopes of one energy,

    dF = −T di + … ,   dλ = T du + L di,     T = ∂λ/∂g = −∂F/∂i,   L = ∂λ/∂i

from the co-energy map, so that what the coil does to the rod and the rod to the coil is one
number.  The current is answered by its flux linkage: v = R i + jΩ λ.

An upright head keeps axial and lateral motion apart.  A spring that presses off the axis tilts the
head at rest; one side of the contact is then stiffer, and each motion drives the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.bimorph.boundary_conditions import Law as TipLaw
from tactgen.geometry.bimorph.boundary_conditions import TipLoad
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.geometry.device.winding import winding
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.beam.transfer_matrix import sections
from tactgen.tmm.generator.contact import (
    Stops,
    lateral_guide,
    moving_rod,
    sprung_board,
    stops_of,
    tilt_guide,
)
from tactgen.tmm.generator.equilibrium import (
    AxialForces,
    Pull,
    RestingPlace,
    about_tilt,
    guide_stiffness,
    pressed_support,
    resting_tilt,
    spring_direction,
    turn_across,
)
from tactgen.tmm.harmonic_balance.balance import LawPoint, Orbit, Oscillator
from tactgen.tmm.harmonic_balance.steady import Tabulated
from tactgen.tmm.ports.multiport import (
    AXIAL,
    CURRENT,
    LATERAL,
    MEASURED,
    ROTATION,
    Multiport,
    Port,
    Response,
    connect,
    eliminated,
    reduce,
    terminate,
)
from tactgen.tmm.ports.supports_and_loads import load_tip

#: The rod's ports: its three motions at the top face, and the coil's current.
ROD = (
    Port("w_base", LATERAL),
    Port("psi_base", ROTATION),
    Port("u", AXIAL),
    Port("current", CURRENT),
)
#: What is left of machine and bimorph together.
MACHINE = ("w_tip", "psi_tip", "u", "voltage", "current")


_FREE_TIP = TipLoad()


@dataclass(frozen=True)
class Linearised:
    """The rod with all that acts on it but the bimorph, about a resting place."""

    #: (3, 3) Over (w, ψ, u) at the top face; SI, symmetric
    mass: Floats
    damping: Floats
    stiffness: Floats
    motional: float = 0.0  #: T = ∂λ/∂u (V s/m), of a current that the supply makes positive
    inductance: float = 0.0  #: L = ∂λ/∂i (H), the rod held
    resistance: float = 0.0  #: Of wire, leads and supply (Ω)
    #: Dynamic stiffness (n, 3, 3) over frequency (Hz) that an upper board on springs and the plane
    #: across the width add
    added: Callable[[Floats], Complex] | None = None


def linearised(
    device: Device,
    beam: Beam,
    place: RestingPlace,
    current: float,
    magnetic: Pull,
    tip: TipLoad | TipLaw = _FREE_TIP,
) -> Linearised:
    """Rod about the place where it rests at a current (A).

    What loads the `tip` counts where the rod rocks in both planes together.

    Raises InputError if the spring presses so far off the axis that the head tips.
    """
    tilt = resting_tilt(device, place)
    stiffness, damping = _contact(device, place, tilt)
    stiffness = stiffness + _spring_and_guide(device, tilt)
    damping[2, 2] += device.guide.axial_damping
    gap = device.gap + place.lift
    stiffness[2, 2] += float(magnetic.force_gradient(current, gap))
    mass = _mass(device, beam)
    law = stops_of(device).holding(place.lift)
    board = sprung_board(device, place.lift, place.contact_force)
    along = float(law.tangential_stiffness(place.contact_force))

    def added(frequencies: Floats) -> Complex:
        found = np.zeros((frequencies.size, 3, 3), dtype=complex)
        omega = 2.0 * np.pi * frequencies[:, None, None]
        if board is not None:  # in place of the contact alone
            rigid = along * (1.0 + 1j * omega[:, 0, 0] * law.relaxation_time)
            found[:, 0, 0] = board(frequencies) - rigid
        whole: Complex = stiffness + 1j * omega * damping
        ties = whole[:, :3, 4]
        if ties.any():
            base: Complex = whole[:, 3:, 3:] - omega**2 * mass[:2, :2]
            base[:, 0, 0] += found[:, 0, 0]
            turn = turn_across(device, beam, tip, base, frequencies)
            found -= turn[:, None, None] * ties[:, :, None] * ties[:, None, :]
        return found

    return Linearised(
        mass=mass,
        damping=damping[:3, :3],
        stiffness=stiffness[:3, :3],
        motional=float(magnetic.motional_coefficient(current, gap)),
        inductance=float(magnetic.incremental_inductance(current, gap)),
        resistance=winding(device.coil).resistance + device.coil.source_resistance,
        added=added if board or device.spring.tilts_both_planes else None,
    )


def rod_ports(linear: Linearised, frequencies: Floats) -> Multiport:
    """Rod over its ports: dynamic stiffness, and the coil's flux linkage."""
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    omega = 2.0 * np.pi * f[:, None, None]
    d = np.zeros((f.size, 4, 4), dtype=complex)
    d[:, :3, :3] = linear.stiffness + 1j * omega * linear.damping - omega**2 * linear.mass
    if linear.added is not None:
        d[:, :3, :3] += linear.added(f)
    d[:, 2, 3], d[:, 3, 2] = -linear.motional, linear.motional
    d[:, 3, 3] = linear.inductance
    return Multiport(f, d, ROD)


def machine(bimorph: Multiport, linear: Linearised) -> Multiport:
    """Bimorph and rod as one, over tip, lift, voltage and the coil's current.

    The bimorph moves along the axis as a rigid mass, which is in `linear`; so u is the tip's
    axial motion, too.
    """
    found = joined(bimorph, linear)
    return reduce(found, [name for name in (*MACHINE, MEASURED.name) if name in found.names])


def joined(bimorph: Multiport, linear: Linearised) -> Multiport:
    """Bimorph and rod as :func:`machine`, over the bimorph's foot and the tip's turn, too.

    Its condition is what the machine costs in digits: much on a contact that hardly holds.
    """
    rod = rod_ports(linear, bimorph.frequencies)
    return connect(bimorph, rod, {"w_base": "w_base", "psi_base": "psi_base"})


def axial_poles(linear: Linearised, *, voltage: bool) -> Complex:
    """Poles (rad/s) of axial motion and coil, (2,) or with a voltage supply (3,).

    m s² + d s + k = 0 with the current held; a voltage held adds the circuit,
    (m s² + d s + k)(R + s L) + s T² = 0.  The head does not rock.
    """
    motion = np.array([linear.mass[2, 2], linear.damping[2, 2], linear.stiffness[2, 2]])
    if not voltage:
        return _sorted(np.roots(motion))
    circuit = np.array([linear.inductance, linear.resistance])
    both = np.polymul(motion, circuit)
    both[-2] += linear.motional**2
    return _sorted(np.roots(both))


def _sorted(poles: Numbers) -> Complex:
    return np.asarray(poles[np.lexsort((poles.real, poles.imag))], dtype=complex)


def _mass(device: Device, beam: Beam) -> Floats:
    """Rigid rod's mass matrix; along the axis the bimorph's mass is in it."""
    body = moving_rod(device)
    mass = np.zeros((3, 3))
    mass[:2, :2], mass[2, 2] = body.mass_matrix, body.mass
    mass[2, 2] += sum(
        float(np.real(element.m)) * length
        for element, length in sections(device, Support(kind="clamped"), beam, lossy=False)
        if isinstance(element, Section)
    )
    return mass


def _contact(device: Device, place: RestingPlace, tilt: float) -> tuple[Floats, Floats]:
    """Stiffness and damping (5, 5) of the stop that holds the rod.

    Over (w, ψ, u) and (w, ψ) in the plane across the width.
    """
    stops = stops_of(device)
    law, below = stops.holding(place.lift), stops.is_below(place.lift)
    # a tilted head carries the same load closer to or farther from its stop
    approach = float(law.approach(max(place.contact_force, 1e-300), tilt))
    (pressing, both), (_, along) = law.tangent(approach, tilt)  # over (δ, ψ)
    beside = float(law.moment(approach, tilt)) / tilt if tilt else along
    height = -device.rod.head_thickness if below else 0.0
    lever = np.array([[1.0, -height, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, -height]])
    stiffness = float(law.tangential_stiffness(place.contact_force)) * (lever.T @ lever)
    stiffness[np.ix_(_TURNS, _TURNS)] += about_tilt(device, along, beside)
    stiffness[2, 2] += pressing
    # δ = u above and −u below
    stiffness[2, _TURNS] += (-both if below else both) * spring_direction(device)
    stiffness[_TURNS, 2] = stiffness[2, _TURNS]
    return stiffness, law.relaxation_time * stiffness


#: The turns of the head in both planes, among its motions.
_TURNS = np.array([1, 4])


def _spring_and_guide(device: Device, tilt: float) -> Floats:
    spring = device.spring
    lever = np.array([0.0, 0.0, 1.0, 0.0, 0.0])
    lever[_TURNS] = spring.eccentricity * spring_direction(device)
    held = spring.stiffness * np.outer(lever, lever)
    held[np.ix_(_TURNS, _TURNS)] += guide_stiffness(device, tilt)
    held[[0, 3], [0, 3]] += lateral_guide(device).at_rest
    return np.asarray(held)


#: What is given, and what follows, of the bimorph's ports; the last only if it is one.
_DRIVEN, _FREE = ("psi_base", "voltage"), ("w_base", "w_tip", "psi_tip", MEASURED.name)


@dataclass(frozen=True)
class RockingHead:
    """The bimorph on its head, as harmonic balance takes it."""

    place: RestingPlace  #: Where the rod rests
    support: Support  #: What the contact is to small motions there
    #: In lift from that place (m) and tilt (rad) of the head; the drive is the voltage (V)
    oscillator: Oscillator
    stops: Stops  #: What the head touches
    #: From frequencies (n,) in Hz to what the bimorph with load, lateral support and the head's
    #: inertia, but not what resists the tilt, does when tilt and voltage are given, (n, 2 k): the
    #: efforts there, then the other motions, see :func:`_seen`
    attached: Tabulated

    def response(self, orbit: Orbit) -> Response:
        """All motions and the charge at the harmonics (H + 1,) of an orbit."""
        n = np.arange(orbit.harmonics + 1)
        drive = np.stack([orbit.spectrum[:, 1], orbit.level * (n == 1)], axis=-1)
        attached = self.attached(n * orbit.frequency)
        answers = attached.reshape(n.size, -1, 2) @ drive[..., None]
        given = dict(zip(_DRIVEN, drive.T, strict=True))
        effort, motion = answers[:, :2, 0].T, answers[:, 2:, 0].T
        return Response(
            {**given, **dict(zip(_FREE, motion, strict=False))},
            dict(zip(_DRIVEN, effort, strict=True)),
        )

    def contact(self, orbit: Orbit, samples: int) -> tuple[Floats, Floats]:
        """Undamped stop forces on the head over a period.

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
    """Bimorph on a head that rests on a stop.

    Parameters
    ----------
    bimorph : callable
        From frequencies (n,) in Hz, 0 among them, to the bimorph's ports, wired as it is.
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
    support = pressed_support(device, law, place.contact_force, resting_tilt(device, place))
    body, spring = moving_rod(device), device.spring
    offset = spring.eccentricity
    at_spring = np.array([1.0, offset])
    bore = tilt_guide(device)
    mass = body.mass + bimorph_mass

    board = sprung_board(device, place.lift, place.contact_force)
    guide = lateral_guide(device).at_rest

    def lateral(frequencies: Floats) -> Complex | float:
        return support.lateral_stiffness if board is None else board(frequencies) + guide

    def seen(frequencies: Floats) -> Complex:
        omega = 2.0 * np.pi * frequencies
        tilting = bore.at_rest - omega**2 * support.rotational_inertia
        loads = {"w_base": lateral(frequencies), "psi_base": tilting}
        return _seen(terminate(load_tip(bimorph(frequencies), tip), loads))

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
        # the spring presses beside the axis: it lifts by u + e ψ where it stands
        effort += spring.stiffness * offset * tilt[:, None] * at_spring
        effort[:, 1] -= offset * (spring.preload - spring.stiffness * lift)
        by_motion += spring.stiffness * np.outer(at_spring, at_spring)
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
    """Efforts at tilt and voltage, then the free motions, per tilt and per volt (n, 2 k)."""
    seen, follows = eliminated(port, _DRIVEN)
    parts = (seen.stiffness, follows)
    return np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1)
