"""Which meshes are benchmarked, ours and those that suit each public program.

Peers get what a user who knows them would choose: bricks graded towards clamp, layer faces
and edges, of order 2 and 3 (4 costs NGSolve's assembly more than it gives), and for NGSolve
Netgen's tetrahedra too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tactgen.validation.bench.bimorph import jobs
from tactgen.validation.bench.bimorph.jobs import job
from tactgen.validation.bench.bimorph.peers import PEERS, missing, solve
from tactgen.validation.bench.bimorph.peers.job import Answer, Job
from tactgen.validation.bench.one_core import on_one_core

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
        found: Answer = on_one_core(jobs.__name__, "solve_own", family, fineness, frequencies)
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
        *levels(jobs.BRICKS, list(range(2 if quick else 4)), True),
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
