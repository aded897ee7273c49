"""Mass and inertia of rod and coil: closed forms against sums over thin rings and CAD volumes."""

import math

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Coil, Device, Rod
from tactgen.geometry.device.parts import closed_form_volumes, moving_rings
from tactgen.tmm.generator.contact import moving_rod


def test_a_cylinder_is_the_textbooks():
    """Equal radii all along and a coil of next to nothing: m (3 R² + h²)/12 about the middle."""
    r = 0.9e-3
    rod = Rod(radius=r, head_radius=r, flange_radius=r)
    light = Coil(copper_density=1e-9)
    device = Device(rod=rod, coil=light)
    body = moving_rod(device)
    height = rod.length + 0.2e-3 + rod.head_thickness
    mass = rod.density * math.pi * r**2 * height
    assert body.mass == pytest.approx(mass, rel=1e-9)
    assert body.centre == pytest.approx(-height / 2, rel=1e-9)
    assert body.inertia == pytest.approx(mass * (3 * r**2 + height**2) / 12, rel=1e-9)
    assert body.mass_matrix[1, 1] == pytest.approx(mass * (3 * r**2 / 12 + height**2 / 3), rel=1e-9)


def test_sums_over_thin_discs():
    """Mass, centre and inertia from slices; midpoints of n slices leave 1/n² of a ring's own."""
    device = Device()
    density = {"rod": device.rod.density, "coil": 0.5 * device.coil.copper_density}
    m = s = second = 0.0
    for name, rings in moving_rings(device).items():
        for ring in rings:
            edges = np.linspace(ring.low, ring.high, 401) * 1e-3
            z, h = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
            inner, outer = 1e-3 * ring.inner, 1e-3 * ring.outer
            slices = density[name] * math.pi * (outer**2 - inner**2) * h * np.ones_like(z)
            m, s = m + slices.sum(), s + slices @ z
            second += slices @ (z**2 + (inner**2 + outer**2) / 4)
    body = moving_rod(device)
    assert body.mass == pytest.approx(m, rel=1e-12)
    assert body.centre == pytest.approx(s / m, rel=1e-12)
    assert body.mass_matrix[1, 1] == pytest.approx(second, rel=1e-5)


def test_the_rod_is_that_of_the_cad_parts():
    """Its volume with the slot filled, and the winding's window."""
    device = Device()
    volumes = closed_form_volumes(Device(bimorph={"tab_length": 2e-3}))
    glue, bond = device.glue.thickness, device.rod.slot_depth
    b = device.bimorph
    slot = (b.shim_thickness + 2 * glue) * (b.width + 2 * glue) * bond
    steel = moving_rod(Device(coil=Coil(copper_density=1e-9))).mass / device.rod.density
    assert steel == pytest.approx(volumes["rod"] + slot, rel=1e-6)
    copper = moving_rod(device).mass - steel * device.rod.density
    filled = device.coil.fill_factor * device.coil.copper_density
    assert copper == pytest.approx(volumes["coil"] * filled, rel=1e-6)
