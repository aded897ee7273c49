"""What the four models of the lateral actuator have in common: one interface.

Each gives, with the means to judge its numerical error: D(Ω) over the scene's
frequencies, the lossless D(0), and the lossless modes.
"""

from __future__ import annotations

import importlib
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from geometry.arrays import Floats
from geometry.store.values import storable
from tmm.ports.multiport import Multiport
from validation.engine.stages import Stages
from validation.scene.scene import Scene

T = TypeVar("T")


@storable
@dataclass(frozen=True)
class Refined(Generic[T]):
    """A result and what its numerical error is judged by.

    Attributes
    ----------
    fine : T
        The result.
    coarser : tuple of (T, float)
        Poorer results, each with the factor that turns its distance into an error bar;
        the bars add.  Empty for closed forms, whose error is rounding.
    method : str
        How the error bar comes about, for the reader.
    rounding : float or (n,) array
        Relative rounding error beyond that of the port equations; of modes, one for each.
    """

    fine: T
    coarser: tuple[tuple[T, float], ...]
    method: str
    rounding: Floats | float = 0.0


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
    """One model of the scene's lateral actuator; results are computed at most once."""

    name: str

    def __init__(self, scene: Scene, stages: Stages) -> None:
        self.scene, self.stages = scene, stages
        self.frequencies = np.asarray(scene.frequency, dtype=float)

    @abstractmethod
    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses over the scene's frequencies, parallel wiring."""

    @abstractmethod
    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0), parallel wiring."""

    @abstractmethod
    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless modes on the scene's support."""


#: Where each model is.
_CLASSES = {
    "lumped": ("validation.models.bimorph.rows", "LumpedModel"),
    "tmm": ("validation.models.bimorph.rows", "TmmModel"),
    "beam": ("validation.models.bimorph.beam", "BeamModel"),
    "solid": ("validation.models.bimorph.solid", "SolidModel"),
}


def make_model(name: str, scene: Scene, stages: Stages) -> Model:
    """Return the named model of a scene; its module is loaded now and not before."""
    module, kind = _CLASSES[name]
    model: Model = getattr(importlib.import_module(module), kind)(scene, stages)
    return model
