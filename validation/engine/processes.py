"""Processes of this machine that work beside this one."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multiprocessing.connection import Connection


class Processes:
    """Processes that end when this one does, or an error leaves the block."""

    def __init__(self, count: int) -> None:
        self._count = count

    def __enter__(self) -> Processes:
        import multiprocessing

        context = multiprocessing.get_context("spawn")
        self._theirs, self._mine = context.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(
            self._count, context, initializer=_begin, initargs=(self._theirs, os.getpid())
        )
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            self._mine.close()  # the processes see it, and end amid their work
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._mine.close()
        self._theirs.close()

    def submit(self, work: Callable[..., Any], *given: Any) -> Future[Any]:
        """Begin a function of a module.

        Raises BrokenProcessPool if a process has died since the block began.
        """
        return self._pool.submit(work, *given)


def _begin(line: Connection, parent: int) -> None:
    """Prepare a worker: one solver thread, and an end when the line to the parent is cut."""
    import signal

    os.environ["TACTGEN_THREADS"] = "1"
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent is told as well, and ends this one

    def watch() -> None:
        try:
            line.recv()
        except (EOFError, OSError):
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    if os.getppid() != parent:  # it died before the watch began
        os._exit(1)
