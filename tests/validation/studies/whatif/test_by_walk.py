"""Points that are walked through: what they share, walks side by side, what is left out."""

import itertools
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.results import Quantity
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.whatif import by_walk

SCENE = load_scene("reluctance")[0]
FORCE = ("magnetic_force",)


@pytest.fixture
def threads(monkeypatch):
    """Let threads do what processes do; return how many were asked for."""
    asked = []

    def workers(count):
        asked.append(count)
        return ThreadPoolExecutor(count)

    monkeypatch.setattr(by_walk, "Workers", workers)
    return asked


@pytest.mark.parametrize(("processes", "pools"), [(1, []), (2, [2]), (8, [3])])
def test_what_is_shared_is_prepared_side_by_side(threads, processes, pools):
    """A part that fails is tried again with all of it."""
    done, said = [], []

    def part(number):
        done.append(number)
        if number == 1:
            raise InputError("no")

    parts = [lambda number=number: part(number) for number in range(3)]
    route = Stub(model="axisymmetric", shared_parts=lambda _: parts)
    route.prepare = lambda quantities, announce: done.append(quantities)
    by_walk._prepare(route, FORCE, processes, said.append)
    assert threads == pools
    assert (sorted(done[:-1]), done[-1]) == ([0, 1, 2] if pools else [], FORCE)
    assert said == ["axisymmetric: 3 parts of what the points share"] * len(pools)


def test_where_nothing_can_be_shared_it_is_said(threads):
    def refused(*_):
        raise InputError("the map is too wide")

    said = []
    route = Stub(model="axisymmetric", shared_parts=lambda _: [], prepare=refused)
    by_walk._prepare(route, FORCE, 2, said.append)
    assert said == ["axisymmetric: nothing is shared, since the map is too wide"]


@pytest.mark.parametrize("processes", [1, 2])
def test_every_walk_gives_what_it_could_answer(threads, processes, monkeypatch):
    """A point that cannot be solved is left to be asked alone, and a walk whose process died."""
    force = Quantity(
        name=FORCE[0],
        model="axisymmetric",
        value=np.array(0.1),
        unit="N",
        error=np.array(0.0),
        method="",
        seconds=0.0,
    )
    failing = itertools.cycle([None, InputError("no"), SolverError("no"), None])

    def solved(scene):
        error = next(failing)
        if error is not None:
            raise error
        return (force,), ("told",)

    route = Stub(model="axisymmetric", begin=lambda _: Stub(solved=solved))
    walks = [[(number, SCENE) for number in range(4)], [(9, SCENE)]]
    walk = by_walk._walk

    def one_dies(route, quantities, part, announce=lambda _: None):
        if processes > 1 and len(part) == 1:
            raise BrokenProcessPool
        return walk(route, quantities, part, announce)

    monkeypatch.setattr(by_walk, "_walk", one_dies)
    found = {}
    for part in by_walk._walked(route, FORCE, walks, processes, lambda _: None):
        found |= part
    assert sorted(found) == ([0, 3, 9] if processes == 1 else [0, 3])
    assert all(each.quantities == (force,) for each in found.values())
    assert all("told" in each.warnings and each.seconds >= 0.0 for each in found.values())
    assert threads == ([2] if processes > 1 else [])
