"""Equilibria of the rod at a coil current: all, the stable ones, the one taken.

Static and without friction.  Along the axis act the return spring, the finger that presses the
tip down, the magnetic pull, and the stops by the law of their contact.  The rod's lift u is told
as in tmm.generator.contact: 0 at the upper stop, negative downwards.

The head tilts towards where the spring presses.  In that direction the contact is softer, ∂M/∂ψ,
than beside it, M/ψ.  Between the axes a turn in the plane of bending then needs a moment in the
other one as well, where rod and bimorph, which hardly bends across its width, rock on the same
contact.  Seen from the plane of bending they are a resonator on the head.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, Law, Springs, TipLoad
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.sections import section_across
from tactgen.tmm.beam.transfer_matrix import chain, sections
from tactgen.tmm.generator.contact import (
    RoughContact,
    Stops,
    lateral_guide,
    moving_rod,
    sprung_board,
    stops_of,
    tilt_guide,
)
from tactgen.tmm.ports.multiport import hold, reduce
from tactgen.tmm.ports.supports_and_loads import base_stiffness, load_tip

#: Lifts between the stops at which forces are compared, and at each stop, that reach so many
#: decay lengths of the contact to both sides.
_BETWEEN, _AT_STOP, _REACH = 401, 97, 12.0
#: A stop holds the rod where it carries more than this share of the larger of its spring's
#: force and the contact's reference load.
_TOUCHES = 0.01

#: Decimals of a direction, so that one across an axis has nothing along it.
_DIGITS = 15
#: How far a place is looked for, of the way that its forces and their slope tell.
_FURTHER = np.array([1.0 + 1e-6, 2.0, 5.0])

History = Literal["rising", "falling"]
Kind = Literal["upper stop", "lower stop", "floating", "unstable"]


class Pull(Protocol):
    """The magnetic pull, positive when it closes the gap, such as a CoenergyMap."""

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Pull (N) at a current (A) and gap (m)."""

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Its slope ∂F/∂g with the gap at constant current (N/m)."""

    def motional_coefficient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂g (V s/m)."""

    def incremental_inductance(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂i (H)."""


@dataclass(frozen=True)
class RestingPlace:
    """A place at which all axial forces balance."""

    lift: float  #: u (m)
    kind: Kind  #: ``upper stop``, ``lower stop``, ``floating`` between them, or ``unstable``
    #: Spring less pull (N): with which the rod would push a finger that takes it over from what
    #: holds it; negative where the pull holds it down
    finger_force: float
    contact_force: float  #: What the stop carries (N), both together if both touch
    #: Axial stiffness of spring, pull and contact together (N/m), negative where unstable
    stiffness: float

    @property
    def stable(self) -> bool:
        """Whether the rod stays there."""
        return self.kind != "unstable"


@dataclass(frozen=True)
class AxialForces:
    """Axial forces on the rod."""

    device: Device  #: Spring and gap are read
    stops: Stops  #: Both contacts
    pull: Pull | None = None  #: None without current
    pressed: float = 0.0  #: Force of a finger that presses the tip down (N)

    def finger_force(self, current: Floats | float, lift: Floats | float) -> Floats:
        """Spring less pull (N), upwards."""
        spring = self.device.spring
        up = spring.preload - spring.stiffness * np.asarray(lift, dtype=float)
        if self.pull is None:
            return np.asarray(up)
        return np.asarray(up - self.pull.force(current, self.gap(lift)))

    def gap(self, lift: Floats | float) -> Floats:
        """Working gap (m), at most as far as a map of the pull goes.

        A head that presses its stop is closer by a few decay lengths at most.
        """
        gap = self.device.gap + np.asarray(lift, dtype=float)
        limits = getattr(self.pull, "gap_limits", None)
        return np.asarray(gap if limits is None else np.clip(gap, *limits))

    def total(self, current: Floats | float, lift: Floats | float) -> Floats:
        """Force on the upright rod (N), upwards; 0 where it rests."""
        upper, lower = self.stops.loads(lift)
        return np.asarray(self.finger_force(current, lift) - self.pressed - upper + lower)

    def stiffness(self, current: Floats | float, lift: Floats | float) -> Floats:
        """−∂(total)/∂u (N/m)."""
        slope = self.device.spring.stiffness + self.stops.tangent(lift, 0.0)[..., 0, 0]
        if self.pull is None:
            return np.asarray(slope)
        return np.asarray(slope + self.pull.force_gradient(current, self.gap(lift)))

    def lifts(self) -> Floats:
        """Lifts from the lower to the upper stop among which forces are compared (m)."""
        stroke = self.stops.stroke
        near = np.linspace(-_REACH, _REACH, _AT_STOP)
        found = np.concatenate(
            [
                np.linspace(-stroke, 0.0, _BETWEEN),
                near * self.stops.upper.decay_length,
                near * self.stops.lower.decay_length - stroke,
            ]
        )
        return np.unique(found)


def axial_forces(device: Device, pull: Pull | None, pressed: float = 0.0) -> AxialForces:
    """Axial forces on a device's rod.

    Raises InputError if there is nothing between the stops.
    """
    return AxialForces(device, stops_of(device), pull, pressed)


def resting_places(forces: AxialForces, current: float) -> tuple[RestingPlace, ...]:
    """All places where the rod can rest at a constant current, from the top down.

    One is stable if a small displacement is driven back: the slope of spring, pull and contact
    together is positive.

    Raises InputError if there is none, or the map of the pull does not reach so high a current.
    """
    lifts = forces.lifts()
    total = forces.total(current, lifts)
    crossings = np.flatnonzero(np.sign(total[1:]) * np.sign(total[:-1]) < 0.0)[::-1]
    roots = [_root(forces, current, float(lifts[k]), float(lifts[k + 1])) for k in crossings]
    roots += [float(lift) for lift in lifts[total == 0.0]]
    if not roots:
        raise InputError(
            f"the rod rests nowhere between its stops at coil.current = {1e3 * current:g} mA "
            f"with spring.preload = {1e3 * forces.device.spring.preload:g} mN; check spring, gap "
            "and contact.decay_length"
        )
    return tuple(_place(forces, current, lift) for lift in sorted(roots, reverse=True))


def resting_place(forces: AxialForces, current: float, history: History) -> RestingPlace:
    """Where the rod is after its current rose slowly from 0, or fell from far above.

    The pull grows with the current.  Rising, the rod has not passed the uppermost stable place
    yet; falling, it has not left the lowest.

    Raises InputError if it rests nowhere.
    """
    stable = [place for place in resting_places(forces, current) if place.stable]
    return stable[0] if history == "rising" else stable[-1]


def settled_place(forces: AxialForces, current: float, near: RestingPlace) -> RestingPlace | None:
    """Equilibrium near one of almost the same forces; None if there is none.

    Close is within five times the way that what is missing there and its slope tell.
    """
    miss = float(forces.total(current, near.lift))
    slope = float(forces.stiffness(current, near.lift))
    if not slope > 0.0:
        return None
    way = miss / slope
    for reach in _FURTHER * way:
        there = float(forces.total(current, near.lift + reach))
        if np.sign(there) != np.sign(miss):
            low, high = sorted((near.lift, near.lift + float(reach)))
            return _place(forces, current, _root(forces, current, low, high))
    return None


@dataclass(frozen=True)
class PositionLoop:
    """All resting places over the coil's current, and the way there and back."""

    currents: Floats  #: (c,) A, ascending
    places: tuple[tuple[RestingPlace, ...], ...]  #: At each current, from the top down

    @property
    def rising(self) -> tuple[RestingPlace, ...]:
        """Where the rod is at each current that rose slowly from 0."""
        return tuple(next(p for p in at if p.stable) for at in self.places)

    @property
    def falling(self) -> tuple[RestingPlace, ...]:
        """Where it is at each current that fell slowly from far above."""
        return tuple(next(p for p in reversed(at) if p.stable) for at in self.places)

    @property
    def unstable(self) -> Floats:
        """Currents and lifts (k, 2) in A and m of the places between, from which it falls."""
        pairs = zip(self.currents.tolist(), self.places, strict=True)
        found = [(i, p.lift) for i, at in pairs for p in at if not p.stable]
        return np.array(found).reshape(-1, 2)


def position_loop(forces: AxialForces, currents: Floats) -> PositionLoop:
    """All resting places while the current rises through (c,) A, and falls again.

    Raises InputError if it rests nowhere, or the map of the pull does not reach so high a current.
    """
    return PositionLoop(currents, tuple(resting_places(forces, float(i)) for i in currents))


def _root(forces: AxialForces, current: float, low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(lambda u: float(forces.total(current, u)), low, high, xtol=1e-16))


def _place(forces: AxialForces, current: float, lift: float) -> RestingPlace:
    upper, lower = (float(load) for load in forces.stops.loads(lift))
    stiffness = float(forces.stiffness(current, lift))
    least = _TOUCHES * max(forces.device.spring.preload, forces.stops.upper.reference_load)
    kind: Kind = "floating"
    if not stiffness > 0.0:
        kind = "unstable"
    elif max(upper, lower) > least:
        kind = "upper stop" if upper >= lower else "lower stop"
    return RestingPlace(
        lift=lift,
        kind=kind,
        finger_force=float(forces.finger_force(current, lift)),
        contact_force=upper + lower,
        stiffness=stiffness,
    )


def resting_tilt(device: Device, place: RestingPlace) -> float:
    """Tilt (rad) at which contact and guide balance the spring's moment.

    Raises InputError if they cannot: the head tips over its edge.
    """
    lever = device.spring.eccentricity
    if lever == 0.0:
        return 0.0
    from scipy.optimize import brentq

    law, guide = stops_of(device).holding(place.lift), tilt_guide(device)
    moment = lever * (device.spring.preload - device.spring.stiffness * place.lift)
    if abs(moment) >= float(law.tipping_moment(place.contact_force)):
        raise InputError(
            f"spring.eccentricity = {1e3 * lever:g} mm tips the rod's head over its edge: the "
            f"moment is {moment:.3g} N m and the contact bears less than "
            f"{float(law.tipping_moment(place.contact_force)):.3g} N m; bring the spring closer to "
            "the axis or press the head harder"
        )

    def left(tilt: float) -> float:
        borne = float(law.moment_under(place.contact_force, tilt))
        return float(borne + guide.force(tilt) - abs(moment))

    # the disc's moment falls short of N R by 3/(2a), a = R ψ/u0, and the ring's by 1/(2a)
    share = abs(moment) / float(law.tipping_moment(place.contact_force))
    most = 4.0 * law.decay_length / (law.radius * (1.0 - share))
    return float(np.copysign(brentq(left, 0.0, most, xtol=1e-18), moment))


def spring_direction(device: Device) -> Floats:
    """(2,) In which the spring presses off the axis, and towards which the head tilts."""
    angle = device.spring.eccentricity_angle
    return np.round([np.cos(angle), np.sin(angle)], _DIGITS)


def about_tilt(device: Device, along: float, beside: float) -> Floats:
    """Stiffness (2, 2) over the turns [ψ_x, ψ_y] in the plane of bending and in the other one.

    `along` against more of the tilt, `beside` against a turn at right angles to it.
    """
    towards = spring_direction(device)
    return np.asarray(beside * np.eye(2) + (along - beside) * np.outer(towards, towards))


def guide_stiffness(device: Device, tilt: float) -> Floats:
    """Tilt guide's stiffness (2, 2) over the turns, about a tilt (rad)."""
    guide = tilt_guide(device)
    beside = float(guide.force(tilt)) / tilt if tilt else guide.at_rest
    return about_tilt(device, float(guide.slope(tilt)), beside)


def rocking_stiffness(
    device: Device, contact: RoughContact, load: float, tilt: float
) -> tuple[Floats, Floats]:
    """Stiffness of contact and of guide (2, 2) over the turns, about a tilt (rad).

    A tilted head that rocks moves along the axis, too: its load (N) stays.
    """
    along = float(contact.stiffness_under(load, tilt))
    beside = float(contact.moment_under(load, tilt)) / tilt if tilt else along
    return about_tilt(device, along, beside), guide_stiffness(device, tilt)


def pressed_support(
    device: Device, contact: RoughContact, load: float, tilt: float = 0.0
) -> Support:
    """Springs in the plane of bending of a head that a stop carries with `load` (N), 0 or more.

    At a tilt (rad), and without turning in the other plane.
    """
    rocking, guide = (float(part[0, 0]) for part in rocking_stiffness(device, contact, load, tilt))
    return Support(
        kind="spring",
        rotational_stiffness=rocking + guide,
        rotational_damping=contact.relaxation_time * rocking,
        lateral_stiffness=float(contact.tangential_stiffness(load)) + lateral_guide(device).at_rest,
        rotational_inertia=float(moving_rod(device).mass_matrix[1, 1]),
    )


def held_support(
    device: Device, pull: Pull | None, current: float, history: History, pressed: float = 0.0
) -> tuple[RestingPlace, Support]:
    """Where the rod rests, and the springs that it is there to the bimorph.

    Parameters
    ----------
    device : Device
        Spring, contact, guide, rod and coil are read.
    pull : Pull or None
        The magnetic pull; None without current.
    current : float
        In the coil (A).
    history : {"rising", "falling"}
        How the current came there.
    pressed : float
        Force of a finger that presses the tip down (N).

    Raises InputError if the rod rests nowhere.
    """
    forces = axial_forces(device, pull, pressed)
    place = resting_place(forces, current, history)
    law, tilt = forces.stops.holding(place.lift), resting_tilt(device, place)
    return place, pressed_support(device, law, place.contact_force, tilt)


def _on_board(base: Springs, device: Device, place: RestingPlace) -> Springs:
    """Springs of a contact, with those of the upper board if it is not rigid.

    Statics and undamped modes have the board at rest on its springs.
    """
    board = sprung_board(device, place.lift, place.contact_force)
    guide = lateral_guide(device).at_rest
    if board is None:
        return base

    def law(frequencies: Floats) -> tuple[Complex, Complex]:
        return board(frequencies) + guide, base_stiffness(base, frequencies)[1]

    at_rest = float(board(np.zeros(1))[0].real) + guide
    return replace(base, lateral_stiffness=at_rest, law=law)


def turn_across(
    device: Device, beam: Beam, tip: TipLoad | Law, base: Complex, frequencies: Floats
) -> Complex:
    """Turn of the head per moment (n,) in rad/(N m) in the plane across the width.

    At frequencies (n,) in Hz, the load being alike in all lateral directions.  `base` (n, 2, 2) is
    the dynamic stiffness of rod, contact and guide over motion and turn of the head.
    """
    row = sections(device, Support(kind="clamped"), beam, lossy=True, section_of=section_across)
    loaded = hold(load_tip(chain(row, frequencies), tip), "voltage")
    bimorph = reduce(loaded, ("w_base", "psi_base"))
    return np.asarray(np.linalg.inv(bimorph.stiffness + base)[:, 1, 1])


def on_contact(ends: Ends, device: Device, beam: Beam, place: RestingPlace) -> Ends:
    """Ends of the bimorph on the contact of the rod's head, from those on the contact's springs.

    A tilted head holds both planes and may tie them together.  Statics and undamped modes take the
    other plane at rest.
    """
    assert ends.base is not None
    law, tilt = stops_of(device).holding(place.lift), resting_tilt(device, place)
    base = _on_board(ends.base, device, place)
    if not tilt:
        return replace(ends, base=base, across=ends.base)
    contact, guide = rocking_stiffness(device, law, place.contact_force, tilt)
    across = replace(
        base,
        rotational_stiffness=float(contact[1, 1] + guide[1, 1]),
        rotational_damping=law.relaxation_time * float(contact[1, 1]),
        law=None,
    )
    if not device.spring.tilts_both_planes:
        return replace(ends, base=base, across=across)

    def both(frequencies: Floats, tip: TipLoad | Law = ends.tip) -> tuple[Complex, Complex]:
        omega = 2.0 * np.pi * np.asarray(frequencies, dtype=float)
        lateral, rotational = base_stiffness(base, frequencies)
        turning = guide + contact * (1.0 + 1j * omega * law.relaxation_time)[:, None, None]
        other = np.zeros((omega.size, 2, 2), dtype=complex)
        other[:, 0, 0] = lateral
        other[:, 1, 1] = turning[:, 1, 1] - omega**2 * base.rotational_inertia
        turn = turn_across(device, beam, tip, other, frequencies)
        return lateral, rotational - turning[:, 0, 1] ** 2 * turn

    at_rest = float(both(np.zeros(1), ends.conservative_tip)[1][0].real)
    return Ends(replace(base, rotational_stiffness=at_rest, law=both), ends.tip, across)
