"""What the rod's head, pressed on its stop, is to the bimorph that stands on it.

Rocking and lateral stiffness of the contact under its net force, their damping, and the inertia
of rod and coil about the head's top face: the springs of a support.  Left out, since they are
small below 1 kHz: the rod's mass against the lateral spring, the head's thickness as a lever
while the lower stop holds it, and the magnetic field's own moment on a tilted head.
"""

from __future__ import annotations

from tactgen.geometry.device.parameters import Device, Support
from tactgen.tmm.generator.contact import RoughContact
from tactgen.tmm.generator.guide import lateral_guide, tilt_guide
from tactgen.tmm.generator.moving_mass import moving_rod
from tactgen.tmm.generator.positions import History, Pull, RestingPlace, axial_forces, resting_place


def pressed_support(device: Device, contact: RoughContact, load: float) -> Support:
    """Return the springs of a head that a stop carries with `load` (N), 0 or more."""
    rocking = float(contact.stiffness_under(load))
    return Support(
        kind="spring",
        rotational_stiffness=rocking + tilt_guide(device).at_rest,
        rotational_damping=contact.relaxation_time * rocking,
        lateral_stiffness=float(contact.tangential_stiffness(load)) + lateral_guide(device).at_rest,
        rotational_inertia=moving_rod(device).inertia_about(0.0),
    )


def held_support(
    device: Device,
    pull: Pull | None,
    current: float,
    history: History,
    pressed: float = 0.0,
) -> tuple[RestingPlace, Support]:
    """Return where the rod rests, and the springs that it is there to the bimorph.

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

    Raises
    ------
    InputError
        If the rod rests nowhere.
    """
    forces = axial_forces(device, pull, pressed)
    place = resting_place(forces, current, history)
    return place, pressed_support(device, forces.stops.holding(place.lift), place.contact_force)
