"""A reduced family against members that are solved on their own bricks."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.bimorph.reduction.parametric import builder, compression
from tactgen.fem.bimorph.reduction.parametric.answers import (
    family_modes,
    family_statics,
    mode_states,
    softest,
    static_states,
)
from tactgen.fem.bimorph.reduction.parametric.builder import FamilyBuilder
from tactgen.fem.bimorph.reduction.parametric.compression import compressed
from tactgen.fem.bimorph.reduction.parametric.expansion import with_values
from tactgen.fem.bimorph.reduction.parametric.family import build_family
from tactgen.fem.bimorph.reduction.parametric.training_set import at_rest
from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import ports_from_blocks, static_multiport
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.bimorph.ends import Ends, Springs, TipLoad
from tactgen.geometry.bimorph.stretching import dividing, stretched
from tactgen.geometry.device.parameters import Device

COARSE = BrickMeshing((2, 2, 2), smallest=0.5)
TOLERANCE = 1e-5
#: Rounding of a direct solution's frequencies and statics on these bricks.
ROUNDING = 2e-7
PLAIN = Device()
TABBED = with_values(PLAIN, {"bimorph.tab_length": 2e-3})
MODES = {"bending_x": 3, "bending_y": 1, "torsion": 1, "axial": 1}
LENGTH = {"bimorph.length": (10e-3, 20e-3)}
TAB_AND_CERAMIC = {"bimorph.tab_length": (1e-3, 3e-3), "piezo.s11": (15e-12, 18e-12)}


@pytest.fixture(scope="module")
def family():
    return build_family(PLAIN, LENGTH, COARSE, MODES, tolerance=TOLERANCE)


def direct(device, ranges, point):
    """Return a member of a family on bricks of its own, and the point as arrays."""
    corners = [with_values(device, {key: ends[i] for key, ends in ranges.items()}) for i in (0, 1)]
    # the thinnest and longest are at the corners of every range
    bricks = dividing(corners, COARSE)
    member = with_values(device, point)
    system = assemble_bricks(member, stretched(bricks, member.bimorph), lossy=False)
    return system, {key: np.array([value]) for key, value in point.items()}


@pytest.mark.parametrize("length", [11.3e-3, 17.7e-3])
def test_modes_of_all_classes_lie_within_their_bars(family, length):
    system, values = direct(PLAIN, LENGTH, {"bimorph.length": length})
    for motion, count in MODES.items():
        members = family.members(motion, PLAIN, values)
        found = family_modes(members, Ends(), count, open_circuit=False)
        exact = natural_modes(system.related(motion), Ends(), count)
        frequencies = np.array([mode.frequency for mode in exact])
        apart = np.abs(found.frequencies[0] - frequencies)
        assert (apart <= found.bars[0] + ROUNDING * frequencies).all()
        assert (found.bars[0] <= TOLERANCE * frequencies).all()
        named = np.where(found.shares(members)[0] >= 0.5, motion, "mixed")
        assert list(named) == [mode.kind for mode in exact]


ENDS = {
    "the paper's springs": Ends(Springs(3e6, 0.24, 1e-4, 1e-12)),
    "heavy base, load": Ends(Springs(1e4, 0.01, 0.0, 1e-8), TipLoad(10.0, 0.1, 1e-6)),
    "sprung tip": Ends(None, TipLoad(1e4)),
    "free": Ends(Springs(0.0, 0.0)),
}


@pytest.mark.parametrize("open_circuit", [False, True], ids=["short", "open"])
@pytest.mark.parametrize("ends", ENDS.values(), ids=ENDS)
def test_ends_and_circuits_that_the_basis_was_not_made_for(family, ends, open_circuit):
    system, values = direct(PLAIN, LENGTH, {"bimorph.length": 14.2e-3})
    found = family_modes(
        family.members("bending_x", PLAIN, values), ends, 3, open_circuit=open_circuit
    )
    exact = natural_modes(system, ends, 3, open_circuit=open_circuit)
    frequencies = np.array([mode.frequency for mode in exact])
    assert (np.abs(found.frequencies[0] - frequencies) <= found.bars[0] + 1e-6 * frequencies).all()
    assert (found.bars[0] <= 1e-3 * frequencies).all()


def test_statics_lie_within_their_bounds(family):
    system, values = direct(PLAIN, LENGTH, {"bimorph.length": 12.9e-3})
    found = family_statics(family.members("bending_x", PLAIN, values))
    d = ports_from_blocks(found.held, found.through, found.follows, found.compliance)[0]
    exact = static_multiport(system).stiffness[0]
    size = np.sqrt(np.abs(np.diag(exact)))
    np.testing.assert_allclose(d / np.outer(size, size), exact / np.outer(size, size), atol=1e-5)
    compliance = np.linalg.inv(exact[2:4, 2:4])
    bound = np.outer(found.missing[0, 1:], found.missing[0, 1:])
    off = np.abs(found.compliance[0] - compliance)
    assert (off <= bound + ROUNDING * np.abs(compliance)).all()


def test_the_stated_bound_is_that_of_the_family_as_it_is(family):
    """Margins included: the largest over a fine row of members, which may miss the very worst."""
    values = {"bimorph.length": np.linspace(*LENGTH["bimorph.length"], 61)}
    largest = max(
        at_rest(family.members(motion, PLAIN, values), count).bound.max()
        for motion, count in MODES.items()
    )
    assert 0.7 * family.bound < largest < 1.3 * family.bound


def test_what_is_looked_at_at_rest_is_all_that_is_answered(family):
    """Modes of both circuits, and of statics what a force and a volt do, each with its bound."""
    members = family.members("bending_x", PLAIN, {"bimorph.length": np.array([11e-3, 18e-3])})
    modes = [family_modes(members, Ends(), 3, open_circuit=o) for o in (False, True)]
    statics = family_statics(members)
    answers = at_rest(members, 3)
    assert np.array_equal(answers.values[:, :6], np.hstack([m.frequencies for m in modes]))
    assert np.array_equal(answers.missing[:, :6], np.hstack([m.bars for m in modes]))
    assert answers.values[:, 6] == pytest.approx(statics.compliance[:, 0, 0].real)
    assert answers.values[:, 7] == pytest.approx(statics.follows[:, 0, 2].real)
    assert answers.values[:, 8] == pytest.approx(statics.held[:, 2, 2].real)
    volt, force = statics.missing[:, 0], statics.missing[:, 1]
    assert pytest.approx(np.array([force**2, force * volt, volt**2])) == answers.missing[:, 6:].T
    others = family.members("torsion", PLAIN, {"bimorph.length": np.array([14e-3])})
    assert at_rest(others, 1).values.shape == (1, 1)


def test_a_division_does_not_depend_on_who_is_named_first():
    """It is that of the longest pieces and the thinnest layers, each from whichever has it."""
    least = {"length": 10e-3, "width": 2e-3, "tab_length": 1e-3, "bare_below": 0.5e-3,
             "bare_above": 0.4e-3, "piezo_thickness": 0.2e-3, "shim_thickness": 0.2e-3,
             "glue_thickness": 10e-6}  # fmt: skip
    base = with_values(PLAIN, {f"bimorph.{name}": value for name, value in least.items()})
    for name, value in least.items():
        other = with_values(base, {f"bimorph.{name}": 1.7 * value})
        found, turned = dividing([base, other], COARSE), dividing([other, base], COARSE)
        alone = [dividing([device], COARSE) for device in (base, other)]
        chosen = alone[0 if name.endswith("_thickness") else 1]
        for ours, same, expected in zip(found.axes, turned.axes, chosen.axes, strict=True):
            assert np.array_equal(ours.breaks, same.breaks), name
            assert np.array_equal(ours.breaks, expected.breaks), name


def test_a_thickness_changes_the_proportions_and_the_bound_is_reached():
    """Layers stretched apart need more shapes; a point that stays the worst is asked more of."""
    ranges = LENGTH | {"bimorph.piezo_thickness": (0.2e-3, 0.3e-3)}
    family = build_family(PLAIN, ranges, COARSE, {"bending_x": 1}, tolerance=1e-4)
    assert family.bound <= 1e-4
    assert family.asked <= 20


def test_a_narrow_range_of_three_keys_needs_fewer_members_than_it_has_corners():
    ranges = {
        "bimorph.length": (14e-3, 16e-3),
        "bimorph.piezo_thickness": (0.24e-3, 0.26e-3),
        "piezo.s11": (16e-12, 17e-12),
    }
    family = build_family(PLAIN, ranges, COARSE, {"bending_x": 1}, tolerance=1e-4)
    assert family.bound <= 1e-4
    assert family.asked <= 8
    corner = {key: ends[1] for key, ends in ranges.items()}
    system, values = direct(PLAIN, ranges, corner)
    members = family.members("bending_x", PLAIN, values)
    found = family_modes(members, Ends(), 1, open_circuit=False)
    exact = natural_modes(system, Ends(), 1)[0].frequency
    assert abs(found.frequencies[0, 0] - exact) <= found.bars[0, 0] + ROUNDING * exact


def test_few_modes_of_a_large_basis_are_those_of_the_whole_problem():
    """Subspace iteration on compliances that fall as those of a rod, the slowest of all classes."""
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.standard_normal((2, 60, 60)))[0]
    exact = 1.0 / np.arange(1, 61) ** 2.0
    matrix = turn @ (exact[:, None] * np.swapaxes(turn, 1, 2))
    values, vectors = softest(np.tile(np.eye(60), (2, 1, 1)), matrix, 5)
    np.testing.assert_allclose(values[:, :5], np.tile(exact[:5], (2, 1)), rtol=1e-12)
    left = matrix @ vectors[:, :, :5] - vectors[:, :, :5] * values[:, None, :5]
    assert np.abs(left).max() < 1e-6


def test_a_constant_of_the_material_and_the_tab_vary_together():
    modes = {"bending_x": 2, "torsion": 1}
    family = build_family(TABBED, TAB_AND_CERAMIC, COARSE, modes, tolerance=1e-3)
    assert family.bound <= 1e-3
    point = {"bimorph.tab_length": 2.4e-3, "piezo.s11": 16e-12}
    system, values = direct(TABBED, TAB_AND_CERAMIC, point)
    for motion, count in modes.items():
        found = family_modes(
            family.members(motion, TABBED, values), Ends(), count, open_circuit=False
        )
        exact = [m.frequency for m in natural_modes(system.related(motion), Ends(), count)]
        assert (np.abs(found.frequencies[0] - exact) <= found.bars[0] + 1e-6 * exact[0]).all()


def test_fewer_shapes_say_the_same_of_what_they_were_taken_from(family):
    """Modes and statics of two members to rounding, with fewer shapes; the bound stays."""
    values = {"bimorph.length": np.array([11e-3, 18e-3])}

    def states(motion, members):
        modes = mode_states(members, Ends(), 1, open_circuit=False)
        return np.concatenate([modes, static_states(members)], 2) if members.ports else modes

    small = compressed(family, PLAIN, values, states, 1e-9)
    for motion in family.motions:
        few, many = (f.members(motion, PLAIN, values) for f in (small, family))
        ours, theirs = (family_modes(m, Ends(), 1, open_circuit=False) for m in (few, many))
        assert ours.frequencies == pytest.approx(theirs.frequencies, rel=1e-9)
        assert ours.bars == pytest.approx(theirs.bars, rel=1e-3, abs=1e-12 * ours.frequencies.max())
        assert ours.shares(few) == pytest.approx(theirs.shares(many), rel=1e-9)
    assert small.motions["bending_x"].size < 0.7 * family.motions["bending_x"].size
    few, many = (family_statics(f.members("bending_x", PLAIN, values)) for f in (small, family))
    for name in ("held", "through", "follows", "compliance"):
        one, other = getattr(few, name), getattr(many, name)
        assert one == pytest.approx(other, rel=1e-8, abs=1e-9 * np.abs(other).max()), name


def test_shapes_of_less_than_the_least_energy_are_left_out():
    """A root of energy is what a shape's part of the columns is measured by; the rest is held."""
    columns = np.diag([1.0, 2e-3, 5e-4, 0.0])[None]
    shapes = compression._shapes(columns, 1e-3)
    assert shapes.shape == (4, 2)
    np.testing.assert_allclose(np.abs(shapes).sum(axis=1), [1.0, 1.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(("keys", "asked"), [(1, 2), (2, 2), (3, 4)])
def test_a_family_begins_near_corners_without_a_common_edge(keys, asked):
    """A share of the half range from the middle; of one key both ends, else every second corner."""
    low, high = np.array([1.0, 10.0, -3.0])[:keys], np.array([2.0, 30.0, 5.0])[:keys]
    ranges = dict(enumerate(zip(low, high, strict=True)))
    points = np.array(FamilyBuilder.beginning(SimpleNamespace(ranges=ranges)))
    corners = (2.0 * points - low - high) / (high - low)
    np.testing.assert_allclose(np.abs(corners), builder._NEAR, rtol=1e-12)
    assert len(np.unique(corners > 0.0, axis=0)) == asked
    edges = [(one != other).sum() for one, other in itertools.combinations(corners > 0.0, 2)]
    assert set(edges) == {1 if keys == 1 else 2}
