"""Elements of a row of beams against scikit-fem's, whose bubbles have other lengths."""

import numpy as np
import pytest
from scipy.linalg import eigvalsh
from skfem import Basis, BilinearForm, ElementLinePp, MeshLine, asm

from tactgen.fem.beam.row_elements import ORDER, RowElements

HEIGHTS = np.array([0.0, 0.7, 1.1, 2.0])
ROW = RowElements(HEIGHTS, np.array([[0, 1], [1, 2], [2, 3]]))


@BilinearForm
def elastic(w, psi, v, phi, at):
    shear = (w.grad[0] + psi) * (v.grad[0] + phi)
    return (2.0 - at.x[0] / 3.0) * psi.grad[0] * phi.grad[0] + (5.0 + at.x[0]) * shear


@BilinearForm
def inertial(w, psi, v, phi, at):
    return (1.0 + at.x[0]) * w * v + 0.1 * psi * phi


def test_a_tapered_row_vibrates_as_by_scikit_fem():
    """All its natural frequencies, the rigid motions with them, to rounding."""
    z = ROW.places
    found = eigvalsh(ROW.elastic(2.0 - z / 3.0, 5.0 + z), ROW.inertial(1.0 + z, np.array(0.1)))
    space = Basis(MeshLine(HEIGHTS[None]), ElementLinePp(ORDER), intorder=2 * ORDER)
    exact = eigvalsh(*(asm(form, space * space).toarray() for form in (elastic, inertial)))
    assert found.size == exact.size == 2 * ROW.functions == 32
    np.testing.assert_allclose(found, exact, rtol=1e-12, atol=1e-13 * exact[-1])


def test_moments_act_where_they_change():
    """A uniform one at both ends; of one that grows as the height, its mean on each element."""
    uniform, growing = ROW.bent(np.ones_like(ROW.places)), ROW.bent(ROW.places)
    hats = ROW.functions + np.arange(4)
    assert uniform[hats] == pytest.approx([-1.0, 0.0, 0.0, 1.0], abs=1e-15)
    means = HEIGHTS[:-1] + 0.5 * np.diff(HEIGHTS)
    assert growing[hats] == pytest.approx(-np.diff(means, prepend=0.0, append=0.0), rel=1e-14)
    assert not uniform[: ROW.functions].any()
    assert ROW.measure.sum() == pytest.approx(2.0, rel=1e-15)
