"""Parts of a report that another process makes: none is lost, made twice, or made otherwise."""

import pickle
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from tactgen.validation.report.second_process import Ahead
from tactgen.validation.report.sections.contents import alone, made_alone
from tactgen.validation.scene.scene import load_scene


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


@pytest.mark.heavy
def test_all_parts_travel():
    """Each of them, of a whole report with the finger."""
    for scene, quick in (("prototype", True), ("paper", False)):
        loaded, origins = load_scene(scene, ["models=tmm,solid", "mesh.level=1"])
        for name in alone(loaded):
            if name not in ("holding", "stress"):  # minutes of tetrahedra; figures and rows
                pickle.loads(pickle.dumps(made_alone((loaded, origins, quick), name)))


def test_who_has_no_bimorph_has_no_such_parts():
    """The normal actuator's report has none; the machine's, none of what it does not show."""
    assert alone(load_scene("reluctance")[0]) == ()
    assert "length" in alone(load_scene("paper")[0])
    assert "length" not in alone(load_scene("generator")[0])
