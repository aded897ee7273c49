"""Told to end: the work is unwound."""

import signal
import subprocess
import sys

import pytest

from tactgen.validation.command_line import exit as ending

#: Who runs the tests may ignore signals (nohup, a job in the background); children inherit that.
ENDED = """
import os, signal, sys
signal.signal(signal.Signals[sys.argv[2]], signal.SIG_DFL)
from tactgen.validation.show import export as files
from tactgen.validation.command_line.cli import main

def half(scene, drafts, announce):
    for draft in drafts.values():
        draft.write_text("half")
    try:
        if sys.argv[3] == "in text":
            exec("os.kill(os.getpid(), signal.Signals[sys.argv[2]])")
        os.kill(os.getpid(), signal.Signals[sys.argv[2]])
    except BaseException:
        if sys.argv[3] == "swallowed":
            raise ImportError("initialization failed") from None
        raise

files._write = half
sys.exit(main(["export", "reluctance", "--set", "models=network", "--map", sys.argv[1]]))
"""


@pytest.mark.parametrize(
    ("name", "how", "code", "words"),
    [("SIGTERM", "in text", 143, "told to end"), ("SIGINT", "swallowed", 130, "interrupted")],
)
def test_told_to_end_leaves_nothing_behind(tmp_path, tmp_path_factory, name, how, code, words):
    """A signal amid writing: the usual exit code, one sentence, no draft in the folder.

    Also where a library makes an error of its own of the signal.
    """
    program = tmp_path_factory.mktemp("program")
    (program / "told.py").write_text(ENDED)
    command = [sys.executable, "-m", "told", str(tmp_path / "map.nc"), name, how]
    done = subprocess.run(command, cwd=program, capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert done.stderr.endswith(f"tactgen: {words}; nothing half-written was kept\n")
    assert not list(tmp_path.iterdir())


def test_an_error_that_a_library_makes_of_the_signal_is_the_end():
    """And one without a signal is what it is."""

    def unwound(told):
        with ending.unwind_on_signal():
            try:
                if told:
                    signal.raise_signal(signal.SIGTERM)
            finally:
                raise ImportError("initialization failed")

    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        with pytest.raises(ending.TerminationRequest):
            unwound(told=True)
        with pytest.raises(ImportError):
            unwound(told=False)
    finally:
        signal.signal(signal.SIGTERM, before)
