"""Studies that are killed, shared, or whose workers die: nothing is lost, nothing changes."""

import contextlib
import csv
import os
import random
import signal
import subprocess
import sys
import time

import pytest

from tactgen.validation.command_line.cli import main
from tactgen.validation.studies.whatif import point_answers as questions

#: A command line that writes down each point as its solution begins, also in workers.
SCRIPT = """
import os, sys
from tactgen.validation.studies.whatif import point_answers as questions
whole = questions.solve

def noted(scene, *arguments, **options):
    length = f"{1e3 * scene.bimorph.length:.6g}"
    with open(os.environ["NOTES"], "a") as notes:
        notes.write(f"{os.getpid()} {length}\\n")
    if length == os.environ.get("DEADLY"):
        os._exit(9)
    return whole(scene, *arguments, **options)

questions.solve = noted

if __name__ == "__main__":
    from tactgen.validation.command_line.cli import main
    sys.exit(main(["whatif", *sys.argv[1:]]))
"""


@pytest.fixture
def start(own_store, tmp_path, monkeypatch):
    """Return a function that starts a study in a process; `start.notes` are its solutions."""
    script = tmp_path / "noted.py"
    script.write_text(SCRIPT)
    notes = tmp_path / "notes"
    notes.touch()
    monkeypatch.setenv("NOTES", str(notes))

    def begin(*arguments):
        command = [sys.executable, str(script), *map(str, arguments)]
        return subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            start_new_session=True,
        )  # fmt: skip

    begin.notes = lambda: notes.read_text().splitlines()
    return begin


def finished(process):
    """Return what a process that ends by itself says."""
    _, err = process.communicate()
    assert process.returncode == 0, err
    return err


def numbers(folder):
    """Return the table without what it cost."""
    with (folder / "study.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


def killed_study(start, tmp_path, store, count, points, *more):
    """Kill a study at random moments until so many kills fell into it; return how many did."""
    random.seed(7)
    vary = ("prototype", "--vary", f"bimorph.length=14mm:30mm:{points}", "--model", "tmm", *more)
    asked = (*vary, "--quantity", "short_circuit_frequencies", "--out")
    assert main(["whatif", *asked, str(tmp_path / "whole")]) == 0  # in this process
    begun = []
    for file in store.glob("whatif*"):
        file.unlink()
    out, kills, kept = tmp_path / "killed", 0, set()
    while kills < count:
        process = start(*asked, out, "--resume")
        before = len(start.notes())
        # kill amid the points, not while Python starts
        while process.poll() is None and len(start.notes()) == before:
            time.sleep(0.005)
        time.sleep(random.uniform(0.0, 0.03))  # a fraction of what all points take
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        if process.returncode == 0:
            break  # it was done before
        kills += 1
        now = {file.name: file.read_bytes() for file in store.glob("whatif*.kept")}
        assert kept <= set(now.items())  # none lost, none changed
        kept = set(now.items())
    with pytest.MonkeyPatch.context() as patch:
        whole = questions.solve
        patch.setattr(questions, "solve", lambda *a, **b: begun.append(1) or whole(*a, **b))
        assert main(["whatif", *asked, str(out), "--resume"]) == 0
    assert numbers(out) == numbers(tmp_path / "whole")
    repeated = len(start.notes()) + len(begun) - points
    assert repeated <= kills  # one process: at most one point in flight
    return kills


@pytest.mark.heavy
def test_a_study_survives_fifty_kills(start, tmp_path, own_store):
    """The same with fifty."""
    assert killed_study(start, tmp_path, own_store, 50, 400) == 50


@pytest.mark.heavy
def test_two_processes_share_a_study(start, tmp_path):
    """Each point is solved by one of them, and both write all."""
    asked = (
        "prototype", "--vary", "bimorph.length=14mm:30mm:60", "--model", "tmm", "--quantity",
        "short_circuit_frequencies", "--resume", "--out", tmp_path / "study",
    )  # fmt: skip
    first, second = start(*asked), start(*asked)
    finished(first)
    finished(second)
    solved = [line.split() for line in start.notes()]
    lengths = [length for _, length in solved]
    assert len(lengths) == len(set(lengths)) == 60
    assert len(numbers(tmp_path / "study")) == 1 + 4 * 60


@pytest.mark.heavy
def test_a_worker_that_dies_takes_one_point_with_it(start, tmp_path, monkeypatch):
    """As when memory runs out: that point failed, with what to do; the others are there."""
    monkeypatch.setenv("DEADLY", "16")
    asked = (
        "prototype", "--vary", "bimorph.length=14mm:20mm:4", "--model", "beam", "--quantity",
        "capacitance_free", "--jobs", "2", "--out", tmp_path / "study",
    )  # fmt: skip
    assert "1 failed" in finished(start(*asked))
    rows = numbers(tmp_path / "study")[1:]
    assert [row[-2] for row in rows] == ["ok", "failed", "ok", "ok"]
    assert "take fewer --jobs" in rows[1][-1]
    monkeypatch.delenv("DEADLY")
    assert "0 failed" in finished(start("--resume", "--retry", "--out", tmp_path / "study"))


@pytest.mark.heavy
def test_workers_end_with_their_parent(start, tmp_path, own_store):
    """Killed without warning, it leaves no process behind that goes on computing."""
    process = start(
        "prototype", "--vary", "bimorph.length=14mm:30mm:3000", "--model", "beam", "--quantity",
        "short_circuit_frequencies", "--jobs", "2", "--out", tmp_path / "study",
    )  # fmt: skip
    while not start.notes():
        assert process.poll() is None
        time.sleep(0.01)
    workers = {int(line.split()[0]) for line in start.notes()}
    process.kill()
    process.communicate()
    deadline = time.monotonic() + 20.0
    while any(os.path.exists(f"/proc/{worker}") for worker in workers):  # noqa: PTH110
        assert time.monotonic() < deadline
        time.sleep(0.02)
