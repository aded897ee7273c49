"""One computed quantity with its error bar, and how it is written for other programs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.store.values import storable

Array = NDArray[Any]


@storable
@dataclass(frozen=True)
class Measured:
    """A value with its numerical error bar, both in the same SI unit; nan where there is none."""

    value: float
    bar: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", self.value + 0.0)  # no -0


@storable
@dataclass(frozen=True)
class MeasuredList:
    """Values with their error bars (n,), in one SI unit, and of a list the class of each."""

    value: Array
    bar: Array
    classes: tuple[str, ...] | None = None


@storable
@dataclass(frozen=True)
class Quantity:
    """One number, or array over frequency or mode, by one model.

    `uncertainty` is the numerical one, absolute, of the shape of `value`'s magnitude.
    """

    name: str
    model: str
    value: Array
    unit: str
    uncertainty: Array
    uncertainty_method: str
    seconds: float
    frequency: tuple[float, ...] | None = None
    classes: tuple[str, ...] | None = None


def quantity_json(q: Quantity) -> dict[str, Any]:
    """Return a quantity as plain JSON values; complex numbers as [re, im], no value as null."""
    out: dict[str, Any] = {
        "name": q.name,
        "model": q.model,
        "value": _numbers(q.value),
        "unit": q.unit,
        "uncertainty": _numbers(q.uncertainty),
        "uncertainty_method": q.uncertainty_method,
        "seconds": q.seconds,
    }
    if q.frequency is not None:
        out["frequency"] = list(q.frequency)
    if q.classes is not None:
        out["classes"] = list(q.classes)
    return out


def _numbers(values: Array) -> Any:
    if np.iscomplexobj(values):
        return np.stack([values.real, values.imag], axis=-1).tolist()
    if np.isfinite(values).all():
        return values.tolist()
    known = np.isfinite(values)
    return np.where(known, values.astype(object), np.array(None)).tolist()
