"""Questions are answered here, in processes of this machine, or on a Dask cluster.

Whoever works, the answers are kept one by one as they come, so that a study that is killed goes
on where it was.  A process that dies takes only the question with it that it died of.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.operating_system import core_count
from tactgen.geometry.store.store import library_versions
from tactgen.geometry.units import quoted
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.processes import processes
from tactgen.validation.studies.whatif.point_answers import Question, code_of

#: Most questions of one batch: few enough for progress to be seen.
_MOST = 32
#: Time (s) in which a scheduler must answer, and in which it must have a worker.
PATIENCE = 10.0
#: Time (s) after which a cluster that lost all of its workers is given up.
_DESERTED = 60.0
_ADDRESS = re.compile(r"(tcp|tls|ucx)://[^\s/]+:[0-9]{1,5}")
_MIND = "answers that came are kept; run the study again to go on"

#: In a worker of a cluster: one batch at a time.
_alone = threading.Lock()


@dataclass(frozen=True)
class Batch:
    """Questions by number for one worker, one after another, `after` other batches are done."""

    questions: dict[int, Question]
    after: frozenset[int] = frozenset()


def schedule(asked: Mapping[int, Question]) -> list[Batch]:
    """Batches, each with those that it waits for.

    Questions with the same kept stages, such as one geometry under several loads, go to one
    worker, since all but the first cost little; of a stage that several batches share the first
    of them is waited for.
    """
    groups: dict[tuple[str, tuple[str, ...]], list[int]] = {}
    for number, question in asked.items():
        groups.setdefault((question.model, question.shared), []).append(number)
    batches: list[Batch] = []
    first: dict[str, int] = {}
    for (_, shared), own in groups.items():
        for start in range(0, len(own), _MOST):
            place = len(batches)
            after = {first.setdefault(key, place) for key in shared} - {place}
            some = {number: asked[number] for number in own[start : start + _MOST]}
            batches.append(Batch(some, frozenset(after)))
    return batches


def execute(
    asked: Mapping[int, Question],
    jobs: int = 0,
    scheduler: str = "",
    announce: Callable[[str], None] = lambda _: None,
    *,
    retry: bool = False,
) -> Iterator[tuple[int, Answer]]:
    """Yield the answer to every question by its number as it is there, kept.

    `jobs` processes work at a time (0: one for each processor if a model takes long, else this one
    alone), or the workers of a Dask cluster whose address `scheduler` is.  With `retry` answers
    that are kept as failed give way.

    Raises InputError if the cluster is of no use, or lost.  What came before is kept.
    """
    if not asked:
        return
    batches, done = schedule(asked), 0

    def stage(text: str) -> None:
        announce(f"{done} of {len(asked)} answers: {text}")

    def stored(number: int, given: Answer) -> Answer:
        return asked[number].keep(lambda: given, retry=retry)

    announce(f"0 of {len(asked)} answers")
    models = tuple(dict.fromkeys(question.model for question in asked.values()))
    quick = all(MODELS[model].quick for model in models)
    count = min(jobs or (1 if quick else core_count()), len(batches))
    with contextlib.ExitStack() as stack:
        if scheduler:
            found = _pooled(batches, _connected(scheduler, models, stack))
        elif count > 1:
            found = _pooled(batches, _Processes(count, retry, stack))
        else:
            found = (
                (number, question.keep(partial(question.solve, stage), stage, retry=retry))
                for batch in batches for number, question in batch.questions.items()
            )  # fmt: skip
        for number, given in found:
            done += 1
            announce(f"{done} of {len(asked)} answers")
            if scheduler or given.status == "failed":  # whoever solved it kept nothing, or died
                given = stored(number, given)
            yield number, given


def _pooled(batches: Sequence[Batch], pool: Any) -> Iterator[tuple[int, Answer]]:
    """Yield the answers of a pool's workers; questions of a dead one are asked one by one."""
    left, done = dict(enumerate(batches)), set[int]()
    running: dict[Any, tuple[int, dict[int, Question]]] = {}
    suspects: dict[int, Question] = {}
    while left or running or suspects:
        ready = [place for place, batch in left.items() if batch.after <= done]
        for place in ready[: pool.most - len(running)]:
            batch = left.pop(place)
            running[pool.begin([*batch.questions.values()])] = place, batch.questions
        if not running:
            number, question = suspects.popitem()
            running[pool.begin([question])] = -1, {number: question}
        for future in pool.ended(running):
            place, asked = running.pop(future)
            answers = pool.result(future)
            done.add(place)
            if answers is None and place >= 0:
                suspects |= asked
            elif answers is None:
                yield next(iter(asked)), Answer("failed", pool.death)
            else:
                yield from zip(asked, answers, strict=True)


# -- processes of this machine ------------------------------------------------------------------


class _Processes:
    """Processes that keep their answers; when one dies the others are started anew."""

    death = (
        "the process that solved it was ended from outside, which is what happens when memory runs "
        "out; take fewer --jobs or a coarser mesh"
    )

    def __init__(self, count: int, retry: bool, stack: contextlib.ExitStack) -> None:
        self.most, self._count, self._retry, self._stack = 2 * count, count, retry, stack
        self._pool = stack.enter_context(processes(count))

    def begin(self, questions: Sequence[Question]) -> Future[list[Answer]]:
        try:
            return self._pool.submit(_in_process, questions, self._retry)
        except BrokenProcessPool:
            self._stack.close()
            self._pool = self._stack.enter_context(processes(self._count))
            return self._pool.submit(_in_process, questions, self._retry)

    def ended(self, running: Iterable[Future[list[Answer]]]) -> Iterable[Future[list[Answer]]]:
        return wait(running, return_when=FIRST_COMPLETED).done

    def result(self, future: Future[list[Answer]]) -> list[Answer] | None:
        try:
            return future.result()
        except BrokenProcessPool:
            return None


def _in_process(questions: Sequence[Question], retry: bool) -> list[Answer]:
    return [question.keep(question.solve, retry=retry) for question in questions]


# -- a Dask cluster -----------------------------------------------------------------------------


#: Version of tactgen, hash of each model's code, and libraries of a process.
Build = tuple[str, ...]


def build(models: Sequence[str]) -> Build:
    """Build of this process for some models."""
    code = (f"code {code_of(model)} of {model}" for model in models)
    return (f"tactgen {version('tactgen')}", *code, *library_versions())


def check_address(address: str) -> str:
    """Address of a scheduler; InputError if it is none."""
    if not _ADDRESS.fullmatch(address):
        raise InputError(
            f"--scheduler {quoted(address)} is not the address of a Dask scheduler; write for "
            "example --scheduler tcp://127.0.0.1:8786"
        )
    return address


def check_workers(own: Build, workers: Mapping[str, Build | Exception]) -> None:
    """Refuse workers that would give other answers than this process.

    Raises InputError with the first of them and what to do.
    """
    for name, theirs in workers.items():
        if theirs == own:
            continue
        if isinstance(theirs, Exception):
            what = f"cannot run this tactgen ({theirs})"
        else:
            others = [part for part in theirs if part not in own]
            what = f"has {', '.join(others)}, other than here"
        raise InputError(
            f"the worker {name} {what}, so that its answers would differ; install the same there, "
            "or start the cluster without it"
        )


def _connected(address: str, models: Sequence[str], stack: contextlib.ExitStack) -> _Cluster:
    """Workers of a scheduler, until the stack closes; InputError if there are none of use."""
    try:
        from distributed import Client
    except ImportError:
        raise InputError(
            "--scheduler needs Dask, which is not installed; run: pip install -e '.[cluster]'"
        ) from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # its troubles are told here
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise InputError(
            f"no Dask scheduler answers at {address} within {PATIENCE:g} s "
            f"({type(error).__name__}); start one with dask scheduler, or leave --scheduler out"
        ) from None
    stack.callback(client.close, timeout=PATIENCE)
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        raise InputError(
            f"the scheduler at {address} has no worker after {PATIENCE:g} s; start some with "
            f"dask worker {address} --nthreads 1"
        ) from None
    own = build(models)
    check_workers(own, client.run(build, models, on_error="return"))
    return _Cluster(client, models, own)


class _Cluster:
    """The workers of a cluster, which keep nothing."""

    most = 1_000_000
    death = (
        "every worker of the cluster that solved it was ended from outside, which is what happens "
        "when memory runs out; give the workers more of it or take a coarser mesh"
    )

    def __init__(self, client: Any, models: Sequence[str], own: Build) -> None:
        self._client, self._models, self._own = client, models, own

    def begin(self, questions: Sequence[Question]) -> Any:
        return self._client.submit(_in_cluster, questions, self._models, pure=False)

    def ended(self, running: Iterable[Any]) -> list[Any]:
        """Finished futures; InputError if the cluster is lost."""
        deserted = time.monotonic() + _DESERTED
        while True:
            ended = [future for future in running if future.done()]
            if ended:
                return ended
            if self._client.status != "running":
                raise InputError(f"the scheduler ended; {_MIND}")
            if self._client.nthreads():
                deserted = time.monotonic() + _DESERTED
            elif time.monotonic() > deserted:
                raise InputError(f"the cluster has had no worker for {_DESERTED:g} s; {_MIND}")
            time.sleep(0.02)

    def result(self, future: Any) -> list[Answer] | None:
        from distributed import KilledWorker

        try:
            theirs, answers = future.result(timeout=PATIENCE)
        except KilledWorker:
            return None
        except Exception as error:  # noqa: BLE001  (whatever a lost cluster raises)
            raise InputError(
                f"the cluster was lost ({type(error).__name__}: {str(error)[:200]}); {_MIND}"
            ) from None
        check_workers(self._own, {"that joined the cluster": theirs})
        found: list[Answer] = answers
        return found


def _in_cluster(questions: Sequence[Question], models: Sequence[str]) -> tuple[Build, list[Answer]]:
    """Solve a batch in a worker, with one solver thread, as local processes do."""
    os.environ["TACTGEN_THREADS"] = "1"
    with _alone:
        return build(models), [question.solve() for question in questions]
