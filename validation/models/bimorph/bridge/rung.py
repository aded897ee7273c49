"""What a step of a bridge is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


class Values(NamedTuple):
    """What a bridge follows.

    Attributes
    ----------
    deflection : float
        Static tip displacement per volt (m).
    first_frequency, open_frequency : float
        Of the first bending mode in x (Hz), at U = 0 and at Q = 0.
    capacitance, blocked_capacitance : float
        Static, with a free tip, and with base and tip held (F).
    coupling : float
        sqrt(1 - (first / open)²).
    """

    deflection: float
    first_frequency: float
    capacitance: float
    open_frequency: float
    coupling: float
    blocked_capacitance: float

    def step_from(self, before: Values) -> Steps:
        """Return the relative changes from another set of values."""
        return Steps(*(float(a / b - 1.0) for a, b in zip(self, before, strict=True)))


class Steps(NamedTuple):
    """Relative changes of :class:`Values`; nan where none is known."""

    deflection: float = np.nan
    first_frequency: float = np.nan
    capacitance: float = np.nan
    open_frequency: float = np.nan
    coupling: float = np.nan
    blocked_capacitance: float = np.nan


#: Where no change is known.
UNKNOWN = Steps()


@dataclass(frozen=True)
class Rung:
    """One step of a bridge.

    Attributes
    ----------
    name, what : str
        Short, and in a sentence.
    values : Values
        After this step.
    step : Steps
        Change from the rung before, nan at the start.
    predicted : Steps
        The change that a closed form gives.
    theory : str
        Which closed form.
    section : Steps
        The change that the solid's own section, far from its ends, makes in the beam model.
    """

    name: str
    what: str
    values: Values
    step: Steps = UNKNOWN
    predicted: Steps = UNKNOWN
    theory: str = ""
    section: Steps = UNKNOWN

    @property
    def deflection(self) -> float:
        """Tip displacement per volt (m)."""
        return self.values.deflection

    @property
    def first_frequency(self) -> float:
        """First short-circuit bending frequency (Hz)."""
        return self.values.first_frequency

    @property
    def capacitance(self) -> float:
        """Free capacitance (F)."""
        return self.values.capacitance
