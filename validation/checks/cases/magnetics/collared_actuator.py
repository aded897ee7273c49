"""A normal actuator with a collar: a device of its own whose field is known from elsewhere.

Like the reconstructed one in outer diameter and gap, but its sleeve ends in a collar around the
shaft, its coil begins below the collar, and its shaft is saturated at the larger current.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactgen.geometry.device.parameters import Coil, Device, Rod, Sleeve
from tactgen.validation.checks.cases.magnetics.actuator_field import field_point

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint

#: The device; its steel is that of TEAM problem 20.
COLLARED = Device(
    rod=Rod(
        radius=0.62e-3,
        flange_radius=0.91e-3,
        flange_thickness=0.9e-3,
        flange_position=2.4e-3,
        length=3.3e-3,
    ),
    coil=Coil(
        inner_radius=0.62e-3, outer_radius=0.88e-3, length=2e-3, position=0.3e-3, turns=849.0
    ),
    sleeve=Sleeve(
        inner_radius=0.96e-3, length=3.6e-3, collar_radius=0.9e-3, collar_thickness=0.2e-3
    ),
)


def collared(**changes: dict[str, float]) -> Device:
    """Return the device with some values of its groups changed, as ``sleeve={"length": 3e-3}``."""
    groups = {name: getattr(COLLARED, name).model_copy(update=new) for name, new in changes.items()}
    return COLLARED.model_copy(update=groups)


#: Gap (m), and by current (A) the pull (N) and the flux linkage per turn (Wb), by an axisymmetric
#: solution that is not published, of a program that shares nothing with this one; it states 0.03 %
#: and 0.01 % as its own error.
GAP = 0.2e-3
KNOWN = {0.13: (110.0507e-3, 2.278879e-6), 0.05: (37.9644e-3, 1.376275e-6)}


def field(current: float) -> FieldPoint:
    """Return the axisymmetric field's answer at a current (A)."""
    return field_point(COLLARED, current, GAP)
