"""What is said of an error that is not the program's own refusal."""

import errno
import resource
import subprocess
import sys

import pytest

from tactgen.validation.command_line.exit import explained


class SolverError(RuntimeError):
    """Named like the one of the sparse solver."""


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (MemoryError(), "there is not enough memory for this; free some"),
        (OSError(errno.ENOMEM, "Cannot allocate memory"), "there is not enough memory for this"),
        (
            ImportError("x.so: failed to map segment from shared object", name="x"),
            "x.so: failed to map segment from shared object); if memory is short",
        ),
        (SystemError("error return without exception set"), "a library failed (error return"),
        (
            PermissionError(errno.EACCES, "Permission denied", "a.csv"),
            "a.csv cannot be used (permission denied); make room or choose another place",
        ),
        (SolverError("singular"), 'scene "paper" cannot be solved (singular); bring'),
        (OverflowError(), 'scene "paper" cannot be solved (OverflowError); bring'),
        (ImportError("cannot import name 'a'", name="tactgen.fem"), None),
        (TypeError("ours"), None),
    ],
)
def test_words_for_what_the_system_refuses(error, words):
    """Memory that is short has many faces; a mistake of ours keeps its traceback."""
    said = explained(error, "paper")
    assert said is None if words is None else words in said


@pytest.mark.parametrize(
    ("megabytes", "words"), [(250, "numpy, scipy and MKL need 0.5 GB"), (700, "CAD solids need")]
)
def test_little_room_for_libraries(tmp_path, megabytes, words):
    """Looked for before they fail amid loading, or wait without end; nothing is left behind."""
    room = megabytes * 2**20
    done = subprocess.run(
        [sys.executable, "-m", "tactgen", "export", "paper", "--step", str(tmp_path / "a.step")],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (room, room)),
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.startswith(f"tactgen: {words}")
    assert "ulimit -v" in done.stderr
    assert not list(tmp_path.iterdir())
