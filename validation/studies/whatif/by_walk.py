"""Points that a model solves one after another, each from those before; several walks at a time."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import as_completed, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import replace

from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.families import Box
from tactgen.validation.engine.walks import Route, find_routes
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.processes import Workers
from tactgen.validation.studies.whatif.answers import Question, keep
from tactgen.validation.studies.whatif.by_family import answer_with_warnings

#: Points of a walk: their numbers and scenes.
_Part = list[tuple[int, Scene]]


def answers_by_walk(
    asked: Mapping[int, tuple[Question, Scene]],
    processes: int,
    announce: Callable[[str], None],
    box: Box | None = None,
    *,
    retry: bool = False,
) -> dict[int, Answer]:
    """Return the answers to the questions that are solved each from others, by their numbers.

    Each is kept as a walk ends.  What a walk cannot solve is left out.

    Parameters
    ----------
    processes : int
        How many walks go at a time; 0 is one for each processor.
    box : dict of str to (float, float), optional
        The range of keys of which more will be asked.
    retry : bool
        Whether an answer that is kept as failed gives way.
    """
    count = processes or len(os.sched_getaffinity(0))
    found: dict[int, Answer] = {}
    for numbers, route in routes(asked, box):
        quantities = asked[numbers[0]][0].quantities
        announce(route.reason)
        _prepare(route, quantities, count, announce)
        walks = [[(numbers[n], asked[numbers[n]][1]) for n in part] for part in route.parts()]
        for part in _walked(route, quantities, walks, count, announce):
            found |= {n: keep(asked[n][0], answer, retry=retry) for n, answer in part.items()}
            if part:
                route.took(quantities, sum(a.seconds for a in part.values()) / len(part))
            announce(f"{route.model}: {len(found)} of {len(asked)} points")
    return found


def routes(
    asked: Mapping[int, tuple[Question, Scene]], box: Box | None = None
) -> Iterator[tuple[list[int], Route]]:
    """Yield routes through the questions, each with the numbers that its places stand for."""
    groups: dict[tuple[str, tuple[str, ...]], list[int]] = {}
    for number, (question, _) in asked.items():
        groups.setdefault((question.model, question.quantities), []).append(number)
    for (model, _), numbers in groups.items():
        for route in find_routes(model, [asked[number][1] for number in numbers], box):
            yield numbers, route


def _prepare(
    route: Route, quantities: tuple[str, ...], processes: int, announce: Callable[[str], None]
) -> None:
    """Compute what all walks share, side by side where that can be."""
    try:
        parts = route.shared_parts(quantities)
        if min(processes, len(parts)) > 1:
            announce(f"{route.model}: {len(parts)} parts of what the points share")
            with Workers(min(processes, len(parts))) as pool:
                wait([pool.submit(part) for part in parts])  # what fails is tried again below
        route.prepare(quantities, announce)
    except InputError as error:
        announce(f"{route.model}: nothing is shared, since {error}")


def _walked(
    route: Route,
    quantities: tuple[str, ...],
    walks: Sequence[_Part],
    processes: int,
    announce: Callable[[str], None],
) -> Iterator[dict[int, Answer]]:
    if min(processes, len(walks)) < 2:
        for part in walks:
            yield _walk(route, quantities, part, announce)
        return
    with Workers(min(processes, len(walks))) as pool:
        for done in as_completed([pool.submit(_walk, route, quantities, each) for each in walks]):
            with suppress(BrokenProcessPool):  # ended from outside: its points are asked alone
                yield done.result()


def _walk(
    route: Route,
    quantities: tuple[str, ...],
    part: _Part,
    announce: Callable[[str], None] = lambda _: None,
) -> dict[int, Answer]:
    """Return the answers of one walk."""
    walk = route.begin(quantities)
    found: dict[int, Answer] = {}
    for number, scene in part:
        announce(f"{route.model}: point {len(found) + 1} of {len(part)} of a walk")
        start = time.perf_counter()
        try:
            given, warnings = walk.solved(scene)
        except (InputError, SolverError):
            continue  # asked alone, it says why
        answer = answer_with_warnings(scene, route.model, given, warnings)
        if answer is not None:
            found[number] = replace(answer, seconds=time.perf_counter() - start)
    return found
