"""How many threads the sparse solver may take: the environment variable TACTGEN_THREADS.

Unset, MKL decides: all cores, or what OMP_NUM_THREADS or MKL_NUM_THREADS say.  Jobs that have
nothing to do with one another share the cores better than the threads of one job do.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable
from typing import TypeVar

from tactgen.geometry.errors import InputError

S = TypeVar("S")
T = TypeVar("T")

VARIABLE = "TACTGEN_THREADS"

#: Says of a thread that it is one of several that do jobs side by side.
_here = threading.local()


def thread_count() -> int | None:
    """Return the number of threads that the environment asks for, None if it does not say.

    Raises
    ------
    InputError
        If that is not a whole number from 1.
    """
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return None
    if not (text.isascii() and text.isdigit() and 1 <= int(text) <= 1024):
        raise InputError(
            f"the environment variable {VARIABLE} is '{text}'; "
            "set it to a whole number of threads from 1 to 1024, or unset it to use all cores"
        )
    return int(text)


def solver_threads() -> int:
    """Return how many threads a call of the sparse solver may take here; 0 leaves it to MKL."""
    return 1 if _beside_others() else thread_count() or 0


def side_by_side(work: Callable[[S], T], jobs: Iterable[S]) -> list[T]:
    """Return what is worked out for each job, several at a time, in the order of the jobs.

    For jobs of which nearly all is done by libraries that let other threads run.  Each has one
    thread of the sparse solver, so that together they take no more than the setting allows.
    """
    asked = list(jobs)
    threads = min(thread_count() or len(os.sched_getaffinity(0)), len(asked))
    if threads < 2 or _beside_others():
        return [work(job) for job in asked]
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(threads, initializer=_say_beside_others) as pool:
        try:
            return list(pool.map(work, asked))
        except BaseException:  # interrupted, too: what has not begun is not waited for
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _beside_others() -> bool:
    return getattr(_here, "beside_others", False)


def _say_beside_others() -> None:
    _here.beside_others = True
