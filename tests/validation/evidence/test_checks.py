"""The declarative rows that the report shows, run as tests."""

import math
from dataclasses import replace

import pytest

from tactgen.geometry.bimorph import bricks as bimorph_bricks
from tactgen.validation.evidence.case import run_check
from tactgen.validation.evidence.cases import actuator as square_law
from tactgen.validation.evidence.cases import bimorph as bimorph_measurements
from tactgen.validation.evidence.cases import coils as coaxial_coils
from tactgen.validation.evidence.cases.amplitude import CASES as AMPLITUDE_CHECKS
from tactgen.validation.evidence.cases.bimorph import CASES as CHECKS
from tactgen.validation.evidence.cases.display import CASES as DISPLAY_CHECKS
from tactgen.validation.evidence.cases.motion import CASES as MOTION_CHECKS
from tactgen.validation.evidence.cases.reluctance import CASES as MAGNETIC_CHECKS

ALL = (*CHECKS, *MAGNETIC_CHECKS, *AMPLITUDE_CHECKS, *MOTION_CHECKS, *DISPLAY_CHECKS)


#: Rows that cost seconds and whose like is asked elsewhere: of job J1's default mesh on level 2
#: (tests/validation/engine/test_refinement.py), of the force and its
#: derivative in another state.
_ELSEWHERE = ("SOL-1", "SOL-2", "FORCE-2", "FORCE-3", "FORCE-D2", "FORCE-D3", "FORCE-D4")


@pytest.fixture(scope="module", autouse=True)
def coarsest():
    """Take the coarsest bricks for what bridges from a beam to the solid."""
    with pytest.MonkeyPatch.context() as patch:
        levels = bimorph_bricks.LEVELS
        patch.setattr(bimorph_bricks, "LEVELS", levels[:1] * len(levels))
        yield
    bimorph_measurements._clamped_steps.cache_clear()


def test_ids_are_unique_and_rows_complete():
    """A row that lacks a source or a reason for its tolerance is no check."""
    assert len({c.id for c in ALL}) == len(ALL)
    assert set(_ELSEWHERE) < {c.id for c in ALL}
    assert all(c.source and c.reason and c.requirement.endswith(".") for c in ALL)


def test_explained_rows_can_fail():
    """An explanation covers one known deviation: any other, or none, or nan, is a failure."""
    for check in ALL:
        if check.explained:
            end = check.reference
            if isinstance(end, tuple):
                end = end[0] if check.known < 0.0 else end[1]
            assert abs(check.known) > check.tolerance
            for factor in (1.0 + check.known + math.copysign(0.1, check.known), math.nan):
                moved = replace(check, measure=lambda value=factor * end: value)
                assert run_check(moved).status == "fail"


@pytest.mark.parametrize(
    ("measured", "reference", "deviation"),
    [
        (1.1, 1.0, 0.1),
        (1.5, (1.0, 2.0), 0.0),
        (2.2, (1.0, 2.0), 0.1),
        (0.0, (0.0, 2.0), 0.0),
        (-0.5, (0.0, 2.0), -0.25),  # below 0: relative to the range's other end
        (0.5, (-2.0, 0.0), 0.25),
        (0.0, 0.0, 0.0),
        (1e-9, 0.0, math.inf),
    ],
)
def test_deviation_is_relative_to_the_nearer_end_that_is_not_zero(measured, reference, deviation):
    """A range from 0 has a deviation on both sides; nothing is relative to 0 itself."""
    row = replace(CHECKS[0], reference=reference, tolerance=0.0, measure=lambda: measured)
    outcome = run_check(row)
    assert outcome.deviation == pytest.approx(deviation, rel=1e-12)  # rounding
    assert (outcome.status == "pass") is (deviation == 0.0)


def test_rows_tell_whose_report_shows_them():
    """Those about a built-in scene are in its report, the others in none."""
    assert {c.scene for c in CHECKS} == {"", "paper", "prototype", "j1"}
    assert {c.scene for c in MAGNETIC_CHECKS} == {"", "reluctance"}


def test_references_of_the_coils_are_maxwells():
    """The rows' references are the elliptic integrals with more Gauss points than it takes."""
    by_id = {c.id: c.reference for c in MAGNETIC_CHECKS}
    windings = coaxial_coils.LOW, coaxial_coils.HIGH
    mutual, slope = (
        coaxial_coils.between_windings(*windings, function, points=16)
        for function in (coaxial_coils.mutual_inductance, coaxial_coils.mutual_inductance_slope)
    )
    one, other = coaxial_coils.CURRENTS
    assert by_id["COI-1"] == pytest.approx(mutual, rel=1e-12)
    assert by_id["COI-2"] == by_id["COI-3"] == pytest.approx(one * other * slope, rel=1e-12)
    assert by_id["VM213-1"] == pytest.approx(square_law.COENERGY, rel=1e-15)
    assert by_id["VM213-2"] == pytest.approx(square_law.ENERGY, rel=1e-15)


def test_known_deviations_of_a_quotient_and_of_what_it_divides_agree():
    """ROCK-9 divides ROCK-7 by ROCK-8: so do the models' values that the rows state."""
    rows = {c.id: c for c in AMPLITUDE_CHECKS}
    held, up, quotient = (
        rows[name].reference * (1.0 + rows[name].known) for name in ("ROCK-7", "ROCK-8", "ROCK-9")
    )
    assert held / up == pytest.approx(quotient, rel=2e-4)  # four digits of each deviation
