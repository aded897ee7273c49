"""What another process begins while the report is solved."""

import pickle
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool

import pytest

from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.contents import work_ahead
from tactgen.validation.scene.load import load_scene


def study(name, *, quick=False):
    scene, origins = load_scene(name)
    return Study(scene, origins, lambda _: None, quick=quick)


@pytest.mark.parametrize(("name", "quick", "begun"), [
    ("paper", False, {"uncertainty", "bridge", "measurements"}),
    ("generator", False, {"uncertainty", "amplitude", "measurements"}),
    ("j1", False, {"uncertainty", "bridge"}),
    ("paper", True, set()), ("reluctance", False, set()),
])  # fmt: skip
def test_only_what_follows_from_the_scene_alone_is_begun(name, quick, begun):
    """And it can be sent: functions of modules, and scenes."""
    jobs = work_ahead(study(name, quick=quick))
    assert set(jobs) == begun
    for work, *given in jobs.values():
        assert pickle.loads(pickle.dumps(work)) is work
        assert pickle.loads(pickle.dumps(given)) == given


def test_what_was_not_begun_or_whose_process_died_is_done_here():
    made = study("paper")
    assert made.begun("measurements", lambda: "here") == "here"
    done, died, wrong = Future(), Future(), Future()
    done.set_result("there")
    died.set_exception(BrokenProcessPool())
    wrong.set_exception(ValueError("its own"))
    made._begun = {"done": done, "died": died, "wrong": wrong}
    assert made.begun("done", lambda: "here") == "there"
    assert made.begun("died", lambda: "here") == "here"
    with pytest.raises(ValueError, match="its own"):
        made.begun("wrong", lambda: "here")
