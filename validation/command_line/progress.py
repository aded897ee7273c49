"""Progress: one line that changes on a terminal, a line now and then in a log, nothing if quick."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tactgen.validation.command_line.streams import say

if TYPE_CHECKING:
    from rich.console import Console

#: Seconds of work from which on a log hears of it, and between two lines of it.  Quicker work
#: is silent in a pipe: who reads the result wants no words beside it.
_LINES = 20.0
_COUNTED = re.compile(r"(?P<before>.*?)(?P<number>\d+) of (?P<all>\d+)(?P<after>.*)", re.DOTALL)


class Clock:
    """What is being done, with the time since the start, and what is left of a counted row.

    `stages` are those of a plan, in order: which of them it is stands beside its name.
    """

    def __init__(
        self, stages: Sequence[str] = (), now: Callable[[], float] = time.monotonic
    ) -> None:
        self._stages = list(stages)
        self._now, self._start = now, now()
        self._row: tuple[str, int, float] | None = None

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return self._now() - self._start

    def words(self, text: str) -> str:
        """Text with times; of equal steps ("gap 3 of 9") also about how long to go."""
        stage = ""
        if text in self._stages:
            stage = f" (stage {self._stages.index(text) + 1} of {len(self._stages)})"
        return f"{text}{stage}, {_time(self.elapsed)}{self._left(text)}"

    def _left(self, text: str) -> str:
        found = _COUNTED.fullmatch(text)
        # stages differ in cost by orders of magnitude: their number says nothing of the time
        if found is None:
            self._row = None
            return ""
        number, all_ = int(found["number"]), int(found["all"])
        if self._row is None or self._row[0] != found["before"] or number <= self._row[1]:
            self._row = found["before"], number, self._now()
            return ""
        _, first, since = self._row
        rest = (self._now() - since) / (number - first) * (all_ - number + 1)
        return f", about {_time(rest)} left"


def _time(seconds: float) -> str:
    whole = round(seconds)
    return f"{whole} s" if whole < 120 else f"{whole // 60} min {whole % 60:02} s"


@contextmanager
def announcer(stages: Sequence[str] = ()) -> Iterator[Callable[[str], None]]:
    """Yield a function that is told what is being done, and shows it on stderr."""
    clock = Clock(stages)
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
