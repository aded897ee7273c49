"""Mesh levels of a case, and the case on coarser levels.

Every kind of model states its fineness here once, through :func:`degree`, :func:`intervals`,
:func:`size`, :func:`segments`, :func:`steps` or :func:`level`.  So any measurement can be run again
some levels coarser without a word of its own: by how much it changes on the next level is its error
bar, and its values over the levels are its convergence.  What asks for none of these is not divided
at all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import cache, wraps
from typing import Any, NamedTuple, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class Kind(NamedTuple):
    """Kind of division: levels, measure, expected order."""

    coarser: str
    finer: str
    measure: str
    theory: str


DEGREE = Kind(
    "one polynomial degree less",
    "one polynomial degree more",
    "unknowns",
    "exponential in the degree where the answer is smooth, a power of the unknowns where edges "
    "make it singular",
)
CELLS = Kind(
    "cells half as large again",
    "cells two thirds as large",
    "unknowns",
    "a power of the cells' size: for a mean or an energy twice the order where the field is "
    "smooth, less where edges make it singular",
)
SEGMENTS = Kind(
    "half as many segments",
    "twice as many segments",
    "segments",
    "the fourth power of a segment's length, less where the taper ends in a point",
)
STEPS = Kind("half as many steps", "twice as many steps", "steps in time", "the square of the step")
LEVEL = Kind(
    "the next coarser level of the model's own meshes",
    "the next finer level of the model's own meshes",
    "unknowns",
    "a power of the unknowns, less where edges and clamps make the answer singular",
)

#: By what sizes of cells grow from one level to the next coarser one.
_GROWTH = 1.5
#: The least degree that is taken in place of a higher one.
_QUADRATIC = 2


@dataclass
class Run:
    """Division that a measurement used on one level."""

    below: int = 0  #: How many levels coarser than the case's own; below 0 finer
    kinds: set[Kind] = field(default_factory=set)  #: How it is divided; empty if it is not
    #: Whether anything differs from the next level towards the case's own: degrees cannot fall for
    #: ever
    new: bool = False
    count: int = 0  #: The most unknowns, or steps

    def join(self, other: Run) -> None:
        """Take over the division of a part of the measurement."""
        self.kinds |= other.kinds
        self.new |= other.new
        self.count = max(self.count, other.count)


_run: ContextVar[Run] = ContextVar("run")


@contextmanager
def on_level(below: int) -> Iterator[Run]:
    """Context in which meshes are so many levels coarser."""
    run = Run(below)
    token = _run.set(run)
    try:
        yield run
    finally:
        _run.reset(token)


def cached(function: Callable[P, T]) -> Callable[P, T]:
    """Cache a function's values by level."""

    @cache
    def on(below: int, *arguments: Any, **named: Any) -> tuple[T, Run]:
        with on_level(below) as run:
            return function(*arguments, **named), run

    @wraps(function)
    def call(*arguments: P.args, **named: P.kwargs) -> T:
        here = _here()
        value, run = on(here.below, *arguments, **named)  # type: ignore[arg-type]
        here.join(run)
        return value

    call.cache_clear = on.cache_clear  # type: ignore[attr-defined]
    return call


def degree(wanted: int) -> int:
    """Polynomial degree, on each coarser level one less.

    Not below quadratics, but for what is linear from the start: linear functions lock where a
    body bends.
    """
    return _chosen(DEGREE, lambda below: max(min(wanted, _QUADRATIC), wanted - below))


def intervals(wanted: int, least: int = 2) -> int:
    """Number of intervals along an edge, each level's two thirds of the finer one's."""
    return _chosen(CELLS, lambda below: max(least, round(wanted / _GROWTH**below)))


def size(wanted: float) -> float:
    """Size of cells, on each coarser level half as large again."""
    return _chosen(CELLS, lambda below: wanted * _GROWTH**below)


def segments(wanted: int) -> int:
    """Number of segments of a taper, on each coarser level half of it; it is counted."""
    return counted(_chosen(SEGMENTS, lambda below: max(1, int(wanted * 0.5**below))))


def steps(wanted: int) -> int:
    """Number of steps in time, on each coarser level half of it; it is counted."""
    return counted(_chosen(STEPS, lambda below: max(1, int(wanted * 0.5**below))))


def level(wanted: int, least: int = 1) -> int:
    """Level of a model's own meshes."""
    return _chosen(LEVEL, lambda below: max(least, wanted - below))


def counted(count: int) -> int:
    """Say how many unknowns a division has."""
    _here().join(Run(count=count))
    return count


def _here() -> Run:
    """Run that this is a part of; one that nobody looks at where there is none."""
    return _run.get(None) or Run()


def _chosen(kind: Kind, on: Callable[[int], T]) -> T:
    here = _here()
    found = on(here.below)
    towards = here.below - (here.below > 0) + (here.below < 0)
    here.join(Run(kinds={kind}, new=found != on(towards)))
    return found
