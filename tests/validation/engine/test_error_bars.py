"""Error bars from refinement: coverage where the answer is known, or much better known."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactgen.geometry.bimorph.bricks import BrickMeshing
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.coverage_bimorph import AT, affordable_case, judged
from tactgen.validation.evidence.judgement import PROMISED, median_width
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.bimorph.solid import _BRICK_BARS, level_for
from tactgen.validation.scene.load import load_scene

#: The paper's layers clamped, 10 mm long, by level 5, converged to a twentieth of the bars below.
CLAMPED = {
    "static_tip_displacement": 2.372073e-7,
    "capacitance_free": 7.916739e-9,
    "capacitance_blocked": 6.711322e-9,
    "short_circuit_frequencies": 4219.0893,
    "coupling_factor": 0.3074319,
    "tip_displacement": [2.559709e-7 - 1.269892e-9j, 4.539989e-7 - 9.257954e-9j],
    "admittance": [2.122065e-6 + 6.020067e-5j, 5.653886e-6 + 1.637462e-4j],
}


@pytest.mark.usefixtures("own_store")
def test_bars_of_every_kind_are_the_size_of_the_error(monkeypatch, few_bricks):
    """On bricks too few to promise more: a third of a bar nor three times as much would pass.

    Responses are asked at 0.28 and 0.71 times the first resonance.
    """
    bricks = BrickMeshing(
        (3, 3, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0), richness=2.0
    )
    monkeypatch.setattr(solid, "LEVELS", (few_bricks[0], bricks))
    settings = ["support.kind=clamped", "load.kind=none", "bimorph.length=10mm", "modes=1"]
    scene, _ = load_scene("prototype", [*settings, "frequency=1200,3000", "mesh.level=2"])
    for found in solve(scene, ("solid",), tuple(CLAMPED)).quantities:
        error = np.abs(found.value - np.array(CLAMPED[found.name]))
        assert (0.8 * error < found.error).all(), found.name
        assert (found.error < 2.0 * error).all(), found.name


NAMES = ("static_tip_displacement", "capacitance_free", "short_circuit_frequencies")


@cache
def solved(scene_name, level):
    """Deflection, capacitance and frequencies of a scene at a mesh level."""
    scene, _ = load_scene(scene_name, [f"mesh.level={level}"])
    return solve(scene, ("solid",), NAMES).quantities


def against_consensus(level):
    """Quantities of job J1 at a mesh level, with the four-code consensus."""
    static, _, frequencies = solved("j1", level)
    yield static.value, static.error, -6.7582e-7, 1e-5
    reference = (1065.96, 3329.10, 6642.85, 16267.0)
    for value, bar, known in zip(frequencies.value, frequencies.error, reference, strict=True):
        yield value, bar, known, 3e-5


@pytest.mark.parametrize(
    "level", [2, *(pytest.param(n, marks=pytest.mark.heavy) for n in (3, 4, 5))]
)
def test_error_bars_cover_the_known_answer(level):
    """On job J1 the true error lies inside the bar (plus the reference's own uncertainty),
    and the bar is not more than 20 times the error."""
    ratios = []
    for value, bar, known, own in against_consensus(level):
        error = abs(value - known)
        assert error <= bar + own * abs(known)
        ratios.append(bar / max(error, own * abs(known)))
    assert sorted(ratios)[len(ratios) // 2] < 20.0


@pytest.mark.parametrize(
    ("scene_name", "level"),
    [
        ("j1", 2),
        *(pytest.param("j1", level, marks=pytest.mark.heavy) for level in (3, 4, 5)),
        *(pytest.param("paper", level, marks=pytest.mark.heavy) for level in (2, 3, 4, 5)),
    ],
)
def test_each_level_has_the_bars_it_is_chosen_by(scene_name, level):
    """Static deflection, capacitance and the first frequency of the two scenes."""
    for q in solved(scene_name, level):
        relative = q.error / abs(q.value)
        first = relative if q.value.ndim == 0 else relative[0]
        assert first <= _BRICK_BARS[level - 1]


@pytest.mark.parametrize(
    ("scene_name", "accuracy"),
    [
        ("j1", _BRICK_BARS[1]),
        *(pytest.param(name, 1e-3, marks=pytest.mark.heavy) for name in ("j1", "paper")),
    ],
)
def test_wanted_accuracy_is_reached(scene_name, accuracy):
    """The mesh chosen for an accuracy, such as the default of 1e-3, has bars within it."""
    scene, _ = load_scene(scene_name, [f"accuracy={accuracy}"])
    for q in solved(scene_name, level_for(scene) + 1):
        relative = q.error / abs(q.value)
        first = relative if q.value.ndim == 0 else relative[0]
        assert first <= scene.accuracy


def varied_cases(seed, count):
    """Random bimorphs; the first that is small enough comes at level 3 as well."""
    rng, cases, finer = np.random.default_rng(seed), [], []
    while len(cases) < count:
        number = len(cases)
        case = replace(
            affordable_case(rng), all_motions=number % 3 == 0, at=AT if number % 4 == 3 else ()
        )
        cases.append(case)
        again = replace(case, level=3, all_motions=False, at=())
        if not finer and again.affordable:
            finer.append(again)
            cases.append(again)
    return cases[:count]


@pytest.mark.heavy
def test_error_bars_cover_nearly_all_varied_bimorphs():
    """36 cases: at least 95 % of the errors inside, half the bars at most five times the error.

    The errors of one device are small or large together: over a dozen the median bar scatters
    from 2 to 7 errors.  The factors were chosen on other devices, and `tactgen coverage` takes
    more.
    """
    cases = [case for seed in (11, 12, 13) for case in varied_cases(seed, 12)]
    assert {case.level for case in cases} == {2, 3}
    outcomes = [one for case in cases for one in judged(case)]
    assert np.mean([one.within for one in outcomes]) >= PROMISED
    assert median_width(outcomes) < 5.0
