"""Points of the axisymmetric model one after another, against closed forms and points alone."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.magnetics import axisymmetric as actuator
from tactgen.fem.magnetics.axisymmetric import FieldErrors, FieldPoint, solve_point
from tactgen.fem.magnetics.axisymmetric_path import FieldWalk
from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.families import find_families
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.reluctance import field
from tactgen.validation.models.reluctance.family import map_table, walk
from tactgen.validation.scene.nearby import value_of, with_values
from tactgen.validation.scene.scene import load_scene, scene_values
from tactgen.validation.studies.whatif import answers
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.run import run_study
from tactgen.validation.studies.whatif.study_plan import plan_study

SETS = ["models=axisymmetric", "accuracy=10%"]
STROKE = ("magnetic_force", "pull_in_current", "holding_current", "rod_position", "finger_force")


def stated(*vary, quantities=("magnetic_force",)):
    values, _ = scene_values("reluctance", SETS)
    return Statement("reluctance", values, vary, ("axisymmetric",), quantities)


def never_alone(monkeypatch):
    monkeypatch.setattr(answers, "solve", lambda *_, **__: pytest.fail("a point was solved alone"))


def offset(device):
    """Return what the gap of the closed form is longer by: a function with some bend."""
    return 0.3e-3 * (0.6e-3 / device.rod.radius) ** 2


def closed_form(device, current, gap, *, spread=1e-3):
    """A coil whose inductance is L = A/(g + g0): W' = L i²/2."""
    width = gap + offset(device)
    inductance = 4e-6 / width
    force = 0.5 * inductance / width * current**2
    return FieldPoint(
        current=current, gap=gap, flux_linkage=inductance * current,
        coenergy=0.5 * inductance * current**2, force=force, force_eggshell=force,
        incremental_inductance=inductance,
        errors=FieldErrors(spread * inductance * abs(current), 0.0, spread * force, 0.0),
        iterations=1, unknowns=1, beyond_table=0.0,
    )  # fmt: skip


@pytest.fixture
def closed(own_store, monkeypatch):
    """Replace the field by a closed form; return the devices of which maps were made."""
    maps = []

    def solve_map(device, gaps, currents, **_):
        maps.append(device.rod.radius)
        return [[closed_form(device, i, g, spread=1e-2) for i in currents] for g in gaps]

    monkeypatch.setattr(actuator, "solve_map", solve_map)
    monkeypatch.setattr(FieldWalk, "at", lambda _, device, i, g, _place: closed_form(device, i, g))
    few = partial(map_grid, currents=7, gaps=6)
    monkeypatch.setattr("tactgen.tmm.reluctance.map_range.map_grid", few)
    return maps


def test_gap_current_and_spring_share_one_map_without_a_table(closed, monkeypatch):
    asked = stated("gap=0.18mm:0.2mm:3", "spring.stiffness=90N/m,110N/m", quantities=STROKE)
    (before,) = plan_study(asked)
    assert "the samples of a co-energy map" in before.sentences[-1]
    never_alone(monkeypatch)
    assert run_study(asked, 1).counts.walked == 6
    assert len(closed) == 1
    (later,) = plan_study(stated("gap=0.18mm:0.2mm:4", quantities=STROKE))
    assert later.sentences[-1].endswith("it is kept")


def test_the_last_line_says_how_many_were_walked(closed, capsys):
    asked = ["whatif", "reluctance", "--vary", "gap=0.18mm,0.2mm", "--model", "axisymmetric",
             "--quantity", "magnetic_force", "--jobs", "1"]  # fmt: skip
    assert main(asked) == 0
    assert "2 answers computed (2 of them each from others), 0 kept" in capsys.readouterr().err
    assert main(asked) == 0
    assert "0 answers computed, 2 kept" in capsys.readouterr().err


@pytest.fixture
def coarse(own_store, monkeypatch):
    for module in (field, walk):
        monkeypatch.setattr(module, "REFINEMENTS", ((0.0, 0.5),))


def test_two_dimensions_are_walked_as_solved_alone(coarse, monkeypatch):
    """Four points of rod and gap, by which no table would pay."""
    asked = stated("rod.radius=0.6mm,0.62mm", "gap=0.19mm,0.2mm")
    with monkeypatch.context() as alone:
        never_alone(alone)
        rows = list(run_study(asked, 1).rows)
    assert len(rows) == 4
    for point, _, answer in rows[1::2]:
        there = [f"{key}={value!r} m" for key, value in point.items()]
        scene, _ = load_scene("reluctance", [*SETS, *there])
        (single,) = solve(scene, ("axisymmetric",), ("magnetic_force",)).quantities
        (walked,) = answer.quantities
        assert (walked.unit, walked.method) == (single.unit, single.method)
        assert abs(walked.value - single.value) <= walked.error + single.error
        assert walked.error <= 2.0 * single.error
    assert run_study(asked, 1).counts.recalled == 4


def test_what_a_walk_cannot_solve_is_asked_alone(coarse, monkeypatch):
    def refuses(*_):
        raise SolverError("the field did not settle")

    monkeypatch.setattr(FieldWalk, "at", refuses)
    study = run_study(stated("gap=0.19mm,0.2mm"), 1)
    assert [answer.status for _, _, answer in study.rows] == ["ok", "ok"]
    assert (study.counts.computed, study.counts.walked) == (2, 0)


@pytest.mark.parametrize(
    ("key", "own"),
    [("rod.radius", True), ("spring.stiffness", True), ("load.normal_force", True),
     ("accuracy", False), ("rod.density", False), ("steel.curve", False)],
)  # fmt: skip
def test_numbers_that_the_model_reads_vary_within_a_walk(key, own):
    scene, _ = load_scene("reluctance", SETS)
    assert walk.is_walk_key(scene, key) is own
    assert find_families("axisymmetric", [scene] * 33, ("magnetic_force",)) == []


@pytest.mark.heavy
@pytest.mark.parametrize("seed", range(10))
def test_bars_of_a_walk_hold_a_better_field(seed):
    """Two sizes, gap and current by chance, walked in any order; the better field's walls are
    farther, too."""
    rng = np.random.default_rng(seed)
    scene, _ = load_scene("reluctance", ["models=axisymmetric", "accuracy=1e-3"])
    keys = rng.choice(["rod.radius", "rod.head_thickness", "coil.turns", "sleeve.length"], 2, False)
    ranges = {
        key: (float(value_of(scene, key)) * 0.95, float(value_of(scene, key))) for key in keys
    }
    ranges |= {"gap": (0.1e-3, 0.2e-3), "coil.current": (0.03, 0.2)}
    found = walk.begin_walk(scene, ranges, ("magnetic_force", "flux_linkage"), 5)
    for _ in range(5):
        there = with_values(scene, {key: rng.uniform(*ends) for key, ends in ranges.items()})
        given, _ = found.solved(there)
        current, gap = there.coil.current, there.gap
        point = solve_point(
            there.device, current, gap, order=5, refinement=1.7, outer_radius=3.0 * OUTER_RADIUS
        )
        for quantity, name in zip(given, ("force", "flux_linkage"), strict=True):
            off = abs(float(quantity.value) - getattr(point, name))
            assert off <= float(quantity.error) + getattr(point.errors, name)


def test_bars_of_maps_leave_room_for_what_two_orders_share(monkeypatch):
    """A bar of the field, or two percent of the value where that is more."""
    names = tuple(map_table._SAMPLES)
    values, bars = dict.fromkeys(names, -3.0), dict.fromkeys(names, 0.01)
    wide = dict.fromkeys(names, 0.5)
    point = SimpleNamespace(**values, errors=SimpleNamespace(**bars))
    open_point = SimpleNamespace(**values, errors=SimpleNamespace(**wide))
    monkeypatch.setattr(actuator, "solve_map", lambda *_, order: [[point, open_point]])
    currents = np.array([0.1, 0.2])
    found = map_table._solved(load_scene("reluctance")[0], currents, np.array([1e-4]))
    for name, counts in map_table._SAMPLES.items():
        value, bar = found[name]
        assert value.tolist() == [[-3.0], [-3.0]]
        assert bar * counts == pytest.approx(np.array([[0.06], [0.5]]))
