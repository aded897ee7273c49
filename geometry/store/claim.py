"""A claim on a piece of work, so that two processes do not do the same twice.

A locked file: the system takes the lock away from a process that dies, however it dies.
Threads claim against each other as well.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

#: Claims that one sweep looks at.
_MOST_SWEPT = 1000


@contextlib.contextmanager
def claimed(path: Path, waiting: Callable[[], None]) -> Iterator[None]:
    """Hold the claim `path`; if another has it, call `waiting` once and wait.

    Where no file can be made or locked, there is no claim: work done twice is no harm.
    Claims inside claims are safe as long as work waits only for what it is made from.
    """
    descriptor = None
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = _locked(path, waiting)
    try:
        yield
    finally:
        if descriptor is not None:
            with contextlib.suppress(OSError):
                path.unlink()
            # a child that was forked meanwhile shares the lock: closing alone would not end it
            fcntl.flock(descriptor, fcntl.LOCK_UN)
            os.close(descriptor)


def sweep_claims(folder: Path, ending: str) -> None:
    """Remove the claims that nobody holds: those of processes that were killed.

    Of thousands only some, so that it takes no time that is noticed; the next sweep goes on.
    """
    with contextlib.suppress(OSError):
        for path in islice(folder.glob(f"*{ending}"), _MOST_SWEPT):
            with contextlib.suppress(OSError):
                _remove_unheld(path)


def _remove_unheld(path: Path) -> None:
    descriptor = os.open(path, os.O_RDWR)
    try:
        # who waits for it finds, once the lock is its own, that the file is gone, and claims anew
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(os.fstat(descriptor), path.stat()):
            path.unlink()
        fcntl.flock(descriptor, fcntl.LOCK_UN)
    finally:
        os.close(descriptor)


def _locked(path: Path, waiting: Callable[[], None]) -> int:
    """Return the descriptor of the locked file."""
    said = False
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                if not said:
                    waiting()
                    said = True
                fcntl.flock(descriptor, fcntl.LOCK_EX)
            # who had it before may have taken the file away
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), path.stat()):
                    return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)
