"""The bimorph on its rod in bricks: what is where, and in which parts."""

import numpy as np
import pytest

from tactgen.fem.elements.line_basis import line_matrices
from tactgen.fem.piezo.brick_matrices import round_matrices
from tactgen.geometry.bimorph.bimorph_bricks import BrickParts
from tactgen.geometry.bimorph.bricks import Axis, Bricks, Slab
from tactgen.geometry.bimorph.rod_bricks import _GROWTH, ROD_LEVELS, rod_bricks, rod_parts
from tactgen.geometry.device.layout import closed_form_volumes
from tactgen.geometry.device.parameters import Bimorph, Device, Rod
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.values import fingerprint

GLUED = Device(bimorph=Bimorph(tab_length=2e-3))


def volumes(bricks: Bricks) -> dict[str, float]:
    """Volume of each region (m³): four quarters."""
    found = dict.fromkeys(bricks.regions, 0.0)
    for slab in bricks.slabs:
        if np.isinf(slab.radius):
            x, y = (
                np.ptp(axis.breaks[list(ends)])
                for axis, ends in ((bricks.x, slab.x), (bricks.y, slab.y))
            )
            area = x * y
        else:
            area = round_matrices(bricks, slab)[0].sum()
        found[slab.region] += 4.0 * area * np.ptp(bricks.z.breaks[list(slab.z)])
    return found


@pytest.mark.parametrize(
    ("rod", "level"), [({}, 0), ({}, 2), ({"radius": 0.1e-3}, 0), ({"head_radius": 1.3e-3}, 0)]
)
def test_every_part_has_its_volume(rod, level):
    """To rounding, round parts too: their outline is followed exactly."""
    device = GLUED.model_copy(update={"rod": Rod(**rod)})
    known = closed_form_volumes(device)
    found = volumes(rod_bricks(device, ROD_LEVELS[level]))
    assert found.pop("piezo") == pytest.approx(2.0 * known["piezo_top"], rel=1e-12)
    assert found == pytest.approx({name: known[name] for name in found}, rel=1e-12)


def test_moments_of_a_disc():
    """∫ x² and ∫ x² y² over a quarter of a disc, πr⁴/16 and πr⁶/96, on a grid that it cuts."""
    radius, axis = 1.0, Axis(np.array([0.0, 0.3, 0.8, 1.2]), 2)
    bricks = Bricks(axis, axis, axis, (Slab("rod", (0, 3), (0, 3), None, radius),), (0, 1))
    area, _ = round_matrices(bricks, bricks.slabs[0])
    pairs = line_matrices(axis)
    x = axis.nodes
    # the polynomials of degree two interpolate x exactly
    one_x = x[pairs.rows] * x[pairs.columns]
    assert one_x @ area @ np.ones_like(one_x) == pytest.approx(np.pi / 16.0, rel=1e-13)
    assert one_x @ area @ one_x == pytest.approx(np.pi / 96.0, rel=1e-13)


def test_another_length_has_the_same_ends():
    """Foot, tip and section are asked of the store by what they are, to the last bit."""
    short, long = (
        rod_parts(
            GLUED.model_copy(update={"bimorph": Bimorph(tab_length=2e-3, length=length)}),
            ROD_LEVELS[1],
        )
        for length in (14e-3, 25e-3)
    )
    assert isinstance(short, BrickParts)
    assert isinstance(long, BrickParts)
    for part in ("foot", "tip", "middle"):
        one, other = (getattr(parts, part) for parts in (short, long))
        assert one.slabs == other.slabs
        for a, b in zip(one.axes, other.axes, strict=True):
            assert np.array_equal(a.breaks, b.breaks)
    assert long.stretch.breaks[-1] - short.stretch.breaks[-1] == pytest.approx(11e-3)
    assert short.stretch.breaks[0] == 0.0
    assert (np.diff(short.stretch.breaks) > 0.0).all()


def test_another_tab_has_the_same_tip_and_section():
    """To the last bit: only the foot depends on tab, slot and rod."""
    parts = [
        rod_parts(
            GLUED.model_copy(
                update={"bimorph": Bimorph(tab_length=tab), "rod": Rod(slot_depth=deep)}
            ),
            ROD_LEVELS[1],
        )
        for tab, deep in ((2e-3, 0.45e-3), (1.7e-3, 0.45e-3), (1.3e-3, 0.41e-3))
    ]
    first, *others = (part for part in parts if isinstance(part, BrickParts))
    assert len(others) == 2
    for other in others:
        assert not np.array_equal(first.foot.z.breaks, other.foot.z.breaks)
        for part in ("tip", "middle"):
            assert fingerprint(getattr(first, part)) == fingerprint(getattr(other, part))


def test_a_stub_is_left_whole():
    """Where nothing would be left between the sections."""
    stub = Bimorph(tab_length=2e-3, length=2e-3)
    assert isinstance(rod_parts(Device(bimorph=stub), ROD_LEVELS[0]), Bricks)


def test_bare_ends_are_refused():
    """As by the CAD parts, with the key and the remedy."""
    bare = Bimorph(tab_length=2e-3, bare_below=1e-3)
    with pytest.raises(InputError, match="bare_below"):
        rod_bricks(Device(bimorph=bare), ROD_LEVELS[0])


@pytest.mark.parametrize(
    ("level", "breaks"),
    list(enumerate([(6, 6, 32), (7, 6, 37), (8, 6, 39), (9, 7, 40), (11, 7, 43)])),
)
def test_divisions_are_those_that_the_bars_were_held_against(level, breaks):
    """Breaks along x, y and z: a coarser grading is another error, and its bars another study."""
    bricks = rod_bricks(GLUED, ROD_LEVELS[level])
    assert tuple(axis.breaks.size for axis in (bricks.x, bricks.y, bricks.z)) == breaks


@pytest.mark.parametrize("level", range(len(ROD_LEVELS)))
def test_a_division_is_what_its_level_states(level):
    """Shares across the layers fill them; bricks at the edges are of the size stated or, to fit
    in whole, less, by no more than their growth; each level is finer than the one before.
    """
    meshing, b, bond = ROD_LEVELS[level], GLUED.bimorph, GLUED.glue.thickness
    bricks = rod_bricks(GLUED, meshing)
    thick = (0.5 * b.shim_thickness, bond, b.piezo_thickness - bond)
    shares = (meshing.core, meshing.bond, meshing.layer)
    assert [sum(each) for each in shares] == pytest.approx([1.0, 1.0, 1.0], rel=1e-12)
    across = np.concatenate([t * np.array(each) for t, each in zip(thick, shares, strict=True)])
    assert np.diff(bricks.x.breaks)[: across.size] == pytest.approx(across, rel=1e-9)
    side = np.flatnonzero(np.isclose(bricks.y.breaks, 0.5 * b.width))[0]
    ceramic, tip = bricks.electrode
    y, z = np.diff(bricks.y.breaks), np.diff(bricks.z.breaks)
    for found, stated in (
        (y[side - 1], meshing.side), (z[ceramic - 1], meshing.smallest),
        (z[ceramic], meshing.smallest), (z[tip - 1], max(meshing.smallest, meshing.tip)),
    ):  # fmt: skip
        assert stated / _GROWTH < found / b.shim_thickness < stated * (1.0 + 1e-9)
    if level:
        coarser = ROD_LEVELS[level - 1]
        assert meshing.smallest < coarser.smallest
        assert meshing.side <= coarser.side
        assert meshing.tip <= coarser.tip
