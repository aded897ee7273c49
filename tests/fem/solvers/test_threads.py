"""The number of threads is one setting, and a bad one is answered before anything runs."""

import threading

import pytest

from tactgen.fem.solvers.pardiso import VARIABLE, side_by_side, solver_threads, thread_count
from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main


@pytest.mark.parametrize(("text", "count"), [("", None), (" ", None), ("16", 16)])
def test_count(monkeypatch, text, count):
    """A whole number, or nothing, which leaves the choice to MKL."""
    monkeypatch.setenv(VARIABLE, text)
    assert thread_count() == count
    monkeypatch.delenv(VARIABLE)
    assert thread_count() is None


@pytest.mark.parametrize("text", ["0", "two", "1.5", "²", "99999"])
def test_bad_count(monkeypatch, text, capsys):
    """One sentence and exit code 2, also where no system is solved."""
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(InputError, match=r"TACTGEN_THREADS is '.*'; set it to a whole number"):
        thread_count()
    assert main(["scenes"]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1


def test_jobs_side_by_side_share_the_threads(monkeypatch):
    """Two jobs at the same time, each with one thread of the solver; answers in their order."""
    monkeypatch.setenv(VARIABLE, "2")
    both = threading.Barrier(2, timeout=60.0)  # breaks if they come one after the other

    def work(job):
        both.wait()
        return job, solver_threads()

    assert side_by_side(work, ["first", "second"]) == [("first", 1), ("second", 1)]
    assert solver_threads() == 2


@pytest.mark.parametrize(("threads", "jobs"), [("1", 3), ("4", 1)])
def test_what_cannot_be_shared_stays_where_it_is(monkeypatch, threads, jobs):
    """One thread or one job: no other thread, and the solver has all that the setting allows."""
    monkeypatch.setenv(VARIABLE, threads)
    own = (threading.get_ident(), int(threads))
    found = side_by_side(lambda _: (threading.get_ident(), solver_threads()), range(jobs))
    assert found == [own] * jobs


def test_jobs_within_jobs_take_no_more_threads(monkeypatch):
    """A job that shares out work does it by itself."""
    monkeypatch.setenv(VARIABLE, "2")

    def inner(_):
        return threading.get_ident()

    for seen in side_by_side(lambda _: {*side_by_side(inner, range(3)), inner(None)}, range(2)):
        assert len(seen) == 1


def test_a_job_that_fails_ends_all(monkeypatch):
    """Its own error arrives."""
    monkeypatch.setenv(VARIABLE, "2")

    def work(job):
        if job == 1:
            raise ArithmeticError("no solution")
        return job

    with pytest.raises(ArithmeticError, match="no solution"):
        side_by_side(work, range(9))
