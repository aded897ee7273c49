"""The stress run of the solid: each family holds its bounds, or says why it has no answer."""

from functools import cache

import pytest

from tactgen.validation.checks.stress import solid, solid_answers, solid_exact

EXACT = (
    solid_exact.scaling_row,
    solid_exact.uniform_section_row,
    solid_exact.slender_row,
    solid_exact.one_element_row,
    solid_exact.distorted_row,
    # by default reduction is tried at peaks and dips (tests/fem/bimorph/reduction/test_krylov.py)
    pytest.param(solid_answers.resonance_row, marks=pytest.mark.heavy),
)


@cache
def quick(family):
    return family(True)


@pytest.mark.parametrize("family", EXACT, ids=lambda f: f.__name__)
def test_exact_families_hold(family, approved_line):
    """Scaling laws, patch tests and the slender limit, far beyond the device."""
    row = quick(family)
    assert row.verdict in ("holds", "holds or says why not"), (row.worst, row.refusals)
    assert row.points > 0
    approved_line(f"{row.family} | {row.what} | {row.points} | {row.verdict} | {row.refusals}")


def test_too_slender_is_refused_and_not_wrong():
    """At L/h = 1e4 rounding hides the stiffness of bending: a sentence, no number."""
    row = quick(solid_exact.slender_row)
    assert len(row.refusals) == 1
    assert "L/h 100" in row.worst.where


@pytest.mark.heavy
def test_full_run():
    """No family of the full run fails."""
    found = solid.run(False, lambda _: None)
    assert [row.family for row in found.rows if row.verdict == "fails"] == []
