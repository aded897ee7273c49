"""Studies killed, shared, on a cluster, or whose workers die: the same answers bit for bit."""

import contextlib
import csv
import os
import random
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.load import scene_values
from tactgen.validation.studies.whatif import executor, point_answers
from tactgen.validation.studies.whatif import point_answers as questions
from tactgen.validation.studies.whatif.definition import Statement, read_statement
from tactgen.validation.studies.whatif.study import run_study

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


ADDRESS = "tcp://127.0.0.1:8786"


def statement(count, *sets, models=("lumped", "tmm")):
    values, _ = scene_values("prototype", ["frequency=100,500", *sets])
    vary = (f"bimorph.length=14mm:18mm:{count}",)
    quantities = ("tip_displacement", "short_circuit_frequencies")
    return Statement("prototype", values, vary, models, quantities)


def assert_same(study, other):
    for (_, _, a), (_, _, b) in zip(study.rows, other.rows, strict=True):
        assert (a.status, a.warnings) == (b.status, b.warnings) == ("ok", b.warnings)
        for one, two in zip(a.quantities, b.quantities, strict=True):
            np.testing.assert_array_equal(one.value, two.value)
            np.testing.assert_array_equal(one.error, two.error)


class KilledWorker(Exception):
    """As of distributed."""


class Future:
    """As of distributed; it can be a key."""


class Cluster:
    """A scheduler in this process; `deadly` lengths kill whoever solves them."""

    def __init__(self, deadly=(), joined=None):
        self.deadly, self.joined, self.status, self.batches = deadly, joined, "running", []

    def Client(self, address, **_):
        self.address = address
        return self

    def wait_for_workers(self, *_, **__):
        pass

    def run(self, function, *arguments, on_error):
        assert on_error == "return"
        return {"tcp://127.0.0.1:1": function(*arguments)}

    def nthreads(self):
        return {"tcp://127.0.0.1:1": 1}

    def close(self, **_):
        self.status = "closed"

    def submit(self, function, questions, models, *, pure):
        assert not pure
        self.batches.append(questions)
        future = Future()

        def result(timeout):
            lengths = [1e3 * float(asked.values["bimorph"]["length"]) for asked in questions]
            if any(length in self.deadly for length in lengths):
                raise KilledWorker
            build, answers = function(questions, models)
            return self.joined or build, answers

        future.result = result
        future.done = lambda: True
        return future


@pytest.fixture
def as_cluster(own_store, monkeypatch):
    """Return a function that puts a cluster into the place of Dask's."""
    point_answers._earlier.clear()
    monkeypatch.setenv("TACTGEN_THREADS", "1")

    def put(found):
        module = SimpleNamespace(Client=found.Client, KilledWorker=KilledWorker)
        monkeypatch.setitem(sys.modules, "distributed", module)
        return found

    return put


def test_a_cluster_answers_as_this_machine_does_and_the_client_keeps_it(
    as_cluster, monkeypatch, tmp_path
):
    there = as_cluster(Cluster())
    asked = statement(2, "modes=1")
    study = run_study(asked, scheduler=ADDRESS)
    assert (there.address, there.status) == (ADDRESS, "closed")
    counts = [(of.counts["computed"], of.counts["recalled"]) for of in (study, run_study(asked))]
    assert counts == [(4, 0), (0, 4)]
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "another"))
    assert_same(study, run_study(asked))


def test_a_question_that_kills_every_worker_fails_alone(as_cluster):
    there = as_cluster(Cluster(deadly=(16.0,)))
    study = run_study(statement(3, "modes=1", models=("tmm",)), scheduler=ADDRESS)
    assert [answer.status for _, _, answer in study.rows] == ["ok", "failed", "ok"]
    assert "every worker of the cluster that solved it" in study.answers[1]["tmm"].reason
    assert sorted(map(len, there.batches)) == [1, 1, 1, 3]  # one by one after all


def test_workers_that_would_answer_otherwise_are_refused(as_cluster):
    """One that joins later, one with other libraries, one that cannot run this at all."""
    own = executor.build(("tmm",))
    as_cluster(Cluster(joined=("tactgen 0", *own[1:])))
    with pytest.raises(InputError, match="that joined the cluster has tactgen 0, other than here"):
        run_study(statement(3, "modes=1", models=("tmm",)), scheduler=ADDRESS)
    executor.check_workers(own, {"a": own})
    for theirs, words in (
        ((own[0], "numpy 1.0", *own[2:]), "has numpy 1.0, other than here"),
        (ModuleNotFoundError("No module named 'tactgen'"), "cannot run this tactgen .No module"),
    ):
        with pytest.raises(InputError, match=f"the worker b {words}.*install the same there"):
            executor.check_workers(own, {"a": own, "b": theirs})


def test_schedulers_that_cannot_be_had_are_refused(as_cluster, monkeypatch, capsys, tmp_path):
    """No address; beside --jobs; nobody there, no worker, no Dask."""
    varied = ["--vary", "bimorph.length=14mm:18mm:3", "--model", "tmm"]

    def refused(*options, scheduler=ADDRESS):
        assert main(["whatif", "prototype", *varied, "--scheduler", scheduler, *options]) == 2
        return capsys.readouterr().err

    def nobody(*_, **__):
        raise OSError("timed out")

    def lonely(*_, **__):
        raise TimeoutError

    there = as_cluster(Cluster())
    assert '"here" is not the address of a Dask scheduler' in refused(scheduler="here")
    assert f"write for example --scheduler {ADDRESS}" in refused(scheduler="tcp://nowhere")
    assert "remove one of them" in refused("--jobs", "2")
    monkeypatch.setattr(sys.modules["distributed"], "Client", nobody)
    said = refused("--out", str(tmp_path / "study"))
    assert f"no Dask scheduler answers at {ADDRESS} within 10 s" in said
    # nothing is lost: the study is stated, and can be gone on with here
    assert read_statement(tmp_path / "study").vary == (varied[1],)
    monkeypatch.setattr(there, "wait_for_workers", lonely)
    monkeypatch.setattr(sys.modules["distributed"], "Client", there.Client)
    assert "has no worker after 10 s" in refused("--set", "drive.voltage=3V")
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install -e '.[cluster]'" in refused("--set", "drive.voltage=2V")


@pytest.mark.heavy
@pytest.mark.filterwarnings("ignore")
def test_a_real_cluster_of_which_a_worker_is_killed(own_store, monkeypatch, tmp_path):
    """Scheduler and two workers on loopback, one killed in the middle: all answers, bit for bit."""
    import distributed

    asked = statement(160, models=("tmm",))
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as there,
        distributed.Client(there) as mine,
    ):
        pids = mine.run(os.getpid)
        killed = []

        def kill_one(text):
            if not killed and text.startswith("1 of 160"):
                killed.append(next(iter(pids.values())))
                os.kill(killed[0], signal.SIGKILL)

        study = run_study(asked, announce=kill_one, scheduler=there.scheduler_address)
    assert killed
    assert study.counts["computed"] == 160
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "another"))
    monkeypatch.setenv("TACTGEN_THREADS", "1")
    assert_same(study, run_study(asked, 1))
