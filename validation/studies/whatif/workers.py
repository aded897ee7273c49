"""Batches of questions in this process or in others, which end with it however it ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tactgen.validation.engine.answers import Answer
from tactgen.validation.studies.processes import Workers
from tactgen.validation.studies.whatif.answers import Busy, Question, answer
from tactgen.validation.studies.whatif.schedule import Batch

if TYPE_CHECKING:
    from tactgen.validation.engine.solve import Solution


@dataclass(frozen=True)
class Job:
    """A question with the scene that it is asked at."""

    number: int
    asked: Question
    values: dict[str, Any]


#: An answer by the number of its job; None if another process is at it.
Found = tuple[int, Answer | None]
#: Of this process, by model: what the next question may take over.
_earlier: dict[str, Solution] = {}


def work_through(
    batches: Sequence[Batch],
    jobs: Sequence[Job],
    processes: int,
    announce: Callable[[str], None],
    *,
    retry: bool,
    patient: bool,
) -> Iterator[Found]:
    """Yield the answer to every job as it is there.

    Parameters
    ----------
    batches : sequence of Batch
        Their numbers are places in `jobs`.
    processes : int
        How many work at a time; one is this process.
    retry, patient : bool
        See :func:`validation.studies.whatif.answers.answer`.
    """
    if processes == 1:
        for batch in batches:
            for number in batch.numbers:
                yield _answered(jobs[number], announce, retry=retry, patient=patient)
        return
    yield from _Pool(batches, jobs, processes, retry, patient).found()


def _answered(job: Job, announce: Callable[[str], None], *, retry: bool, patient: bool) -> Found:
    try:
        found = answer(job.asked, job.values, announce, _earlier, retry=retry, patient=patient)
    except Busy:
        return job.number, None
    return job.number, found


class _Pool:
    """Processes that work on batches; a process that dies takes only its own batch with it."""

    def __init__(
        self,
        batches: Sequence[Batch],
        jobs: Sequence[Job],
        processes: int,
        retry: bool,
        patient: bool,
    ) -> None:
        self.batches, self.jobs, self.processes = batches, jobs, processes
        self.options = {"retry": retry, "patient": patient}

    def found(self) -> Iterator[Found]:
        """Yield all answers."""
        waiting = list(range(len(self.batches)))
        suspects: list[int] = []
        done: set[int] = set()
        while waiting:
            for place, found in self._run(waiting, done, suspects, self.processes):
                done.add(place)
                waiting.remove(place)
                yield from found
            # a process died, and with it the pool: who did it shows when each is alone
            for place in suspects:
                waiting.remove(place)
                for number in self.batches[place].numbers:
                    yield self._alone(number)
                done.add(place)
            suspects.clear()

    def _run(
        self, waiting: Sequence[int], done: set[int], suspects: list[int], processes: int
    ) -> Iterator[tuple[int, list[Found]]]:
        """Yield batches that were worked through; of a pool that broke note what was in it."""
        left = list(waiting)
        running: dict[Future[list[Found]], int] = {}
        with Workers(processes) as pool:
            while left or running:
                ready = [place for place in left if self.batches[place].after <= done]
                try:
                    for place in ready[: 2 * processes - len(running)]:
                        work = [self.jobs[number] for number in self.batches[place].numbers]
                        running[pool.submit(_worked_through, work, self.options)] = place
                        left.remove(place)
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        found = future.result()
                        yield running.pop(future), found
                except BrokenProcessPool:
                    suspects += running.values()
                    return

    def _alone(self, number: int) -> Found:
        """Return one answer from a process of its own, whose death is the answer."""
        with Workers(1) as pool:
            try:
                (found,) = pool.submit(_worked_through, [self.jobs[number]], self.options).result()
            except BrokenProcessPool:
                return number, Answer(
                    "failed",
                    "the process that solved it was ended from outside, which is what happens when "
                    "memory runs out; take fewer --jobs or a coarser mesh",
                )
        return found


def _worked_through(jobs: Sequence[Job], options: dict[str, bool]) -> list[Found]:
    return [_answered(job, lambda _: None, **options) for job in jobs]
