"""Standard streams: what goes to which, and closed or narrow ones; progress is on stderr alone."""

import io
import re
import sys
from pathlib import Path

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line import streams as progress
from tactgen.validation.command_line.streams import announcer, name_files, say, usable_streams


def test_words_and_files_are_named_on_stderr(capsys):
    """Standard output is left to results; a word is one line, whatever is in it."""
    say("one\ntwo")
    name_files([Path("a.csv"), Path("b.svg")])
    assert capsys.readouterr() == ("", "tactgen: one two\na.csv\nb.svg\n")


@pytest.mark.parametrize("name", ["stdout", "stderr"])
def test_narrow_streams_take_every_character(monkeypatch, name):
    """By their number where the stream has them not."""
    written = io.BytesIO()
    stream = io.TextIOWrapper(written, encoding="ascii")
    monkeypatch.setattr(sys, name, stream)
    usable_streams()
    stream.write("2 µm ∠")
    stream.flush()
    assert written.getvalue() == rb"2 \xb5m \u2220"


def test_closed_streams(monkeypatch):
    """Words go nowhere then, and not among the results; results must go somewhere."""
    monkeypatch.setattr(sys, "stderr", None)
    usable_streams()
    assert sys.stderr.name == "/dev/null"
    sys.stderr.close()
    monkeypatch.setattr(sys, "stdout", None)
    with pytest.raises(InputError, match="standard output is closed"):
        usable_streams()


def test_a_word_that_cannot_be_written_stops_nothing(monkeypatch):
    """On a full disk, say."""

    class Full(io.StringIO):
        def write(self, _):
            raise OSError(28, "no space left on device")

    monkeypatch.setattr(sys, "stderr", Full())
    say("anything")


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
