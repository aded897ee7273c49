"""The one number that stands for a quantity where there is room for one only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.validation.engine.results import Quantity
from tactgen.validation.view.formats import engineering, with_bar


@dataclass(frozen=True)
class Representative:
    """A number (SI) with its bar, and what it is of the quantity.

    Attributes
    ----------
    what : str
        ``first`` mode, ``size of the first`` pole, ``largest`` magnitude of a response, or nothing
        of a single number.
    at : float or None
        Frequency (Hz) of the largest.
    """

    value: float
    error: float
    unit: str
    what: str
    at: float | None = None

    @property
    def text(self) -> str:
        """As people read it."""
        if np.isnan(self.value):
            return "no value"
        where = f" at {self.at:g} Hz" if self.at is not None else ""
        if np.isnan(self.error):
            return engineering(self.value, self.unit) + where
        return with_bar(self.value, self.error, self.unit) + where


def representative(q: Quantity) -> Representative:
    """Return the number itself, of modes and poles the first, of a response the largest magnitude.

    Of what is complex it is the magnitude: a pole's is its natural angular frequency.
    Of one frequency it is the magnitude there, of a matrix its largest entry, without a bar.
    """
    bars = np.broadcast_to(q.error, q.value.shape)
    if q.frequency is None:
        place: Any = (0,) * q.value.ndim
        what, value = "first" if q.value.ndim else "", q.value[place]
        if np.iscomplexobj(value):
            what, value = "size of the first", np.abs(value)
        return Representative(float(value), float(bars[place]), q.unit, what)
    size = np.abs(q.value)
    if not np.isfinite(size).any():
        return Representative(np.nan, np.nan, q.unit, "largest")
    place = np.unravel_index(int(np.nanargmax(size)), size.shape)
    several = len(q.frequency) > 1
    return Representative(
        float(size[place]),
        float(bars[place]) if q.value.ndim == 1 else np.nan,
        q.unit,
        "largest entry" if q.value.ndim > 1 else "largest" if several else "",
        q.frequency[int(place[0])] if several else None,
    )
