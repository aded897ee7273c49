"""Usable standard streams, also closed ones and those of few characters."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console


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
    """Print the names of written files to stderr."""
    for path in paths:
        print(path, file=sys.stderr)


def drop_output() -> None:
    """Discard the rest of stdout, so that Python does not complain at exit."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def usable_streams() -> None:
    """Let both streams be there and take every character.

    Raises InputError if standard output is closed.
    """
    if sys.stderr is None:  # closed: words and progress go nowhere, not to stdout
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:
        raise InputError("standard output is closed; leave it open or send it to a file")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            with contextlib.suppress(OSError, ValueError):
                stream.reconfigure(errors="backslashreplace")


#: Seconds of work from which on a log hears of it, and between two lines of it.  Quicker work
#: is silent in a pipe: who reads the result wants no words beside it.
_LINES = 20.0
_COUNTED = re.compile(r"(?P<before>.*?)(?P<number>\d+) of (?P<all>\d+)(?P<after>.*)", re.DOTALL)


class Clock:
    """Progress line: activity, elapsed time, and time left of a counted list."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now, self._start = now, now()
        self._row: tuple[str, int, float] | None = None

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return self._now() - self._start

    def words(self, text: str) -> str:
        """Text with times; of equal steps ("gap 3 of 9") also about how long to go."""
        words, found = f"{text}, {_time(self.elapsed)}", _COUNTED.fullmatch(text)
        if found is None:
            self._row = None
            return words
        number = int(found["number"])
        if self._row is None or self._row[0] != found["before"] or number <= self._row[1]:
            self._row = found["before"], number, self._now()
            return words
        _, first, since = self._row
        rest = (self._now() - since) / (number - first) * (int(found["all"]) - number + 1)
        return f"{words}, about {_time(rest)} left"


def _time(seconds: float) -> str:
    whole = round(seconds)
    return f"{whole} s" if whole < 120 else f"{whole // 60} min {whole % 60:02} s"


@contextmanager
def announcer() -> Iterator[Callable[[str], None]]:
    """Yield a function that shows progress on stderr."""
    clock = Clock()
    console = _rewritten()
    if console is None:
        yield _in_lines(clock)
        return
    with console.status("starting") as status:
        yield lambda text: status.update(clock.words(text))


def _rewritten() -> Console | None:
    """Stderr where a line of it can be written over: a terminal that is not a dumb one."""
    if not sys.stderr.isatty():
        return None
    from rich.console import Console

    console = Console(stderr=True)
    return None if console.is_dumb_terminal else console


def _in_lines(clock: Clock) -> Callable[[str], None]:
    last = 0.0

    def announce(text: str) -> None:
        nonlocal last
        words = clock.words(text)
        if clock.elapsed - last >= _LINES:
            last = clock.elapsed
            say(words)

    return announce
