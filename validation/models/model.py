"""What a model is, of whichever actuator: stages give answers, and quantities are read off these.

The answers to "static" and "harmonic" are Refined[Multiport], parallel wiring; to "modes_short"
and "modes_open" Refined[Modes]; the normal actuator's hold an Estimate for each value.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.errors import CoarseGridError
from tactgen.geometry.store.store import cached_result
from tactgen.geometry.store.values import storable
from tactgen.tmm.ports.multiport import Multiport, Response, round_off
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import Need
from tactgen.validation.scene.scene import Scene

T = TypeVar("T")


# ---- numbers with their errors ----


@storable
@dataclass(frozen=True)
class Estimate:
    """A number, or an array of them, with its numerical error."""

    value: Any  #: In SI units; nan where there is none
    #: Absolute numerical error, of the unit and shape of `value`'s magnitude; nan if not known
    error: Any
    method: str = ""  #: How the error was estimated, for the reader
    classes: tuple[str, ...] | None = None  #: The class of motion of each value of a list of modes

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", self.value + 0.0)  # no -0


@storable
@dataclass(frozen=True)
class Extreme:
    """Largest size of a response over a band, of a limit the least, with its numerical error."""

    frequency: float  #: Hz
    value: float
    error: float
    #: What the most detailed model is expected to reach at its own resonance, and the error of that
    expected: float = float("nan")
    expected_error: float = float("nan")


@storable
@dataclass(frozen=True)
class Modelling:
    """What the most detailed model is expected to answer in place of another one."""

    expected: Any  #: Its value, in SI units; nan where nothing is known
    error: Any  #: Absolute error of `expected`
    method: str  #: Where both come from, for the reader


@storable
@dataclass(frozen=True, kw_only=True)
class Quantity(Estimate):
    """An estimate by one model: one number, or an array over frequency or mode."""

    name: str
    model: str
    unit: str
    seconds: float = 0.0
    frequency: tuple[float, ...] | None = None
    #: Between the frequencies of a sweep too, at the model's own resonance
    extreme: Extreme | None = None
    #: Beside the most detailed model; None of its own answers, and where nothing is known
    modelling: Modelling | None = None

    @property
    def modelling_error(self) -> Any:
        """Absolute difference from the most detailed model that is possible; nan if not known."""
        if self.modelling is None:
            # a stated level is of no model
            detailed = not self.model or MODELS[self.model].detailed
            return np.full(np.shape(self.value), 0.0 if detailed else np.nan)
        return np.abs(self.value - self.modelling.expected) + self.modelling.error

    @property
    def extreme_at_end(self) -> bool:
        """Whether its largest or least value lies where the band ends."""
        ends = min(self.frequency or (0.0,)), max(self.frequency or (0.0,))
        return self.extreme is not None and self.extreme.frequency in ends

    @property
    def alone_at_extreme(self) -> Quantity:
        """Largest or least value of a sweep as a number of its own."""
        assert self.extreme is not None
        value, modelling = self.extreme.value, self.modelling
        if modelling is not None:
            modelling = replace(
                modelling, expected=self.extreme.expected, error=self.extreme.expected_error
            )
        return replace(
            self, value=np.asarray(value), error=np.asarray(self.extreme.error), frequency=None,
            modelling=modelling,
        )  # fmt: skip


@storable
@dataclass(frozen=True)
class Refined(Generic[T]):
    """Result with the basis of its numerical error."""

    fine: T  #: The result
    #: Poorer results, each with the factor that turns its distance into an error bar; the bars add.
    #: Empty for closed forms, whose error is rounding
    coarser: tuple[tuple[T, float], ...]
    method: str  #: How the error bar comes about, for the reader
    #: Relative rounding error beyond that of the port equations; of modes, one for each
    rounding: Floats | float = 0.0
    #: Whether the coarser results tell rounding, too, of whatever is read off them
    rounds_apart: bool = False
    #: Relative error bar that the coarser results are trusted with at least: they may agree by
    #: chance.  Only of what is read off ports at 0 Hz
    least: float = 0.0
    #: Judges what is read off this and another result together, in place of `coarser`, where much
    #: of both errors is alike; empty where `coarser` serves
    beside: tuple[tuple[T, float], ...] = ()


@storable
@dataclass(frozen=True)
class Modes:
    """Natural frequencies (Hz), ascending, with the class of each."""

    frequencies: Floats
    classes: tuple[str, ...]

    @property
    def first_bending(self) -> float:
        """Lowest bending mode in x (Hz); nan if there is none among the modes."""
        if "bending_x" not in self.classes:
            return float("nan")
        return float(self.frequencies[self.classes.index("bending_x")])


# ---- numerical errors from coarser results ----

#: Safety factor on the extrapolated error (grid convergence index, Roache 1994).
SAFETY = 1.25
#: Order assumed between two uniform meshes of tetrahedra.  Corners where stiffness jumps at a clamp
#: limit quadratic elements to between 1 and 2 in energy-like quantities.
ASSUMED_ORDER = 1.5
#: Factor by which the error falls at least from one level of bricks to the next: with it, and
#: the safety factor, 19 of 20 errors of varied bimorphs are within their bars
#: (validation/evidence/coverage_bimorph.py).
ASSUMED_GAIN = 1.6
#: Error of one level of bricks per difference from the next coarser level.
BRICK_FACTOR = SAFETY / (ASSUMED_GAIN - 1.0)
#: Error of bricks per difference that polynomials of one degree more make by their residual,
#: those of displacement and those of potential apart.  Theirs is most of what is missing, but less
#: where the solution is singular at an edge inside the body: at the end of a tab, of glue, of a
#: patch, of a thin ceramic or of an electrode, or where a base holds the shim alone.  Chosen on 31
#: bimorphs drawn at random, so that 19 of 20 errors are within their bars; of 35 drawn after it
#: 98 % were, with half the bars at most 4.2 times the error (validation/evidence/
#: coverage_bimorph.py).  With one factor for all, those without such an edge had to have bars of
#: ten errors for those with one to be covered.
SURPLUS_FACTOR, SURPLUS_FACTOR_AT_EDGES = 2.5, 5.0
#: Least gain in error of halved elements that is counted with.  Less is seen where rounding is all
#: that separates two meshes; then what does separate them is the bar, with the safety factor.
LEAST_HALVED = 2.0
#: Share of the largest difference in a class of modes, or at rest; or of what a difference of two
#: errors can be at most.
_BY_CHANCE = 0.1


def two_mesh_factor(ratio: float, order: float = ASSUMED_ORDER) -> float:
    """Error of the finer of two meshes per difference; `ratio` > 1 is that of element sizes."""
    return float(SAFETY / (ratio**order - 1.0))


def observed_factor(before: Floats, last: Floats, order: float) -> Floats:
    """Error of the finest of three meshes, elements halved, per difference from the next coarser.

    The error falls by what the two differences show: at most by what the order promises, at least
    by :data:`LEAST_HALVED`.  `before` and `last` (...) are the sizes of the difference of the
    coarser two meshes, and of the finer two; `order` is that of the error in the elements' size.
    """
    shown = np.asarray(before) / np.maximum(last, np.finfo(float).tiny)
    return np.asarray(SAFETY / (np.clip(shown, LEAST_HALVED, 2.0**order) - 1.0))


def least_difference(fine: Floats, coarse: Floats) -> Floats:
    """Relative difference (...) that each answer of a group (..., n) counts with at least.

    Two levels may agree in one mode, or in one answer at rest, by chance, while they differ in
    its neighbours: a tenth of the largest difference in the group.  A mode without partner is nan.
    What is zero, such as motion without piezoelectricity, has no share.
    """
    apart = np.abs(fine - coarse) / np.where(fine == 0.0, np.inf, fine)
    return np.asarray(
        _BY_CHANCE * np.where(np.isfinite(apart), apart, 0.0).max(axis=-1, initial=0.0)
    )


def cancelling(change: float, most: float) -> float:
    """Size that a difference of two errors counts with, estimated as `change`.

    Of two errors that are much alike next to nothing may be left by chance: a tenth of the `most`
    that it can be counts besides.  Chosen on coupling factors of 20 bimorphs and of 15 members of
    families drawn at random: with the factors above, those of 20 and of 7 drawn after them were
    all covered, half of them by bars of at most 2.7 and 2.2 errors.
    """
    return abs(change) + _BY_CHANCE * most


def rounding_of_ports(
    refined: Refined[Multiport], attached: Multiport, driven: Sequence[str] = ("voltage",)
) -> Any:
    """Relative rounding (n,) of the port equations that no other result shows."""
    if refined.rounds_apart:
        return np.full(attached.frequencies.shape, np.finfo(float).eps)
    return round_off(attached, driven)


# ---- stages and models ----


@dataclass
class Stages:
    """Stages of a plan: each runs once, is timed, and is looked for in the store.

    A stage that the plan does not contain is refused, so the plan shown to the user is the
    plan that runs.
    """

    keys: dict[str, str]  #: Stages with the hash of exactly the inputs that each reads
    announce: Callable[[str], None] = lambda _: None  #: Called with a stage as it is computed
    seconds: dict[str, float] = field(default_factory=dict)  #: Cost of each stage that ran
    #: Stages that were computed, not recalled or taken over
    computed: set[str] = field(default_factory=set)
    _results: dict[str, Any] = field(default_factory=dict)

    def run(self, name: str, work: Callable[[], T], code: tuple[str, ...] = ()) -> T:
        """Stage's result: of this run, from the store if it is of some `code`, or computed now.

        Raises RuntimeError if the stage is not part of the plan: a defect of the plan, not of the
        input.
        """
        if name not in self._results:
            if name not in self.keys:
                raise RuntimeError(f"stage {name} ran although the plan skips it")
            start, inner = time.perf_counter(), sum(self.seconds.values())

            def announced() -> T:
                self.announce(name)
                self.computed.add(name)
                return work()

            try:
                self._results[name] = (
                    cached_result(name, (self.keys[name],), code, announced, announce=self.announce)
                    if code else announced()
                )  # fmt: skip
            except CoarseGridError as error:
                self._results[name] = error  # not tried again for the next quantity
            spent_inside = sum(self.seconds.values()) - inner
            self.seconds[name] = time.perf_counter() - start - spent_inside
        result = self._results[name]
        if isinstance(result, CoarseGridError):
            raise result
        found: T = result
        return found

    def adopt(self, other: Stages) -> None:
        """Take over the results of another study whose inputs, by key, were the same."""
        for name, key in self.keys.items():
            if other.keys.get(name) == key and name in other.seconds:
                self.seconds[name] = other.seconds[name]
                if name in other._results:
                    self._results[name] = other._results[name]


class Model(ABC):
    """One model of a scene's actuator; results are computed at most once.

    What it gives, by which stages, and what each stage reads stands in its row of
    :data:`validation.catalogue.models.MODELS`.
    """

    name: ClassVar[str]

    def __init__(self, scene: Scene, stages: Stages) -> None:
        self.scene, self.stages = scene, stages

    @classmethod  # noqa: B027  (most models take every scene)
    def check(cls, scene: Scene) -> None:
        """Refuse a scene that the model cannot take with InputError, before any computation."""

    @classmethod
    def finest(cls, scene: Scene) -> float:
        """Relative error that its finest mesh keeps to."""
        return MODELS[cls.name].finest

    @classmethod
    def code(cls) -> tuple[str, ...]:
        """Modules that compute its answers."""
        return (cls.__module__, *MODELS[cls.name].loads)

    @abstractmethod
    def answer(self, need: Need) -> Any:
        """What quantities with this need are read from."""

    def closed_form(self, ends: Ends) -> Refined[Response] | None:
        """What tip and charge do at 1 V, as wired, if a closed form knows it."""
        return None

    def warnings(self, quantities: Sequence[str]) -> tuple[str, ...]:
        """What the reader of these quantities must know."""
        return ()

    def run(self, stage: str, work: Callable[[], T]) -> T:
        """Result of one of the row's stages, computed the first time."""
        stored = stage in MODELS[self.name].kept
        return self.stages.run(f"{self.name}.{stage}", work, self.code() if stored else ())
