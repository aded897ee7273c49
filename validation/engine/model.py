"""Interface of a model: it provides the answers that quantities are read from.

The answers to "static" and "harmonic" are Refined[Multiport], parallel wiring; to "modes_short"
and "modes_open" Refined[Modes]; the normal actuator's hold an Estimate for each value.
"""

from __future__ import annotations

import importlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, TypeVar

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.store.values import storable
from tactgen.tmm.ports.multiport import Response
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.row import Need
from tactgen.validation.engine.stages import Stages
from tactgen.validation.scene.scene import Scene

T = TypeVar("T")


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
        """Refuse a scene that the model cannot take, before anything is computed.

        Raises InputError with the remedy.
        """

    @classmethod
    def finest(cls, scene: Scene) -> float:
        """Relative error bar that its finest mesh keeps to."""
        return MODELS[cls.name].finest

    @abstractmethod
    def answer(self, need: Need) -> Any:
        """Answer that quantities of this analysis are read from."""

    def closed_form(self, ends: Ends) -> Refined[Response] | None:
        """Closed-form motion of the tip and charge at 1 V, if there is one."""
        return None

    def warnings(self, quantities: Sequence[str]) -> tuple[str, ...]:
        """Warnings about these quantities."""
        return ()

    def run(self, stage: str, work: Callable[[], T]) -> T:
        """Result of one of the row's stages, computed the first time."""
        return self.stages.run(f"{self.name}.{stage}", work)

    def will_run(self, stage: str) -> bool:
        """Whether one of the row's stages is in the plan."""
        return f"{self.name}.{stage}" in self.stages.keys


def model_class(name: str) -> type[Model]:
    """Class of a model; its module is loaded now and not before."""
    row = MODELS[name]
    found: type[Model] = getattr(importlib.import_module(row.module), row.kind)
    return found


def make_model(name: str, scene: Scene, stages: Stages) -> Model:
    """Named model of a scene."""
    return model_class(name)(scene, stages)
