"""Progress is for people at a terminal and never on stdout."""

import io
import re

from tactgen.validation.command_line import streams as progress
from tactgen.validation.command_line.streams import announcer


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self):
        return True


def test_progress_is_on_stderr_of_a_terminal(monkeypatch, capsys):
    """Stdout is for results, and a log file gets warnings and errors only."""
    for stream, shown in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr("sys.stderr", stream)
        with announcer() as announce:
            announce("solid.mesh")
        assert bool(stream.getvalue()) is shown
        assert capsys.readouterr().out == ""


def test_long_work_says_a_line_now_and_then(monkeypatch):
    """Plain lines, at most one in twenty seconds."""
    pipe, now = io.StringIO(), iter([0.0, *(float(t) for t in range(1, 400))])
    monkeypatch.setattr("sys.stderr", pipe)
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(now))
    announce = progress._in_lines(progress.Clock(lambda: next(now)))
    for _ in range(50):
        announce("solid.ports")
    lines = pipe.getvalue().splitlines()
    assert 4 <= len(lines) <= 8  # about 150 ticks of a second
    assert all(re.fullmatch(r"tactgen: solid.ports, .* s", s) for s in lines)
