"""Processes that work for this one, and end with it however it ends."""

from __future__ import annotations

import os
import threading
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multiprocessing.connection import Connection


class Workers:
    """A pool whose processes end when this one does, or when the block is left by an error."""

    def __init__(self, processes: int) -> None:
        import multiprocessing

        context = multiprocessing.get_context("spawn")
        theirs, self.mine = context.Pipe(duplex=False)
        self.theirs = theirs
        self.executor = ProcessPoolExecutor(
            processes, context, initializer=_begin, initargs=(theirs, os.getpid())
        )

    def __enter__(self) -> ProcessPoolExecutor:
        return self.executor

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            self.mine.close()  # the processes see it, and end amid their work
        self.executor.shutdown(wait=True, cancel_futures=True)
        self.mine.close()
        self.theirs.close()


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
