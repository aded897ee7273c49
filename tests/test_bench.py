"""The benchmark: honest errors, one core, and a command that says whether targets are met."""

import argparse
import json
import os

import pytest

from geometry.errors import InputError
from validation.bench import beam
from validation.bench.one_core import on_one_core, peak_memory
from validation.bench.result import Bench, Target, Timing
from validation.commands import bench as command


def test_measured_alone_on_one_core():
    """A measurement runs in its own process, limited to one thread."""
    assert on_one_core("os", "getenv", "OMP_NUM_THREADS") == "1"
    assert on_one_core("os", "getpid") != os.getpid()


def test_a_failed_measurement_is_explained():
    """In one sentence with the reason and a remedy."""
    with pytest.raises(InputError, match=r"could not be finished .*--quick"):
        on_one_core("os", "no_such_measurement")


def test_memory_of_a_million_points():
    """A tenth of the ten million that have to fit into 1 GB."""
    assert 1e7 < on_one_core(beam.__name__, "memory_of", 1_000_000) < 3e8
    assert peak_memory() > 1e7


@pytest.mark.heavy
def test_memory_of_ten_million_points():
    """They fit into 1 GB."""
    assert on_one_core(beam.__name__, "memory_of", 10_000_000) < 1e9


def test_errors_of_the_ways():
    """The closed form has twelve digits everywhere, matrix A only in the paper's range."""
    narrow, wide = beam.CASES
    closed, naive = next(iter(beam._PATHS)), beam._NAIVE
    assert beam.error_of(closed, narrow) < 1e-12
    assert beam.error_of(closed, wide) < 1e-12
    assert beam.error_of(naive, narrow) < 1e-10
    assert beam.error_of(naive, wide) > 1e-3


def test_all_ways_can_be_timed():
    """Every way takes some time for a few points."""
    for path in (*beam._PATHS, beam._CASCADE, beam._NAIVE):
        assert beam.seconds_of(path, next(iter(beam.CASES)), 3000) > 0.0
    assert beam.map_seconds(2, 100, 2) > 0.0


@pytest.mark.parametrize(
    ("measured", "at_most", "met"), [(1.0, True, True), (3.0, True, False), (3.0, False, True)]
)
def test_targets(measured, at_most, met):
    """A requirement is an upper or a lower limit."""
    assert Target("what", 2.0, measured, "s", at_most, "how").met is met


@pytest.fixture
def made_up(monkeypatch):
    """Put a made-up measurement in the place of the real one."""
    timings = (Timing("way", "range", 100, 1e-3, 1e-15), Timing("other", "range", 100, 1.0, 1e9))
    targets = (Target("speed", 1e6, 1e5, "1/s", False, "how"),)
    made = Bench("tmm", "on paper", timings, targets, 0.0)
    monkeypatch.setattr(beam, "run", lambda *_: made)


def options(**changes):
    return argparse.Namespace(
        **{"only": None, "quick": True, "out": None, "json": False, **changes}
    )


def test_command(made_up, tmp_path, capsys):
    """Tables on stdout; with --out a CSV file and the time-against-error plot."""
    assert command.run(options(out=str(tmp_path))) == 0
    text = capsys.readouterr().out
    assert "100,000" in text
    assert "not met" in text
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bench-tmm.csv", "bench-tmm.svg"]


def test_command_as_json(made_up, capsys):
    """Timings and verdicts, machine-readable."""
    command.run(options(json=True))
    told = json.loads(capsys.readouterr().out)
    assert told["met"] == {"tmm": [False]}
    assert told["parts"][0]["timings"][0]["points"] == 100


def test_unknown_part_is_refused():
    """With the nearest known name."""
    with pytest.raises(InputError, match='did you mean "tmm"'):
        command.run(options(only=["tm"]))
