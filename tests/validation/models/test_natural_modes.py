"""Classes of motion side by side, or one after another where that would take too much memory."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.piezo.modal_model import BareMode
from tactgen.validation.models.bimorph import natural_modes as lowest_modes
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.bimorph.natural_modes import (
    LEAST_GAIN,
    MOST_GAIN_OF_MODES,
    estimated_gains,
    gain_factor,
)
from tactgen.validation.models.model import SAFETY, Modes
from tactgen.validation.scene.load import load_scene


def test_where_others_are_lower_more_modes_are_asked_until_one_bends_in_x():
    """A narrow bimorph bends in y first; the finer mesh is asked for as many."""
    asked = []

    def lowest(ends, count, *, open_circuit):
        asked.append(count)
        kinds = ["bending_y"] * 8 + ["bending_x"] * 9
        modes = [SimpleNamespace(kind=k, frequency=100.0 + n) for n, k in enumerate(kinds)]
        found = {kind: [m for m in modes[:count] if m.kind == kind] for kind in set(kinds)}
        return {kind: modes for kind, modes in found.items() if modes}

    mesh = SimpleNamespace(lowest=lowest)
    fine, coarse = lowest_modes.lowest_modes(mesh, mesh, None, 1, open_circuit=False)
    assert asked == [1, 4, 10, 10]
    assert [m.kind for m in fine] == ["bending_y"] * 8 + ["bending_x"]
    assert len(coarse) >= len(fine)


def test_matched_modes_are_of_one_class_and_none_is_taken_twice():
    fine = Modes(np.array([100.0, 110.0, 120.0]), ("bending_x", "torsion", "bending_x"))
    coarse = Modes(np.array([113.0, 104.0]), ("bending_x", "torsion"))
    found = lowest_modes.matched(fine, coarse)
    assert found.classes == fine.classes
    np.testing.assert_array_equal(found.frequencies, [113.0, 104.0, np.nan])


@pytest.mark.parametrize(("level", "index"), [(1, 1), (5, 4)])
def test_a_level_is_never_the_coarsest_which_judges_it(level, index):
    assert solid.level_for(load_scene("prototype", [f"mesh.level={level}"])[0]) == index


def test_like_is_held_against_like():
    """Classes interleave differently on both meshes; what has no estimate has no gain."""
    fine = [
        BareMode(100.0, "bending_x", "bending_x"),
        BareMode(200.0, "torsion", "torsion", 1e-3),
        BareMode(250.0, "bending_y", "bending_y", 2e-4),
        BareMode(300.0, "torsion", "torsion", 4e-3),
        BareMode(400.0, "axial", "axial", 1e-3),
    ]
    coarse = [
        BareMode(101.0, "bending_x", "bending_x"),
        BareMode(251.0, "bending_y", "bending_y", 6e-4),
        BareMode(270.0, "torsion", "torsion", 2e-3),
        BareMode(330.0, "torsion", "torsion", 2e-2),
    ]
    found = estimated_gains(fine, coarse)
    assert found[1:4] == pytest.approx([2.0, 3.0, 5.0], rel=1e-12)
    assert np.isnan(found[[0, 4]]).all()  # no estimate, no partner
    # of a true gain g the finer mesh's error is the difference over g - 1, up to what is trusted
    assert gain_factor(2.0, MOST_GAIN_OF_MODES) == pytest.approx(SAFETY)
    assert gain_factor(1e3, 5.0) == pytest.approx(SAFETY / 4.0)
    assert gain_factor(0.5, 5.0) == pytest.approx(SAFETY / LEAST_GAIN)
