"""Axes as users write them, what is refused in one sentence, what is asked where none is named."""

import json

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import representative
from tactgen.validation.engine.solve import check_models, check_on_contact, solve
from tactgen.validation.scene.files import built_in_scenes
from tactgen.validation.scene.load import checked_scene, load_scene, scene_values
from tactgen.validation.studies.whatif.axes import parse_axes, scene_field
from tactgen.validation.studies.whatif.defaults import chosen, with_tolerances
from tactgen.validation.studies.whatif.definition import Statement


def one(text, *, sampled=False):
    (axis,) = parse_axes([text], sampled=sampled)
    return axis


def statement(*vary, **more):
    return Statement("paper", {}, vary, ("tmm",), ("capacitance_free",), **more)


def test_ranges_and_lists_are_in_si():
    """The ends are what was written, to the last bit; the steps are even or of one ratio."""
    for text, values in (
        ("bimorph.length=14mm:22mm:5", (0.014, 0.016, 0.018, 0.02, 0.022)),
        ("load.kind=none, finger", ("none", "finger")), ("mesh.level=2:5:4", (2, 3, 4, 5)),
        ("frequency=100,0.5 kHz", (100.0, 500.0)),
        ("bimorph.width_profile=uniform; 0 mm: 2.1 mm, 20 mm: 1 mm",
         ("uniform", "0 mm: 2.1 mm, 20 mm: 1 mm")),
    ):  # fmt: skip
        assert one(text).values == values
    stiffness = one("support.rotational_stiffness = 0.01 N*m/rad:1 N*m/rad:3:log")
    np.testing.assert_allclose(stiffness.values, [0.01, 0.1, 1.0], rtol=1e-15)
    assert scene_field(stiffness.key).label == "support.rotational_stiffness (N*m/rad)"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("bimorph.lenght=1mm,2mm", 'did you mean "bimorph.length"'),
        ("bimorph.length", "is not KEY=VALUES"),
        ("bimorph.length=22mm:14mm:5", "is empty or runs backwards"),
        ("bimorph.length=14mm:22mm:1", "whole number from 2"),
        ("bimorph.length=14mm:22mm:5:cubic", "is not START:STOP:N"),
        ("bimorph.length=14mm,14mm", "names a value twice"),
        ("drive.voltage=0V:5V:3:log", "begin above 0"),
        ("mesh.level=2:5:3", "mesh.level is a whole number"),
        ("load.kind=finger,nonw", 'did you mean "none"'),
        ("models=tmm,solid", "use --model"),
        ("bimorph=1,2", "is a group"),
        ("bimorph.length=14mm:22mm", "add for example --sample 16"),
        ("gap=gauss(200um,10um)", "is not a distribution; write normal(mean"),
        ("load.kind=normal(1,2)", "not a number on a scale"),
    ],
)  # fmt: skip
def test_what_cannot_be_an_axis_is_refused(text, words):
    """One sentence with the key, the value and the remedy."""
    with pytest.raises(InputError) as caught:
        parse_axes([text], sampled=False)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [("gap=normal(200um,10V)", "which is not a length"),
     ("gap=lognormal(200um,10um)", "share of the median"),
     ("gap=lognormal(200um,0%)", '"0%" must be above 0; write for example 2%'),
     ("gap=200um,210um", "no axis can be drawn from")],
)  # fmt: skip
def test_what_cannot_be_drawn_is_refused(text, words):
    with pytest.raises(InputError, match=words):
        parse_axes([text], sampled=True)


def test_tolerances_are_axes():
    """Alone a key means its tolerance; without axes all that are stated are drawn from."""
    values, _ = scene_values("paper", ["bimorph.width=2.1 ± 0.1 mm", "gap=0.2 mm (0.19..0.22)"])
    every, notes = with_tolerances(values, (), sampled=True)
    assert {axis.key for axis in parse_axes(every, sampled=True)} == {"bimorph.width", "gap"}
    assert "gap is drawn from 0.19 mm to 0.22 mm (stated: 0.19 mm..0.22 mm)" in notes
    mixed, notes = with_tolerances(values, ("gap=0.1mm,0.2mm", "shim.density"), sampled=True)
    steps, drawn = parse_axes(mixed, sampled=True)
    assert (steps.values, drawn.drawn.first, drawn.drawn.second) == ((1e-4, 2e-4), 1450.0, 1550.0)
    assert len(notes) == 1
    assert with_tolerances(values, ("gap=0.1mm,0.2mm",), sampled=False)[0] == ("gap=0.1mm,0.2mm",)


def test_a_tolerance_that_makes_no_scene_is_left_out():
    """A profile ends where the ceramic does, so the length is not drawn; the note says why."""
    stated = [
        "bimorph.width_profile=0 mm: 2 mm, 18 mm: 1 mm", "bimorph.length=18 ± 0.1 mm",
        "bimorph.shim_thickness=0.25 mm ± 5 %",
    ]  # fmt: skip
    (axis,), notes = with_tolerances(scene_values("paper", stated)[0], (), sampled=True)
    assert axis.startswith("bimorph.shim_thickness=")
    assert "bimorph.length is not drawn: bimorph.width_profile ends" in "".join(notes)


@pytest.mark.parametrize(
    ("overrides", "vary", "sampled", "words"),
    [
        ([], (), True, "the scene states no tolerance"),
        ([], ("gap",), True, "states no tolerance of it"),
        (["gap=0.2 ± 0.1 mm"], ("gap",), False, "add --sample 16"),
        ([], ("bimorph.lenght",), True, 'did you mean "bimorph.length"'),
    ],
)
def test_without_a_tolerance_nothing_is_drawn(overrides, vary, sampled, words):
    """The sentence says what to write."""
    with pytest.raises(InputError) as refused:
        with_tolerances(scene_values("paper", overrides)[0], vary, sampled=sampled)
    assert words in str(refused.value)


def test_axes_are_combined_or_taken_hand_in_hand():
    """The last axis runs fastest; zipped ones must be of one length."""
    lengths, loads = "bimorph.length=14mm,20mm", "load.kind=none,finger"
    combined = statement(lengths, loads)
    assert [tuple(p.values()) for p in combined.points()] == [
        (0.014, "none"), (0.014, "finger"), (0.02, "none"), (0.02, "finger"),
    ]  # fmt: skip
    zipped = statement(lengths, loads, zipped=True)
    assert [tuple(p.values()) for p in zipped.points()] == [(0.014, "none"), (0.02, "finger")]
    with pytest.raises(InputError, match=r"bimorph.length has 2, gap has 3"):
        list(statement(lengths, "gap=10um:30um:3", zipped=True).points())
    with pytest.raises(InputError, match=r"make 10000000000 points"):
        _ = statement("gap=10um:30um:100000", "bimorph.length=10mm:20mm:100000").size
    with pytest.raises(InputError, match=r"stated several times"):
        _ = statement(lengths, lengths).axes


def test_samples_grow_and_do_not_depend_on_one_another():
    """More samples begin with the fewer; another axis leaves them; another seed does not."""
    gap, length = "gap=normal(200um,5%)", "bimorph.length=14mm:22mm"

    def drawn(*vary, samples=8, seed=1):
        return statement(*vary, samples=samples, seed=seed).columns["gap"][1]

    few, more = drawn(gap), drawn(gap, samples=16)
    assert more[:8] == few == drawn(length, gap)
    assert not set(drawn(gap, seed=2)) & set(few)
    many = np.array(drawn(gap, samples=20000))
    # the standard error of mean and deviation, four times
    assert abs(many.mean() - 200e-6) < 4 * 10e-6 / np.sqrt(20000)
    assert abs(many.std() - 10e-6) < 4 * 10e-6 / np.sqrt(40000)
    # what is stepped is combined with all samples
    mixed = statement(gap, "load.kind=none,finger", samples=8)
    assert mixed.shape == {"sample": 8, "load.kind": 2}


@pytest.mark.parametrize(
    ("kind", "low", "middle", "high"),
    [("1mm:3mm", 1e-3, 2e-3, 3e-3), ("1mm:4mm:log", 1e-3, 2e-3, 4e-3),
     ("lognormal(2mm,10%)", 0.0, 2e-3, 1.0)],
)  # fmt: skip
def test_distributions_have_their_medians_and_ends(kind, low, middle, high):
    values = np.array(statement(f"gap={kind}", samples=4001).columns["gap"][1])
    assert values.min() > low
    assert values.max() < high
    # half the samples are below the median, within four standard errors
    assert abs((values < middle).mean() - 0.5) < 4 * 0.5 / np.sqrt(4001)


@pytest.mark.parametrize("quantities", [None, ["all"]])
@pytest.mark.parametrize("scene", built_in_scenes())
def test_every_scene_gives_what_is_asked_of_it(scene, quantities):
    """All that its models give, and nothing that it has no rod or neighbours for."""
    values, _ = scene_values(scene)
    models, names = chosen(values, None, quantities, Statement("", {}, (), (), ()))
    check_models(models, names)
    check_on_contact(checked_scene(values), names)


def test_a_study_of_a_scene_that_asks_for_all_asks_its_headline_quantities(capsys):
    """They cost least; all of them are had by name."""
    vary = ["--vary", "coil.current=120mA", "--model", "network", "--json"]
    for more, expected in (
        ([], {name for name, row in QUANTITIES.items() if row.headline}),
        (["--quantity", "all"], set(QUANTITIES)),
    ):
        assert main(["whatif", "reluctance", *vary, *more]) == 0
        points = json.loads(capsys.readouterr().out)["points"]
        assert [point["status"] for point in points] == ["ok"]
        found = {of["name"] for of in points[0]["quantities"]}
        assert {"magnetic_force"} <= found <= expected
        assert ("coenergy" in found) == bool(more)


def test_one_number_stands_for_poles():
    """The size of the first, which is its natural angular frequency: poles are complex."""
    (poles,) = solve(load_scene("generator", [])[0], ("tmm",), ("axial_poles",)).quantities
    assert np.iscomplex(poles.value[0])
    assert representative(poles).value == abs(poles.value[0])


@pytest.mark.parametrize("command", ["design", "whatif"])
def test_the_remedy_for_an_idle_model_is_one_that_the_command_has(command, capsys):
    """`design` has no --quantity."""
    options = {
        "design": ["bimorph.length=14mm:22mm", "--aim", "maximise static_tip_displacement"],
        "whatif": ["bimorph.length=14mm,22mm", "--quantity", "static_tip_displacement"],
    }
    assert main([command, "paper", "--model", "network", "--vary", *options[command]]) == 2
    said = capsys.readouterr().err
    assert "model network gives none of static_tip_displacement; remove it, or ask for" in said
    assert "such as magnetic_force" in said
    assert "--quantity" not in said
