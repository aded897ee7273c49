"""Run time against error of the piezoelectric solid: our meshes, and public programs beside them.

Job J1: a clamped PZT-5H bimorph, static deflection, capacitance and four natural
frequencies.  Job J2: its damped sweep at 200 frequencies.  All in one run, one process with
one thread each.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import platform
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy import sparse

from tactgen.geometry.arrays import Complex, Floats, Ints, Numbers
from tactgen.geometry.bimorph.bimorph_bricks import LEVELS, BrickMeshing, bimorph_bricks
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.bimorph.tets import TetMeshing, tetrahedralise
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.engine.error_bars import BRICK_FACTOR
from tactgen.validation.evidence.bench import (
    Bench,
    Point,
    Target,
    Timing,
    front,
    time_at_error,
)
from tactgen.validation.evidence.one_core import on_one_core
from tactgen.validation.evidence.peers import PEERS, missing, solve
from tactgen.validation.evidence.peers.job import (
    LAYERS,
    Answer,
    Clock,
    Job,
    Material,
    answer,
    bricks,
)
from tactgen.validation.scene.scene import Scene, load_scene

#: Natural frequencies that are compared.
MODES = 4
#: Error asked of the reduction to ports, relative; far below the meshes' errors.
_REDUCTION = 1e-6

Kind = Literal["brick", "tetra"]

#: The solid model's own family.
BRICKS = "bricks of high order"


def j1() -> Scene:
    """Return the scene of the job."""
    return load_scene("j1", [])[0]


def job(
    frequencies: Sequence[float] = (),
    *,
    kind: Kind = "brick",
    order: int = 2,
    through_piezo: int = 1,
    through_shim: int = 1,
    across: int = 2,
    longest: float,
    first: float,
    growth: float = 4.0,
    device: Device | None = None,
) -> Job:
    """Return job J1, or another device's, as plain numbers; with frequencies, its damped sweep."""
    from tactgen.fem.piezo.system import materials

    device = device or j1().device
    regions = ("piezo_top", "shim")
    exact, lossy = (
        materials(device, regions, device.piezo.ceramic(), lossy=loss) for loss in (False, True)
    )
    bimorph = device.bimorph
    return Job(
        piezo_thickness=bimorph.piezo_thickness,
        shim_thickness=bimorph.shim_thickness,
        width=bimorph.width,
        length=bimorph.length,
        ceramic=_plain(exact["piezo_top"], lossy["piezo_top"]),
        shim=_plain(exact["shim"], lossy["shim"]),
        modes=MODES,
        frequencies=list(frequencies),
        kind=kind,
        order=order,
        through_piezo=through_piezo,
        through_shim=through_shim,
        across=across,
        longest=longest,
        first=first,
        growth=growth,
    )


def _plain(exact: Any, lossy: Any) -> Material:
    """Return a region's tensors as lists: the lossy ones hold the imaginary parts."""

    def rows(values: Numbers) -> list[list[float]]:
        return [[float(v) for v in row] for row in values]

    empty: list[list[float]] = []
    piezo, damped = exact.piezo, lossy.piezo
    return Material(
        stiffness=rows(lossy.c.real),
        stiffness_loss=rows(lossy.c.imag),
        coupling=rows(damped.e.real) if piezo else empty,
        coupling_loss=rows(damped.e.imag) if piezo else empty,
        permittivity=rows(damped.eps.real) if piezo else empty,
        permittivity_loss=rows(damped.eps.imag) if piezo else empty,
        density=exact.density,
    )


def solve_own(family: str, fineness: Any, frequencies: list[float]) -> Answer:
    """Solve the job (or, with frequencies, its sweep) on a mesh of one of our families."""
    # imported before the clock starts: their time is the process's, not the mesh's
    from tactgen.fem.piezo.solid import assemble
    from tactgen.fem.solvers.linear_solver import available_solver, factorise

    later_on = (
        "scipy.sparse.linalg",
        "tactgen.fem.piezo.krylov",
        "tactgen.validation.models.bimorph.lowest_modes",
    )
    for later in later_on:
        importlib.import_module(later)
    # the solver's libraries come with its first call
    factorise(sparse.csr_matrix(np.eye(2)))
    solver = available_solver()
    device, make = j1().device, FAMILIES[family]

    clock = Clock()
    mesh = make(device, fineness)
    clock.stop("mesh")
    system = assemble(device, mesh, lossy=bool(frequencies))
    clock.stop("assembly")
    if frequencies:
        values = _sweep(system, frequencies)
        clock.stop("sweep")
        return answer(clock, system.size, solver, sweep=values)
    _ = system.held_factor
    clock.stop("factor")
    static = _static(system)
    clock.stop("solve")
    natural = _natural(device, mesh, system)
    clock.stop("eigen")
    return answer(clock, system.size, solver, static=static, natural=natural)


def _static(system: Any) -> tuple[float, float]:
    """Return deflection and capacitance of the clamped, free bimorph."""
    from tactgen.fem.piezo.ports import static_multiport
    from tactgen.geometry.bimorph.ends import Ends
    from tactgen.tmm.ports.elements import attach
    from tactgen.tmm.ports.multiport import respond

    response = respond(attach(static_multiport(system), Ends()), {"voltage": 1.0})
    return float(response.motion["w_tip"][0].real), float(response.effort["voltage"][0].real)


def _natural(device: Device, mesh: Mesh | Bricks, system: Any) -> list[float]:
    """Return the natural frequencies; a coarse mesh says which classes of motion they are in."""
    from tactgen.fem.piezo.modes import natural_modes
    from tactgen.fem.piezo.solid import assemble
    from tactgen.geometry.bimorph.ends import Ends
    from tactgen.validation.models.bimorph.lowest_modes import (
        coarse_modes,
        fine_modes,
        lowest_modes,
    )

    clamped = Ends()
    if not isinstance(mesh, Bricks):
        return [mode.frequency for mode in natural_modes(system, clamped, MODES)]
    below = coarse_modes(assemble(device, scout(device), lossy=False), MODES)
    above = fine_modes(system, below, MODES)
    found, _ = lowest_modes(above, below, clamped, MODES, open_circuit=False)
    return [mode.frequency for mode in found][:MODES]


def _sweep(system: Any, frequencies: list[float]) -> list[complex]:
    """Return the complex deflection by reduction to ports."""
    from tactgen.fem.piezo.krylov import reduce_to_ports
    from tactgen.geometry.bimorph.ends import Ends
    from tactgen.tmm.ports.elements import attach
    from tactgen.tmm.ports.multiport import respond

    f = np.array(frequencies)
    port = reduce_to_ports(system, f, tolerance=_REDUCTION).multiport(f)
    response = respond(attach(port, Ends()), {"voltage": 1.0})
    return [complex(w) for w in response.motion["w_tip"]]


#: Mesh of each of our families from a device and a fineness.  Another one is one line.
FAMILIES: dict[str, Callable[[Device, Any], Mesh | Bricks]] = {
    BRICKS: lambda device, level: high_order(device, level),  # noqa: PLW0108  (defined below)
    "hexahedra of 27 nodes": lambda device, sizes: second_order(device, *sizes),
    "hexahedra of 20 nodes": lambda _, fineness: hexahedra(fineness),
    "structured P2 tetrahedra": lambda _, fineness: structured_tetrahedra(fineness),
    "tetwild P2 tetrahedra": lambda device, edges: free_tetrahedra(device, *edges),
}


#: Solves J1, or J2 at the frequencies (Hz) given.
Solve = Callable[[list[float]], Answer]

#: Fineness of bricks: through a ceramic layer, through the shim, across, longest (m), first
#: at the clamp (m), ratio of neighbours.
_Grid = tuple[int, int, int, float, float, float]
_SECOND: tuple[_Grid, ...] = (
    (2, 1, 3, 1.2e-3, 1e-4, 3.0),
    (2, 1, 4, 1.2e-3, 5e-5, 2.0),
    (3, 2, 5, 0.9e-3, 2.5e-5, 2.0),
)
_THIRD: tuple[_Grid, ...] = (
    (1, 1, 2, 3e-3, 2e-4, 4.0),
    (1, 1, 3, 4e-3, 4e-4, 12.0),
    (1, 1, 3, 3e-3, 1e-4, 4.0),
    (1, 1, 3, 2e-3, 2.5e-5, 3.0),
    (2, 1, 4, 2e-3, 2.5e-5, 3.0),
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
    """Return all that is to be run; peers that are not installed are left out."""
    found = _own_ways(quick=quick)
    for peer in PEERS:
        if not missing(peer):
            found += _peer_ways(peer, quick=quick)
    return found


def own(family: str, fineness: Any) -> Solve:
    """Return how one of our families solves the jobs at a fineness."""

    def run(frequencies: list[float]) -> Answer:
        found: Answer = on_one_core(__name__, "solve_own", family, fineness, frequencies)
        return found

    return run


def _own_ways(*, quick: bool) -> list[Level]:
    def levels(family: str, finenesses: list[Any], swept: bool) -> list[Level]:
        return [
            Level(family, str(number), own(family, fineness), swept, own=True)
            for number, fineness in enumerate(finenesses, 1)
        ]

    grids = [_bricks(grid, 2) for grid in _SECOND[: 1 if quick else None]]
    return [
        *levels(BRICKS, list(range(2 if quick else 4)), True),
        *levels("hexahedra of 27 nodes", list(_TRIQUADRATIC[: 1 if quick else None]), False),
        *levels("hexahedra of 20 nodes", grids, False),
        *levels("structured P2 tetrahedra", grids, False),
        *levels("tetwild P2 tetrahedra", [] if quick else list(_TETWILD), False),
    ]


def _peer_ways(peer: str, *, quick: bool) -> list[Level]:
    def level(path: str, number: int, fineness: Job, swept: bool) -> Level:
        def run(frequencies: list[float]) -> Answer:
            chosen = fineness.copy()
            chosen["frequencies"] = frequencies
            return solve(peer, chosen)

        return Level(f"{peer}, {path}", str(number), run, swept, own=False)

    found = []
    for order, grids in ((2, _SECOND), (3, _THIRD)):
        for number, grid in enumerate(grids[: 1 if quick else None], 1):
            # direct sweeps of the finer grids take minutes and only widen the distance
            swept = number <= (1 if quick else 2)
            found.append(level(f"bricks of order {order}", number, _bricks(grid, order), swept))
    if peer == "NGSolve" and not quick:
        for order in (2, 3):
            for number, (longest, first) in enumerate(_NETGEN, 1):
                fineness = job(kind="tetra", order=order, longest=longest, first=first)
                found.append(level(f"tetrahedra of order {order}", number, fineness, False))
    return found


def _bricks(grid: _Grid, order: int) -> Job:
    through_piezo, through_shim, across, longest, first, growth = grid
    return job(
        order=order, through_piezo=through_piezo, through_shim=through_shim, across=across,
        longest=longest, first=first, growth=growth,
    )  # fmt: skip


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
    with _no_kept_meshes():
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
    """Return a solution's values in the order of :data:`VALUES`."""
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


def _timing(level: Level, case: str, found: Answer, errors: dict[str, float]) -> Timing:
    return timing_of(
        level.path, level.level, case, found["unknowns"], found["seconds"], errors, own=level.own,
        process=found["process_seconds"], memory=found["peak_memory"],
    )  # fmt: skip


def timing_of(
    path: str, level: str, case: str, unknowns: int, phases: dict[str, float],
    errors: dict[str, float], *, own: bool, process: float = math.nan, memory: float = math.nan,
) -> Timing:  # fmt: skip
    """Return the timing of one solution of one job.

    Parameters
    ----------
    phases : dict of str to float
        Processor time (s) of :data:`STEPS`, as far as they occur.
    errors : dict of str to float
        Relative, by value; all but the capacitance are judged.
    process, memory : float
        Processor time (s) and peak memory (bytes) of the whole process.
    """
    cost = sum(phases.values())
    worst = max(error for name, error in errors.items() if name != "capacitance")
    if "sweep" in errors:
        curves = {"J2: damped sweep": worst}
    else:
        natural = max(errors[name] for name in VALUES if name.startswith("f"))
        curves = {"J1: deflection": errors["deflection"], "J1: worst of f1…f4": natural}
    values: dict[str, str | float] = {
        "way": path, "fineness": level, "job": case, "unknowns": unknowns,
        **{f"{step}_seconds": phases.get(step, "") for step in STEPS},
        "compute_seconds": cost, "process_seconds": process, "peak_memory": float(memory),
        **{f"error_{name}": errors.get(name, "") for name in (*VALUES, "sweep")},
    }  # fmt: skip
    return Timing(path, case, cost, worst, values, 1e-3, curves, own)


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
    """Return the least time at an error, and the way that has it."""
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


#: Six tetrahedra of a brick, all around its diagonal from corner 0 to corner 6.
_TETS = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]


def high_order(device: Device, level: int) -> Bricks:
    """Return the bricks of high order of a level of the solid model's own family."""
    return bimorph_bricks(device, LEVELS[level])


def second_order(
    device: Device, through: int, side: float, smallest: float, longest: float
) -> Bricks:
    """Return bricks of degree 2, which are hexahedra of 27 nodes, on the quarter.

    `through` a ceramic layer; `side`, `smallest` and `longest` as of a BrickMeshing.
    """
    layers = (1.0 / through,) * through
    meshing = BrickMeshing(
        (2, 2, 2), layers, side=side, smallest=smallest, tip=smallest, longest=longest,
        pieces=(10.0, 1e3), growth=3.0,
    )  # fmt: skip
    return bimorph_bricks(device, meshing)


def scout(device: Device) -> Bricks:
    """Return so few bricks that asking them which modes are the lowest costs next to nothing.

    Two along the length, of degree 5: two percent off, where its modes lie tens apart.
    """
    whole = 1e3  # so long at both ends that nothing is left between them
    return bimorph_bricks(device, BrickMeshing((2, 2, 5), smallest=whole, tip=whole))


def hexahedra(job: Job) -> Mesh:
    """Return the job's grid of bricks as hexahedra."""
    grid = bricks(job)
    faces: dict[str, list[Ints]] = {}
    for face in grid.faces():
        if face.name != "side" and face.quads.size:
            name = face.name
            if name in ("outer", "inner"):
                name = f"electrode_{LAYERS[face.layer].removeprefix('piezo_')}_{name}"
            faces.setdefault(name, []).append(face.quads)
    return Mesh(
        points=grid.points,
        cells=grid.cells,
        kind="hexahedron",
        region_of_cell=grid.layer,
        regions=LAYERS,
        faces={name: np.concatenate(parts) for name, parts in faces.items()},
    )


def structured_tetrahedra(job: Job) -> Mesh:
    """Return the job's grid with every brick cut into six tetrahedra."""
    mesh = hexahedra(job)
    return Mesh(
        points=mesh.points,
        cells=mesh.cells[:, _TETS].reshape(-1, 4),
        kind="tetra",
        region_of_cell=np.repeat(mesh.region_of_cell, len(_TETS)),
        regions=mesh.regions,
        faces={name: _triangles(quads) for name, quads in mesh.faces.items()},
    )


def _triangles(quads: Ints) -> Ints:
    """Cut quadrilaterals as the tetrahedra do: along lowest to highest corner."""
    start = np.argmin(quads, axis=1)
    a, b, c, d = (quads[np.arange(len(quads)), (start + turn) % 4] for turn in range(4))
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def free_tetrahedra(device: Device, root: float, far: float) -> Mesh:
    """Return the tetwild mesh with edges of `root` at the clamp and `far` elsewhere (m)."""
    options = TetMeshing(edge_length=far, root_edge_length=root)
    return tetrahedralise(device, "alone", LAYERS, options)
