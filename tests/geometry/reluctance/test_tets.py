"""The normal actuator and its air from CAD: volumes, planes at the winding's ends, regions."""

import numpy as np
import pytest

from tactgen.geometry.device.layout import closed_form_volumes
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.quadratic import jacobian_coefficients
from tactgen.geometry.reluctance.tets import (
    REGIONS,
    ActuatorMeshing,
    actuator_solids,
    actuator_tets,
    with_fitting_tab,
)

GAP = 0.2e-3
DEVICE = with_fitting_tab(Device(), GAP)
MM3 = 1e-9


def slot_volume():
    """The tab with a bond all around, as deep as the slot (m³)."""
    bimorph, bond = DEVICE.bimorph, DEVICE.glue.thickness
    across = bimorph.shim_thickness + 2.0 * bond
    return across * (bimorph.width + 2.0 * bond) * DEVICE.rod.slot_depth


@pytest.mark.parametrize("slot", [True, False])
def test_solids_have_their_closed_form_volumes(slot):
    """Four quarters make each part, the rod with or without its slot, in a box that is full."""
    far = 20.0
    solids = actuator_solids(DEVICE, ActuatorMeshing(slot=slot, far=far * 1e-3))
    found = dict.fromkeys(("rod", "coil", "sleeve", "air"), 0.0)
    for name, solid in solids.items():
        found[name.split("-")[0]] += 4.0 * solid.Volume() * MM3
    expected = closed_form_volumes(DEVICE)
    expected["rod"] += 0.0 if slot else slot_volume()
    for name in ("rod", "coil", "sleeve"):
        assert found[name] == pytest.approx(expected[name], rel=1e-9)
    assert sum(found.values()) == pytest.approx(8.0 * far**3 * MM3, rel=1e-9)


def test_rod_is_cut_where_the_winding_ends():
    """The source field jumps on the winding's end planes: both must be faces of the rod."""
    coil = DEVICE.coil
    heights = {
        round(face.Center().z, 6)
        for name, solid in actuator_solids(DEVICE, ActuatorMeshing()).items()
        if name.startswith("rod")
        for face in solid.Faces()
        if abs(face.normalAt().z) > 0.5
    }
    assert {round(-1e3 * coil.position, 6), round(-1e3 * (coil.position + coil.length), 6)} < (
        heights
    )


@pytest.mark.heavy
def test_mesh_has_regions_and_volumes(tmp_path, monkeypatch):
    """All regions are there, iron and winding with their volumes, sleeve's top at z = 0."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path))
    mesh = actuator_tets(DEVICE, GAP, ActuatorMeshing(size=3.0, growth=1.0))
    assert mesh.regions == REGIONS
    coefficients = jacobian_coefficients(mesh.points[mesh.cells])
    assert coefficients.min() > 0.0
    volumes = coefficients.mean(axis=1) / 6.0
    expected = closed_form_volumes(DEVICE)
    expected["rod"] += slot_volume()
    for name in ("rod", "coil", "sleeve"):
        found = 4.0 * volumes[mesh.cells_of(name)].sum()
        assert found == pytest.approx(expected[name], rel=1e-3)  # what the mesh is held against
    top = mesh.points[np.unique(mesh.cells[mesh.cells_of("sleeve")]), 2].max()
    assert top == pytest.approx(0.0, abs=1e-12)
