"""Numbers with their errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tactgen.geometry.store.values import storable


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
@dataclass(frozen=True, kw_only=True)
class Quantity(Estimate):
    """An estimate by one model: one number, or an array over frequency or mode."""

    name: str
    model: str
    unit: str
    seconds: float = 0.0
    frequency: tuple[float, ...] | None = None
