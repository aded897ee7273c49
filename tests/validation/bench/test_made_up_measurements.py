"""The benchmark's runs on made-up measurements: what is asked for, and what is told of it."""

import numpy as np
import pytest
from approved import described

from tactgen.validation.bench import one_core, reluctance, skip, solver
from tactgen.validation.bench.bimorph import beam, meshes, solid, ways
from tactgen.validation.bench.bimorph.jobs import j1

#: Of TEAM problem 20 by potential: co-energy (J) and force (N) over those of a fine mesh.
TEAM = {"A": 0.98, "φ": 1.02}


@pytest.fixture
def measured(monkeypatch):
    """Put numbers in place of processes; return all that was asked of those."""
    asked = []

    def alone(module, function, *arguments):
        asked.append((function, *arguments))
        if function == "seconds_of":
            path, _, points = arguments
            return points / (2e6 if path == beam._CLOSED else 1e6)
        if function == "point_of":
            order, fineness, _ = arguments
            off = 1e-2 / order**4 / fineness**2 if order < 5 else 0.0
            return {
                "order": order, "refinement": fineness, "seconds": order * fineness,
                "unknowns": 10 * order, "flux_linkage": 2.0 * (1.0 + off), "force": 3.0 + off,
                "force_eggshell": 3.0 - 5.0 * off, "flux_linkage_bar": 1e-6, "force_bar": 1e-6,
            }  # fmt: skip
        if function == "solid_of":
            name, scale = arguments
            share = 1.0 + scale * (TEAM[name] - 1.0)
            return {"seconds": 1.0, "unknowns": 100.0, "force": 80.0 * share, "coenergy": 4 * share}
        return {"map_seconds": 1.5, "memory_of": 5e8}[function]

    for module in (beam, reluctance):
        monkeypatch.setattr(module, "on_one_core", alone)
    return asked


@pytest.mark.parametrize(("quick", "points"), [(True, 100_000), (False, 1_000_000)])
def test_every_way_of_the_beam_is_timed_over_both_ranges(
    measured, monkeypatch, quick, points, told
):
    """The slow ways take a twentieth of the points; targets read the chosen way's rate."""
    monkeypatch.setattr(beam, "error_of", lambda path, case: 1e-13)
    found = beam.run(quick, lambda _: None)
    rows = {(t.path, t.case): t for t in found.timings}
    assert len(rows) == 2 * (len(beam._PATHS) + 2) == len(found.timings)
    for (path, _), row in rows.items():
        assert row.points == (points if path in beam._PATHS else points // 20)
        assert row.rate == pytest.approx(2e6 if path == beam._CLOSED else 1e6)
        assert row.cost == pytest.approx(1e9 / row.rate)
        assert len(row.cells) == len(row.columns)
        assert len(row.values) == len(row.fields)
    rate, mapped, memory = found.targets
    assert (rate.measured, rate.at_most, rate.met) == (pytest.approx(2e6), False, True)
    assert (mapped.measured, mapped.at_most, mapped.met) == (1.5, True, True)
    assert (memory.measured, memory.at_most, memory.met) == (5e8, True, True)
    assert measured[-2:] == [("map_seconds", 200, 2000, 3), ("memory_of", 10 * points)]
    assert "200 lengths x 2000 frequencies x 3 loads" in mapped.what
    # asked for: 1.5 million points a second, the map in 2 s, all in 1 GB
    assert [target.wanted for target in found.targets] == [1.5e6, 2.0, 1e9]
    told(found)


@pytest.mark.parametrize(
    ("quick", "grids", "scales"),
    [(True, 6, [1.4, 3.0, 2.0]), (False, 15, [0.8, 3.0, 2.0, 1.4, 1.0])],
)
def test_fields_are_timed_against_a_finer_one(measured, quick, grids, scales, told):
    """Linkage and both forces by grid; TEAM problem 20 between both potentials."""
    found = reluctance.run(quick, lambda _: None)
    half = [t for t in found.timings if t.path.startswith("order")]
    team = [t for t in found.timings if not t.path.startswith("order")]
    assert len(half) == 3 * grids
    assert len(team) == 4 * (len(scales) - 1)
    assert [one[2] for one in measured if one[0] == "solid_of"][::2] == scales
    for row in half:
        order, fineness = int(row.path.split()[1]), float(row.level)
        off = 1e-2 / order**4 / fineness**2
        expected = {
            reluctance._LINKAGE_CASE: off, reluctance._WORK: off / 3.0,
            reluctance._STRESS: 5.0 * off / 3.0,
        }[row.case]  # fmt: skip
        assert row.error == pytest.approx(expected, rel=1e-6)
        assert (row.unknowns, row.seconds) == (10 * order, order * fineness)
    repeats = {one[3] for one in measured if one[0] == "point_of" and one[1] < 5}
    assert repeats == {1 if quick else 3}
    for row in team:
        scale = float(row.level.removeprefix("1/"))
        share = scale * 0.02  # either potential is as far off; their mean is exact
        assert row.error == pytest.approx(share, rel=1e-9)
        assert row.value == pytest.approx((80.0 if row.unit == "N" else 4.0) * (
            1.0 + scale * (TEAM[row.path] - 1.0)))  # fmt: skip
    assert ("map_seconds", 10, 10) in measured
    assert found.targets[1].measured == 1.5
    assert f"each {0.02 * scales[0]:.0e} from that" in found.conditions
    told(found)


def made_answers(scene, *, seconds, computed, answers=(1.0,)):
    return {
        "answers": list(answers), "computed": computed, "asked": ["solid.ports", "tmm.ports"],
        "seconds": seconds, "modules": 7, "watched": [], "skipped": 3,
    }  # fmt: skip


def test_a_scene_is_solved_alone_and_with_the_store_it_starts_from(monkeypatch, told):
    """Cold from an empty store; warm from its own, or from that of the scene it comes after."""
    asked = []

    def solved(case, store):
        asked.append((case.name, store.name))
        warm = store.name == f"cold {case.after}" or (case.name, store.name) in asked[:-1]
        done = [] if warm and case.name != "changed density" else ["solid.ports", "tmm.ports"]
        return made_answers(case, seconds=1.0 if warm else 2.0, computed=done)

    monkeypatch.setattr(skip, "solved", solved)
    found = skip.run(False, lambda _: None)
    stores = dict(zip([name for name, _ in asked[1::2]], [s for _, s in asked[1::2]], strict=True))
    assert stores["changed load"] == "cold piezo only"
    assert stores["TMM only"] == "cold TMM only"
    assert all(store == f"cold {name}" for name, store in asked[::2])
    needless, slowest = found.targets
    assert (needless.measured, needless.met) == (0.0, True)
    assert slowest.measured == 0.5
    rows = {(t.case, t.path): t for t in found.timings}
    assert len(rows) == 2 * len(skip.cases())
    row = rows["changed load", "warm"]
    assert (row.reused, row.computed, row.error) == (("solid.ports", "tmm.ports"), (), 0.0)
    assert (rows["changed load", "cold"].reused, row.skipped, row.modules) == ((), 3, 7)
    assert len(row.cells) == len(row.columns)
    assert len(row.values) == len(row.fields)
    assert row.cells[-1] == "bit for bit"
    assert found.seconds == sum(t.seconds for t in found.timings)
    told(found)


def test_a_warm_answer_that_differs_is_a_fault(monkeypatch, told):
    """Counted, named, and shown in its row; a quick run solves no field."""

    def solved(case, store):
        first = not store.exists()
        store.mkdir(exist_ok=True)
        return made_answers(case, seconds=1.0, computed=["x"], answers=[1.0 if first else 2.0])

    monkeypatch.setattr(skip, "solved", solved)
    found = skip.run(True, lambda _: None)
    (needless,) = found.targets
    assert needless.measured == len(found.timings) / 2 == 5.0
    assert needless.how.startswith("TMM only answers otherwise when warm; ")
    assert [t.error for t in found.timings] == 5 * [0.0, 1.0]
    assert found.timings[1].cells[-1] == "they differ"
    told(found)


def level(*, own, swept=True):
    def solve(frequencies):
        values = {"deflection": 1.0, "natural": [2.0, 3.0, 4.0, 5.1], "capacitance": 6.0}
        sweep = [(2.0 * f, 0.0) for f in frequencies]
        seconds = {"mesh": 1.0, "sweep": 0.5 * len(frequencies)}
        return {**values, "sweep": sweep, "seconds": seconds, "unknowns": 9,
                "process_seconds": 3.0, "peak_memory": 8}  # fmt: skip

    return ways.Level("way", "2", solve, swept, own)


@pytest.mark.parametrize(("own", "seconds"), [(True, 10.0), (False, 10.0)])
def test_a_way_runs_the_job_and_the_sweep(own, seconds, approved):
    """Errors with the reference's bar; a sample's time is scaled up to all frequencies."""
    f = np.geomspace(10.0, 1000.0, 20)
    bars = np.full(6, 1e-3)
    reference = solid.Reference(
        np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), bars, f, 2.1 * f + 0j, 0.0
    )
    one, two = solid._timings(level(own=own), reference, 4)
    assert (one.case, two.case, one.path, one.level, one.own) == ("J1", "J2", "way", "2", own)
    assert one.errors == pytest.approx(dict.fromkeys(solid.VALUES, 1e-3) | {"f4": 0.021})
    assert two.errors == {"sweep": pytest.approx(0.1 / 2.1)}
    assert two.phases["sweep"] == pytest.approx(seconds)
    assert (one.unknowns, one.process_seconds, one.peak_memory) == (9, 3.0, 8)
    assert len(list(solid._timings(level(own=own, swept=False), reference, 4))) == 1
    approved(described([one, two]))


def test_the_solids_run_says_what_is_missing_and_how_far_the_reference_is(monkeypatch, approved):
    """Absent peers are told at once; distances from the published values are shown."""
    values = np.append(solid.PUBLISHED * (1.0 + 2e-4), 1e-9)
    reference = solid.Reference(values, np.full(6, 3e-5), np.array([1.0]), np.array([1.0]), 7e-4)
    monkeypatch.setattr(solid, "missing", lambda peer: f"{peer} is not there")
    monkeypatch.setattr(solid, "_reference", lambda quick, announce: reference)
    monkeypatch.setattr(solid, "ways", lambda quick: [level(own=True, swept=False)])
    sampled = []
    monkeypatch.setattr(
        solid, "_timings", lambda way, right, number: sampled.append(number) or [way]
    )
    monkeypatch.setattr(solid, "targets_of", lambda timings: timings)
    said = []
    found = [solid.run(quick, said.append) for quick in (True, False)]
    assert sampled == [4, 12]
    assert said[: len(solid.PEERS)] == [f"piezo: {peer} is not there" for peer in solid.PEERS]
    assert found[0].conditions.endswith(" ".join(f"{p} is not there." for p in solid.PEERS))
    assert "2e-04 (1e-05), 2e-04 (3e-05)" in found[0].conditions
    assert "deflection -6.759552e-07 ± 3e-05, f1 1066.173 ± 3e-05" in found[0].conditions
    assert "sweep ± 7e-04" in found[0].conditions
    assert len(found[0].timings) == 1
    approved(described([one.conditions for one in found]))


@pytest.mark.parametrize("peer", ["NGSolve", "SfePy"])
def test_peers_get_bricks_of_two_orders_from_coarse_to_fine(monkeypatch, peer, approved):
    """Only NGSolve tetrahedra too; sweeps of the two coarsest; the frequencies that are asked."""
    asked = []
    monkeypatch.setattr(ways, "solve", lambda name, job: asked.append((name, job)) or "answer")
    whole, quick = (ways._peer_ways(peer, quick=quick) for quick in (False, True))
    paths = [(one.path, one.level, one.swept) for one in whole]
    bricks = [(f"{peer}, bricks of order {order}", str(n), n <= 2)
              for order, grids in ((2, ways._SECOND), (3, ways._THIRD))
              for n in range(1, len(grids) + 1)]  # fmt: skip
    tetrahedra = [(f"{peer}, tetrahedra of order {order}", str(n), False)
                  for order in (2, 3) for n in (1, 2)]  # fmt: skip
    assert paths == bricks + (tetrahedra if peer == "NGSolve" else [])
    first = [bricks[0], bricks[len(ways._SECOND)]]
    assert [(one.path, one.level, one.swept) for one in quick] == first
    assert not any(one.own for one in whole)
    for one in whole:
        assert one.solve([1.0, 2.0]) == "answer"
        name, job = asked[-1]
        assert name == peer
        assert job["frequencies"] == [1.0, 2.0]
        assert f"of order {job['order']}" in one.path
        assert ("tetra" in one.path) == (job["kind"] == "tetra")
    assert all(job["first"] < job["longest"] for _, job in asked)
    first = asked[0][1]
    changed = [{k: v for k, v in job.items() if first.get(k) is not v} for _, job in asked[1:]]
    plain = {key: value for key, value in first.items() if not isinstance(value, dict)}
    ceramic = {key: np.array(value) for key, value in first["ceramic"].items()}
    approved(described([plain, ceramic, changed]))


def test_hexahedra_of_27_nodes_are_bricks_of_degree_two():
    """As many through a layer as asked for; finer ones have more nodes."""
    device = j1().device
    sizes = []
    for through, *fineness in ways._TRIQUADRATIC:
        bricks = meshes.second_order(device, through, *fineness)
        assert bricks.degree == (2, 2, 2)
        assert bricks.shape[0] == 2 * (through + 1) + 1  # and one through half the shim
        sizes.append(int(bricks.used().sum()))
    assert sizes == sorted(set(sizes))


def test_rows_of_the_solver_are_complete():
    row = solver.SolverTiming("superlu, real", "solve", 10, 100, 0.5, 1e6, 1e-9)
    assert len(row.cells) == len(row.columns)
    assert row.values == ("superlu, real", "solve", 10, 100, 0.5, 1e6, 1e-9)
    assert len(row.fields) == len(row.values)


def test_the_least_time_of_several_runs_counts(monkeypatch):
    """From the start of each to its end; with the last result."""
    clock = iter([10.0, 13.0, 20.0, 21.5, 30.0, 32.0])
    monkeypatch.setattr(one_core.time, "process_time", lambda: next(clock))
    results = iter("abc")
    assert one_core.least_time(lambda: next(results), 3) == (1.5, "c")
