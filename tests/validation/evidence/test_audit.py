"""The audit of the printed formulas: every one convicted or acquitted by its number."""

import numpy as np
import pytest

from tactgen.tmm.beam.printed_formulas import FORMULAS, MISPRINTS
from tactgen.validation.evidence.cases.audit import AT, audit
from tactgen.validation.scene.load import load_scene


@pytest.fixture(scope="module")
def paper():
    return audit(load_scene("paper")[0])


def test_every_formula_has_its_row(paper):
    """Eqs 6 to 55 in order; no number for matrices of other formulas and two without a value."""
    assert [row.formula for row in paper.rows] == list(FORMULAS)
    assert [r.formula.equation for r in paper.rows if r.deviation is None] == [6, 9, 10, 12]


def test_right_formulas_leave_rounding(paper):
    """Every formula that stands as printed equals the 80-digit value.

    Doubles leave 1e-15; C3, and C5 − 1 in A35 and A52, are differences that cancel by
    β⁴/100 and β⁴/1000 at 10 Hz, which costs two and four digits.
    """
    for row in paper.rows:
        if row.formula.correct or row.deviation is None:
            continue
        tolerance = 1e-11 if row.formula.equation in (22, 35) else 1e-13
        assert row.deviation < tolerance, row.formula
        assert row.velocity is None


def test_wrong_formulas_are_off(paper):
    """Every formula that has a correction is off by far more than rounding."""
    for equation in MISPRINTS:
        assert paper.row(equation).deviation > 1e-4, equation
    # twice tan δ of ε^T in C_p, times ε^T/(ε^T − d31²/s11) = 1.21; a sign; 1 − C3(0)
    assert paper.row(55).deviation == pytest.approx(2 * 0.03 * 1.213, rel=2e-3)
    assert paper.row(36).deviation == pytest.approx(2.0, rel=1e-12)
    assert paper.row(24).deviation == pytest.approx(5 / 6, rel=1e-5)


def test_effects_on_what_a_reader_cares_about(paper):
    """Sizes at 10, 100 and 1000 Hz, to the digits in which they are quoted."""
    assert AT[[0, 1, 3]].tolist() == [10.0, 100.0, 1000.0]
    sign = paper.row(36).velocity[[0, 1, 3]]
    np.testing.assert_allclose(sign, [0.0011, 0.11, 54.0], rtol=0.03)
    factor = paper.row(24).velocity[[0, 1, 3]]
    np.testing.assert_allclose(factor, [0.0124, 0.0476, 3.45], rtol=0.005)
    # exchanged denominators: that of σ leaves nothing, that of τ hardly matters
    assert paper.row(39).velocity.min() > 0.99
    assert paper.row(41).velocity.max() < 1e-3
    assert paper.row(47).velocity.max() == pytest.approx(0.0337, abs=2e-4)
    assert paper.row(49).velocity.max() < 1e-3
    # a capacitor that gives off power: the current only; the rest is the processor's rounding
    assert paper.row(55).velocity.max() < 1e-13
    assert 0.06 < paper.row(55).current.min() < paper.row(55).current.max() < 0.065
    assert paper.velocity.min() > 0.9


def test_corrected_chain_is_exact(paper):
    """Eqs 6 to 12 with everything corrected give the 80-digit motion and current.

    The chain cancels by four digits at 10 Hz.
    """
    assert paper.residual < 1e-11


def test_other_lengths_and_ceramics():
    """The verdicts do not hang on the paper's numbers."""
    other = audit(load_scene("j1", ["piezo.material=PZT-5A", "bimorph.length=30mm"])[0])
    for row in other.rows:
        if row.deviation is not None:
            # rounding grows by 1/λ⁴ or shrinks with length; wrong ones are off by 1e-4 or more
            assert (row.deviation < 1e-10) != bool(row.formula.correct), row.formula
    assert other.row(24).velocity.max() > 0.01
