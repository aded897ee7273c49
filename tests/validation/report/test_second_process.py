"""Parts of a report that another process makes: none is lost, made twice, or made otherwise."""

import os
import pickle
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tactgen.fem.solvers.pardiso import VARIABLE
from tactgen.validation.engine.solve import solve
from tactgen.validation.report import study
from tactgen.validation.report.request import prepared
from tactgen.validation.report.second_process import Ahead, ahead
from tactgen.validation.report.sections.contents import alone, made_alone, made_apart
from tactgen.validation.report.study import Study
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.parameter_uncertainty import targets


def test_parts_come_from_there_or_from_here():
    """Begun there: taken from there.  Not begun, failed there or unknown there: made here."""
    may_go_on, made = threading.Event(), []

    def make(asked, name):
        made.append(name)
        if name == "slow":
            assert may_go_on.wait(60.0)
        if name == "broken":
            raise OSError(name)
        return asked, name

    with ThreadPoolExecutor(1) as pool:
        other = Ahead(pool, make, "scene", ["slow", "taken", "broken", "last"])
        assert other.take("taken", lambda: "here") == "here"  # not begun: no waiting for it
        assert other.take("unknown", lambda: "here") == "here"
        may_go_on.set()
        assert other.take("slow", lambda: "here") == ("scene", "slow")
        while "last" not in made:
            threading.Event().wait(1e-3)
        assert other.take("broken", lambda: "here") == "here"
        assert other.take("last", lambda: "here") == ("scene", "last")
    assert made == ["slow", "broken", "last"]


def test_two_processes_share_the_cores(monkeypatch):
    """While the other is at work the solver here leaves it a core, whatever else was said."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2})
    for said, meant in (("", "2"), ("1", "1"), ("8", "2")):
        monkeypatch.setenv(VARIABLE, said)
        with ahead("scene", str, ["part"]) as other:
            assert os.environ[VARIABLE] == meant
            other._left.clear()
        assert os.environ.get(VARIABLE, "") == said


def test_who_waits_makes_what_is_left():
    """In an order of its own, also what only this process makes; nothing begun; once each."""
    may_go_on, here = threading.Event(), []

    def make(asked, name):
        assert may_go_on.wait(60.0)
        return name

    def meanwhile(name):
        here.append(name)
        if name == "shorter":  # the other part is done while this one is made
            may_go_on.set()
            other._begun["long"].result()
        return name.upper()

    with ThreadPoolExecutor(1) as pool:
        other = Ahead(pool, make, "scene", ["long", "next", "shorter", "shortest"])
        other.meanwhile(meanwhile, ["mine", "long", "shortest", "shorter"])
        assert other.take("long", pytest.fail) == "long"
        assert here == ["mine", "shortest", "shorter"]
        assert [other.take(name, pytest.fail) for name in here] == [n.upper() for n in here]
        assert other.take("next", pytest.fail) == "next"


def test_a_model_solved_elsewhere_is_not_solved_here(monkeypatch):
    """Its quantities, and what its stages gave and cost, come from there."""
    scene, origins = load_scene("prototype", ["models=lumped,tmm,beam"])
    monkeypatch.setattr(study, "model_apart", lambda _: "beam")
    scene = prepared(scene, quick=True)
    found = pickle.loads(pickle.dumps(made_apart(Study(scene, origins, str, quick=True), "beam")))
    whole, steps = solve(scene), []
    with ThreadPoolExecutor(1) as pool:
        other = Ahead(pool, lambda _, name: found, "scene", ["beam"])
        here = Study(scene, origins, steps.append, quick=True, ahead=other)
        solution = here.solution
    assert [(q.name, q.model) for q in solution.quantities] == [
        (q.name, q.model) for q in whole.quantities
    ]
    for ours, theirs in zip(solution.quantities, whole.quantities, strict=True):
        np.testing.assert_array_equal(ours.value, theirs.value)
        np.testing.assert_array_equal(ours.error, theirs.error)
    assert solution.warnings == whole.warnings
    assert not any(step.startswith("beam.") for step in steps)
    assert set(solution.stages.seconds) == set(whole.stages.seconds)
    assert solution.stages.seconds["beam.ports"] == found.stages.seconds["beam.ports"]


def _travels(name, *, quick):
    scene, origins = load_scene("prototype", ["models=lumped,tmm"])
    assert name in alone(scene)
    found = made_alone((scene, origins, quick), name)
    again = pickle.loads(pickle.dumps(found))
    assert (again is None) == (found is None)
    return again


@pytest.mark.usefixtures("undrawn")
def test_a_part_travels():
    """What a section shows survives the way between processes."""
    found = _travels("audit", quick=True)
    assert len(found["audit"].rows) > 10


def test_a_headline_number_travels_with_its_row():
    """Its row of the catalogue holds functions, so it is found again by its name."""
    for target in targets(load_scene("paper")[0]):
        again = pickle.loads(pickle.dumps(target))
        assert again == target
        assert again.quantity is target.quantity


@pytest.mark.heavy
def test_all_parts_travel():
    """Each of them, of a whole report with the finger."""
    for scene, quick in (("prototype", True), ("paper", False)):
        loaded, origins = load_scene(scene, ["models=tmm,solid", "mesh.level=1"])
        for name in alone(loaded):
            if name != "stress":  # figures and rows
                pickle.loads(pickle.dumps(made_alone((loaded, origins, quick), name)))


def test_who_has_no_bimorph_has_no_such_parts():
    """The normal actuator's report has none; the machine's, none of what it does not show."""
    assert alone(load_scene("reluctance")[0]) == ()
    assert "length" in alone(load_scene("paper")[0])
    assert "length" not in alone(load_scene("generator")[0])


def test_who_does_not_wait_makes_nothing_ahead():
    """What is done there is taken at once."""
    with ThreadPoolExecutor(1) as pool:
        other = Ahead(pool, lambda _, name: name, "scene", ["done"])
        other._begun["done"].result()
        other.meanwhile(pytest.fail, ["mine"])
        assert other.take("done", pytest.fail) == "done"
