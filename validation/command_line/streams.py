"""Standard streams, closed or narrow ones too, and the end of a command by a signal."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

from tactgen.geometry.errors import InputError


def say(text: str) -> None:
    """Print one line to stderr, if that can be written."""
    from tactgen.validation.scene.files import one_line

    with contextlib.suppress(OSError):
        print(f"tactgen: {one_line(text)}", file=sys.stderr)


def print_json(value: Any) -> None:
    """Print a record in one line, alone on standard output."""
    import json

    from tactgen.validation.engine.answers import plain

    print(json.dumps(plain(value), allow_nan=False))


def name_files(paths: Iterable[Path]) -> None:
    """Print where files were written, to stderr: standard output holds what was asked for."""
    for path in paths:
        print(path, file=sys.stderr)


def drop_output() -> None:
    """Send what is left of stdout nowhere, so that Python does not complain at exit."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def usable_streams() -> None:
    """Let both streams be there and take every character, if need be as its number.

    Raises
    ------
    InputError
        If standard output is closed.
    """
    if sys.stderr is None:  # closed: words and progress go nowhere, not to stdout
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:
        raise InputError("standard output is closed; leave it open or send it to a file")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            with contextlib.suppress(OSError, ValueError):
                stream.reconfigure(errors="backslashreplace")


class ToldToEnd(KeyboardInterrupt):
    """A signal's number.

    KeyboardInterrupt itself, passing code made of text, as dataclasses are, leaves a mark by which
    ``python -m`` ends as if by Ctrl-C, whatever answered it.
    """


@contextlib.contextmanager
def unwound_when_told_to_end() -> Iterator[None]:
    """Raise :class:`ToldToEnd` where the work is when a signal arrives, so that no half file stays.

    What is ignored already stays so.  After the signal any error counts as the end: libraries
    that call back make errors of their own of it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    told = 0

    def end(number: int, _: FrameType | None) -> None:
        nonlocal told
        told = told or number
        raise ToldToEnd(told)

    signals = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    heard = [number for number in signals if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, end) for number in heard}
    try:
        yield
    except Exception as error:
        if told:
            raise ToldToEnd(told) from error
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def said_of_the_end(interrupt: KeyboardInterrupt) -> tuple[int, str]:
    """Return exit code, 128 and the signal's number as shells have it, and words."""
    number = interrupt.args[0] if interrupt.args else signal.SIGINT
    how = "interrupted" if number == signal.SIGINT else "told to end"
    return 128 + number, f"{how}; nothing half-written was kept"
