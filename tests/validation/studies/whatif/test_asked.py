"""What a study or a comparison asks when nothing is named."""

import json

import numpy as np
import pytest

from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import representative
from tactgen.validation.engine.solve import check_models, check_on_contact, solve
from tactgen.validation.scene.files import built_in_scenes
from tactgen.validation.scene.load import checked_scene, load_scene, scene_values
from tactgen.validation.studies.whatif.defaults import chosen
from tactgen.validation.studies.whatif.definition import Statement


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
    scene, _ = load_scene("generator", ["models=tmm", "quantities=axial_poles"])
    (poles,) = solve(scene).quantities
    assert np.iscomplex(poles.value[0])
    shown = representative(poles)
    assert shown.value == abs(poles.value[0])
    assert "size of the first" in shown.what


@pytest.mark.parametrize("command", ["design", "whatif"])
def test_the_remedy_for_an_idle_model_is_one_that_the_command_has(command, capsys):
    """`design` has no --quantity."""
    options = {
        "design": ["bimorph.length=14mm:22mm", "--aim", "maximise static_tip_displacement"],
        "whatif": ["bimorph.length=14mm,22mm", "--quantity", "static_tip_displacement"],
    }
    asked = [command, "paper", "--model", "network", "--vary", *options[command]]
    assert main(asked) == 2
    said = capsys.readouterr().err
    assert "model network gives none of static_tip_displacement; remove it, or ask for" in said
    assert "such as magnetic_force" in said
    assert "--quantity" not in said
