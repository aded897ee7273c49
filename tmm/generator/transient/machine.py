"""The generator as a system that moves: bimorph, rigid rod, spring, two stops, coil.

Coordinates: lift u of the rod (m, 0 at the upper stop, positive upwards), lateral motion w and
tilt ψ of its head, then the bimorph's modes and the parts of what the tip touches.  The head stands
on points around its rim, each of which pushes by the law of rough contact that
:mod:`tmm.generator.contact` states for the whole rim: lift, rocking and tipping follow.  Friction
holds the head laterally while it is pressed, and that of the bore is a constant force along the
axis.

Left out: the bimorph's stretching, tilting about the second axis, the field's moment on a tilted
head, the head's thickness as a lever.  The weight (2 % of the preload) is in the preload, which is
set by hand on the standing device.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.winding import winding
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.contact import (
    Play,
    RoughContact,
    lateral_guide,
    moving_rod,
    stops_of,
    tilt_guide,
)
from tactgen.tmm.generator.equilibrium import RestingPlace, resting_tilt
from tactgen.tmm.generator.small_signal import Linearised
from tactgen.tmm.generator.transient.system import (
    Coil,
    Element,
    Friction,
    Output,
    RoughPoint,
    Stop,
    System,
)
from tactgen.tmm.ports.supports_and_loads import Chain
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap, cells


@dataclass(frozen=True)
class BimorphModes:
    """k modes over a base that moves by [w, ψ]."""

    omega: Floats  #: (k,) Angular frequencies with the base held (rad/s)
    damping: Floats  #: (k,) 2 ζ ω (1/s)
    inertia: Floats  #: (k, 2) What a base acceleration does to the modes (√kg, √kg m)
    #: (2, 2) Mass matrix of the bimorph as a rigid body about its base (kg, kg m, kg m²)
    rigid: Floats
    coupling: Floats  #: (k,) Force on the modes per volt across each layer, and charge per mode
    #: (k + 2,) Tip displacement (m) of base motions w and ψ, then of the modes; that which is
    #: measured
    tip: Floats
    seen: Floats
    capacitance: float  #: With all motion held (F)
    #: (n, k + 2) The unknowns that the modes were made of, of base motions w and ψ, then of the
    #: modes
    shapes: Floats


def bimorph_modes(
    stiffness: Complex,
    mass: Floats,
    coupling: Complex,
    capacitance: complex,
    base: Ints,
    tip: int,
    seen: int,
    highest: float,
) -> BimorphModes:
    """Modes of a discretised bimorph.

    Parameters
    ----------
    stiffness, mass : (n, n)
        Lossy and lossless, free at both ends.
    coupling : (n,) complex
        Force per volt.
    capacitance : complex
        With all unknowns held (F).
    base : (2,) int
        Unknowns that are w and ψ of a base that moves or is clamped; of one that springs hold, and
        that are in `stiffness`, none (0,).
    tip, seen : int
        Unknowns that are the displacement of the tip, and at the place where it is measured.
    highest : float
        Modes above this frequency (Hz) are only there as statics.
    """
    from scipy.linalg import eigh

    inner = np.setdiff1d(np.arange(mass.shape[0]), base)
    k, m = stiffness[np.ix_(inner, inner)], mass[np.ix_(inner, inner)]
    follows = -np.linalg.solve(k.real, stiffness.real[np.ix_(inner, base)])
    dragged = m @ follows + mass[np.ix_(inner, base)]
    squares, shapes = eigh(k.real, m)
    kept = shapes[:, squares < (2.0 * np.pi * highest) ** 2]
    forced = (inner == tip).astype(float)
    loads = np.column_stack([coupling.real[inner], forced, dragged])
    # the part of the static answers that the modes do not have
    statics = np.linalg.solve(k.real, loads)
    statics -= kept @ (kept.T @ m @ statics)
    statics /= np.sqrt(np.einsum("ij,ik,kj->j", statics, m, statics))
    values, vectors = eigh(statics.T @ k.real @ statics, statics.T @ m @ statics)
    basis = np.hstack([kept, statics @ vectors])
    omega = np.sqrt(np.concatenate([squares[: kept.shape[1]], values]))
    whole = np.zeros((mass.shape[0], base.size))
    whole[inner], whole[base] = follows, np.eye(base.size)
    moved = np.zeros((mass.shape[0], basis.shape[1]))
    moved[inner] = basis
    found = np.hstack([whole, moved])
    return BimorphModes(
        omega=omega,
        damping=np.einsum("ij,ik,kj->j", basis, k.imag, basis) / omega,
        inertia=basis.T @ dragged,
        rigid=whole.T @ mass @ whole,
        coupling=basis.T @ coupling.real[inner],
        tip=found[tip],
        seen=found[seen],
        capacitance=float(capacitance.real),
        shapes=found,
    )


#: Points on the rim, in mirror pairs: as a quadrature of the ring's law they are exact to 1e-8
#: up to the tilt at which one side carries e⁸ times the other.
_POINTS = 16
#: How far beyond its stops the rod may be pressed, in decay lengths: e²⁵ of the reference load.
_BEYOND = 25.0
#: And the least gap that the map is read at, as a share of its lowest.
_LEAST_GAP = 0.1
#: A deflection (m) below which it is none that steps must follow.
_STILL = 1e-9
#: Rounds in which contact and spring come to rest.
_ROUNDS = 20
#: How much more closely a step follows the head's tilt than the motion that it gives the tip.
_TURNED = 3.0

LOWER, UPPER, BORE = "lower_stop", "upper_stop", "bore"


@dataclass(frozen=True)
class Machine:
    """System with its initial state."""

    system: System  #:
    rest: Floats  #: (n,) At rest on the upper stop without current and voltage
    modes: BimorphModes  #: Those among the coordinates


def machine(
    device: Device,
    modes: BimorphModes,
    pull: CoenergyMap,
    *,
    load: Chain,
    source: Literal["current", "voltage"],
    drive_scale: float = 1.0,
) -> Machine:
    """Generator.

    Parameters
    ----------
    modes : BimorphModes
        Of the bimorph that stands on the rod's head.
    pull : CoenergyMap
        Of the normal actuator, over the stroke.
    load : Chain
        On the tip, laterally; its parts follow the bimorph's modes among the coordinates.
    source : {"current", "voltage"}
        What is prescribed in the coil.
    drive_scale : float
        Largest voltage across each layer (V), by which the lateral error's scale is set.

    Raises InputError if the spring cannot hold the rod on its upper stop, or a disc is asked for.
    """
    spring, contact = device.spring, device.contact
    lateral_bore, tilt_bore = lateral_guide(device), tilt_guide(device)
    if contact.shape != "ring":
        raise InputError(
            f'contact.shape = "{contact.shape}" has no time simulation yet; set contact.shape = '
            '"ring"'
        )
    if spring.preload <= 0.0:
        raise InputError(
            f"spring.preload = {spring.preload * 1e3:g} mN does not hold the rod up; give it the "
            "force with which it presses on the upper stop, such as 110 mN"
        )
    body, stops = moving_rod(device), stops_of(device)
    k = modes.omega.size
    parts = load.mass.shape[0] - 1
    n = 3 + k + parts
    own = slice(3, 3 + k)
    # rows that read the load's coordinates: the tip, then its parts
    tip, seen = (np.concatenate([[0.0], row, np.zeros(parts)]) for row in (modes.tip, modes.seen))
    loaded = np.vstack([tip, np.eye(n)[3 + k :]])
    mass = loaded.T @ load.mass @ loaded
    mass[0, 0] += body.mass + modes.rigid[0, 0] + load.carried
    mass[1:3, 1:3] += modes.rigid + body.mass_matrix
    mass[own, 1:3] += modes.inertia
    mass[1:3, own] += modes.inertia.T
    mass[own, own] += np.eye(k)
    damping = loaded.T @ load.damping @ loaded
    damping[0, 0] += device.guide.axial_damping
    damping[own, own] += np.diag(modes.damping)
    stiffness = loaded.T @ load.stiffness @ loaded
    at_spring = np.array([1.0, 0.0, spring.eccentricity])
    stiffness[:3, :3] += np.diag([0.0, lateral_bore.at_rest, tilt_bore.at_rest])
    stiffness[:3, :3] += spring.stiffness * np.outer(at_spring, at_spring)
    stiffness[own, own] += np.diag(modes.omega**2)
    pushed = np.zeros(n)
    pushed[:3] = spring.preload * at_spring
    elements = (
        _rim(UPPER, stops.upper, 1.0, 0.0, n),
        _rim(LOWER, stops.lower, -1.0, -stops.stroke, n),
        *_bore(lateral_bore, np.eye(n)[1]),
        *_bore(tilt_bore, np.eye(n)[2]),
    )
    low, high = pull.gap_limits
    beyond = _BEYOND * max(stops.upper.decay_length, stops.lower.decay_length)
    lateral, axial = np.eye(n)[1], np.eye(n)[0]
    static = drive_scale * float(modes.seen[2:] @ (modes.coupling / modes.omega**2))
    bent = max(abs(static), _STILL)
    frictions = [Friction(i, lateral, contact.friction) for i in range(2)]
    if device.guide.friction:
        frictions.append(Friction(None, axial, 1.0, load=device.guide.friction))
    system = System(
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        load=pushed,
        coupling=np.concatenate([np.zeros(3), modes.coupling, np.zeros(parts)]),
        capacitance=modes.capacitance,
        elements=elements,
        frictions=tuple(frictions),
        coil=Coil(
            coenergy=cells(pull),
            direction=axial,
            gap=device.gap,
            resistance=winding(device.coil).resistance + device.coil.source_resistance,
            source=source,
            width=0.5 * device.gap,
            largest_current=pull.current_limit,
            gaps=(max(low - beyond, _LEAST_GAP * low), high),
        ),
        outputs={
            "rod_lift": Output(axial, "m", stops.stroke, "lift of the rod, 0 on top"),
            "lateral_tip": Output(seen, "m", bent, f"lateral motion {device.measurement.where}"),
            "head_tilt": Output(
                np.eye(n)[2], "rad", np.inf, "tilt of the rod's head",
                # a rocking head turns the tip by its height; what it does to the contact counts too
                step_scale=bent / (_TURNED * abs(float(seen[2]))),
            ),
        },
    )  # fmt: skip
    rest = np.zeros(n)
    force, tilt = spring.preload, 0.0
    # N(u) = preload − k u: the contact gives way by decay lengths, so the spring hardly changes
    for _ in range(_ROUNDS):
        rest[0] = float(stops.upper.approach(force, tilt))
        force = spring.preload - spring.stiffness * (rest[0] + spring.eccentricity * tilt)
        if spring.eccentricity:
            place = RestingPlace(rest[0], "upper stop", force, force, 0.0)
            tilt = resting_tilt(device, place)
    rest[2] = tilt
    return Machine(system, rest, modes)


def _bore(bore: Play, direction: Floats) -> tuple[Element, ...]:
    """Both sides of a bore with play, each a spring that only pushes; none without play."""
    if not bore.play:
        return ()
    sides = np.stack([direction, -direction])
    return (Element(BORE, Stop(bore.stiffness), sides, -bore.play),)


def _rim(name: str, law: RoughContact, upwards: float, offset: float, n: int) -> Element:
    """Points of the rim, those at equal x as one: δ = offset ± u + x ψ."""
    pairs = _POINTS // 2
    direction = np.zeros((pairs, n))
    direction[:, 0] = upwards
    direction[:, 2] = law.radius * np.cos(np.pi * (np.arange(pairs) + 0.5) / pairs)
    point = RoughPoint(law.reference_load / pairs, law.decay_length, law.relaxation_time)
    return Element(name, point, direction, offset)


#: Inputs besides the coil's, and outputs besides the coil's current, each with its unit.
_INPUTS = ("bimorph voltage (V)", "tip force (N)")
_OUTPUTS = ("lateral tip (m)", "lift (m)")
_LIFT = 2


@dataclass(frozen=True)
class MachineStateSpace:
    """Matrices (m, m), (m, 3), (p, m), (p, 3) in SI units, with column and row names."""

    a: Floats
    b: Floats
    c: Floats
    d: Floats
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def machine_state_space(
    rod: Linearised, modes: BimorphModes, *, supply: Literal["current", "voltage"]
) -> MachineStateSpace:
    """Machine with changes of the coil's current, or of its voltage, as third input.

    Parameters
    ----------
    rod : Linearised
        About its resting place; the bimorph's mass along the axis is in it.
    modes : BimorphModes
        Of the bimorph over the rod's head, wired as it is.
    """
    k = modes.omega.size
    n, own = 3 + k, slice(3, 3 + k)
    mass, damping, stiffness = np.eye(n), np.zeros((n, n)), np.zeros((n, n))
    mass[:3, :3] = rod.mass
    mass[:2, :2] += modes.rigid
    mass[own, :2], mass[:2, own] = modes.inertia, modes.inertia.T
    damping[:3, :3], damping[own, own] = rod.damping, np.diag(modes.damping)
    stiffness[:3, :3], stiffness[own, own] = rod.stiffness, np.diag(modes.omega**2)
    tip, seen = (np.insert(row, 2, 0.0) for row in (modes.tip, modes.seen))
    lift = np.eye(n)[_LIFT]
    forces = np.stack([np.concatenate([np.zeros(3), modes.coupling]), tip, rod.motional * lift], 1)
    pushed = np.linalg.solve(mass, np.hstack([-stiffness, -damping, forces]))
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:], a[n:] = np.eye(n), pushed[:, : 2 * n]
    b = np.vstack([np.zeros((n, 3)), pushed[:, 2 * n :]])
    c = np.hstack([np.stack([seen, lift]), np.zeros((2, n))])
    inputs: tuple[str, ...] = (*_INPUTS, "coil current (A)")
    outputs: tuple[str, ...] = _OUTPUTS
    if supply == "voltage":
        # the current i = (λ − T u)/L takes the place of the third input
        reads = np.append(np.zeros(2 * n), 1.0 / rod.inductance)
        reads[_LIFT] = -rod.motional / rod.inductance
        a = np.pad(a, (0, 1))
        a[:-1] += np.outer(b[:, 2], reads)
        a[-1] = -rod.resistance * reads
        b = np.vstack([b, np.zeros(3)])
        b[:-1, 2], b[-1, 2] = 0.0, 1.0
        c = np.vstack([np.pad(c, ((0, 0), (0, 1))), reads])
        inputs, outputs = (*_INPUTS, "coil voltage (V)"), (*_OUTPUTS, "coil current (A)")
    return MachineStateSpace(a, b, c, np.zeros((c.shape[0], 3)), inputs, outputs)
