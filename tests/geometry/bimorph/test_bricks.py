"""The bricks are the device: volumes, faces and names, and their mirrored whole."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks, lobatto_points
from tactgen.geometry.device.parameters import Bimorph, Device

VARIANTS = (
    {"tab_length": 1.6e-3, "width": 9e-3},
    {"bare_below": 1e-3, "bare_above": 0.4e-3},
    {"glue_thickness": 10e-6, "width": 0.3e-3},
)


@pytest.mark.parametrize("variant", VARIANTS)
def test_volumes_of_regions_and_areas_of_named_faces_are_exact(variant):
    """Each layer is the box it stands for, the tab belongs to the shim; outer electrodes leave the
    bare ends free; the base is the section or the tab's end.
    """
    b = Bimorph(**variant)
    bricks = bimorph_bricks(Device(bimorph=b), LEVELS[1])
    ceramic = b.length * b.width * b.piezo_thickness
    shim = (b.length + b.tab_length) * b.width * b.shim_thickness
    expected = {"piezo_top": ceramic, "piezo_bottom": ceramic, "shim": shim}
    if b.glue_thickness:
        expected["glue"] = 2.0 * b.length * b.width * b.glue_thickness
    for mesh in (bricks.node_mesh(), bricks.corner_mesh()):
        volumes = np.prod(np.ptp(mesh.points[mesh.cells], axis=1), axis=1)
        assert set(expected) == set(mesh.regions)
        for region, volume in expected.items():
            assert volumes[mesh.cells_of(region)].sum() == pytest.approx(volume, rel=1e-11)
    areas = {}
    for name, quads in mesh.faces.items():
        extent = np.sort(np.ptp(mesh.points[quads], axis=1), axis=1)
        areas[name] = (extent[:, 1] * extent[:, 2]).sum()
    covered = (b.length - b.bare_below - b.bare_above) * b.width
    for side in ("top", "bottom"):
        assert areas[f"electrode_{side}_outer"] == pytest.approx(covered, rel=1e-11)
        assert areas[f"electrode_{side}_inner"] == pytest.approx(b.length * b.width, rel=1e-11)
    assert areas["tip"] == pytest.approx(b.width * b.thickness, rel=1e-11)
    base = b.shim_thickness if b.tab_length else b.thickness
    assert areas["base"] == pytest.approx(b.width * base, rel=1e-11)
    nodes = bricks.node_mesh()  # in VTK's order: the Jacobian of every box is positive
    p = nodes.points[nodes.cells]
    edges = np.stack([p[:, i] - p[:, 0] for i in (1, 3, 4)], axis=1)
    assert (np.linalg.det(edges) > 0.0).all()


def test_held_shim_leaves_the_ceramic_free():
    """A base of the shim alone is the shim's section, with and without a tab."""
    b = Bimorph()
    bricks = bimorph_bricks(Device(bimorph=b), LEVELS[0], held="shim")
    x = bricks.x.nodes[bricks.base().any(axis=(1, 2))]
    assert x.max() == pytest.approx(0.5 * b.shim_thickness)
    quads = bricks.corner_mesh().points[bricks.corner_mesh().faces["base"]]
    assert np.abs(quads[..., 0]).max() == pytest.approx(0.5 * b.shim_thickness)


@pytest.mark.parametrize("degree", [1, 3, 6])
def test_lobatto_points_are_exact(degree):
    """Ends included, symmetric, and the inner ones are where Legendre's slope vanishes."""
    points = lobatto_points(degree)
    assert points[[0, -1]] == pytest.approx([-1.0, 1.0], abs=0.0)
    assert points == pytest.approx(-points[::-1], abs=1e-14)
    slope = np.polynomial.Legendre.basis(degree).deriv()
    assert np.abs(slope(points[1:-1])).max(initial=0.0) < 1e-12


def test_a_thick_shim_gets_finer_with_every_level():
    """Half a shim of ten ceramic layers has more nodes from level to level; a thin one is one."""
    thick = Device(bimorph=Bimorph(shim_thickness=1e-3, piezo_thickness=50e-6))
    counts, nodes = [], []
    for level in LEVELS:
        bricks, usual = (bimorph_bricks(device, level) for device in (thick, Device()))
        (shim,) = (slab for slab in bricks.slabs if slab.region == "shim")
        counts.append(shim.x[1] * bricks.x.degree)
        (shim,) = (slab for slab in usual.slabs if slab.region == "shim")
        assert shim.x == (0, 1)
        nodes.append(np.prod(usual.shape))
    assert counts == sorted(set(counts))
    assert nodes == sorted(set(nodes))


def test_a_long_tab_takes_long_bricks():
    """Bricks are long beside the whole length, not beside a short ceramic's."""
    long = Device(bimorph=Bimorph(length=2e-3, tab_length=1.0))
    assert bimorph_bricks(long, LEVELS[2]).z.intervals < 40
