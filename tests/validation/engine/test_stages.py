"""What is kept between runs: found again, bit for bit, without the field solvers' libraries."""

import json
import subprocess
import sys
from functools import partial

import pytest

from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.validation.catalogue.models import gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.solve import as_json, solve
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.model import Stages
from tactgen.validation.scene.load import load_scene

#: Solid and fields, small.
SCENES = (
    ("j1", ("frequency=100,2000", "mesh.level=2", "modes=2", "models=solid")),
    ("reluctance", ("models=axisymmetric", "accuracy=5%")),
)


@pytest.fixture(scope="module", autouse=True)
def small(tmp_path_factory, rough_fields, few_bricks):
    """Take few bricks, and few points of the actuator's map: what is kept is asked for."""
    few = partial(map_grid, currents=7, gaps=6)
    with rough_fields(tmp_path_factory.mktemp("store")) as patch:
        patch.setattr("tactgen.tmm.reluctance.map_range.map_grid", few)
        patch.setattr(solid, "LEVELS", few_bricks)
        yield


def _given(model):
    """Return what a model gives of its own actuator; machine and display want a rod."""
    own = ("bimorph", "reluctance")
    return [q for q in QUANTITIES if gives(model, q) and QUANTITIES[q].actuator in own]


def answers(name, *overrides, announce=lambda _: None):
    scene, _ = load_scene(name, overrides)
    found = as_json(solve(scene, None, _given(*scene.models), announce))
    for quantity in found["quantities"]:
        del quantity["seconds"]
    return found


@pytest.mark.usefixtures("own_store")
def test_only_what_is_of_some_code_is_kept():
    """Found by the next run under the same key; computed again under another, or if not kept."""
    computed, announced = [], []

    def work():
        computed.append(1)
        return len(computed)

    def run(stage, key, *code):
        return Stages({stage: key}, announced.append).run(stage, work, code)

    of = ("tmm.static", "a", "tactgen.tmm.beam"), ("tmm.static", "b", "tactgen.tmm.beam")
    assert [run(*of[0]), run(*of[0]), run(*of[1])] == [1, 1, 2]
    assert [run("tmm.modes", "a"), run("tmm.modes", "a")] == [3, 4]
    assert announced == ["tmm.static", "tmm.static", "tmm.modes", "tmm.modes"]


@pytest.mark.parametrize(("name", "overrides"), SCENES)
def test_the_same_again_is_read(name, overrides):
    """Numbers, bars, methods and warnings are the same; no stage that is kept runs."""
    first = answers(name, *overrides)
    ran = []
    assert answers(name, *overrides, announce=ran.append) == first
    assert set(ran) <= {"solid.modes_short", "solid.modes_open"}


def test_answers_from_the_store_load_no_solver():
    """Neither sparse matrices nor elements nor mesher, in a process of its own."""
    for name, overrides in SCENES:
        answers(name, *overrides)
    script = (
        "import json, sys; from tactgen.validation.scene.load import load_scene; "
        "from tactgen.validation.engine.solve import solve\n"
        "for (name, overrides), quantities in json.loads(sys.argv[1]):\n"
        "    solve(load_scene(name, overrides)[0], None, quantities)\n"
        "heavy = ('scipy.sparse', 'scipy.linalg', 'scipy.optimize', 'skfem', 'pytetwild', "
        "'pyvista', 'cadquery', 'tactgen.fem.piezo.system', "
        "'tactgen.fem.magnetics.axisymmetric')\n"
        "print([m for m in heavy if m in sys.modules])"
    )
    asked = [*zip(SCENES, map(_given, ("solid", "axisymmetric")), strict=True)]
    command = [sys.executable, "-c", script, json.dumps(asked)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (result.stdout.strip(), result.stderr) == ("[]", "")
