"""Values of a family of the solid against single answers, and what the family refuses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.bimorph.reduction.parametric.answers import family_modes
from tactgen.fem.bimorph.reduction.parametric.expansion import with_values
from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.piezo.modes import natural_modes
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.bimorph.stretching import LEVELS, dividing, stretched
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence import coverage_bimorph as coverage
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.bimorph.family import answers, solid_family, surplus
from tactgen.validation.models.bimorph.family.many import _points, for_many
from tactgen.validation.models.bimorph.family.values import family_values
from tactgen.validation.scene.scene import load_scene

QUANTITIES = (
    "short_circuit_frequencies", "open_circuit_frequencies", "coupling_factor",
    "static_tip_displacement", "capacitance_free", "capacitance_blocked",
)  # fmt: skip
AT_REST, MODES = QUANTITIES[3:], QUANTITIES[:1]
RANGE = {"bimorph.length": (12e-3, 16e-3)}
SCENE = ("support.kind=spring", "accuracy=0.1", "modes=2")
QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)
FINER = BrickMeshing((4, 4, 4), smallest=0.2, tip=0.5, pieces=(4.0, 6.0), richness=1.25)


@pytest.fixture(scope="module", autouse=True)
def quick_levels():
    with pytest.MonkeyPatch.context() as patch:
        for module in (solid, solid_family):
            patch.setattr(module, "LEVELS", QUICK)
        yield


@pytest.fixture(scope="module")
def family():
    return solid_family.solid_family(scene(), RANGE, QUANTITIES)


def scene(*more):
    return load_scene("prototype", [*SCENE, *more])[0]


def compare(names, point, family):
    """Return the distances of family and single answer in units of both bars together."""
    found = family_values(scene(), family, {k: np.array([v]) for k, v in point.items()}, names)
    single = solve(
        scene(*(f"{key}={1e3 * value} mm" for key, value in point.items())), ["solid"], names
    )
    apart = {}
    for name in names:
        quantity = single.get(name, "solid")
        assert found[name].value[0].shape == np.shape(quantity.value)
        bars = found[name].error[0] + quantity.error
        apart[name] = float(np.max(np.abs(found[name].value[0] - quantity.value) / bars))
        if quantity.classes:
            assert tuple(found[name].classes[0]) == quantity.classes
    return apart


def test_values_agree_with_single_answers(family):
    """Both divide the bimorph differently, so they agree within the bars of both."""
    apart = compare(QUANTITIES, {"bimorph.length": 14.7e-3}, family)
    assert max(apart.values()) <= 1.0, apart


def test_bars_are_those_of_single_answers_of_the_same_bricks(family):
    """At a point between those that were judged, as if it had been judged.

    To a tenth: what divides a single bimorph is not quite what divides a range.
    """
    at = {"bimorph.length": np.array([13.1e-3])}
    own = scene("bimorph.length=13.1 mm")
    single = surplus.family_surplus(own.device, {}, QUICK[1], family.counts(2))
    exact = replace(family, surplus=single)
    found, right = (family_values(scene(), each, at, QUANTITIES) for each in (family, exact))
    for name in QUANTITIES:
        judged, known = (of[name].error - of[name].basis for of in (found, right))
        assert judged == pytest.approx(known, rel=0.1), name


def test_bars_are_a_few_errors_wide(family, monkeypatch):
    """All errors of five quantities are covered; bars three times as wide, or narrow, are seen."""
    monkeypatch.setattr(coverage.Case, "reference", FINER)
    case = coverage.Case((*SCENE, "bimorph.length=14.7 mm"))
    found = family_values(scene(), family, {"bimorph.length": np.array([14.7e-3])}, QUANTITIES)
    known, widths = coverage.reference(case, ()), []
    for name in (*QUANTITIES[:1], *QUANTITIES[2:]):
        kind = "bending_x" if name == QUANTITIES[0] else ""
        value, bar = (np.ravel(of)[0] for of in (found[name].value, found[name].error))
        widths.append(bar / abs(value - known[name, kind][0]))
    assert min(widths) > 1.0
    assert np.median(widths) < 7.0


def test_responses_agree_with_single_answers_below_and_at_resonance():
    """Losses included; at the resonance what the basis misses is magnified, and its bar with it."""
    sets = ["frequency=100,780"]
    names = ("tip_displacement", "input_current")
    own = scene(*sets)
    family = solid_family.solid_family(own, {"bimorph.length": (13e-3, 15e-3)}, names)
    assert set(family.fine.motions) == {"bending_x"}
    found = family_values(own, family, {"bimorph.length": np.array([14e-3])}, names)
    single = solve(scene(*sets), ["solid"], names)
    for name in names:
        quantity = single.get(name, "solid")
        assert found[name].value.shape == (1, 2)
        apart = np.abs(found[name].value[0] - quantity.value)
        assert (apart <= found[name].error[0] + quantity.error).all(), name
        assert (found[name].basis[0] <= 0.02 * np.abs(quantity.value)).all(), name


def test_a_frequency_beyond_the_basis_is_refused():
    own = scene("frequency=1e6")
    family = solid_family.solid_family(own, {"bimorph.length": (13e-3, 15e-3)}, ["tip_velocity"])
    with pytest.raises(InputError, match=r"1e\+06 Hz is beyond the 4 modes"):
        family_values(own, family, {"bimorph.length": np.array([14e-3])}, ["tip_velocity"])


@pytest.fixture(scope="module")
def few(family):
    """Return for one support and load a scene, and the shapes that some quantities need there."""
    own = scene("load.kind=spring_damper", "load.stiffness=200 N/m")
    return own, {asked: for_many(own, family, asked) for asked in (QUANTITIES, AT_REST, MODES)}


@pytest.mark.parametrize("asked", [QUANTITIES, AT_REST, MODES], ids=["all", "at rest", "modes"])
def test_fewer_shapes_say_the_same_within_the_bars(family, few, asked):
    """On members that were not looked at; rest alone and modes alone need fewer than both."""
    own, kept = few
    few = kept[asked]
    more = kept[QUANTITIES] if asked != QUANTITIES else family
    assert few.fine.motions["bending_x"].size < more.fine.motions["bending_x"].size
    at = {"bimorph.length": np.linspace(12e-3, 16e-3, 7)}
    fewer, whole = (family_values(own, each, at, asked) for each in (few, family))
    for name in asked:
        apart = np.abs(fewer[name].value - whole[name].value)
        assert (apart <= fewer[name].basis + whole[name].basis).all(), name
        enough = np.maximum(
            1.15 * whole[name].error, 0.05 * own.accuracy * np.abs(whole[name].value)
        )
        assert (fewer[name].error <= enough).all(), name


@pytest.mark.parametrize(("members", "taken"), [(1000, "whole"), (1001, "few")])
def test_fewer_shapes_are_looked_for_where_that_pays(monkeypatch, members, taken):
    monkeypatch.setattr(answers, "solid_family", lambda *_: "whole")
    monkeypatch.setattr(answers, "for_many", lambda *_: "few")
    assert answers.reduce_family(scene(), RANGE, MODES, members).family == taken


def test_responses_over_frequency_need_all_shapes(family):
    assert for_many(scene("frequency=100"), family, ("tip_displacement",)) is family


def test_what_is_kept_serves_within_its_range_and_grows_beyond(family):
    said = []
    narrow = {"bimorph.length": (13e-3, 15e-3)}
    again = solid_family.solid_family(scene(), narrow, QUANTITIES, said.append)
    assert again.ranges == family.ranges
    assert not said
    wider = solid_family.solid_family(
        scene(), {"bimorph.length": (15e-3, 17e-3)}, QUANTITIES, said.append
    )
    assert wider.ranges == {"bimorph.length": (12e-3, 17e-3)}
    assert any("grows" in text for text in said)


@pytest.mark.parametrize(
    ("ranges", "words"),
    [
        ({"coil.current": (0.1, 0.2)}, "coil.current does not vary within a family"),
        ({"bimorph.length": (16e-3, 12e-3)}, "begin below where it ends"),
        ({"bimorph.tab_length": (0.0, 1e-3)}, "the piece tab of the bimorph is 0 mm"),
    ],
)
def test_refusals_name_the_key(ranges, words):
    with pytest.raises(InputError, match=words):
        solid_family.solid_family(scene(), ranges, QUANTITIES)


def test_a_point_outside_is_refused(family):
    with pytest.raises(InputError, match=r"outside the family's range of 0.012 to 0.016"):
        family_values(scene(), family, {"bimorph.length": np.array([11e-3])}, QUANTITIES[:1])


@pytest.mark.heavy
def test_bars_of_the_bases_cover_what_they_miss(monkeypatch):
    """200 points of length, width and layer: 95 of 100 within the bases' own part of the bar."""
    ranges = {
        "bimorph.length": (14e-3, 40e-3), "bimorph.width": (1.5e-3, 3e-3),
        "bimorph.piezo_thickness": (0.2e-3, 0.35e-3),
    }  # fmt: skip
    for module in (solid, solid_family):
        monkeypatch.setattr(module, "LEVELS", LEVELS)
    own = load_scene("j1", ["accuracy=5e-3"])[0]
    family = solid_family.solid_family(own, ranges, QUANTITIES)
    extremes = [{k: v[0] for k, v in ranges.items()}, {k: v[1] for k, v in ranges.items()}]
    bricks = dividing([with_values(own.device, e) for e in extremes], LEVELS[0])
    rng = np.random.default_rng(11)
    points = {key: rng.uniform(*ends, 200) for key, ends in ranges.items()}
    found = family_modes(
        family.coarse.members("bending_x", own.device, points), Ends(), 4, open_circuit=False
    )
    inside = []
    for i in range(200):
        member = with_values(own.device, {key: float(v[i]) for key, v in points.items()})
        system = assemble_bricks(member, stretched(bricks, member.bimorph), lossy=False)
        exact = np.array([m.frequency for m in natural_modes(system, Ends(), 4)])
        # slender members' direct solutions are right to this
        inside += list(np.abs(found.frequencies[i] - exact) <= found.bars[i] + 2e-7 * exact)
    assert (found.bars <= 1e-4 * found.frequencies).all()
    assert np.mean(inside) >= 0.95


def test_more_ranges_are_looked_at_in_more_points():
    """So many for each, all inside; the same seed draws the same."""
    ranges = {"bimorph.length": (1.0, 2.0), "shim.density": (3.0, 4.0)}
    family = SimpleNamespace(ranges=ranges)
    found = _points(family, 5, 1)
    for key, (low, high) in ranges.items():
        assert found[key].shape == (10,)
        assert low <= found[key].min() < found[key].max() <= high
        assert np.array_equal(found[key], _points(family, 5, 1)[key])
