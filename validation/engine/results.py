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
class Estimate:
    """A number, or an array of them, with its numerical error.

    Attributes
    ----------
    value : float or array
        In SI units; nan where there is none.
    error : float or array
        Absolute numerical error, of the unit and shape of `value`'s magnitude; nan if not known.
    method : str
        How the error was estimated, for the reader.
    classes : tuple of str, optional
        The class of motion of each value of a list of modes.
    """

    value: Any
    error: Any
    method: str = ""
    classes: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", self.value + 0.0)  # no -0


@storable
@dataclass(frozen=True, kw_only=True)
class Quantity(Estimate):
    """An estimate by one model: one number, or an array over frequency or mode."""

    name: str
    model: str
    unit: str
    seconds: float = 0.0
    frequency: tuple[float, ...] | None = None


def quantity_json(q: Quantity) -> dict[str, Any]:
    """Return a quantity as plain JSON values; complex numbers as [re, im], no value as null."""
    out: dict[str, Any] = {
        "name": q.name,
        "model": q.model,
        "value": _numbers(q.value),
        "unit": q.unit,
        "uncertainty": _numbers(q.error),
        "uncertainty_method": q.method,
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
