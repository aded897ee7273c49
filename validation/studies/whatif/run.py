"""A study is run: what is kept is recalled, the rest is computed, and no failure stops it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.families import Box
from tactgen.validation.engine.plan import check_models
from tactgen.validation.scene.scene import checked_scene
from tactgen.validation.studies.whatif.answers import Answer, Question, question, reason, recall
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.by_family import answers_by_family
from tactgen.validation.studies.whatif.schedule import schedule
from tactgen.validation.studies.whatif.workers import Job, work_through


@dataclass(frozen=True)
class Counts:
    """How many answers were recalled from the store, computed now, failed, and refused.

    `together` of those computed come from reduced bases of families.
    """

    recalled: int
    computed: int
    failed: int
    refused: int
    together: int


@dataclass(frozen=True)
class Study:
    """A statement with its answers.

    Attributes
    ----------
    points : tuple of dict
        Values of the axes by key, in the order of :meth:`Statement.points`.
    answers : tuple of dict
        By model, one for each point.
    """

    statement: Statement
    points: tuple[dict[str, Any], ...]
    answers: tuple[dict[str, Answer], ...]
    counts: Counts

    @property
    def rows(self) -> Iterator[tuple[dict[str, Any], str, Answer]]:
        """Every point with a model and its answer."""
        for point, answers in zip(self.points, self.answers, strict=True):
            for model, found in answers.items():
                yield point, model, found

    @property
    def warnings(self) -> tuple[str, ...]:
        """What must be told of the answers, each sentence once with how many points it is of."""
        found: dict[str, int] = {}
        for _, model, each in self.rows:
            for text in each.warnings:
                found[text] = found.get(text, 0) + 1
            if each.status != "ok":
                text = f"{model} has no answer: {each.reason}"
                found[text] = found.get(text, 0) + 1
        total = len(self.points)
        return tuple(f"at {count} of {total} points: {text}" for text, count in found.items())


def run_study(
    statement: Statement,
    processes: int = 0,
    announce: Callable[[str], None] = lambda _: None,
    *,
    retry: bool = False,
) -> Study:
    """Return the study with every answer, failures among them.

    Parameters
    ----------
    processes : int
        How many work at a time; 0 is one for each processor if a model takes long, else this
        one alone.
    retry : bool
        Whether questions that failed earlier are asked again.

    Raises
    ------
    InputError
        If the axes cannot be used, or no point of them makes a scene.
    """
    check_models(statement.models, statement.quantities)
    points = tuple(statement.points())
    answers, counts = answers_at(statement, points, processes, announce, retry=retry)
    every = [found for each in answers for found in each.values()]
    if all(found.status == "refused" for found in every):
        raise InputError(f"none of the {len(points)} points makes a scene: {every[0].reason}")
    return Study(statement, points, answers, counts)


def answers_at(
    statement: Statement,
    points: Sequence[dict[str, Any]],
    processes: int = 0,
    announce: Callable[[str], None] = lambda _: None,
    *,
    retry: bool = False,
    box: Box | None = None,
) -> tuple[tuple[dict[str, Answer], ...], Counts]:
    """Return the answers by model at any points of a statement's keys, refusals among them.

    Parameters
    ----------
    points : sequence of dict
        Values by key (SI).
    box : dict of str to (float, float), optional
        The range of the keys, if many more points of it will be asked; as of
        :func:`run_study` otherwise.
    """
    asked = _questions(statement, points, announce)
    # points that differ in what a model does not read ask it the same
    different: dict[int, Question] = {}
    place: dict[str, int] = {}
    same: dict[tuple[int, str], int] = {}
    for (number, model), found in asked.items():
        if isinstance(found, Question):
            text = repr((found.model, found.inputs))
            same[number, model] = place.setdefault(text, len(place))
            different.setdefault(same[number, model], found)
    answers = {n: kept for n, q in different.items() if (kept := recall(q, retry=retry))}
    old = len(answers)
    jobs: dict[int, Job] = {}
    for (number, model), n in same.items():
        if n not in answers and n not in jobs:
            jobs[n] = Job(n, different[n], _values(statement, points[number], model))
    together = answers_by_family(list(jobs.values()), announce, box)
    answers.update(together)
    rest = [job for n, job in jobs.items() if n not in together]
    answers.update(_all_answers(rest, processes, announce, retry=retry))
    by_point: list[dict[str, Answer]] = [{} for _ in points]
    for (number, model), given in asked.items():
        by_point[number][model] = (
            given if isinstance(given, Answer) else answers[same[number, model]]
        )
    every = [found for each in by_point for found in each.values()]
    counts = Counts(
        old, len(jobs), sum(a.status == "failed" for a in every),
        sum(a.status == "refused" for a in every), len(together),
    )  # fmt: skip
    return tuple(by_point), counts


def _questions(
    statement: Statement, points: Sequence[dict[str, Any]], announce: Callable[[str], None]
) -> dict[tuple[int, str], Question | Answer]:
    """Return what each model is asked at each point, or why it cannot be asked."""
    found: dict[tuple[int, str], Question | Answer] = {}
    for number, point in enumerate(points):
        if number % 100 == 0:
            announce(f"points checked: {number} of {len(points)}")
        for model in statement.models:
            try:
                scene = checked_scene(_values(statement, point, model))
                found[number, model] = question(scene, model, statement.quantities)
            except InputError as error:
                found[number, model] = Answer("refused", reason(error))
    return found


def _values(statement: Statement, point: dict[str, Any], model: str) -> dict[str, Any]:
    """Return the values of the scene that a model is asked about at a point."""
    return {**statement.scene_at(point), "models": [model], "quantities": ["all"]}


def _all_answers(
    jobs: list[Job], processes: int, announce: Callable[[str], None], *, retry: bool
) -> Iterator[tuple[int, Answer]]:
    """Yield the answers to all jobs; those that another process is at are waited for last."""
    start, total, done = time.monotonic(), len(jobs), 0

    def stage(text: str) -> None:
        announce(f"{done} of {total} answers{_left(start, done, total)}: {text}")

    announce(f"0 of {total} answers")
    for patient in (False, True):
        places = {job.number: place for place, job in enumerate(jobs)}
        batches = schedule(job.asked for job in jobs)
        count = processes or _processes(jobs)
        found = work_through(
            batches, jobs, min(count, max(1, len(batches))), stage, retry=retry, patient=patient
        )
        elsewhere = []
        for number, answered in found:
            if answered is None:
                elsewhere.append(jobs[places[number]])
                continue
            done += 1
            announce(f"{done} of {total} answers{_left(start, done, total)}")
            yield number, answered
        jobs = elsewhere
        if not jobs:
            return


def _processes(jobs: list[Job]) -> int:
    """Return one process for each processor if a model takes long, else one."""
    if all(MODELS[job.asked.model].quick for job in jobs):
        return 1
    return len(os.sched_getaffinity(0))


def _left(start: float, done: int, total: int) -> str:
    """Return the time that is left in words, from the time that was taken."""
    if not done:
        return ""
    seconds = (time.monotonic() - start) * (total - done) / done
    return (
        f", about {seconds:.0f} s left" if seconds < 120 else f", about {seconds / 60:.0f} min left"
    )
