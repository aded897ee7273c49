"""The solid shape of a row of pieces: every region's volume, and who moves how."""

import itertools

import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import CentreLine, beam_pieces, row_shape
from tactgen.geometry.device.parameters import Bimorph, Device, Support
from tactgen.geometry.meshing.structured_tets import box_tetrahedra

DEVICE = Device(bimorph=Bimorph(glue_thickness=10e-6, bare_above=1e-3))
TOP = DEVICE.bimorph.length


@pytest.fixture(scope="module")
def shape_and_line():
    """The row on its rod, two stations at each joint, and some motion of its centre line."""
    pieces = beam_pieces(DEVICE, Support(kind="rod"))
    ends = np.cumsum([0.0, *(p.length for p in pieces if p.section != "bond")])
    z = np.concatenate([np.linspace(a, b, 3) for a, b in itertools.pairwise(ends)])
    line = CentreLine(z, 1e-6 * np.cos(300.0 * z), 1e-3 * np.sin(200.0 * z), 0.0, 3.0, 0.0)
    return row_shape(pieces, DEVICE, z, TOP), line, pieces


def volumes(mesh):
    """Return the volume of each hexahedron, cut as a box is cut into six tetrahedra."""
    two = np.array([0.0, 1.0])
    box = box_tetrahedra(two, two, two, np.zeros((1, 1, 1), dtype=int), ("",))
    place = {(0, 0, 0): 0, (1, 0, 0): 1, (1, 1, 0): 2, (0, 1, 0): 3}
    place |= {(x, y, 1): corner + 4 for (x, y, _), corner in place.items()}
    corner = np.array([place[tuple(p.astype(int))] for p in box.points])
    tets = mesh.points[mesh.cells[:, corner[box.cells]]]
    return np.linalg.det(tets[:, :, 1:] - tets[:, :, :1]).sum(axis=1) / 6.0


def test_every_region_has_its_volume(shape_and_line):
    """Layers to rounding; the rod as a prism on its rim, 1 % less than the cylinders."""
    shape, _, pieces = shape_and_line
    found = np.bincount(shape.mesh.region_of_cell, volumes(shape.mesh))
    found = dict(zip(shape.mesh.regions, found, strict=True))
    b = DEVICE.bimorph
    length = {
        name: sum(p.length for p in pieces if p.section == name) for name in ("bimorph", "shim")
    }
    ceramic = b.width * b.piezo_thickness * length["bimorph"]
    assert found["piezo_top"] == pytest.approx(ceramic, rel=1e-9)
    assert found["piezo_bottom"] == pytest.approx(ceramic, rel=1e-9)
    assert found["glue"] == pytest.approx(2.0 * b.width * 10e-6 * length["bimorph"], rel=1e-9)
    assert found["shim"] == pytest.approx(
        b.width * b.shim_thickness * sum(length.values()), rel=1e-9
    )
    assert shape.mesh.points[:, 2].max() == pytest.approx(TOP, rel=1e-12)
    rod = sum(np.pi * p.radius**2 * p.length for p in pieces if p.section == "cylinder")
    assert 0.98 * rod < found["rod"] < rod
    assert volumes(shape.mesh).min() > 0.0


def test_sections_stay_plane_and_outer_electrodes_have_the_voltage(shape_and_line):
    """At every point what the centre line does at its height, from either side of a joint."""
    shape, line, _ = shape_and_line
    points, mesh = shape.mesh.points, shape.mesh
    height = points[:, 2] - points[:, 2].min()
    u_x, u_y, u_z, potential = shape.values(line).T
    np.testing.assert_allclose(u_x, np.interp(height, line.z, line.w), rtol=1e-9)
    np.testing.assert_allclose(
        u_z, points[:, 0] * np.interp(height, line.z, line.psi), rtol=1e-9, atol=1e-20
    )
    assert not u_y.any()
    b = DEVICE.bimorph
    inner = 0.5 * b.shim_thickness + b.glue_thickness
    share = (np.abs(points[:, 0]) - inner) / b.piezo_thickness
    electrode = TOP - b.bare_above
    for side in ("piezo_top", "piezo_bottom"):
        at = np.unique(mesh.cells[mesh.cells_of(side)])
        below = at[points[at, 2] < electrode - 1e-9]
        np.testing.assert_allclose(potential[below], line.voltage * share[below], atol=1e-9)
        assert not potential[at[points[at, 2] > electrode + 1e-9]].any()
    for name in ("shim", "glue", "rod"):
        assert not potential[np.unique(mesh.cells[mesh.cells_of(name)])].any()
