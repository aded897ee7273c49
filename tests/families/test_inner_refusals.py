"""Refusals that no command reaches at a small cost, provoked where they are said."""

import subprocess
import sys
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from tactgen.geometry.cad import solids
from tactgen.geometry.cad.tessellation import Plane
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError, MeshError
from tactgen.geometry.meshing.tetwild import conform as snapping
from tactgen.tmm.generator.equilibrium import resting_places
from tactgen.tmm.generator.transient import time_integration as passes
from tactgen.tmm.harmonic_balance import continuation
from tactgen.tmm.harmonic_balance.balance import NoConvergence, Orbit
from tactgen.validation.models import backbone
from tactgen.validation.models.display import spread
from tactgen.validation.scene import files as frequencies
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show import browser, pictures
from tactgen.validation.studies.whatif import executor
from tactgen.validation.studies.whatif.pictures import study_picture


def scene(name="paper", *overrides):
    return load_scene(name, list(overrides))[0]


UPWARD = Stub(lifts=lambda: np.array([0.0, 1.0]), total=lambda *_: np.ones(2), device=Device())
FAILED = Stub(rows=[(None, "tmm", Stub(status="failed"))])


@pytest.mark.parametrize(
    ("what", "error", "words"),
    [
        (
            lambda: snapping.snapped(
                np.zeros((1, 3)), np.array([0]), np.array([0]),
                [Plane((0.0, 0.0, 1.0), 1.0)], 0.5,
            ),
            MeshError, "would have to move 1e.03 um",
        ),
        (
            lambda: solids._only_solid(Stub(Solids=lambda: [1, 2])),
            InputError, "falls into 2 pieces",
        ),
        (lambda: resting_places(UPWARD, 0.05), InputError, "nowhere between its stops at coil"),
        (
            lambda: spread(scene("display", "spring.stiffness=0 N/m"), None),
            InputError, "give the spring a stiffness",
        ),
        (lambda: study_picture(FAILED), InputError, "nothing to draw"),
        (
            lambda: passes.Marcher._keep(
                Stub(_system=Stub(coil=Stub(largest_current=1.0, gaps=(1e-4, 2e-4)))),
                None, 1e-3, Stub(current=0.5, gap=3e-4), None, 0.0,
            ),
            InputError, "at 1 ms the gap is 300 um, outside the 100 to 200 um of the co-energy map",
        ),
        (
            lambda: snapping.snapped(
                np.zeros((1, 3)), np.array([0, 0]), np.array([0, 1]),
                [Plane((0.0, 0.0, 1.0), 0.0), Plane((0.0, 0.0, 1.0), 1.0)], np.inf,
            ),
            MeshError, "belongs to faces that do not meet; choose a smaller edge length",
        ),
    ],
)  # fmt: skip
def test_each_is_said(what, error, words):
    """The sentence names what is wrong."""
    with pytest.raises(error, match=words):
        what()


def test_a_cluster_that_is_lost(monkeypatch):
    """What it raises is said; a scheduler that ended is not waited for."""

    def gone(timeout):
        raise OSError("closed")

    monkeypatch.setitem(sys.modules, "distributed", Stub(KilledWorker=KeyError))
    pool = executor._Cluster(Stub(status="closed"), ("tmm",), None)
    with pytest.raises(InputError, match=r"the cluster was lost \(OSError: closed\); "):
        pool.result(Stub(result=gone))
    with pytest.raises(InputError, match="the scheduler ended; "):
        pool.ended([Stub(done=lambda: False)])


def test_a_cluster_without_workers_is_left_after_a_while(monkeypatch):
    """A minute after the last one went: as long as there are some, it may take its time."""
    hours = Stub(monotonic=iter(range(0, 10_000, 25)).__next__, sleep=lambda _: None)
    there = iter([2, 0, 1, 0, 0, 0])
    client = Stub(status="running", nthreads=lambda: {"worker": 1} if next(there) else {})

    monkeypatch.setattr(executor, "time", hours)
    pool = executor._Cluster(client, ("tmm",), None)
    with pytest.raises(InputError, match="the cluster has had no worker for 60 s; "):
        pool.ended([Stub(done=lambda: False)])
    assert list(there) == []


def test_a_film_that_is_not_made(monkeypatch, tmp_path):
    """What ffmpeg says last is quoted, and nothing is left."""
    failed = Stub(returncode=1, stderr=b"first\nUnknown encoder\n")
    monkeypatch.setattr(pictures, "check_ffmpeg", lambda _: None)
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: failed)
    picture = Stub(tobytes=lambda: b"", size=(2, 2))
    with pytest.raises(InputError, match="ffmpeg says: Unknown encoder; write --gif"):
        pictures.save_film(tmp_path / "a.mp4", [picture], 40)
    assert not list(tmp_path.iterdir())


def test_orbits_that_are_lost_are_refused(monkeypatch):
    """No response to begin with, a branch that ends, a rod between its stops, a step back."""

    def lost(*_, **__):
        raise NoConvergence("lost")

    course = Stub(pack=lambda _: np.zeros(2), unpack=lambda *_: Stub(omega=-1.0))
    with pytest.raises(NoConvergence, match="negative frequency"):
        continuation._advance(None, Stub(course=course, tangent=np.ones(2), orbit=None), 1.0)
    head = Stub(oscillator=None)
    monkeypatch.setattr(backbone, "steady_orbit", lost)
    with pytest.raises(InputError, match=r"--voltage 5 V no response was found .* lost"):
        backbone.response_branch(head, 5.0, (10.0, 20.0))
    rest = Stub(with_harmonics=lambda _: Orbit(1.0, 0.0, np.zeros((2, 1))))
    monkeypatch.setattr(backbone, "equilibrium", lambda _: rest)
    for ended, level in (("lost", 5.0), ("", 4.0)):
        branch = Stub(ended=ended, orbits=[Stub(level=level)])
        monkeypatch.setattr(backbone, "follow", lambda *_, found=branch, **__: found)
        with pytest.raises(InputError, match="cannot be followed up to 5 V"):
            backbone._raised(head, 100.0, 5.0)
    monkeypatch.setattr(backbone, "resting_place", lambda *_: Stub(kind="floating"))
    with pytest.raises(InputError, match="leaves the rod between its stops"):
        backbone.held_head(scene("generator"))


def test_a_list_of_very_many_frequencies(monkeypatch):
    """A sweep says the same of its number."""
    monkeypatch.setattr(frequencies, "_MOST", 2)
    with pytest.raises(InputError, match="has 3 values; give at most 2"):
        frequencies.parse_frequencies([10.0, 20.0, 30.0])


def test_a_browser_that_does_not_end(monkeypatch):
    """After its time it is said which page was not finished."""

    def waits(command, **_):
        raise subprocess.TimeoutExpired(command, 1.0)

    monkeypatch.setattr(subprocess, "run", waits)
    with pytest.raises(InputError, match=r"did not finish page\.html in"):
        browser.run_browser("chromium", "page.html")


def test_a_kernel_that_does_not_write(monkeypatch, tmp_path):
    """Nothing is left in the folder."""
    kernel = Stub(exportAssembly=lambda *_: False)
    monkeypatch.setitem(sys.modules, "cadquery.occ_impl.exporters.assembly", kernel)
    with pytest.raises(InputError, match=r"cannot be written \(the CAD kernel .*\); make room"):
        solids.write_step(None, tmp_path / "a.step")
    assert not list(tmp_path.iterdir())
