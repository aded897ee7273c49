"""Mass and inertia of rod and coil: closed forms against sums over thin rings and CAD volumes."""

import math

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Coil, Device
from tactgen.geometry.device.parts import closed_form_volumes, moving_rings
from tactgen.tmm.generator.contact import moving_rod


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
