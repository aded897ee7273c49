"""The generator as a system that moves: bimorph, rigid rod, spring, two stops, coil.

Coordinates: lift u of the rod (m, 0 at the upper stop, positive upwards), lateral motion w and
tilt ψ of its head, then the bimorph's modes and the parts of what the tip touches.  The head stands
on points around its rim, each of which pushes by the law of rough contact that
:mod:`tmm.generator.contact` states for the whole rim: lift, rocking and tipping follow.  Friction
holds the head laterally while it is pressed.

Left out: the bimorph's stretching, tilting about the second axis, the field's moment on a tilted
head, the head's thickness as a lever.  The weight (2 % of the preload) is in the preload, which is
set by hand on the standing device.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.winding import winding
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.contact import RoughContact
from tactgen.tmm.generator.guide import Play, lateral_guide, tilt_guide
from tactgen.tmm.generator.moving_mass import moving_rod
from tactgen.tmm.generator.stops import stops_of
from tactgen.tmm.generator.transient.bimorph import BimorphModes
from tactgen.tmm.generator.transient.laws import RoughPoint, Stop
from tactgen.tmm.generator.transient.system import Coil, Element, Friction, Output, System
from tactgen.tmm.ports.springs_dampers_masses import Chain
from tactgen.tmm.reluctance.coenergy.cells import cells
from tactgen.tmm.reluctance.coenergy.map import CoenergyMap

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
    """The system with what an initial state needs.

    Attributes
    ----------
    system : System
    rest : (n,) float
        At rest on the upper stop without current and voltage.
    modes : BimorphModes
        Those among the coordinates.
    """

    system: System
    rest: Floats
    modes: BimorphModes


def machine(
    device: Device,
    modes: BimorphModes,
    pull: CoenergyMap,
    *,
    load: Chain,
    source: Literal["current", "voltage"],
    drive_scale: float = 1.0,
) -> Machine:
    """Return the generator.

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

    Raises
    ------
    InputError
        If the spring cannot hold the rod on its upper stop, or a disc is asked for.
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
    tip: Floats = np.concatenate([[0.0], modes.tip, np.zeros(parts)])
    loaded = np.vstack([tip, np.eye(n)[3 + k :]])
    mass = loaded.T @ load.mass @ loaded
    mass[0, 0] += body.mass + modes.rigid[0, 0] + load.carried
    lever = -body.mass * body.centre
    mass[1:3, 1:3] += modes.rigid + np.array([[body.mass, lever], [lever, body.inertia_about(0.0)]])
    mass[own, 1:3] += modes.inertia
    mass[1:3, own] += modes.inertia.T
    mass[own, own] += np.eye(k)
    damping = loaded.T @ load.damping @ loaded
    damping[0, 0] += device.guide.axial_damping
    damping[own, own] += np.diag(modes.damping)
    stiffness = loaded.T @ load.stiffness @ loaded
    stiffness[:3, :3] += np.diag([spring.stiffness, lateral_bore.at_rest, tilt_bore.at_rest])
    stiffness[own, own] += np.diag(modes.omega**2)
    pushed = np.zeros(n)
    pushed[0] = spring.preload
    elements = (
        _rim(UPPER, stops.upper, 1.0, 0.0, n),
        _rim(LOWER, stops.lower, -1.0, -stops.stroke, n),
        *_bore(lateral_bore, np.eye(n)[1]),
        *_bore(tilt_bore, np.eye(n)[2]),
    )
    low, high = pull.gap_limits
    beyond = _BEYOND * max(stops.upper.decay_length, stops.lower.decay_length)
    lateral, axial = np.eye(n)[1], np.eye(n)[0]
    static = drive_scale * float(modes.tip[2:] @ (modes.coupling / modes.omega**2))
    bent = max(abs(static), _STILL)
    system = System(
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        load=pushed,
        coupling=np.concatenate([np.zeros(3), modes.coupling, np.zeros(parts)]),
        capacitance=modes.capacitance,
        elements=elements,
        frictions=tuple(Friction(i, lateral, contact.friction) for i in range(2)),
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
            "lateral_tip": Output(tip, "m", bent, "lateral motion of the tip"),
            "head_tilt": Output(
                np.eye(n)[2], "rad", np.inf, "tilt of the rod's head",
                # a rocking head turns the tip by its height; what it does to the contact counts too
                step_scale=bent / (_TURNED * abs(float(tip[2]))),
            ),
        },
    )  # fmt: skip
    rest = np.zeros(n)
    force = spring.preload
    # N(u) = preload − k u: the contact gives way by decay lengths, so the spring hardly changes
    for _ in range(_ROUNDS):
        rest[0] = float(stops.upper.approach(force))
        force = spring.preload - spring.stiffness * rest[0]
    return Machine(system, rest, modes)


def _bore(bore: Play, direction: Floats) -> tuple[Element, ...]:
    """Return both sides of a bore with play, each a spring that only pushes; none without play."""
    if not bore.play:
        return ()
    sides = np.stack([direction, -direction])
    return (Element(BORE, Stop(bore.stiffness), sides, -bore.play),)


def _rim(name: str, law: RoughContact, upwards: float, offset: float, n: int) -> Element:
    """Return the points of the rim, those at equal x as one: δ = offset ± u + x ψ."""
    pairs = _POINTS // 2
    direction = np.zeros((pairs, n))
    direction[:, 0] = upwards
    direction[:, 2] = law.radius * np.cos(np.pi * (np.arange(pairs) + 0.5) / pairs)
    point = RoughPoint(law.reference_load / pairs, law.decay_length, law.relaxation_time)
    return Element(name, point, direction, offset)
