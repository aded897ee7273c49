"""Parts of a report that stand alone, made by another process while this one solves.

What that process has not begun when it is wanted is made here, and so is what it fails to hand
over: a report is the same with it and without.  While this process waits for a part, it makes
others that nobody has begun.  Both have an order of their own: the longest first, so that they end
together, and what shares work by the same.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from threading import Lock
from typing import Any

from tactgen.fem.solvers.pardiso import VARIABLE, thread_count
from tactgen.validation.scene.scene import Scene

#: What is asked of the other process: the scene, where its values are from, whether quick.
Asked = tuple[Scene, dict[str, str], bool]
#: What makes a part, in any process: what is asked, and the part's name.
Maker = Callable[[Asked, str], Any]


class Ahead:
    """Parts by name: one after the other elsewhere, any of them here once it is wanted."""

    def __init__(
        self, pool: ProcessPoolExecutor, make: Maker, asked: Asked, names: Sequence[str]
    ) -> None:
        self._pool, self._make, self._asked = pool, make, asked
        self._left, self._begun = deque(names), dict[str, Future[Any]]()
        self._order = list[str]()
        self._here: Callable[[str], Any] | None = None
        self._made = dict[str, Any]()
        self._lock = Lock()
        self._next()

    def meanwhile(self, here: Callable[[str], Any], order: Sequence[str]) -> None:
        """Say what makes parts in this process while it waits, and which, in their order.

        What is not among those that the other process makes is made here only.
        """
        self._here, self._order = here, list(order)

    def take(self, name: str, here: Callable[[], Any]) -> Any:
        """Return a part: from the other process if it has begun it, else made by `here`."""
        with self._lock:
            future = self._begun.get(name)
            if future is None:
                self._claim(name)
        if future is None:
            return self._made[name] if name in self._made else here()
        self._work_until(future)
        # where it died, or its part cannot travel, what is wrong shows here
        return here() if future.exception() else future.result()

    def _work_until(self, future: Future[Any]) -> None:
        """Make parts that nobody has begun until another one is done."""
        while self._here is not None and not future.done():
            with self._lock:
                name = next((name for name in self._order if name not in self._begun), None)
                if name is None:
                    return
                self._claim(name)
            self._made[name] = self._here(name)

    def _claim(self, name: str) -> None:
        """Leave a part to this process."""
        for waiting in (self._order, self._left):
            if name in waiting:
                waiting.remove(name)

    def _next(self, _: object = None) -> None:
        """Hand over the next part: one at a time, since what is handed over is not taken back."""
        with self._lock:
            if not self._left:
                return
            name = self._left.popleft()
            try:
                future = self._pool.submit(self._make, self._asked, name)
            except RuntimeError:  # the pool is broken, or ends
                self._left.clear()
                return
            self._begun[name] = future
        future.add_done_callback(self._next)


@contextmanager
def ahead(asked: Asked, make: Maker, names: Sequence[str]) -> Iterator[Ahead | None]:
    """Yield another process at work on parts; None where there is only one core to work on."""
    cores = len(os.sched_getaffinity(0))
    if cores == 1 or not names:
        yield None
        return
    from tactgen.validation.studies.processes import Workers

    with Workers(1) as pool, _at_most(cores - 1):
        yield Ahead(pool, make, asked, names)


@contextmanager
def _at_most(threads: int) -> Iterator[None]:
    """Let the solver of this process take the cores that the other leaves it.

    Threads of both on one core wait for each other and burn it meanwhile: a quarter of the time.
    """
    found = thread_count()
    os.environ[VARIABLE] = str(min(threads, found or threads))
    try:
        yield
    finally:
        if found is None:
            del os.environ[VARIABLE]
        else:
            os.environ[VARIABLE] = str(found)
