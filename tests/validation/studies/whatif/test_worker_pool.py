"""Batches among processes that die: threads stand for them, and one of them takes all along."""

from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from typing import ClassVar

import pytest

from tactgen.validation.studies.whatif import workers
from tactgen.validation.studies.whatif.answers import Busy
from tactgen.validation.studies.whatif.schedule import Batch
from tactgen.validation.studies.whatif.workers import Job, work_through


class Pool:
    """Works at once; dies with all that was given to it when it meets a deadly job."""

    deadly: ClassVar[frozenset] = frozenset()
    seen: ClassVar[list] = []
    made: ClassVar[int] = 0

    def __init__(self, processes):
        self.processes, self.broken = processes, False
        Pool.made += 1
        assert Pool.made < 20, "pool after pool, without end"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def submit(self, work, jobs, options):
        future = Future()
        numbers = [job.number for job in jobs]
        Pool.seen.append((self.processes, numbers, options))
        if self.broken:
            raise BrokenProcessPool
        if self.deadly & set(numbers):
            self.broken = True
            future.set_exception(BrokenProcessPool())
        else:
            future.set_result(work(jobs, options))
        return future


@pytest.fixture
def pool(monkeypatch):
    monkeypatch.setattr(workers, "Workers", Pool)
    monkeypatch.setattr(Pool, "deadly", frozenset())
    monkeypatch.setattr(Pool, "seen", [])
    monkeypatch.setattr(Pool, "made", 0)

    def answer(asked, values, announce, earlier, *, retry, patient):
        if asked == "busy":
            raise Busy
        return asked, values["at"], retry, patient

    wait = workers.wait

    def waits_for_some(futures, return_when):
        assert futures, "nothing runs, and something is waited for: without end"
        return wait(futures, return_when=return_when)

    monkeypatch.setattr(workers, "answer", answer)
    monkeypatch.setattr(workers, "wait", waits_for_some)
    return Pool


def jobs(*asked):
    return [Job(number, name, {"at": 10 * number}) for number, name in enumerate(asked)]


BATCHES = [Batch((0, 1), frozenset()), Batch((2,), frozenset({0})), Batch((3, 4), frozenset())]


@pytest.mark.parametrize("processes", [1, 2])
def test_every_job_is_answered_once_and_busy_ones_by_none(pool, processes):
    """In this process or in others; a batch waits for what it comes after."""
    asked = jobs("a", "b", "busy", "c", "d")
    found = dict(work_through(BATCHES, asked, processes, lambda _: None, retry=True, patient=False))
    assert found == {
        0: ("a", 0, True, False), 1: ("b", 10, True, False), 2: None,
        3: ("c", 30, True, False), 4: ("d", 40, True, False),
    }  # fmt: skip
    if processes == 2:
        given = [numbers for _, numbers, _ in pool.seen]
        assert sorted(given) == [[0, 1], [2], [3, 4]]
        assert given.index([0, 1]) < given.index([2])
        assert all(options == {"retry": True, "patient": False} for *_, options in pool.seen)
        assert {count for count, *_ in pool.seen} == {2}
    else:
        assert not pool.seen


def test_a_job_that_kills_its_process_takes_no_other_along(pool, monkeypatch):
    """What was in the pool is asked again, each alone; who waited for it goes on."""
    monkeypatch.setattr(pool, "deadly", frozenset({1}))
    asked = jobs("a", "b", "e", "c", "d")
    found = dict(work_through(BATCHES, asked, 2, lambda _: None, retry=False, patient=True))
    assert set(found) == {0, 1, 2, 3, 4}
    assert found[1].status == "failed"
    assert "--jobs" in found[1].reason
    assert {n: a[0] for n, a in found.items() if n != 1} == {0: "a", 2: "e", 3: "c", 4: "d"}
    alone = [numbers for count, numbers, _ in pool.seen if count == 1]
    assert [0] in alone
    assert [1] in alone


def test_no_more_is_given_out_than_keeps_all_busy(pool, monkeypatch):
    """Two batches a process wait at a time; the others until one of those is done."""
    running = []

    def wait(futures, return_when):
        running.append(len(futures))
        first = next(iter(futures))
        return type("Done", (), {"done": [first]})

    monkeypatch.setattr(workers, "wait", wait)
    batches = [Batch((n,), frozenset()) for n in range(9)]
    found = list(work_through(batches, jobs(*"abcdefghi"), 2, lambda _: None, retry=False,
                              patient=False))  # fmt: skip
    assert sorted(number for number, _ in found) == list(range(9))
    assert max(running) == 4
