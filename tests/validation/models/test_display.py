"""The display by models of its generators: crosstalk, units that differ, screws that tune them."""

from functools import cache

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.quantities import quantities_of
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.backbone import five_port
from tactgen.validation.models.display import display_ports, first_frequency
from tactgen.validation.models.model import Modes, Refined
from tactgen.validation.scene.load import load_scene

CROSSTALK = tuple(q for q in quantities_of("display") if q.startswith("crosstalk"))
SPREAD = ("unit_frequencies", "frequency_spread", "screw_turns", "tuned_spread", "tuning_range")
FIELD = (
    "pull_all_driven", "pull_alternating", "pull_one_driven", "magnetic_crosstalk", "passive_pull",
)  # fmt: skip
SMALL = ("display.rows=2", "display.columns=3", "frequency=10,100,430,1000")


@cache
def answers(quantities, *overrides, model="tmm"):
    scene, _ = load_scene("display", [*SMALL, *overrides])
    return {q.name: q for q in solve(scene, (model,), quantities, modelling=False).quantities}


@pytest.fixture(scope="module")
def tuned():
    return answers(SPREAD)


def test_models_agree_on_what_passes():
    """Exact beams and beam elements: the same display within the elements' bar and rounding."""
    exact, elements = answers(CROSSTALK), answers(CROSSTALK, model="beam")
    for name, q in exact.items():
        bar = q.error + elements[name].error + 1e-12
        assert (np.abs(q.value - elements[name].value) <= bar).all(), name


def test_without_neighbours_there_is_none():
    """Of a display of one row there is no unit behind, of one unit none at all."""
    row = answers(CROSSTALK, "display.rows=1")
    assert np.isnan(row["crosstalk_behind"].value).all()
    assert np.isfinite(row["crosstalk_beside"].value).all()
    alone = answers(CROSSTALK, "display.rows=1", "display.columns=1")
    assert not alone["crosstalk_largest"].value.any()


def test_without_skin_the_board_passes_all():
    """Skin of no thickness leaves what the board passes on."""
    bare = answers(CROSSTALK, "skin.thickness=0mm")
    np.testing.assert_array_equal(bare["crosstalk_largest"].value, bare["crosstalk_by_board"].value)
    covered = answers(CROSSTALK)
    # at 10 Hz nothing is near a resonance
    assert covered["crosstalk_largest"].value[0] > 2.0 * bare["crosstalk_largest"].value[0]


def test_screws_bring_units_together(tuned):
    """To 1e-6 of the frequency, which is where the search ends."""
    found = tuned["unit_frequencies"].value
    assert tuned["frequency_spread"].value == pytest.approx(np.ptp(found))
    assert tuned["tuned_spread"].value < 3e-6 * np.median(found)
    # who is below the median is tightened, which stiffens the contact
    turns = tuned["screw_turns"].value
    assert (turns[found < 0.999 * np.median(found)] > 0.0).all()
    assert (turns[found > 1.001 * np.median(found)] < 0.0).all()
    # a turn is 0.35 mm on 100 N/m; a screw goes 1 mm either way, of 110 mN less a loose head
    assert np.abs(turns).max() < 1e-3 / 0.35e-3


def test_the_papers_tuning_range_is_within_reach(tuned):
    """Some 300 Hz (section 6); and the scatter needs no more."""
    assert tuned["tuning_range"].value > 300.0
    assert tuned["frequency_spread"].value < tuned["tuning_range"].value


def test_a_screw_that_hardly_moves_tunes_hardly():
    """Units that its travel does not reach stay apart, and the turns end at the travel."""
    short = answers(SPREAD, "display.screw_length=3.9mm")
    assert short["tuned_spread"].value > 10.0
    assert np.abs(short["screw_turns"].value).max() == pytest.approx(0.1 / 0.35)
    assert short["tuning_range"].value < 60.0


def test_equal_units_need_no_screw():
    """Without scatter all have one frequency and no screw turns."""
    none = [f"scatter.{key}=0" for key in ("length", "thickness", "roughness", "preload")]
    equal = answers(SPREAD, *none)
    assert equal["frequency_spread"].value == 0.0
    assert not equal["screw_turns"].value.any()
    other_seed = answers(("frequency_spread",), "scatter.seed=2")
    assert other_seed["frequency_spread"].value > 1.0


def test_pulls_and_crosstalk_hang_together():
    """By the network: an eighth of their difference over the current."""
    found = answers(FIELD, model="network")
    same, alternating, single = (found[q].value for q in FIELD[:3])
    assert alternating < single < same
    assert found["magnetic_crosstalk"].value == pytest.approx((same - alternating) / (8.0 * 50e-3))
    assert found["magnetic_crosstalk"].error < 0.01 * found["magnetic_crosstalk"].value


@pytest.mark.heavy
def test_the_field_bears_the_network_out():
    """A third: the network knows no flux between a head and another's sleeve, nor how equal
    neighbours press the field together."""
    network, field = answers(FIELD, model="network"), answers(FIELD, model="magnetic3d")
    for name in FIELD[:4]:
        assert network[name].value == pytest.approx(field[name].value, rel=0.33), name
        assert field[name].error < 0.07 * field[name].value
    # an undriven neighbour is lifted, far beyond the bar
    lifted = field["passive_pull"]
    assert np.isnan(network["passive_pull"].value)
    assert lifted.value < -5.0 * lifted.error < 0.0


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("support.kind=spring", ["support.kind", "contact"]),
        ("display.pitch=2.2mm", ["display.pitch = 2.2 mm", "footprint of 2.3 mm"]),
    ],
)
def test_refusals(override, words):
    """Before anything is computed."""
    scene, _ = load_scene("display", [override])
    with pytest.raises(InputError) as refused:
        make_plan(scene, ("tmm",), CROSSTALK)
    assert all(word in str(refused.value) for word in words)


def test_layers_in_series_pass_on_half_the_motion_per_volt():
    """What a unit's voltage does to every tip; what tips do to one another is the same."""
    scenes = [
        load_scene("display", [*SMALL, f"bimorph.wiring={wiring}"])[0]
        for wiring in ("parallel", "series")
    ]
    alone = five_port(scenes[0], "lumped")(np.array([100.0]))
    parallel, series = (display_ports(scene, alone) for scene in scenes)
    halves = np.array([0.5 if "voltage" in name else 1.0 for name in parallel.names])
    share = halves[:, None] * halves
    np.testing.assert_allclose(series.stiffness, share * parallel.stiffness, rtol=1e-9)


def test_a_first_frequency_is_judged_by_every_coarser_mesh():
    """By its factor each, beside rounding."""
    fine, coarse = (Modes(np.array([value, 900.0]), ("bending_x",) * 2) for value in (100.0, 98.0))
    found = first_frequency(Refined(fine, ((coarse, 0.5), (coarse, 0.25)), "", rounding=1e-3))
    assert (found.value, found.error) == (100.0, pytest.approx(0.1 + 0.75 * 2.0, rel=1e-9))
