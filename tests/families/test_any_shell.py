"""Any shell: the same answer or one sentence, whatever the surroundings of a command are."""

import os
import shlex
import subprocess
import sys

import pytest

ANSWER = "solve --model tmm --quantity static_tip_displacement"
CLI = f"{shlex.quote(sys.executable)} -m tactgen"


def call(arguments, redirection="", **surroundings):
    """Run a command by a shell with some variables set or, where None, taken away."""
    variables = {k: v for k, v in {**os.environ, **surroundings}.items() if v is not None}
    return subprocess.run(
        ["bash", "-c", f"{CLI} {arguments} {redirection}"],
        capture_output=True, text=True, encoding="utf-8", errors="surrogateescape", check=False,
        env=variables, timeout=120,
    )  # fmt: skip


@pytest.mark.parametrize(
    "surroundings",
    [
        {"PYTHONIOENCODING": "ascii"},
        pytest.param({"PYTHONIOENCODING": "latin-1"}, marks=pytest.mark.heavy),
        pytest.param(
            {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}, marks=pytest.mark.heavy
        ),
    ],
    ids=["ascii", "latin-1", "C"],
)
@pytest.mark.parametrize(
    "arguments",
    [
        "solve --model tmm --quantity tip_displacement --frequency 10:900:3",
        pytest.param("design --lengths 20mm:21mm", marks=pytest.mark.heavy),
        pytest.param("sensitivity --quantity static_tip_displacement", marks=pytest.mark.heavy),
    ],
)
def test_streams_of_few_characters(surroundings, arguments):
    """Greek letters and signs become words; what is written is plain ASCII or Latin-1."""
    done = call(arguments, **surroundings)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.isascii() or surroundings.get("PYTHONIOENCODING") == "latin-1"


@pytest.mark.heavy
def test_a_notebooks_backend_is_nobodys_business(tmp_path):
    """The variable that a notebook leaves to its children names a module that may be missing."""
    picture = tmp_path / "a.svg"
    done = call(
        f"design --lengths 20mm:21mm --plot {shlex.quote(str(picture))}",
        MPLBACKEND="module://matplotlib_inline.backend_inline",
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert picture.read_text(encoding="utf-8").startswith("<svg")


def test_help_that_cannot_be_written():
    """A full disk is said of help as of any result."""
    done = call("--help", ">/dev/full")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "standard output cannot be written" in done.stderr


@pytest.mark.heavy
def test_a_home_that_is_empty_is_not_here(tmp_path):
    """HOME= does not fill the folder in which the command runs."""
    subprocess.run(
        ["bash", "-c", f"{CLI} {ANSWER.replace('tmm', 'beam')}"], check=True, cwd=tmp_path,
        capture_output=True, timeout=120,
        env={k: v for k, v in os.environ.items() if k != "TACTGEN_CACHE"} | {"HOME": ""},
    )  # fmt: skip
    assert not list(tmp_path.iterdir())


@pytest.mark.heavy
@pytest.mark.parametrize("redirection", [">&-", ">&- 2>&-", "2>&-", "2>/dev/full"])
def test_streams_that_are_closed(redirection):
    """Without stdout a refusal, without stderr the answer."""
    done = call(ANSWER, redirection)
    assert done.returncode == (2 if ">&- " in f"{redirection} " and redirection[0] == ">" else 0)
    assert "Traceback" not in done.stderr + done.stdout


@pytest.mark.heavy
def test_a_short_time_limit_is_kept():
    """A tenth of a second for a mesh: refused once CAD is built, which takes seconds."""
    done = call(
        "solve j1 --model cad --set mesh.time_limit=0.1s --quantity static_tip_displacement"
    )
    assert done.returncode == 2
    assert "within 0.1 s of processor time; raise the time limit" in done.stderr
