"""The solid's benchmark: the same job for everyone, whole rows, honest readings of the curves."""

import math

import numpy as np
import pytest

from tactgen.fem.piezo.system import materials
from tactgen.validation.evidence import bench_solid as solid
from tactgen.validation.evidence import bench_solid_jobs as jobs
from tactgen.validation.evidence import peers
from tactgen.validation.evidence.bench import front, run_parts, time_at_error
from tactgen.validation.evidence.bench_solid import ways
from tactgen.validation.evidence.peers.job import (
    LAYERS,
    SHIM,
    bricks,
    lowest_frequencies,
    planes,
    tensor,
)

COARSE = {"longest": 3e-3, "first": 2e-4, "through_piezo": 2, "across": 3}


@pytest.fixture(scope="module")
def coarse():
    return jobs.job(**COARSE)


@pytest.fixture(scope="module")
def device():
    return jobs.j1().device


def test_job_has_the_devices_lengths(coarse, device):
    """Every layer has the device's volume, whatever the grid."""
    grid, b = bricks(coarse), device.bimorph
    corners = grid.points[grid.cells]
    volumes = np.prod(corners[:, 6] - corners[:, 0], axis=1)
    assert volumes.min() > 0.0
    for layer, thickness in enumerate((b.piezo_thickness, b.piezo_thickness, b.shim_thickness)):
        whole = thickness * b.width * b.length
        assert volumes[grid.layer == layer].sum() == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize("lossy", [False, True])
def test_job_has_the_devices_tensors(coarse, device, lossy):
    """Stiffness, coupling with the poling's sign, permittivity, density and losses."""
    exact = materials(device, ("piezo_top", "shim"), device.piezo.ceramic(), lossy=lossy)
    piezo_tensors = exact["piezo_top"].piezo
    for name, wanted in (
        ("stiffness", exact["piezo_top"].c),
        ("coupling", piezo_tensors.e),
        ("permittivity", piezo_tensors.eps),
    ):
        told = tensor(coarse["ceramic"], name, lossy=lossy)
        # the lossless tensors come from another inversion of the compliances
        assert told == pytest.approx(wanted, rel=1e-12, abs=1e-12 * np.abs(wanted).max())
    shim, lost = coarse["shim"]
    assert np.array(shim["stiffness"]) == pytest.approx(exact["shim"].c, rel=1e-12)
    assert not np.any(lost["stiffness"])
    assert shim["coupling"] == []
    assert (coarse["ceramic"][0]["density"], shim["density"]) == (7500.0, 1500.0)


def test_faces_of_the_grid(coarse):
    """Every named face has its area; electrodes on the shim know both layers."""
    grid = bricks(coarse)
    width, length = coarse["width"], coarse["length"]
    thickness = coarse["shim_thickness"] + 2.0 * coarse["piezo_thickness"]
    wanted = {
        "base": width * thickness,
        "tip": width * thickness,
        "side": 2.0 * length * thickness,
        "outer": 2.0 * width * length,
        "inner": 2.0 * width * length,
    }
    found = dict.fromkeys(wanted, 0.0)
    for face in grid.faces():
        a, b, c = (grid.points[face.quads[:, i]] for i in (0, 1, 3))
        found[face.name] += np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
        assert (face.behind == SHIM) is (face.name == "inner")
    assert found == pytest.approx(wanted, rel=1e-12)


def test_structured_tetrahedra_fill_the_bricks(coarse):
    """Six per brick, all positive, faces cut as the cells are."""
    mesh = jobs.layered_tetrahedra(*planes(coarse), 0.5 * coarse["shim_thickness"])
    p = mesh.points[mesh.cells]
    volumes = np.linalg.det(p[:, 1:] - p[:, :1]) / 6.0
    assert volumes.min() > 0.0
    thickness = coarse["shim_thickness"] + 2.0 * coarse["piezo_thickness"]
    assert volumes.sum() == pytest.approx(thickness * coarse["width"] * coarse["length"])
    sides = {tuple(sorted(cell[list(f)])) for cell in mesh.cells for f in FACES}
    assert mesh.regions == LAYERS
    assert len(mesh.faces) == 6
    assert all(tuple(sorted(t)) in sides for faces in mesh.faces.values() for t in faces)


FACES = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))


def test_lowest_frequencies_of_a_chain():
    """Lanczos with a given inverse finds the exact frequencies of a fixed-free chain."""
    n = 40
    stiffness = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    stiffness[-1, -1] = 1.0
    inverse = np.linalg.inv(stiffness)
    found = lowest_frequencies(lambda v: inverse @ v, lambda v: v, n, 4)
    angles = (2.0 * np.arange(1, 5) - 1.0) * np.pi / (2.0 * (2 * n + 1))
    assert found == pytest.approx(2.0 * np.sin(angles) / (2.0 * np.pi), rel=1e-9)


def test_own_families_solve_both_jobs():
    """All values within a coarse mesh's error of the published ones, all phases timed."""
    found = jobs.solve_own("bricks of high order", 0, [])
    values = solid.values_of(found)
    assert values[:5] == pytest.approx(solid.PUBLISHED, rel=1e-2)
    assert set(found["seconds"]) == {"mesh", "assembly", "factor", "solve", "eigen"}
    assert min(found["process_seconds"], found["peak_memory"], found["unknowns"]) > 0
    swept = jobs.solve_own("bricks of high order", 0, [10.0, 100.0])
    assert complex(*swept["sweep"][0]).real == pytest.approx(values[0], rel=1e-2)
    assert set(swept["seconds"]) == {"mesh", "assembly", "sweep"}
    # quadratic bricks need three in a half-wave of the second bending mode
    shorter = jobs.job(**{**COARSE, "longest": 1.5e-3})
    hexes = jobs.solve_own("hexahedra of 20 nodes", shorter, [])
    assert solid.values_of(hexes)[:5] == pytest.approx(solid.PUBLISHED, rel=1e-2)


def test_missing_peer_is_one_sentence(monkeypatch):
    """With the remedy, and without it in the ways that are run."""
    monkeypatch.setitem(peers.PEERS, "NGSolve", ("no_such_package", "nowhere"))
    assert peers.missing("NGSolve") == (
        "no_such_package is not installed; run: pip install -e '.[peers]'"
    )
    assert not any(level.path.startswith("NGSolve") for level in ways(quick=True))


def test_python_that_is_not_there(monkeypatch):
    """The variable is named, not shown as a traceback."""
    monkeypatch.setenv(peers.PYTHON, "/nowhere/python")
    assert "TACTGEN_PEERS = /nowhere/python cannot be run" in peers.missing("SfePy")


@pytest.mark.parametrize(("quick", "fine"), [(True, 3), (False, 4)])
def test_the_reference_is_the_finer_of_two_with_the_models_bar(monkeypatch, quick, fine):
    """What the coarser differs by, times the solid model's factor; of the sweep the largest."""

    def own(family, level):
        off = {fine: 1.0, fine - 1: 1.01}[level]
        values = {"deflection": 2.0 * off, "natural": [3.0 * off, 4.0], "capacitance": 5.0}
        return lambda sweep: {**values, "sweep": [(6.0, 0.0), (0.0, 7.0 * off**2)][: len(sweep)]}

    monkeypatch.setattr(solid, "own", own)
    found = solid._reference(quick, lambda _: None)
    assert found.values.tolist() == [2.0, 3.0, 4.0, 5.0]
    assert found.bars == pytest.approx(solid.BRICK_FACTOR * np.array([0.01, 0.01, 0.0, 0.0]))
    assert found.sweep.tolist() == [6.0, 7.0j]
    assert found.sweep_bar == pytest.approx(solid.BRICK_FACTOR * 0.0201)


def test_time_at_an_error():
    """Between neighbours of the front in logarithms, never beyond its ends."""
    points = [(1.0, 1e-2), (2.0, 5e-2), (4.0, 1e-4)]
    assert front(points) == [(1.0, 1e-2), (4.0, 1e-4)]
    assert time_at_error(points, 1e-3) == pytest.approx(2.0)
    assert time_at_error(points, 0.5) == 1.0
    assert time_at_error(points, 1e-5) == math.inf
    assert time_at_error([], 1e-3) == math.inf


def timing(case="J1", own=True, seconds=1.0, error=1e-3, path="ours", **others):
    errors = {"sweep": error} if case == "J2" else dict.fromkeys(solid.VALUES, error) | others
    found = {
        "unknowns": 10, "seconds": {"mesh": seconds}, "process_seconds": 1.0, "peak_memory": 1,
    }  # fmt: skip
    return solid.timing_of(solid.Level(path, "1", None, swept=False, own=own), case, found, errors)


def test_capacitance_is_shown_but_not_judged():
    """The requirement speaks of deflection and natural frequencies."""
    row = timing(capacitance=1.0)
    assert row.error == 1e-3
    assert row.values["error_capacitance"] == 1.0


def test_targets():
    """Times at an error; ratios to the best peer; none of these without a peer."""
    ours = [timing(seconds=0.5), timing(seconds=4.0, error=5e-5), timing("J2", error=1e-4)]
    assert [target.met for target in solid.targets_of(ours)] == [True, True]
    theirs = [
        timing(own=False, seconds=2.0, path="A"), timing(own=False, seconds=9.0, path="B"),
        timing("J2", own=False, seconds=80.0, path="A", error=1e-3),
    ]  # fmt: skip
    _, _, ratio, sweep = solid.targets_of(ours + theirs)
    assert (ratio.measured, ratio.met) == (pytest.approx(4.0), False)
    assert (sweep.measured, sweep.met) == (pytest.approx(80.0), True)


def test_far_targets_are_not_met():
    """Neither a time nor a ratio is made up from a curve that ends too early."""
    first, second, ratio, _ = solid.targets_of(
        [timing(error=1e-2), timing(own=False, error=1e-3), timing("J2"), timing("J2", own=False)]
    )
    assert first.measured == second.measured == math.inf
    assert math.isnan(ratio.measured)
    assert not any(target.met for target in (first, second, ratio))
    rows = [timing("J2", error=1e-2), timing("J2", own=False, seconds=99.0, error=1e-3)]
    assert solid.targets_of(rows)[-1].measured == 0.0  # an error that we do not reach


def test_sample_has_the_steepest_places():
    """The flank of a resonance is in it, and so are both ends."""
    f = np.geomspace(10.0, 1000.0, 200)
    sweep = 1.0 / (1.0 - (f / 300.0) ** 2 + 0.02j)
    reference = solid.Reference(np.zeros(6), np.zeros(6), f, sweep, 0.0)
    chosen = solid.sample(reference, 8)
    assert {0, 199} <= set(chosen)
    assert np.abs(f[chosen] / 300.0 - 1.0).min() < 0.02


@pytest.mark.heavy
@pytest.mark.parametrize("peer", list(peers.PEERS))
def test_peer_reproduces_the_job(peer):
    """Deflection, f1 to f4 and the sweep at 10 Hz within this mesh's error of the published."""
    if sentence := peers.missing(peer):
        pytest.skip(sentence)
    fineness = jobs.job(order=3, across=3, longest=3e-3, first=1e-4)
    values = solid.values_of(peers.solve(peer, fineness))
    assert values[:5] == pytest.approx(solid.PUBLISHED, rel=1e-3)
    swept = peers.solve(peer, fineness, [10.0])["sweep"][0]
    assert complex(*swept) == pytest.approx(values[0], rel=5e-3)  # losses, and the first mode


@pytest.mark.heavy
def test_benchmark_runs():
    """The quick run has rows of both jobs, and its reference agrees with the published values."""
    (made,) = run_parts(["piezo"], True, lambda _: None)
    assert {row.case for row in made.timings if row.own} == {"J1", "J2"}
    best = min((row for row in made.timings if row.case == "J1"), key=lambda row: row.error)
    assert best.error < 1e-3
