"""Batches of questions on the workers of a Dask cluster.

The workers solve; what comes back is kept by this process, in its own store, as it comes.
"""

from __future__ import annotations

import contextlib
import logging
import os
import queue
import re
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import library_versions
from tactgen.geometry.units import quoted
from tactgen.validation.engine.answers import Answer
from tactgen.validation.studies.whatif.answers import code_of, keep, solved
from tactgen.validation.studies.whatif.schedule import Batch
from tactgen.validation.studies.whatif.workers import Found, Job

if TYPE_CHECKING:
    from tactgen.validation.engine.solve import Solution

#: Time (s) in which a scheduler must answer, and in which it must have a worker.
PATIENCE = 10.0
#: Time (s) after which a cluster that lost all of its workers is given up.
_DESERTED = 60.0
_ADDRESS = re.compile(r"(tcp|tls|ucx)://[^\s/]+:[0-9]{1,5}")
_MIND = "answers that came are kept; run the study again to go on"

#: In a worker: one batch at a time, and by model what the next question may take over.
_alone = threading.Lock()
_earlier: dict[str, Solution] = {}


@dataclass(frozen=True)
class Build:
    """What answers are computed by: version, hash of each model's code, numerical libraries."""

    version: str
    code: tuple[str, ...]
    libraries: tuple[str, ...]


def build(models: Sequence[str]) -> Build:
    """Return what this process computes the answers of models by."""
    return Build(version("tactgen"), tuple(map(code_of, models)), library_versions())


def check_address(address: str) -> str:
    """Return the address of a scheduler; InputError if it is none."""
    if not _ADDRESS.fullmatch(address):
        raise InputError(
            f"--scheduler {quoted(address)} is not the address of a Dask scheduler; write for "
            "example --scheduler tcp://127.0.0.1:8786"
        )
    return address


def found_on_cluster(
    batches: Sequence[Batch], jobs: Sequence[Job], address: str, *, retry: bool
) -> Iterator[Found]:
    """Yield the answer to every job as it comes from the cluster.

    A batch whose worker dies is solved by another; a question that every worker dies of fails.

    Raises
    ------
    InputError
        If no scheduler answers, it has no workers, one of them has another tactgen or other
        numerical libraries, or the cluster is lost.  What came before is kept.
    """
    models = tuple(dict.fromkeys(job.asked.model for job in jobs))
    with _connected(address) as client:
        own = build(models)
        check_workers(own, _builds(client, models))
        waiting = [(place, batch.numbers) for place, batch in enumerate(batches)]
        left, done = dict(waiting), set[int]()
        running = _Running(client, models)
        while left or running.count:
            for place in [p for p in left if batches[p].after <= done]:
                numbers = left.pop(place)
                running.submit(place, numbers, [jobs[n] for n in numbers])
            place, numbers, result = running.next()
            if result is None and len(numbers) > 1:  # which of them it is shows one by one
                for number in numbers:
                    running.submit(place, (number,), [jobs[number]])
                continue
            done.add(place)
            if result is None:
                yield jobs[numbers[0]].number, keep(jobs[numbers[0]].asked, _died(), retry=retry)
                continue
            theirs, answers = result
            check_workers(own, {"that joined the cluster": theirs})
            for number, answer in zip(numbers, answers, strict=True):
                yield jobs[number].number, keep(jobs[number].asked, answer, retry=retry)


def check_workers(own: Build, workers: Mapping[str, Build | Exception]) -> None:
    """Refuse workers that would give other answers than this process.

    Raises
    ------
    InputError
        With the first of them and what to do.
    """
    for name, theirs in workers.items():
        if theirs == own:
            continue
        if not isinstance(theirs, Build):
            what = f"cannot run this tactgen ({theirs})"
        elif theirs.version != own.version:
            what = f"has tactgen {theirs.version}, and this is {own.version}"
        elif theirs.code != own.code:
            what = f"has other code of tactgen {own.version} than this"
        else:
            others = set(theirs.libraries) - set(own.libraries)
            what = f"has {', '.join(sorted(others))}, other than here"
        raise InputError(
            f"the worker {name} {what}, so that its answers would differ; install the same there, "
            "or start the cluster without it"
        )


def _builds(client: Any, models: Sequence[str]) -> dict[str, Build | Exception]:
    found: dict[str, Build | Exception] = client.run(build, models, on_error="return")
    return found


@contextlib.contextmanager
def _connected(address: str) -> Iterator[Any]:
    """Give the client of a scheduler that has workers; InputError otherwise."""
    try:
        from distributed import Client
    except ImportError:
        raise InputError(
            "--scheduler needs Dask, which is not installed; pip install 'tactgen[cluster]'"
        ) from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # its troubles are told here
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise InputError(
            f"no Dask scheduler answers at {address} within {PATIENCE:g} s "
            f"({type(error).__name__}); start one with dask scheduler, or leave --scheduler out"
        ) from None
    try:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise InputError(
                f"the scheduler at {address} has no worker after {PATIENCE:g} s; start some with "
                f"dask worker {address} --nthreads 1"
            ) from None
        yield client
    finally:
        client.close(timeout=PATIENCE)


class _Running:
    """Batches that the cluster is at."""

    def __init__(self, client: Any, models: Sequence[str]) -> None:
        self._client, self._models = client, models
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._of: dict[str, tuple[int, tuple[int, ...], Any]] = {}

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self._of)

    def submit(self, place: int, numbers: tuple[int, ...], work: Sequence[Job]) -> None:
        """Give the cluster a batch, or a part of it."""
        future = self._client.submit(_worked, list(work), self._models, pure=False)
        self._of[future.key] = (place, numbers, future)
        future.add_done_callback(self._ended.put)

    def next(self) -> tuple[int, tuple[int, ...], tuple[Build, list[Answer]] | None]:
        """Return the next that ended, None for its result if all workers die of it.

        Raises
        ------
        InputError
            If the cluster is lost.
        """
        from distributed import KilledWorker

        place, numbers, future = self._of.pop(self._await().key)
        try:
            return place, numbers, future.result(timeout=PATIENCE)
        except KilledWorker:
            return place, numbers, None
        except Exception as error:  # noqa: BLE001  (whatever a lost cluster raises)
            raise InputError(
                f"the cluster was lost ({type(error).__name__}: {str(error)[:200]}); {_MIND}"
            ) from None

    def _await(self) -> Any:
        deserted = time.monotonic() + _DESERTED
        while True:
            try:
                return self._ended.get(timeout=1.0)
            except queue.Empty:
                pass
            if self._client.status != "running":
                raise InputError(f"the scheduler ended; {_MIND}")
            if self._client.nthreads():
                deserted = time.monotonic() + _DESERTED
            elif time.monotonic() > deserted:
                raise InputError(f"the cluster has had no worker for {_DESERTED:g} s; {_MIND}")


def _worked(jobs: Sequence[Job], models: Sequence[str]) -> tuple[Build, list[Answer]]:
    """Solve a batch in a worker, with one solver thread, as local processes do."""
    os.environ["TACTGEN_THREADS"] = "1"
    with _alone:
        return build(models), [
            solved(job.asked, job.values, lambda _: None, _earlier) for job in jobs
        ]


def _died() -> Answer:
    return Answer(
        "failed",
        "every worker of the cluster that solved it was ended from outside, which is what happens "
        "when memory runs out; give the workers more of it or take a coarser mesh",
    )
