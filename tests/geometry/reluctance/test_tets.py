"""The normal actuator and its air from CAD, and nine of them: volumes, planes, regions."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.device.parts import closed_form_volumes
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.mesh import TET_FACES, jacobian_coefficients
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.geometry.reluctance import tets
from tactgen.geometry.reluctance.section_grid import actuator_regions, air_radius
from tactgen.geometry.reluctance.sector_tets import COPIES, COUNTS, UNITS, Cell, nine_mesh, part_of
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
    """Four quarters make each part, the rod with or without its slot, in a box that is full; the
    rod is cut where the winding ends.
    """
    far = 20.0  # a third of the 60 mm of the half section
    solids = actuator_solids(DEVICE, ActuatorMeshing(slot=slot))
    found = dict.fromkeys(("rod", "coil", "sleeve", "air"), 0.0)
    for name, solid in solids.items():
        found[name.split("-")[0]] += 4.0 * solid.Volume() * MM3
    expected = closed_form_volumes(DEVICE)
    expected["rod"] += 0.0 if slot else slot_volume()
    for name in ("rod", "coil", "sleeve"):
        assert found[name] == pytest.approx(expected[name], rel=1e-9)
    assert sum(found.values()) == pytest.approx(8.0 * far**3 * MM3, rel=1e-9)
    # the source field jumps on the winding's end planes: both must be faces of the rod
    coil = DEVICE.coil
    heights = {
        round(face.Center().z, 6)
        for name, solid in solids.items()
        if name.startswith("rod")
        for face in solid.Faces()
        if abs(face.normalAt().z) > 0.5
    }
    assert {round(-1e3 * coil.position, 6), round(-1e3 * (coil.position + coil.length), 6)} < (
        heights
    )


MESHING = ActuatorMeshing(size=1.0, growth=0.7)


def sizes(points):
    """Edge lengths (mm) wanted at points (r, z) in mm, at azimuths that do not matter."""
    r, z = np.array(points, dtype=float).T
    turn = np.linspace(0.1, 1.4, r.size)
    return tets._edge_length(
        DEVICE, MESHING, np.column_stack([r * np.cos(turn), r * np.sin(turn), z])
    )


def test_edges_are_shortest_where_iron_is_near_iron():
    """0.3 of the working gap in it, then longer by 0.7 of the way at most, in units of `size`."""
    sleeve, gap = DEVICE.sleeve, 1e3 * GAP
    middle = 0.5e3 * (sleeve.inner_radius + sleeve.outer_radius)
    assert sizes([(middle, 0.5 * gap)])[0] == pytest.approx(0.3 * gap, rel=1e-12)
    up = np.diff(sizes([(middle, 30.0), (middle, 31.0)]))[0]
    assert 0.98 * 0.7 < up <= 0.7 + 1e-12
    rng = np.random.default_rng(1)
    a, b = rng.uniform([0.0, -6.0], [3.0, 3.0], (2, 400, 2))
    slope = np.abs(sizes(a) - sizes(b)) / np.linalg.norm(a - b, axis=1)
    assert slope.max() <= 0.7 + 1e-9
    twice = tets._edge_length(DEVICE, replace(MESHING, size=2.0), np.array([[0.3, 0.4, 0.05]]))
    assert twice[0] == pytest.approx(2.0 * sizes([(0.5, 0.05)])[0], rel=1e-12)


def test_air_is_divided_by_where_it_is():
    """Near within a gap's width around the sleeve, far at the outer walls but not at x, y = 0."""
    sleeve, gap = DEVICE.sleeve, DEVICE.gap
    across = [0.0, sleeve.outer_radius / 1.5, sleeve.outer_radius + gap, 49e-3, 50e-3]
    along = [-50e-3, -49e-3, -sleeve.length - gap, -sleeve.length, 0.0, gap, 49e-3, 50e-3]
    x, z = np.array(across), np.array(along)
    regions = np.full((4, 4, 7), 1)
    regions[0, 0, 3] = 0
    mesh = box_tetrahedra(x, x, z, regions, ("rod-in-0", "air-0"))
    found = tets._with_air_divided(mesh, DEVICE)
    names = np.array(found.regions)[found.region_of_cell].reshape(4, 4, 7, 6)
    assert found.regions == REGIONS
    outer = np.zeros((4, 4, 7), dtype=bool)
    outer[3], outer[:, 3], outer[:, :, [0, 6]] = True, True, True
    assert (names == "rod").all(axis=3).sum() == (names == "rod").any(axis=3).sum() == 1
    assert ((names == "far") <= outer[..., None]).all()
    assert (names == "far").any(axis=3)[outer].all()
    assert (names[0, 0, [2, 4]] == "near").all()
    assert (names[0, 0, [1, 5]] == "air").all()
    assert (names[2, 2] != "near").all()


def test_a_mesh_that_fails_is_tried_once_more_closer_to_the_surface(monkeypatch):
    """Half of the time each; the second refusal stands."""
    tried = []
    box = cq.Solid.makeBox(60.0, 60.0, 120.0, cq.Vector(0.0, 0.0, -60.0))

    def recorded(*_, envelope, time_limit, edge_length, sizing):
        tried.append((envelope, time_limit, edge_length, sizing.points.max()))
        return np.zeros((0, 3)), np.zeros((0, 4), dtype=int)

    def refused(*_, **__):
        raise MeshError(f"no good: {len(tried)}")

    monkeypatch.setattr(tets, "actuator_solids", lambda *_: {"air-0": box})
    monkeypatch.setattr(tets, "run_ftetwild", recorded)
    monkeypatch.setattr(tets, "conform", refused)
    with pytest.raises(MeshError, match="no good: 2"):
        actuator_tets(DEVICE, 2e-3, replace(MESHING, time_limit=50.0))
    first, second = tried
    assert second[0] == pytest.approx(0.7 * first[0], rel=1e-9)
    assert first[1:] == second[1:]
    assert first[1] == 25.0


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


OUTER_RADIUS = air_radius(actuator_regions(Device(), GAP))


@pytest.fixture(scope="module")
def mesh():
    return nine_mesh(Device(), GAP, 2.4e-3, Cell(refinement=0.5, layers=3))


def test_neighbours_share_their_faces(mesh):
    """A face has two cells, or it is in a mirror plane or at the end of the air."""
    faces = np.sort(mesh.cells[:, TET_FACES].reshape(-1, 3), axis=1)
    faces, count = np.unique(faces, axis=0, return_counts=True)
    assert count.max() == 2
    x, y, z = np.moveaxis(mesh.points[faces[count == 1]], -1, 0)
    ends = (y, x - y, x - OUTER_RADIUS, z - z.min(), z - z.max())
    outside = np.any([np.all(np.abs(end) < 1e-12, axis=1) for end in ends], axis=0)
    assert outside.all()


def test_no_cell_folds_and_all_has_its_volume(mesh):
    """Sleeves and windings by unit, and the whole, a box."""
    jacobians = jacobian_coefficients(mesh.points[mesh.cells])
    assert jacobians.min() > 0.0
    volumes = COPIES * jacobians.mean(axis=1) / 6.0
    box = (2.0 * OUTER_RADIUS) ** 2 * float(np.ptp(mesh.points[:, 2]))
    assert volumes.sum() == pytest.approx(box, rel=1e-9)
    expected = closed_form_volumes(Device(bimorph=Bimorph(tab_length=2e-3)))
    for unit in UNITS:
        for part in ("sleeve", "coil"):
            found = volumes[mesh.cells_of(part_of(unit, part))].sum()
            # arcs of up to 21 degrees by parabolas: some 1e-4 of the area
            assert found == pytest.approx(COUNTS[unit] * expected[part], rel=5e-4), unit
