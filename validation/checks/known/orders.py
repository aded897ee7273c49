"""Observed orders of convergence against theory, each with an absolute bound.

On problems whose exact answer is smooth, halving the intervals must divide the error as theory
says; an order without a bound would also be met by a wrong answer, so both are asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

from tactgen.fem.piezo.system import Material
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.validation.checks.case import Answer, Case, Refinement, case
from tactgen.validation.checks.cases.boxes import Box, Held, Where, even, natural_frequencies
from tactgen.validation.checks.cases.manufactured import quarter_wave_error
from tactgen.validation.checks.drawings.drawing import Drawing
from tactgen.validation.checks.drawings.sections import section
from tactgen.validation.checks.known import smooth_fields
from tactgen.validation.checks.known.laminates import bending_bimorph

#: The lowest natural frequency (Hz) of the bimorph below; see case CYL2.
_BENDING = 6981.984969234867
_THICKNESS = 1.0e-3
#: Relative size of the last digit that a report prints.
_PRINTED = 1e-5


@dataclass(frozen=True)
class _Problem:
    """A problem with a smooth exact answer.

    `coarse` is the number of intervals by degree from which halving starts: the error is far from
    rounding then, and its leading term dominates.  `bound` is that on the halves.
    """

    id: str
    title: str
    problem: str
    error: Callable[[int, int], float]
    coarse: dict[int, int]
    bound: Callable[[int], float]
    reason: str
    setup: Callable[[], Drawing]


def _rod(intervals: int, degree: int) -> Box:
    """Return a quarter wave of a rod without Poisson's ratio: ω = π/2 in units of the rod."""
    unit = even(1.0, 1, 1)
    slab = Slab("rod", (0, 1), (0, intervals))
    material = Material(isotropic_stiffness(1.0, 0.0), 1.0)
    box = Box(unit, unit, even(1.0, intervals, degree), ((slab, material),))
    return replace(box, held=(Held(Where(), ("x", "y")), Held(Where(z=0.0), ("z",))))


@cache
def _rod_error(degree: int, intervals: int) -> float:
    found = float(natural_frequencies(_rod(intervals, degree), 1)[0])
    return abs(found / 0.25 - 1.0)


@cache
def _bimorph_error(degree: int, intervals: int) -> float:
    box = bending_bimorph(_THICKNESS, degree=degree, intervals=intervals)
    return abs(float(natural_frequencies(box, 1)[0]) / _BENDING - 1.0)


def _order(problem: _Problem, degree: int) -> float:
    """Return the observed order from a division and its halves."""
    n = problem.coarse[degree]
    return math.log2(problem.error(degree, n) / problem.error(degree, 2 * n))


_THEORY = "a frequency converges with twice the degree"


def _orders(problem: _Problem) -> Case:
    highest = max(problem.coarse)
    return case(
        problem.id,
        problem.title,
        problem.problem,
        model="bricks of the model solid, one degree along z at a time",
        source=_THEORY + " (G. Strang, G. J. Fix, An Analysis of the Finite Element Method, ch. 6)",
        answers=[
            *(
                Answer(f"Bricks of degree {p} converge with order {2 * p}.",
                       (2.0 * p - 0.1, 2.0 * p + 0.1), "1", partial(_order, problem, p), 0.0,
                       "within 0.1 of theory")
                for p in problem.coarse
            ),
            *(
                Answer(f"Degree {p} on {2 * n} intervals is off by no more than its bound.",
                       (0.0, problem.bound(p)), "1", partial(problem.error, p, 2 * n), 0.0,
                       problem.reason)
                for p, n in problem.coarse.items()
            ),
        ],
        refinement=Refinement(
            (1, 2, 4, 8), partial(problem.error, highest), f"order {2 * highest}",
        ),
        setup=problem.setup,
    )  # fmt: skip


_ROD = _orders(_Problem(
    "ROD",
    "Orders on a rod",
    "A rod without Poisson's ratio, one end held: the lowest axial frequency, 1/4 √(E/ρ)/L.",
    _rod_error,
    {1: 16, 2: 6, 3: 2, 4: 1},
    lambda p: 2.0 * quarter_wave_error(p, 2 * {1: 16, 2: 6, 3: 2, 4: 1}[p]),
    "twice the leading term of the error",
    section(_rod, 4, 1, unit="L"),
))  # fmt: skip

_BIMORPH = _orders(_Problem(
    "CYLO",
    "Orders on the bimorph in cylindrical bending",
    "The bimorph of case CYL2, two PZT-5A layers of 1 mm poled towards each other, one half wave "
    "of 20 mm, both faces at 0 V: first bending frequency on bricks of equal length and one degree "
    "along z.",
    _bimorph_error,
    {2: 6, 3: 3},
    lambda _: _PRINTED,
    "below what a report prints",
    section(bending_bimorph, _THICKNESS),
))  # fmt: skip

CASES: tuple[Case, ...] = (_ROD, _BIMORPH, *smooth_fields.CASES)
