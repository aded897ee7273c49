"""Studies on a cluster: the same answers bit for bit, deaths survived, refusals in a sentence."""

import os
import signal
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.load import scene_values
from tactgen.validation.studies.whatif import executor, point_answers
from tactgen.validation.studies.whatif.definition import Statement, read_statement
from tactgen.validation.studies.whatif.study import run_study

ADDRESS = "tcp://127.0.0.1:8786"
ASKED = ["whatif", "prototype", "--vary", "bimorph.length=14mm:18mm:3", "--model", "tmm"]


def statement(count, *sets, models=("lumped", "tmm")):
    values, _ = scene_values("prototype", ["frequency=100,500", *sets])
    quantities = ("tip_displacement", "short_circuit_frequencies")
    return Statement(
        "prototype", values, (f"bimorph.length=14mm:18mm:{count}",), models, quantities
    )


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
    assert study.counts.computed == 4
    assert there.address == ADDRESS
    assert there.status == "closed"
    again = run_study(asked)
    assert (again.counts.computed, again.counts.recalled) == (0, 4)
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "another"))
    assert_same(study, run_study(asked))


def test_a_question_that_kills_every_worker_fails_alone(as_cluster):
    there = as_cluster(Cluster(deadly=(16.0,)))
    study = run_study(statement(3, "modes=1", models=("tmm",)), scheduler=ADDRESS)
    statuses = [answer.status for _, _, answer in study.rows]
    assert statuses == ["ok", "failed", "ok"]
    assert "every worker of the cluster that solved it" in study.answers[1]["tmm"].reason
    assert max(map(len, there.batches)) == 3  # then one by one
    assert len(there.batches) == 4


def test_a_worker_that_joins_with_other_code_is_refused(as_cluster):
    own = executor.build(("tmm",))
    as_cluster(Cluster(joined=("tactgen 0", *own[1:])))
    with pytest.raises(InputError, match="that joined the cluster has tactgen 0, other than here"):
        run_study(statement(3, "modes=1", models=("tmm",)), scheduler=ADDRESS)


@pytest.mark.parametrize(
    ("theirs", "words"),
    [
        (("tactgen 0.0.1", "numpy 2.0"), "has tactgen 0.0.1, other than here"),
        (("tactgen 1.0", "numpy 1.0"), "has numpy 1.0, other than here"),
        (ModuleNotFoundError("No module named 'tactgen'"), "cannot run this tactgen .No module"),
    ],
)
def test_workers_that_would_answer_otherwise_are_refused(theirs, words):
    own = ("tactgen 1.0", "numpy 2.0")
    executor.check_workers(own, {"a": own})
    with pytest.raises(InputError, match=f"the worker b {words}.*install the same there"):
        executor.check_workers(own, {"a": own, "b": theirs})


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--scheduler", "here"], 'scheduler "here" is not the address of a Dask scheduler'),
        (["--scheduler", "tcp://nowhere"], "write for example --scheduler tcp://127.0.0.1:8786"),
        (["--scheduler", ADDRESS, "--jobs", "2"], "remove one of them"),
    ],
)
def test_addresses_that_are_none_are_refused(options, words, capsys):
    assert main([*ASKED, *options]) == 2
    assert words in capsys.readouterr().err


def refused(capsys, *options):
    assert main([*ASKED, "--scheduler", ADDRESS, *options]) == 2
    said = capsys.readouterr().err
    assert "Traceback" not in said
    return said


def test_a_scheduler_that_does_not_answer_is_refused(as_cluster, monkeypatch, capsys, tmp_path):
    def nobody(*_, timeout, **__):
        assert timeout == executor.PATIENCE
        raise OSError("timed out")

    there = as_cluster(Cluster())
    monkeypatch.setattr(sys.modules["distributed"], "Client", nobody)
    said = refused(capsys, "--out", str(tmp_path / "study"))
    assert f"no Dask scheduler answers at {ADDRESS} within 10 s" in said
    # nothing is lost: the study is stated, and can be gone on with here
    assert read_statement(tmp_path / "study").vary == ("bimorph.length=14mm:18mm:3",)

    def lonely(*_, **__):
        raise TimeoutError

    monkeypatch.setattr(there, "wait_for_workers", lonely)
    monkeypatch.setattr(sys.modules["distributed"], "Client", there.Client)
    assert "has no worker after 10 s" in refused(capsys, "--set", "drive.voltage=3V")
    monkeypatch.setitem(sys.modules, "distributed", None)
    said = refused(capsys, "--set", "drive.voltage=2V")
    assert "pip install -e '.[cluster]'" in said


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
    assert study.counts.computed == 160
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "another"))
    monkeypatch.setenv("TACTGEN_THREADS", "1")
    assert_same(study, run_study(asked, 1))
