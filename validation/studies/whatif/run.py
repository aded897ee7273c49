"""A study is run: what is kept is recalled, the rest is computed, and no failure stops it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.families import Box
from tactgen.validation.engine.plan import check_models
from tactgen.validation.studies.whatif.answers import recall, refuse_if_no_scene
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.by_family import answers_by_family
from tactgen.validation.studies.whatif.by_walk import answers_by_walk
from tactgen.validation.studies.whatif.cluster import found_on_cluster
from tactgen.validation.studies.whatif.questions import questions, scenes_nearby
from tactgen.validation.studies.whatif.schedule import schedule
from tactgen.validation.studies.whatif.sweep import sweep
from tactgen.validation.studies.whatif.workers import Found, Job, work_through

_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")
#: Of sentences that differ in their numbers, the first is told.
_OTHERS = " (other numbers at other points)"


@dataclass(frozen=True)
class Counts:
    """How many answers were recalled from the store, computed now, failed, and refused.

    `together` of those computed come from reduced bases of families; `walked` each from others.
    """

    recalled: int
    computed: int
    failed: int
    refused: int
    together: int
    walked: int = 0


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
        """What must be told of the answers, each sentence once with how many points it is of.

        Sentences that differ in their numbers alone are one.
        """
        found: dict[str, list[str]] = {}
        unbounded = [a.key for a in self.statement.axes if a.drawn and a.drawn.kind == "normal"]
        for _, model, each in self.rows:
            texts = list(each.warnings)
            if each.status != "ok":
                text = f"{model} has no answer: {each.reason}"
                for key in unbounded:
                    if each.reason.startswith(f"{key} = "):
                        text += f", or draw {key} with a smaller deviation"
                texts.append(text)
            for text in texts:
                found.setdefault(_NUMBER.sub("#", text), []).append(text)
        total = len(self.points)
        return tuple(
            f"at {len(texts)} of {total} points{_OTHERS if len(set(texts)) > 1 else ''}: {texts[0]}"
            for texts in found.values()
        )


def run_study(
    statement: Statement,
    processes: int = 0,
    announce: Callable[[str], None] = lambda _: None,
    *,
    retry: bool = False,
    scheduler: str = "",
) -> Study:
    """Return the study with every answer, failures among them.

    Parameters
    ----------
    processes : int
        How many work at a time; 0 is one for each processor if a model takes long, else this
        one alone.
    retry : bool
        Whether questions that failed earlier are asked again.
    scheduler : str
        Address of a Dask cluster whose workers solve what is not kept; empty for this machine.

    Raises
    ------
    InputError
        If the axes cannot be used, no point of them makes a scene, or the cluster is of no use.
    """
    check_models(statement.models, statement.quantities)
    points = tuple(statement.points())
    answers, counts = answers_at(
        statement, points, processes, announce, retry=retry, scheduler=scheduler
    )
    refuse_if_no_scene(len(points), [found for each in answers for found in each.values()])
    return Study(statement, points, answers, counts)


def answers_at(
    statement: Statement,
    points: Sequence[dict[str, Any]],
    processes: int = 0,
    announce: Callable[[str], None] = lambda _: None,
    *,
    retry: bool = False,
    box: Box | None = None,
    scheduler: str = "",
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
    nearby = scenes_nearby(statement)
    read_off: dict[tuple[int, str], Answer] = {}
    together = 0
    for model in statement.models:
        swept = sweep(model, statement.quantities, points, nearby[model], announce, box)
        read_off |= {(number, model): answer for number, answer in swept.answers.items()}
        together += swept.different
    asked = questions(statement, points, nearby, read_off, announce)
    different = asked.different
    answers = {n: kept for n, q in different.items() if (kept := recall(q, retry=retry))}
    old = len(answers)
    new = {n: q for n, q in different.items() if n not in answers}
    shared = {n: (q, asked.scenes[n]) for n, q in new.items() if n in asked.scenes}
    by_family = answers_by_family(shared, announce, box)
    rest = {n: each for n, each in shared.items() if n not in by_family and not scheduler}
    by_walk = answers_by_walk(rest, processes, announce, box, retry=retry)
    answers.update(by_family | by_walk)
    computed, together = len(new) + together, len(by_family) + together
    jobs = [
        Job(n, q, nearby[q.model].values(asked.first[n]))
        for n, q in new.items() if n not in answers
    ]  # fmt: skip
    if scheduler and jobs:
        found_there = found_on_cluster(
            schedule(job.asked for job in jobs), jobs, scheduler, retry=retry
        )
        answers.update(_told(found_there, len(jobs), announce))
    else:
        answers.update(_all_answers(jobs, processes, announce, retry=retry))
    given = read_off | asked.at

    def of(place: tuple[int, str]) -> Answer:
        found = given[place]
        return found if isinstance(found, Answer) else answers[found]

    by_point = [{m: of((number, m)) for m in statement.models} for number in range(len(points))]
    every = [found for each in by_point for found in each.values()]
    counts = Counts(
        old, computed, sum(a.status == "failed" for a in every),
        sum(a.status == "refused" for a in every), together,
        len(by_walk),
    )  # fmt: skip
    return tuple(by_point), counts


def _all_answers(
    jobs: list[Job], processes: int, announce: Callable[[str], None], *, retry: bool
) -> Iterator[tuple[int, Answer]]:
    """Yield the answers to all jobs; those that another process is at are waited for last."""
    if not jobs:
        return
    total, done = len(jobs), 0

    def stage(text: str) -> None:
        announce(f"{done} of {total} answers: {text}")

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
            announce(f"{done} of {total} answers")
            yield number, answered
        jobs = elsewhere
        if not jobs:
            return


def _told(
    found: Iterator[Found], total: int, announce: Callable[[str], None]
) -> Iterator[tuple[int, Answer]]:
    """Yield the answers from a cluster, and say how many there are."""
    announce(f"0 of {total} answers")
    for done, (number, answered) in enumerate(found, start=1):
        assert answered is not None
        announce(f"{done} of {total} answers")
        yield number, answered


def _processes(jobs: list[Job]) -> int:
    """Return one process for each processor if a model takes long, else one."""
    if all(MODELS[job.asked.model].quick for job in jobs):
        return 1
    return len(os.sched_getaffinity(0))
