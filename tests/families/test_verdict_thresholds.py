"""Verdicts at their thresholds, for any numbers: what the bars or a tolerance reach, no more."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactgen.validation.engine.comparison import compare
from tactgen.validation.evidence.case import Check, judged
from tactgen.validation.evidence.judgement import Judged
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.whatif.compare import Number, _beyond

VALUES = st.floats(1e-12, 1e12) | st.floats(-1e12, -1e-12)
SHARES = st.floats(0.0, 0.5)
#: How far from a threshold, relative to the bars: rounding decides nothing.
ASIDE = st.floats(1e-6, 1.0)
SCENE = load_scene("paper")[0]


def cell(value, bar, reference, reference_bar):
    """Return what is said of a value of tmm beside a reference of solid."""
    found = [
        Quantity(name="static_tip_displacement", model=m, unit="m", value=np.asarray(v),
                 error=np.asarray(b))
        for m, v, b in (("tmm", value, bar), ("solid", reference, reference_bar))
    ]  # fmt: skip
    (row,) = compare(SCENE, found, "bimorph")
    return row.cells[0].verdict


@given(reference=VALUES, bar=SHARES, other=SHARES, aside=ASIDE, up=st.booleans())
def test_models_agree_as_far_as_both_bars_reach(reference, bar, other, aside, up):
    """Just inside they agree, just outside they do not, whichever of the two has the bar."""
    size, sign = abs(reference), 1.0 if up else -1.0
    reach = (bar + other) * size
    near = reference + sign * reach * (1.0 - aside)
    # beyond rounding of the values, which counts as covered
    far = reference + sign * (reach * (1.0 + aside) + 1e-6 * size)
    for first, second in ((bar, other), (other, bar)):
        assert cell(near, first * size, reference, second * size) == "agrees"
        assert cell(far, first * size, reference, second * size) != "agrees"


@given(first=VALUES, bar=SHARES, other=SHARES, aside=ASIDE)
def test_two_studies_differ_where_the_bars_do_not_reach(first, bar, other, aside):
    """The same threshold, either way round; a bar that nobody knows counts as none."""
    size = abs(first)
    here = Number(complex(first), bar * size, "m")
    for factor, beyond in ((1.0 - aside, False), (1.0 + aside, True)):
        apart = (bar + other) * size * factor + (1e-6 * size if beyond else 0.0)
        there = Number(complex(first + apart), other * size, "m")
        assert _beyond(here, there) == _beyond(there, here) == beyond
    bare = Number(complex(first), math.nan, "m")
    assert _beyond(bare, Number(complex(first * 1.1), math.nan, "m"))
    assert not _beyond(bare, bare)
    assert _beyond(bare, Number(complex(math.nan), 0.0, "m"))


def row(reference, tolerance, **more):
    return Check("It is so.", reference, "m", float, tolerance, **more)


@given(reference=VALUES, tolerance=st.floats(1e-9, 0.5), aside=ASIDE, up=st.booleans())
def test_a_check_passes_up_to_its_tolerance(reference, tolerance, aside, up):
    """Just inside, not just outside; of a range the nearer end counts, and inside all is well."""
    sign = 1.0 if up else -1.0
    # of the relative deviation twelve digits are right where the tolerance is 1e-3 and more
    near, far = (
        reference * (1.0 + sign * (tolerance * share + rounding))
        for share, rounding in ((1.0 - aside, 0.0), (1.0 + aside, 1e-12))
    )
    assert judged(row(reference, tolerance), near).status == "pass"
    assert judged(row(reference, tolerance), far).status == "fail"
    assert judged(row(reference, tolerance, fitted="chosen so"), near).status == "explained"
    ends = tuple(sorted((reference, reference * (1.0 - sign * 0.5))))
    assert judged(row(ends, tolerance), near).status == "pass"
    assert judged(row(ends, tolerance), far).status == "fail"
    assert judged(row(ends, tolerance), sum(ends) / 2.0).deviation == 0.0


@given(known=st.floats(0.01, 0.5), moved=st.floats(0.0, 1.0), up=st.booleans())
def test_an_explanation_holds_for_the_deviation_it_was_written_for(known, moved, up):
    """Two hundredths, or a fifth of it where that is less; then the row fails again."""
    may = min(0.02, 0.2 * known)
    check = row(1.0, 1e-3, explained="the paper rounds", known=known)
    sign = 1.0 if up else -1.0
    inside = judged(check, 1.0 + known + sign * may * moved * 0.999)
    assert inside.status == "explained"
    outside = judged(check, 1.0 + known + sign * may * (1.001 + moved))
    assert outside.status == "fail"
    assert judged(check, math.nan).status == "fail"
    assert judged(replace(check, explained=""), 1.0 + known).status == "fail"


@pytest.mark.parametrize(("error", "bar", "within"), [(1.0, 1.0, True), (1.0, 0.999, False)])
def test_an_error_as_large_as_its_bar_is_within(error, bar, within):
    """The bar is a promise up to and with itself."""
    assert Judged("", "a", error, bar).within is within
