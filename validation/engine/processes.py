"""Processes of this machine that work beside this one."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multiprocessing.connection import Connection


@contextlib.contextmanager
def processes(count: int) -> Iterator[ProcessPoolExecutor]:
    """Give processes that end when this one does, or an error leaves the block."""
    import multiprocessing

    context = multiprocessing.get_context("spawn")
    theirs, mine = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(count, context, initializer=_begin, initargs=(theirs, os.getpid()))
    try:
        yield pool
    except BaseException:
        mine.close()  # the processes see it, and end amid their work
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
        mine.close()
        theirs.close()


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
