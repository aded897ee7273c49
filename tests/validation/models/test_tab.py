"""What holds the bimorph: the tab's compliance from solids, against beams and limits."""

import numpy as np
import pytest

from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.sections import Joint
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.models.bimorph.rod_joint import (
    joint_by_beam,
    support_compliance,
    tab_by_beam,
    tab_by_bricks,
)
from tactgen.validation.models.difference import (
    FIRST_FREQUENCY,
    beam_row,
    beam_values,
    clamped,
    row_values,
)
from tactgen.validation.scene.load import load_scene


def scene(*overrides):
    return load_scene("paper", ["load.kind=none", "support.kind=clamped", *overrides])[0]


def static(row) -> Multiport:
    return transfer_matrix.chain(row, np.zeros(1))


def test_tab_of_a_beam_is_got_back():
    """From the ports of two beams, one on a tab, comes the tab's own compliance."""
    plain, on_tab = scene(), scene("bimorph.tab_length=1.6 mm")
    found = support_compliance(static(beam_row(on_tab)), static(beam_row(plain)), 20e-3)
    np.testing.assert_allclose(found.matrix, tab_by_beam(plain, 1.6e-3).matrix, rtol=1e-8)
    assert found.matrix[0, 1] == pytest.approx(found.matrix[1, 0], rel=1e-8)


@pytest.fixture(scope="module")
def tabs():
    lengths = (0.0, 0.8e-3, 1.6e-3, 2.4e-3)
    return lengths, tab_by_bricks(scene(), lengths, lambda _: None, level=0)


def test_solid_tab_grows_as_a_beam(tabs):
    """Per added length the solid's tab turns as EI says, but for Poisson's effect; its root adds.

    The shim's ν stiffens a strip towards a plate by at most ν² E_y/E = 0.8 %.
    """
    lengths, found = tabs
    rotations = np.array([tab.matrix[1, 1] for tab in found])
    slope = (rotations[3] - rotations[1]) / (lengths[3] - lengths[1])
    beam = tab_by_beam(scene(), 1e-3).matrix[1, 1] / 1e-3
    assert 0.99 * beam < slope < 1.001 * beam
    root = rotations[1] - slope * lengths[1]
    assert 0.05 * rotations[2] < root < 0.25 * rotations[2]


def test_solid_compliance_is_one(tabs):
    """Symmetric and positive definite: the difference of two solids is a passive support."""
    for tab in tabs[1]:
        m = tab.matrix
        assert m[0, 1] == pytest.approx(m[1, 0], rel=1e-6)
        assert np.linalg.eigvalsh(m / np.sqrt(np.outer(np.diag(m), np.diag(m))))[0] > 0.0


def frequency_on(scene, compliance):
    """Return the first frequency (Hz) of the scene's beam on a support without mass."""
    alone = clamped(scene)
    return row_values(alone, [(Joint(compliance), 0.0), *beam_row(alone)])[FIRST_FREQUENCY]


def test_beam_on_a_support_is_the_whole():
    """A beam on the compliance of a tab vibrates as the beam with that tab, its mass apart."""
    plain, on_tab = scene(), scene("bimorph.tab_length=1.6 mm")
    whole = beam_values(on_tab)[FIRST_FREQUENCY]
    # the tab's mass is 0.8 mg of 190 mg, near the node at the root
    assert frequency_on(plain, tab_by_beam(plain, 1.6e-3).matrix) == pytest.approx(whole, rel=1e-4)


def test_softer_glue_turns_more():
    """The joint's rotation falls with the glue's modulus; a stiff rod hardly gives way."""
    turned = [joint_by_beam(scene(), e).matrix[1, 1] for e in (1e9, 3e9, 1e10)]
    assert turned[0] > turned[1] > turned[2]
    rigid_rod = joint_by_beam(scene("rod.youngs_modulus=1e4 GPa"), 3e9)
    assert 0.0 < turned[1] - rigid_rod.matrix[1, 1] < 0.2 * turned[1]
