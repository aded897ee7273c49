"""The benchmark: honest errors, one core, and a command that says whether targets are met."""

import argparse
import json
import math
import os
import resource
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands import evidence as command
from tactgen.validation.evidence import bench_beam as beam
from tactgen.validation.evidence import bench_reluctance as magnetics
from tactgen.validation.evidence import bench_timing as one_core
from tactgen.validation.evidence.bench import Bench, Target, Timing, print_bench
from tactgen.validation.evidence.bench_timing import on_one_core, peak_memory


def test_measured_alone_on_one_core():
    """A measurement runs in its own process, limited to one thread, and finds nothing cached."""
    for limit in ("OMP_NUM_THREADS", "TACTGEN_THREADS"):
        assert on_one_core("os", "getenv", limit) == "1"
    assert on_one_core("os", "getpid") != os.getpid()
    assert on_one_core("os", "getenv", "TACTGEN_CACHE") != os.environ["TACTGEN_CACHE"]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="limits are told by /proc")
def test_a_measurement_keeps_within_a_limit_that_is_there():
    """A hard limit below the free memory, which nobody can raise, is no failure."""
    most = 2**30
    code = (
        "import resource; from tactgen.validation.evidence import bench_timing as one_core; "
        f"resource.setrlimit(resource.RLIMIT_AS, ({most}, {most})); "
        "one_core._keep_within_memory(); print(resource.getrlimit(resource.RLIMIT_AS)[0])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) <= most


def test_a_failed_measurement_is_explained():
    """In one sentence with the last line that it wrote, if any, and a remedy."""
    words = r"no_such_measurement could not be finished \(AttributeError: .*\); .*--quick"
    with pytest.raises(InputError, match=words):
        on_one_core("os", "no_such_measurement")
    with pytest.raises(InputError, match=r"_exit could not be finished \(no message\); "):
        on_one_core("os", "_exit", 3)


@pytest.mark.parametrize(("system", "unit"), [("linux", 1024), ("darwin", 1)])
def test_memory_without_proc_is_what_getrusage_counts(monkeypatch, system, unit):
    """Kilobytes, but bytes on macOS (the manual pages of getrusage)."""
    said = SimpleNamespace(ru_maxrss=7)
    monkeypatch.setattr(one_core, "_kilobytes", Mock(side_effect=OSError))
    monkeypatch.setattr(resource, "getrusage", lambda who: said)
    monkeypatch.setattr(one_core.sys, "platform", system)
    assert peak_memory() == 7 * unit


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


def test_point_of_the_normal_actuator():
    """What the reference and each way bring back; finer is nearer and has a smaller bar."""
    coarse, fine = (magnetics.point_of(order, 0.5, 1) for order in (2, 3))
    assert coarse["unknowns"] < fine["unknowns"]
    assert 0.0 < fine["force_bar"] < coarse["force_bar"]
    assert min(coarse["seconds"], magnetics.map_seconds(2, 2)) > 0.0


@pytest.mark.parametrize("potential", ["A", pytest.param("φ", marks=pytest.mark.heavy)])
def test_team20_in_a_process_of_its_own(potential):
    """A coarse mesh is within a quarter of the 80.1 N that were measured."""
    found = on_one_core(magnetics.__name__, "solid_of", potential, 3.0)
    assert found["force"] == pytest.approx(80.1, rel=0.25)
    assert found["unknowns"] > 1000 > found["coenergy"] > 0.0
    assert found["seconds"] > 0.0


def field_timings(error):
    """One grid with the given error in flux linkage and in force, and a dearer one without."""
    cases = ((magnetics._LINKAGE_CASE, 5e-4), (magnetics._WORK, 1e-3))
    return [
        magnetics.timing_of(f"order {order}", "1", case, {"unknowns": 10, "seconds": seconds}, 1.0,
                            "N", miss, wanted)
        for order, seconds, miss in ((2, 0.5, error), (4, 1.0, 1e-5))
        for case, wanted in cases
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("error", "bar", "seconds", "met"),
    [
        (1e-4, 1e-4, 0.5, True), (4.5e-4, 1e-4, 1.0, True), (7e-4, 1e-4, 1.0, True),
        (1e-4, 1e-2, math.inf, False),
    ],
)  # fmt: skip
def test_cheapest_way_within_both_errors_is_judged(error, bar, seconds, met):
    """With the reference's own bar added; both force and flux linkage count."""
    reference = {"flux_linkage_bar": bar, "force_bar": bar}
    point, mapped = magnetics._targets(field_timings(error), reference, 61.0)
    assert point.measured == seconds
    assert point.met is met
    assert not mapped.met


def test_command_shows_fields(monkeypatch, tmp_path, capsys):
    """The same command for the magnetic part: its own columns, its own files."""
    made = Bench("magnetics", "on paper", tuple(field_timings(1e-4)), (), 0.0)
    monkeypatch.setattr(magnetics, "run", lambda *_: made)
    assert command._bench(options(only=["magnetics"], out=tmp_path)) == 0
    assert "flux linkage" in capsys.readouterr().out
    head = (tmp_path / "bench-magnetics.csv").read_text().splitlines()[0]
    assert head == "way,fineness,result,unknowns,seconds,value,unit,error"


@pytest.mark.heavy
def test_magnetic_targets_are_met():
    """Force within 0.1 %, flux linkage within 0.05 % in 2 s; a 10 x 10 map in a minute."""
    assert all(target.met for target in magnetics.run(True, lambda _: None).targets)


@pytest.fixture
def made_up(monkeypatch):
    """Put a made-up measurement in the place of the real one."""
    timings = (
        beam.timing_of("way", "range", 100, 1e-3, 1e-15),
        beam.timing_of("other", "range", 100, 1.0, 1e9),
    )
    targets = (Target("speed", 1e6, 1e5, "1/s", False, "how"),)
    made = Bench("tmm", "on paper", timings, targets, 0.0)
    monkeypatch.setattr(beam, "run", lambda *_: made)


def options(**changes):
    return argparse.Namespace(
        **{"only": None, "quick": True, "out": None, "json": False, **changes}
    )


def test_command(made_up, tmp_path, capsys):
    """Tables on stdout, or JSON; with --out a CSV file and the time-against-error plot."""
    assert command._bench(options(only=["tmm"], out=tmp_path)) == 0
    text, err = capsys.readouterr()
    assert "100,000" in text
    assert "not met" in text
    assert err.endswith(f"{tmp_path / 'bench-tmm.csv'}\n{tmp_path / 'bench-tmm.svg'}\n")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bench-tmm.csv", "bench-tmm.svg"]
    command._bench(options(only=["tmm"], json=True))
    told = json.loads(capsys.readouterr().out)
    assert told["met"] == {"tmm": [False]}
    assert told["parts"][0]["timings"][0]["values"]["points"] == 100


def test_unknown_part_is_refused():
    """With the nearest known name."""
    with pytest.raises(InputError, match='did you mean "tmm"'):
        command._bench(options(only=["tm"]))


def test_tables_fit_a_terminal(capsys):
    """Of many steps and errors the sum and the worst are shown, on 100 columns."""
    steps = {f"step{n}_seconds": 1.0 for n in range(6)} | {f"error_{n}": 1e-3 for n in range(8)}
    values = {"way": "a way of many words, on a mesh", "unknowns": 123456, **steps}
    part = Bench("piezo", "on one core", (Timing("way", "J1", 6.0, 1e-3, values),), (), 6.0)
    print_bench([part])
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 100
    assert "123,456" in shown
    assert "1.0e-03" in shown
