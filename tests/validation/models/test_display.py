"""The display by models of its generators: crosstalk, units that differ, screws that tune them."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.magnetics import array_3d
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.quantities import quantities_of
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.backbone import five_port
from tactgen.validation.models.display import by_field, display_ports, first_frequency
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


def test_without_neighbours_there_is_none_and_without_skin_the_board_passes_all():
    """Of a display of one row there is no unit behind, of one unit none at all."""
    row = answers(CROSSTALK, "display.rows=1")
    assert np.isnan(row["crosstalk_behind"].value).all()
    assert np.isfinite(row["crosstalk_beside"].value).all()
    alone = answers(CROSSTALK, "display.rows=1", "display.columns=1")
    assert not alone["crosstalk_largest"].value.any()
    bare, covered = answers(CROSSTALK, "skin.thickness=0mm"), answers(CROSSTALK)
    np.testing.assert_array_equal(bare["crosstalk_largest"].value, bare["crosstalk_by_board"].value)
    # at 10 Hz nothing is near a resonance
    assert covered["crosstalk_largest"].value[0] > 2.0 * bare["crosstalk_largest"].value[0]


def test_screws_bring_units_together(tuned):
    """To 1e-6 of the frequency, which is where the search ends; the paper's tuning range of some
    300 Hz (section 6) is within reach, and the scatter needs no more."""
    found, turns = tuned["unit_frequencies"].value, tuned["screw_turns"].value
    assert tuned["frequency_spread"].value == pytest.approx(np.ptp(found))
    assert tuned["tuned_spread"].value < 3e-6 * np.median(found)
    # who is below the median is tightened, which stiffens the contact
    assert (turns[found < 0.999 * np.median(found)] > 0.0).all()
    assert (turns[found > 1.001 * np.median(found)] < 0.0).all()
    # a turn is 0.35 mm on 100 N/m; a screw goes 1 mm either way, of 110 mN less a loose head
    assert np.abs(turns).max() < 1e-3 / 0.35e-3
    assert tuned["tuning_range"].value > 300.0
    assert tuned["frequency_spread"].value < tuned["tuning_range"].value


def test_what_screws_cannot_or_need_not_bring_together():
    """Units that their travel does not reach stay apart, and the turns end at the travel; without
    scatter all have one frequency and no screw turns; other draws scatter, too."""
    short = answers(SPREAD, "display.screw_length=3.9mm")
    assert short["tuned_spread"].value > 10.0
    assert np.abs(short["screw_turns"].value).max() == pytest.approx(0.1 / 0.35)
    assert short["tuning_range"].value < 60.0
    none = [f"scatter.{key}=0" for key in ("length", "thickness", "roughness", "preload")]
    equal = answers(SPREAD, *none)
    assert equal["frequency_spread"].value == 0.0
    assert not equal["screw_turns"].value.any()
    assert answers(SPREAD[1:2], "scatter.seed=2")["frequency_spread"].value > 1.0


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
    [("support.kind=spring", r"support\.kind.*contact"),
     ("display.pitch=2.2mm", r"display\.pitch = 2\.2 mm.*footprint of 2\.3 mm")],
)  # fmt: skip
def test_refusals(override, words):
    """Before anything is computed."""
    with pytest.raises(InputError, match=words):
        make_plan(load_scene("display", [override])[0], ("tmm",), CROSSTALK)


def test_layers_in_series_pass_on_half_the_motion_per_volt():
    """What a unit's voltage does to every tip; what tips do to one another is the same."""
    scenes = [
        load_scene("display", [*SMALL, f"bimorph.wiring={w}"])[0] for w in ("parallel", "series")
    ]
    alone = five_port(scenes[0], "lumped")(np.array([100.0]))
    parallel, series = (display_ports(scene, alone) for scene in scenes)
    halves = np.array([0.5 if "voltage" in name else 1.0 for name in parallel.names])
    expected = halves[:, None] * halves * parallel.stiffness
    np.testing.assert_allclose(series.stiffness, expected, rtol=1e-9)


def test_a_first_frequency_is_judged_by_every_coarser_mesh():
    """By its factor each, beside rounding."""
    fine, coarse = (Modes(np.array([value, 900.0]), ("bending_x",) * 2) for value in (100.0, 98.0))
    found = first_frequency(Refined(fine, ((coarse, 0.5), (coarse, 0.25)), "", rounding=1e-3))
    assert (found.value, found.error) == (100.0, pytest.approx(0.1 + 0.75 * 2.0, rel=1e-9))


#: Pull per square of current, of the unit's own and of one neighbour's beside and on the diagonal.
OWN, BESIDE, DIAGONAL = 5.0, -0.3, -0.06
#: Vector and scalar potential err the one way and the other.
OFF = (1.02, 0.98)


def nine_forces(_device, currents, *place):
    """Q i² + Σ 2 q i j of each kind of unit among nine."""
    assert place == (0.2e-3, 2.4e-3)

    def forces(at):
        a, b, c = (at.get(kind, 0.0) for kind in ("middle", "beside", "diagonal"))
        pulls = {
            "middle": a * (OWN * a + 8.0 * BESIDE * b + 8.0 * DIAGONAL * c),
            "beside": b * (OWN * b + 2.0 * BESIDE * (a + 2.0 * c) + 4.0 * DIAGONAL * b),
            "diagonal": c * (OWN * c + 4.0 * BESIDE * b + 2.0 * DIAGONAL * a),
        }
        both = {unit: tuple(off * pull for off in OFF) for unit, pull in pulls.items()}
        return array_3d.NineForces(**both, unbalanced=(0.03, 0.01))

    return [forces(at) for at in currents]


def array_forces(_device, current, *place):
    assert place == (0.2e-3, 2.4e-3)
    same, alternating = (current**2 * (OWN + sign * 8.0 * BESIDE) for sign in (1.0, -1.0))
    return SimpleNamespace(
        same=tuple(off * same for off in OFF), alternating=tuple(off * alternating for off in OFF)
    )


def test_the_field_of_an_array_is_the_mean_of_both_potentials(monkeypatch):
    """Driven units whose fields only add up.  Bars: the distance of the potentials as a share, and
    of nine units what is out of balance."""
    monkeypatch.setattr(array_3d, "array_forces", array_forces)
    monkeypatch.setattr(array_3d, "nine_forces", nine_forces)
    found = by_field(load_scene("display", ["display.coil_current=50 mA"])[0])
    square = 0.05**2
    for one, expected in (
        (found.same, square * (OWN + 8.0 * BESIDE)),
        (found.alternating, square * (OWN - 8.0 * BESIDE)),
        (found.difference, square * 16.0 * BESIDE),
        (found.per_neighbour, 2.0 * BESIDE * 0.05),  # of what one neighbour's current changes
    ):
        assert one.value == pytest.approx(expected)
        assert one.error == pytest.approx(0.02 * abs(expected), rel=1e-6)
    assert (found.current, found.single.value) == (0.05, pytest.approx(OWN * square))
    assert found.single.error == pytest.approx(0.02)
    assert (found.passive.value, found.passive.error) == (0.0, pytest.approx(0.02 / 4.0))
