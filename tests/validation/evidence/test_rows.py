"""Every row of the cases, run as a test; and what makes a row a row."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.bimorph import bricks as bimorph_bricks
from tactgen.validation.evidence.case import Null, run_check
from tactgen.validation.evidence.cases import bimorph, iron, motion
from tactgen.validation.evidence.mesh_levels import on_level
from tactgen.validation.evidence.verification import GROUPS, ON_SCENES, group_cases, group_rows
from tactgen.validation.models.transient import Phase

CASES = {(group, case.id): case for group in GROUPS for case in group_cases(group)}
ROWS = [row for case in CASES.values() for row in case.rows]
BY_ID = {row.id: row for row in ROWS}
#: Rows that take long and whose like stays: of job J1 the default mesh; another state, current,
#: load or width of a slot; solenoids beside VM168's, loops beside COI's coils, iron around a hollow
#: beside BALL's, a plate on supports beside the clamped and the free one, a sheared patch beside TS
#: and PVDF, bricks at rest beside those that are driven.
_LIKE = (
    "SOL-1", "SOL-2", "FORCE-2", "FORCE-3", "FORCE-D2", "FORCE-D3", "FORCE-D4", "NET-F2", "NET-L2",
    "NAGAOKA-1", "NAGAOKA-3", "NAGAOKA-5", "VM168-1", "LOOPS-1", "LOOPS-2", "SPHEROID-1", "SHELL-1",
    "CARTER-1", "CARTER-3", "CARTER-4", "P13H-1", "P13H-2", "P13H-3", "P13H-4", "P13H-5", "TOR-2",
    "SHEAR-1", "MMSB-9", "MMSB-10", "ACT-F2", "ACT-L2", "MOT-14",
)  # fmt: skip


@pytest.fixture(autouse=True)
def coarsest(request, monkeypatch):
    """Take the coarsest bricks, but for heavy rows: those of job J1 are about a fine mesh."""
    if not request.node.get_closest_marker("heavy"):
        levels = bimorph_bricks.LEVELS
        monkeypatch.setattr(bimorph_bricks, "LEVELS", levels[:1] * len(levels))


@pytest.fixture(scope="module", autouse=True)
def forgotten():
    """What was solved on the coarsest bricks is not for other tests."""
    yield
    bimorph._clamped_steps.cache_clear()


@pytest.mark.parametrize(
    "check",
    [
        pytest.param(
            row, id=row.id, marks=[pytest.mark.heavy] if row.heavy or row.id in _LIKE else []
        )
        for row in ROWS
    ],
)
def test_row(check):
    assert run_check(check).status != "fail"


def test_cases_are_complete():
    """A case says its problem and what solves it; rows have reasons, ids are unique."""
    assert set(_LIKE) < set(BY_ID)
    for group in GROUPS:
        assert len({row.id for row in group_rows(group)}) == len(group_rows(group))
    for case in CASES.values():
        assert all((case.title, case.problem, case.model, case.rows)), case.id
    for row in ROWS:
        assert all((row.requirement, row.source, row.reason)), row.id
        # a tolerance of 0 needs a range, a count has none
        ranged = isinstance(row.reference, tuple) or row.unit in ("folds", "peaks")
        assert row.tolerance > 0.0 or ranged, row.id


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
    row = replace(ROWS[0], reference=reference, tolerance=0.0, measure=lambda: measured)
    outcome = run_check(row)
    assert outcome.deviation == pytest.approx(deviation, rel=1e-12)  # rounding
    assert (outcome.status == "pass") is (deviation == 0.0)


@pytest.mark.parametrize(
    ("reference", "tolerance", "measured", "trivial", "status", "words"),
    [
        (1.0, 0.1, 1.05, 0.5, "pass", "which misses by -50 %"),
        (1.0, 0.1, 1.05, 0.95, "explained", "this row is no evidence"),
        ((1.0, 2.0), 0.0, 1.5, 1.2, "explained", "this row is no evidence"),
        ((1.0, 2.0), 0.0, 1.5, 1.0, "pass", "which is on the limit"),
        ((1.0, 2.0), 0.0, 1.995, 3.0, "pass", "A limit is 0.25 % away"),
        (1.0, 0.1, 1.5, 0.95, "fail", "this row is no evidence"),
    ],
)
def test_what_a_trivial_model_passes_is_no_evidence(
    reference, tolerance, measured, trivial, status, words
):
    """Passing then counts as explained; missing stays missing; a limit nearby is said."""
    row = replace(
        ROWS[0], reference=reference, tolerance=tolerance, measure=lambda: measured, fitted="",
        null=Null("a constant", lambda: trivial), explained="",
    )  # fmt: skip
    outcome = run_check(row)
    assert outcome.status == status
    assert words in outcome.beside


def test_measured_rows_that_pass_have_a_trivial_model():
    """Those against what others measured; published closed forms and misprints have none."""
    for group in ON_SCENES:
        for row in group_rows(group):
            if row.tier == "validation" and not row.explanation:
                assert row.null is not None, row.id


@pytest.mark.parametrize("name", ["ROD", "BEAMO", "AXIO", "MMSE"])
def test_refinements_approach_the_answer(name):
    """The finest level of a refinement has a smaller error than the coarsest."""
    levels, error, _ = CASES["orders", name].refinement
    assert error(levels[-1]) < 0.1 * error(levels[0])


@pytest.mark.parametrize("name", ["CYL2-1", "WEDGE-1", "FV32-1"])
def test_coarser_levels_are_farther_from_the_answer(name):
    """By degree, segments and cells: two levels coarser there is less, and more error by far."""
    row, errors, counts = BY_ID[name], [], []
    for below in (0, 2):
        with on_level(below) as run:
            errors.append(abs(row.measure() / row.reference - 1.0))
        counts.append(run.count)
        assert run.new is (below > 0)
    assert errors[0] < 0.3 * errors[1]
    assert counts[0] > counts[1]


@pytest.fixture
def made_phases(monkeypatch):
    """Put given phases in place of those of any run."""

    def put(*phases):
        phases = tuple(Phase(*phase) for phase in phases)
        monkeypatch.setattr(motion, "phases", lambda run: phases)
        monkeypatch.setattr(motion, "_paper_run", lambda: "run")
        monkeypatch.setattr(motion, "_run_of_fig_16", lambda load, angle=0.0, _=0.0: ("run", angle))

    return put


def test_rise_and_fall_are_from_the_switching_to_the_stop(made_phases):
    """The first phase on the stop after it; what rests there at the start does not count."""
    made_phases(
        ("pressed", 0.0, 1e-4, 0.0), ("falling", 1e-4, 4e-4, 0.0), ("held", 4e-4, 5.1e-3, 0.0),
        ("rising", 5.1e-3, 5.7e-3, 0.0), ("pressed", 5.7e-3, 7e-3, 0.0),
    )  # fmt: skip
    assert motion._fall_time() == pytest.approx(4e-4)
    assert motion._rise_time() == pytest.approx(0.7e-3)


@pytest.mark.parametrize(
    ("rising", "falling", "ratio"), [(3e-6, 8e-6, 4.0), (9e-6, 8e-6, 9.0 / 8.0)]
)
def test_flight_over_contact_takes_the_largest_of_each_kind(made_phases, rising, falling, ratio):
    """Over the smaller of both stops; 1 or more where the rising tip moves more."""
    made_phases(
        ("held", 0.0, 1.0, 1e-6), ("rising", 1.0, 2.0, rising), ("falling", 2.0, 3.0, falling),
        ("falling", 3.0, 4.0, 1e-6), ("pressed", 4.0, 5.0, 5e-6), ("held", 5.0, 6.0, 2e-6),
    )  # fmt: skip
    assert motion._flight_to_contact("finger") == pytest.approx(ratio)


def test_held_over_pressed_is_the_smallest_over_the_largest(made_phases, monkeypatch):
    """Of what both runs have in common, without the rest at the start."""
    sizes = {0.0: 1e9, 1.0: 6.0, 2.0: 2.0, 3.0: 5.0, 4.0: 4.0}
    names = ("pressed", "held", "pressed", "held", "pressed", "rising")
    made_phases(*((name, float(i), i + 0.5, 0.0) for i, name in enumerate(names)))
    monkeypatch.setattr(motion, "common_oscillation", lambda seen, _: sizes[seen[0][1].start] * 1j)
    assert motion._held_to_pressed("finger") == pytest.approx(5.0 / 4.0)


def test_a_stretched_ball_has_the_factor_of_its_shape():
    """A third where it is not stretched; Osborn's on a mesh that errs by percents."""
    assert iron._factor(1.0, 2) == pytest.approx(1.0 / 3.0, rel=0.02)
    assert iron._factor(2.0, 2) == pytest.approx(0.173564, rel=0.05)


def test_two_models_of_a_job_are_apart_by_so_many_of_both_bars(monkeypatch):
    """The largest of all quantities and modes counts."""

    class Found:
        def get(self, name, model):
            scale = 1.0 if name == "coupling_factor" else 0.1
            value, bar = ([10.0, 20.0], 0.3) if model == "solid" else ([10.3, 19.0], 0.1)
            return bimorph.Estimate(scale * np.array(value), np.full(2, bar))

    monkeypatch.setattr(bimorph, "_solved", lambda *_: Found())
    assert bimorph.j1_cad_against_bricks() == pytest.approx(1.0 / 0.4)
