"""What the sparse solver costs on the piezoelectric solid, by size.

Matrices of quadratic bricks of the paper's bimorph, with base and electrodes held.  Each
is factorised in a process of its own that has read it from a file, so that peak memory is
the solver's.
"""

from __future__ import annotations

import platform
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing, bimorph_bricks
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.validation.evidence.bench import Bench, Target, Timing
from tactgen.validation.evidence.one_core import least_time, on_one_core, peak_memory

#: Unknowns asked for.
_SIZES = (50_000, 200_000, 500_000)
#: SuperLU takes minutes for more.
_SUPERLU_SIZES = (50_000,)
_RIGHT_SIDES = 5
#: Share of the wanted number of unknowns by which a matrix may miss it.
_NEAR = 0.05
_FIRST, _AGAIN, _SOLVE = "order and factorise", "factorise again", f"{_RIGHT_SIDES} right sides"


#: Error asked for: a condition of 1e9 leaves seven digits, a large matrix one less.
_WANTED = 1e-6


def run(quick: bool, announce: Callable[[str], None]) -> Bench:
    """Measure everything on one core; some ten minutes, or under one if `quick`."""
    from tactgen.fem.solvers.linear_solver import available_solver

    started = time.perf_counter()
    has_pardiso = available_solver().startswith("Pardiso")
    found: dict[tuple[str, str, int], dict[str, float]] = {}
    left_out = []
    with tempfile.TemporaryDirectory() as folder:
        for size in _SIZES[:1] if quick else _SIZES:
            for kind in ("real", "complex"):
                path = str(Path(folder) / f"{kind}.npz")
                solvers = ["pardiso"] if has_pardiso else []
                solvers += ["superlu"] if size in _SUPERLU_SIZES else []
                for solver in solvers:
                    announce(f"solver: {solver}, {kind} matrix of {size:,} unknowns")
                    try:
                        found[solver, kind, size] = _one(size, kind, solver, path)
                    except InputError as error:  # one that fails takes no other along
                        left_out.append(f"Not measured: {solver}, {kind}, {size:,}: {error}.")
                        announce(left_out[-1])
    if not found:
        raise InputError(left_out[0])
    timings = tuple(
        Timing(f"{solver}, {kind}", step, at[step], at["error"], {
            "way": f"{solver}, {kind}", "step": step, "unknowns": int(at["unknowns"]),
            "entries": int(at["entries"]), "seconds": at[step], "peak_memory": at["memory"],
            "error": at["error"],
        }, _WANTED)
        for (solver, kind, _), at in found.items()
        for step in (_FIRST, _AGAIN, _SOLVE)
    )  # fmt: skip
    conditions = "  ".join([_CONDITIONS, *left_out])
    seconds = time.perf_counter() - started
    return Bench("solver", conditions, timings, _targets(found), seconds)


def _one(size: int, kind: str, solver: str, path: str) -> dict[str, float]:
    """Return what one solver takes for one matrix, made anew in a process of its own."""
    potentials = on_one_core(__name__, "write_matrix", size, kind == "complex", path)
    found: dict[str, float] = on_one_core(__name__, "measured", path, solver)
    return {**found, "potentials": potentials}


_CONDITIONS = (
    "Quadratic bricks of the paper's bimorph (degree 4 across the width), bending in x, base and "
    "electrodes held, lossless (real) and lossy (complex); again: on the same ordering.  "
    "Each factorisation includes balancing and the check with a known solution.  One process "
    f"with one thread per row, processor time, one run; numpy {np.__version__}, "
    f"{platform.machine()}."
)


def _targets(found: dict[tuple[str, str, int], dict[str, float]]) -> tuple[Target, ...]:
    errors = max(at["error"] for at in found.values())
    what, how = "error of a known solution", "worst of all, not refined"
    targets = [Target(what, _WANTED, errors, "", True, how)]
    counted = [at for at in found.values() if at["negative"] >= 0.0]
    if counted:
        off = max(abs(at["negative"] - at["potentials"]) for at in counted)
        gain = min(at[_FIRST] / at[_AGAIN] for at in counted)
        targets += [
            Target(
                "negative pivots other than one per potential", 0.0, off, "", True,
                "lossless, Pardiso",
            ),
            Target(
                "gain of a kept ordering", 1.2, gain, "", False,
                "least over the sizes; lossless, Pardiso",
            ),
        ]  # fmt: skip
    return tuple(targets)


def _bricks(device: Device, unknowns: int) -> Bricks:
    """Return quadratic bricks with about as many unknowns: finer throughout, then along z."""

    def bricks(layers: int, share: float) -> Bricks:
        return bimorph_bricks(device, BrickMeshing(
            (2, 4, 2), (1.0 / layers,) * layers, side=0.1, smallest=0.1, growth=2.0,
            longest=2.0 * share / layers, pieces=(6.0, 1e6),
        ))  # fmt: skip

    def size(bricks: Bricks) -> int:
        inside = bricks.nodes_of("piezo") & ~np.logical_or(*bricks.electrodes())
        return 3 * int(bricks.used().sum()) + int(inside.sum())

    layers = 1
    while size(bricks(layers + 1, 1.0)) <= unknowns:
        layers += 1
    low, high = 0.01, 1.0
    while high - low > _NEAR * low:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if size(bricks(layers, middle)) <= unknowns else (middle, high)
    return bricks(layers, high)


def write_matrix(unknowns: int, lossy: bool, path: str) -> int:
    """Write the matrix of about as many unknowns, and return how many are potentials."""
    from scipy import sparse

    from tactgen.fem.piezo.solid import assemble

    device = Device()
    system = assemble(device, _bricks(device, unknowns), lossy=lossy)
    sparse.save_npz(path, system.held, compressed=False)
    return system.potentials


def measured(path: str, solver: str) -> dict[str, float]:
    """Return the processor times (s) of the steps, peak memory (bytes), error and pivots."""
    from scipy import sparse

    from tactgen.fem.solvers.linear_solver import factorise

    matrix = sparse.load_npz(path)
    known = np.random.default_rng(3).uniform(-1.0, 1.0, (matrix.shape[0], _RIGHT_SIDES))
    right = matrix @ known
    first, factor = least_time(lambda: factorise(matrix, solver=solver))
    again, _ = least_time(lambda: factor.refactorise(matrix))
    seconds, solution = least_time(lambda: factor.solve(right))
    negative = factor.negative_pivots
    return {
        "unknowns": matrix.shape[0],
        "entries": matrix.nnz,
        _FIRST: first,
        _AGAIN: again,
        _SOLVE: seconds,
        "memory": peak_memory(),
        "error": float(np.abs(solution - known).max()),
        "negative": -1 if negative is None else negative,
    }
