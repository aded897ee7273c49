"""What the rod weighs with its coil, and how it resists turning: rings in closed form.

The slot in the head is taken as filled with steel; enamel and the spring's own coils are left
out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from tactgen.geometry.device.layout import MM, Ring, moving_rings
from tactgen.geometry.device.parameters import Device


@dataclass(frozen=True)
class RigidBody:
    """A rigid body of revolution about the z axis.

    Attributes
    ----------
    mass : float
        kg.
    centre : float
        Height of its centre of mass (m), 0 at the rod's top face: usually negative.
    inertia : float
        About a transverse axis through the centre of mass (kg m²).
    """

    mass: float
    centre: float
    inertia: float

    def inertia_about(self, height: float) -> float:
        """Return the inertia about a transverse axis at a height (kg m²), by Steiner."""
        return self.inertia + self.mass * (self.centre - height) ** 2


def moving_rod(device: Device) -> RigidBody:
    """Return rod and coil as one body; the bimorph on top is not in it."""
    rings = list(_weighed(device))
    mass = sum(m for _, m in rings)
    centre = sum(m * _middle(ring) for ring, m in rings) / mass
    inertia = sum(m * (_turned_inertia(ring) + (_middle(ring) - centre) ** 2) for ring, m in rings)
    return RigidBody(mass, centre, inertia)


def _weighed(device: Device) -> Iterator[tuple[Ring, float]]:
    """Yield the rings with the mass of each (kg)."""
    density = {
        "rod": device.rod.density,
        "coil": device.coil.copper_density * device.coil.fill_factor,
    }
    for name, rings in moving_rings(device).items():
        for ring in rings:
            area = math.pi * (ring.outer**2 - ring.inner**2) / MM**2
            yield ring, density[name] * area * (ring.high - ring.low) / MM


def _middle(ring: Ring) -> float:
    return 0.5 * (ring.low + ring.high) / MM


def _turned_inertia(ring: Ring) -> float:
    """Return inertia over mass about a transverse axis through the ring's centre (m²)."""
    radii, height = ring.inner**2 + ring.outer**2, (ring.high - ring.low) ** 2
    return (3.0 * radii + height) / 12.0 / MM**2
