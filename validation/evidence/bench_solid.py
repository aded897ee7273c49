"""Run time against error of the piezoelectric solid: our meshes, and public programs beside them.

The jobs J1 and J2 of :mod:`validation.evidence.bench_solid_jobs`, all in one run, one process
with one thread each.
"""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.validation.evidence import bench_solid_jobs
from tactgen.validation.evidence.bench import Bench, Point, Target, Timing, front, time_at_error
from tactgen.validation.evidence.bench_solid_jobs import BRICKS, j1, job
from tactgen.validation.evidence.bench_timing import on_one_core
from tactgen.validation.evidence.peers import PEERS, missing, solve
from tactgen.validation.evidence.peers.job import Answer, Fineness, Job
from tactgen.validation.models.model import BRICK_FACTOR

#: Solves J1, or J2 at the frequencies (Hz) given.
Solve = Callable[[list[float]], Answer]

#: Bricks of order 2 and of order 3.
_SECOND: tuple[Fineness, ...] = (
    Fineness(through_piezo=2, through_shim=1, across=3, longest=1.2e-3, first=1e-4, growth=3.0),
    Fineness(through_piezo=2, through_shim=1, across=4, longest=1.2e-3, first=5e-5, growth=2.0),
    Fineness(through_piezo=3, through_shim=2, across=5, longest=0.9e-3, first=2.5e-5, growth=2.0),
)
_THIRD: tuple[Fineness, ...] = (
    Fineness(across=2, longest=3e-3, first=2e-4, growth=4.0),
    Fineness(across=3, longest=4e-3, first=4e-4, growth=12.0),
    Fineness(across=3, longest=3e-3, first=1e-4, growth=4.0),
    Fineness(across=3, longest=2e-3, first=2.5e-5, growth=3.0),
    Fineness(across=4, longest=2e-3, first=2.5e-5, growth=3.0, through_piezo=2),
)
#: Of hexahedra of 27 nodes: through a ceramic layer; side, smallest, longest of a BrickMeshing.
_TRIQUADRATIC = ((1, 0.5, 0.4, 2.0), (2, 0.3, 0.2, 1.4), (3, 0.3, 0.1, 1.0))
#: Edges (m) far from the clamp and at it.
_NETGEN = ((2e-3, 2e-4), (2e-3, 1e-4))
_TETWILD = ((2.25e-4, 5.5e-4), (1.75e-4, 4.25e-4), (1.35e-4, 3.25e-4))


@dataclass(frozen=True)
class Level:
    """One fineness of one way; `swept` if it runs J2 too."""

    path: str
    level: str
    solve: Solve
    swept: bool
    own: bool


def ways(*, quick: bool) -> list[Level]:
    """All that is to be run; peers that are not installed are left out."""
    few = slice(1 if quick else None)
    grids = [job(**grid | {"order": 2}) for grid in _SECOND[few]]
    families: tuple[tuple[str, Sequence[Any], bool], ...] = (
        (BRICKS, range(2 if quick else 4), True),
        ("hexahedra of 27 nodes", _TRIQUADRATIC[few], False),
        ("hexahedra of 20 nodes", grids, False),
        ("structured P2 tetrahedra", grids, False),
        ("tetwild P2 tetrahedra", () if quick else _TETWILD, False),
    )
    found = [
        Level(family, str(number), own(family, fineness), swept, own=True)
        for family, finenesses, swept in families
        for number, fineness in enumerate(finenesses, 1)
    ]
    for peer in PEERS:
        if not missing(peer):
            found += _peer_ways(peer, quick=quick)
    return found


def own(family: str, fineness: Any) -> Solve:
    """Solution of the jobs by one of our methods at a fineness."""
    return partial(on_one_core, bench_solid_jobs.__name__, "solve_own", family, fineness)


def _peer_ways(peer: str, *, quick: bool) -> list[Level]:
    def level(path: str, number: int, fineness: Job, swept: bool) -> Level:
        way = f"{peer}, {path}"
        return Level(way, str(number), partial(solve, peer, fineness), swept, own=False)

    found = []
    for order, grids in ((2, _SECOND), (3, _THIRD)):
        for number, grid in enumerate(grids[: 1 if quick else None], 1):
            # direct sweeps of the finer grids take minutes and only widen the distance
            swept = number <= (1 if quick else 2)
            fineness = job(**grid | {"order": order})
            found.append(level(f"bricks of order {order}", number, fineness, swept))
    if peer == "NGSolve" and not quick:
        for order in (2, 3):
            for number, (longest, first) in enumerate(_NETGEN, 1):
                fineness = job(kind="tetra", order=order, longest=longest, first=first)
                found.append(level(f"tetrahedra of order {order}", number, fineness, False))
    return found


#: Converged J1 as four public codes agree on it on identical meshes (deflection in m/V, f1
#: to f4 in Hz), and to how much (relative).
PUBLISHED = np.array([-6.7582e-7, 1065.96, 3329.10, 6642.85, 16267.0])
PUBLISHED_BARS = np.array([1e-5, 3e-5, 3e-5, 3e-5, 3e-5])
#: Phases of a solution.
STEPS = ("mesh", "assembly", "factor", "solve", "eigen", "sweep")
#: Names of a solution's values.
VALUES = ("deflection", "f1", "f2", "f3", "f4", "capacitance")
#: Levels of our bricks that make the reference, the finer first.
_LEVELS = {True: (3, 2), False: (4, 3)}
_FAR = "no way of this run is near enough"


@dataclass(frozen=True)
class Reference:
    """Converged `values` (as :data:`VALUES`) and deflections of the sweep, with relative bars."""

    values: Floats
    bars: Floats
    frequencies: Floats
    sweep: Complex
    sweep_bar: float


def run(quick: bool, announce: Callable[[str], None]) -> Bench:
    """Measure everything: ten minutes with all peers, or about one if `quick`."""
    started = time.perf_counter()
    absent = [sentence for peer in PEERS if (sentence := missing(peer))]
    for sentence in absent:
        announce(f"piezo: {sentence}")
    reference = _reference(quick, announce)
    timings: list[Timing] = []
    for level in ways(quick=quick):
        announce(f"piezo: {level.path}, fineness {level.level}")
        timings.extend(_timings(level, reference, 4 if quick else 12))
    conditions, targets = _conditions(reference, absent), targets_of(timings)
    seconds = time.perf_counter() - started
    return Bench("piezo", conditions, tuple(timings), targets, seconds, "compute time (s)")


def _reference(quick: bool, announce: Callable[[str], None]) -> Reference:
    """Solve on the two finest levels of bricks; the bars are those of the solid model itself."""
    frequencies = np.array(j1().frequency)
    values, sweeps = [], []
    for level in _LEVELS[quick]:
        announce(f"piezo: reference, level {level + 1}")
        solve = own(BRICKS, level)
        values.append(values_of(solve([])))
        sweeps.append(_sweep_of(solve(frequencies.tolist())))
    bars = BRICK_FACTOR * np.abs(values[1] / values[0] - 1.0)
    sweep_bar = BRICK_FACTOR * np.abs(sweeps[1] / sweeps[0] - 1.0).max()
    return Reference(values[0], bars, frequencies, sweeps[0], float(sweep_bar))


def values_of(answer: Answer) -> Floats:
    """Solution's values in the order of :data:`VALUES`."""
    return np.array([answer["deflection"], *answer["natural"], answer["capacitance"]])


def _sweep_of(answer: Answer) -> Complex:
    return np.array([complex(*pair) for pair in answer["sweep"]])


def _timings(level: Level, reference: Reference, sampled: int) -> Iterator[Timing]:
    """Run J1, and J2 where it is asked for.

    Peers factorise at every frequency, so they solve a sample, and its time is scaled up.
    """
    found = level.solve([])
    # the reference may be off by its bar, so an error is at most so large
    errors = np.abs(values_of(found) / reference.values - 1.0) + reference.bars
    yield timing_of(level, "J1", found, dict(zip(VALUES, errors.tolist(), strict=True)))
    if not level.swept:
        return
    everyone = reference.frequencies.size
    chosen = np.arange(everyone) if level.own else sample(reference, sampled)
    found = level.solve(reference.frequencies[chosen].tolist())
    found["seconds"]["sweep"] *= everyone / chosen.size
    error = np.abs(_sweep_of(found) / reference.sweep[chosen] - 1.0).max()
    yield timing_of(level, "J2", found, {"sweep": float(error)})


def sample(reference: Reference, number: int) -> Ints:
    """Where the deflection changes fastest with frequency, and as many evenly spread.

    There, on the flanks of resonances and dips, errors are largest: the largest error of a
    sample without them would flatter whoever is judged by it.
    """
    change = np.gradient(np.log(reference.sweep), np.log(reference.frequencies))
    steepest = np.argsort(-np.abs(change))[: number // 2]
    spread = np.linspace(0, change.size - 1, number - steepest.size).round().astype(int)
    return np.unique(np.concatenate([steepest, spread]))


def timing_of(level: Level, case: str, found: Answer, errors: dict[str, float]) -> Timing:
    """Timing of one solution of one job; of its relative errors all but the capacitance count."""
    cost = sum(found["seconds"].values())
    worst = max(error for name, error in errors.items() if name != "capacitance")
    if "sweep" in errors:
        curves = {"J2: damped sweep": worst}
    else:
        natural = max(errors[name] for name in VALUES if name.startswith("f"))
        curves = {"J1: deflection": errors["deflection"], "J1: worst of f1…f4": natural}
    values: dict[str, str | float] = {
        "way": level.path, "fineness": level.level, "job": case, "unknowns": found["unknowns"],
        **{f"{step}_seconds": found["seconds"].get(step, "") for step in STEPS},
        "compute_seconds": cost, "process_seconds": found["process_seconds"],
        "peak_memory": float(found["peak_memory"]),
        **{f"error_{name}": errors.get(name, "") for name in (*VALUES, "sweep")},
    }  # fmt: skip
    return Timing(level.path, case, cost, worst, values, 1e-3, curves, level.own)


def targets_of(timings: Iterable[Timing]) -> tuple[Target, ...]:
    """Judge times at an error, read off each way's curve, and ratios to the best peer."""
    timings = list(timings)
    j1 = [timing for timing in timings if timing.case == "J1"]
    ours, our_way = _best(j1, 1e-3, own=True)
    finer, finer_way = _best(j1, 1e-4, own=True)
    targets = [
        Target("J1 within 1e-3 (deflection, f1 to f4)", 1.0, ours, "s", True, our_way),
        Target("J1 within 1e-4 (deflection, f1 to f4)", 6.0, finer, "s", True, finer_way),
    ]
    if any(not timing.own for timing in timings):
        theirs, their_way = _best(j1, 1e-3, own=False)
        reached = math.isfinite(theirs) and math.isfinite(ours)
        ratio = theirs / ours if reached else math.nan
        how = f"{their_way} {theirs:.3g} s, {our_way} {ours:.3g} s" if reached else _FAR
        targets.append(
            Target("J1 within 1e-3: best peer's time over ours", 5.0, ratio, "", False, how)
        )
        targets.append(_sweep_target([timing for timing in timings if timing.case == "J2"]))
    return tuple(targets)


def _best(timings: list[Timing], wanted: float, *, own: bool) -> tuple[float, str]:
    """Least time at an error, and the way that has it."""
    curves: dict[str, list[Point]] = {}
    for timing in timings:
        if timing.own == own:
            curves.setdefault(timing.path, []).append((timing.cost, timing.error))
    times = {path: time_at_error(points, wanted) for path, points in curves.items()}
    best = min(times, key=lambda path: times[path], default="")
    if not best or math.isinf(times[best]):
        return math.inf, _FAR
    return times[best], best


def _sweep_target(timings: list[Timing]) -> Target:
    """Compare at the peers' own errors, where the distance is least."""
    theirs = [timing for timing in timings if not timing.own]
    good = front((timing.cost, timing.error) for timing in theirs)
    ours = [(timing.cost, timing.error) for timing in timings if timing.own]
    least, how = math.nan, "no peer swept"
    for seconds, error in good:
        at = time_at_error(ours, error)
        # also true while there is no least yet
        if not seconds / at >= least:
            peer = next(t.path for t in theirs if (t.cost, t.error) == (seconds, error))
            least = seconds / at
            how = f"at {error:.1e}: {peer} {seconds:.3g} s, ours {at:.3g} s"
    return Target("J2: a peer's time over ours at its error", 50.0, least, "", False, how)


def _conditions(reference: Reference, absent: list[str]) -> str:
    bars = ", ".join(
        f"{name} {value:.7g} ± {bar:.0e}"
        for name, value, bar in zip(VALUES, reference.values, reference.bars, strict=True)
    )
    away = np.abs(reference.values[: PUBLISHED.size] / PUBLISHED - 1.0)
    published = ", ".join(
        f"{distance:.0e} ({bar:.0e})" for distance, bar in zip(away, PUBLISHED_BARS, strict=True)
    )
    sentences = f"""
J1: clamped PZT-5H bimorph, deflection, capacitance and four natural frequencies; J2: its damped
sweep, 200 frequencies from 10 Hz to 20 kHz.
Reference (SI; relative bars as the solid model gives them):
{bars}; sweep ± {reference.sweep_bar:.0e}. Errors of J1 include the reference's bar.
Its distance from what four codes agree on, deflection to f4 (their bar): {published}.
J2's error is the largest of all frequencies, relative to the deflection at the same frequency, so
dips count in full; near a resonance it is many times the natural frequency's.
Peers factorise at every frequency: they solve a sample of them with the steepest places, and its
time is scaled up.
Times at an error: straight lines in logarithms between neighbours of a way's front, nothing
extrapolated.
One process with one thread per row, processor time; compute excludes starting Python and imports;
numpy {np.__version__}, {platform.machine()}.
"""
    return " ".join([*sentences.split(), *(f"{sentence}." for sentence in absent)])
