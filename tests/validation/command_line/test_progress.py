"""Progress is for people at a terminal and never on stdout."""

import io

from tactgen.validation.command_line.progress import announcer


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self):
        return True


def test_progress_is_on_stderr(monkeypatch, capsys):
    """What runs is shown on stderr if that is a terminal; stdout is for results."""
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with announcer() as announce:
        announce("solid.mesh")
    assert terminal.getvalue()
    assert capsys.readouterr().out == ""


def test_no_progress_in_a_pipe(monkeypatch, capsys):
    """A log file gets warnings and errors only."""
    pipe = io.StringIO()
    monkeypatch.setattr("sys.stderr", pipe)
    with announcer() as announce:
        announce("solid.mesh")
    assert pipe.getvalue() == capsys.readouterr().out == ""
