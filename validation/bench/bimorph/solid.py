"""Run time against error of the piezoelectric solid: our meshes, and public programs beside them.

Job J1: a clamped PZT-5H bimorph, static deflection, capacitance and four natural
frequencies.  Job J2: its damped sweep at 200 frequencies.  All in one run, one process with
one thread each.
"""

from __future__ import annotations

import contextlib
import math
import os
import platform
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.validation.bench.bimorph import jobs
from tactgen.validation.bench.bimorph.peers import PEERS, missing
from tactgen.validation.bench.bimorph.peers.job import Answer
from tactgen.validation.bench.bimorph.timing import SolidTiming
from tactgen.validation.bench.bimorph.ways import Level, own, ways
from tactgen.validation.bench.result import Bench, Target
from tactgen.validation.bench.work_precision import Point, front, time_at_error
from tactgen.validation.engine.error_bars import BRICK_FACTOR

#: Converged J1 as four public codes agree on it on identical meshes (deflection in m/V, f1
#: to f4 in Hz), and to how much (relative).
PUBLISHED = np.array([-6.7582e-7, 1065.96, 3329.10, 6642.85, 16267.0])
PUBLISHED_BARS = np.array([1e-5, 3e-5, 3e-5, 3e-5, 3e-5])
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
    timings: list[SolidTiming] = []
    with _no_kept_meshes():
        for level in ways(quick=quick):
            announce(f"piezo: {level.path}, fineness {level.level}")
            timings.extend(_timings(level, reference, 4 if quick else 12))
    conditions = _conditions(reference, absent)
    targets = targets_of(timings)
    return Bench("piezo", conditions, tuple(timings), targets, time.perf_counter() - started)


def _reference(quick: bool, announce: Callable[[str], None]) -> Reference:
    """Solve on the two finest levels of bricks; the bars are those of the solid model itself."""
    frequencies = np.array(jobs.j1().frequency)
    values, sweeps = [], []
    for level in _LEVELS[quick]:
        announce(f"piezo: reference, level {level + 1}")
        solve = own(jobs.BRICKS, level)
        values.append(values_of(solve([])))
        sweeps.append(_sweep_of(solve(frequencies.tolist())))
    bars = BRICK_FACTOR * np.abs(values[1] / values[0] - 1.0)
    sweep_bar = BRICK_FACTOR * np.abs(sweeps[1] / sweeps[0] - 1.0).max()
    return Reference(values[0], bars, frequencies, sweeps[0], float(sweep_bar))


def values_of(answer: Answer) -> Floats:
    """Return a solution's values in the order of :data:`VALUES`."""
    return np.array([answer["deflection"], *answer["natural"], answer["capacitance"]])


def _sweep_of(answer: Answer) -> Complex:
    return np.array([complex(*pair) for pair in answer["sweep"]])


def _timings(level: Level, reference: Reference, sampled: int) -> Iterator[SolidTiming]:
    """Run J1, and J2 where it is asked for.

    Peers factorise at every frequency, so they solve a sample, and its time is scaled up.
    """
    found = level.solve([])
    # the reference may be off by its bar, so an error is at most so large
    errors = np.abs(values_of(found) / reference.values - 1.0) + reference.bars
    yield _timing(level, "J1", found, dict(zip(VALUES, errors.tolist(), strict=True)))
    if not level.swept:
        return
    everyone = reference.frequencies.size
    chosen = np.arange(everyone) if level.own else sample(reference, sampled)
    found = level.solve(reference.frequencies[chosen].tolist())
    found["seconds"]["sweep"] *= everyone / chosen.size
    error = np.abs(_sweep_of(found) / reference.sweep[chosen] - 1.0).max()
    yield _timing(level, "J2", found, {"sweep": float(error)})


def sample(reference: Reference, number: int) -> Ints:
    """Return where the deflection changes fastest with frequency, and as many evenly spread.

    There, on the flanks of resonances and dips, errors are largest: the largest error of a
    sample without them would flatter whoever is judged by it.
    """
    change = np.gradient(np.log(reference.sweep), np.log(reference.frequencies))
    steepest = np.argsort(-np.abs(change))[: number // 2]
    spread = np.linspace(0, change.size - 1, number - steepest.size).round().astype(int)
    return np.unique(np.concatenate([steepest, spread]))


def _timing(level: Level, case: str, found: Answer, errors: dict[str, float]) -> SolidTiming:
    return SolidTiming(
        path=level.path,
        level=level.level,
        case=case,
        own=level.own,
        unknowns=found["unknowns"],
        phases=found["seconds"],
        process_seconds=found["process_seconds"],
        peak_memory=found["peak_memory"],
        errors=errors,
    )


@contextlib.contextmanager
def _no_kept_meshes() -> Iterator[None]:
    """Keep meshes of other runs out of the time of meshing."""
    before = os.environ.get("TACTGEN_CACHE")
    with tempfile.TemporaryDirectory() as empty:
        os.environ["TACTGEN_CACHE"] = empty
        try:
            yield
        finally:
            del os.environ["TACTGEN_CACHE"]
            if before is not None:
                os.environ["TACTGEN_CACHE"] = before


def targets_of(timings: Iterable[SolidTiming]) -> tuple[Target, ...]:
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


def _best(timings: list[SolidTiming], wanted: float, *, own: bool) -> tuple[float, str]:
    """Return the least time at an error, and the way that has it."""
    curves: dict[str, list[Point]] = {}
    for timing in timings:
        if timing.own == own:
            curves.setdefault(timing.path, []).append((timing.cost, timing.worst))
    times = {path: time_at_error(points, wanted) for path, points in curves.items()}
    best = min(times, key=lambda path: times[path], default="")
    if not best or math.isinf(times[best]):
        return math.inf, _FAR
    return times[best], best


def _sweep_target(timings: list[SolidTiming]) -> Target:
    """Compare at the peers' own errors, where the distance is least."""
    theirs = [timing for timing in timings if not timing.own]
    good = front((timing.cost, timing.worst) for timing in theirs)
    ours = [(timing.cost, timing.worst) for timing in timings if timing.own]
    least, how = math.nan, "no peer swept"
    for seconds, error in good:
        at = time_at_error(ours, error)
        # also true while there is no least yet
        if not seconds / at >= least:
            peer = next(t.path for t in theirs if (t.cost, t.worst) == (seconds, error))
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
