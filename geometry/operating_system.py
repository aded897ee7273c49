"""What differs between operating systems: locks on files, processes, cores."""

from __future__ import annotations

import importlib
import os
import sys
import time
from pathlib import Path
from typing import Any

#: Flags to open a file for reading: bytes as they are, and no wait for a pipe's other end.
READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)

#: Seconds between two trials of a lock that the system cannot wait for.
_TRIAL = 0.1


def core_count() -> int:
    """Cores that this process may use, or those of the machine where that is not known."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def memory_size() -> float:
    """Memory (bytes) of the machine, infinite where it is not known."""
    if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    return float("inf")


def is_running(process: int) -> bool:
    """Whether a process of this number runs; on Windows, where a look would end it, True."""
    if sys.platform == "win32":
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:  # another user's
        return True
    return True


def bring_to_disk(path: Path) -> None:
    """Flush a file or folder to the disk; Windows flushes no folder, and only what may be written.

    Raises OSError if it cannot be flushed.
    """
    windows = sys.platform == "win32"
    if windows and path.is_dir():
        return
    descriptor = os.open(path, os.O_RDWR if windows else os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def lock(descriptor: int, *, wait: bool) -> bool:
    """Lock an open file against other processes and threads; False if another one has it.

    Raises OSError if the file cannot be locked.
    """
    system = _locking()
    if hasattr(system, "flock"):
        try:
            system.flock(descriptor, system.LOCK_EX | (0 if wait else system.LOCK_NB))
        except BlockingIOError:
            return False
        return True
    while True:
        try:
            system.locking(descriptor, system.LK_NBLCK, 1)
        except PermissionError:
            if not wait:
                return False
            time.sleep(_TRIAL)
        else:
            return True


def unlock(descriptor: int) -> None:
    """Release the lock of :func:`lock`."""
    system = _locking()
    if hasattr(system, "flock"):
        system.flock(descriptor, system.LOCK_UN)
    else:
        system.locking(descriptor, system.LK_UNLCK, 1)


def _locking() -> Any:
    """System's module of locks: fcntl, on Windows msvcrt."""
    try:
        return importlib.import_module("fcntl")
    except ImportError:
        return importlib.import_module("msvcrt")
