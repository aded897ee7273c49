"""A study as a tidy table: one row a point, model, quantity and index, SI units."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.files import write_text
from tactgen.validation.catalogue.models import gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.results import Quantity
from tactgen.validation.studies.whatif.answers import Answer
from tactgen.validation.studies.whatif.run import Study

#: File of the table in a study's folder.
FILE = "study.csv"
#: Columns after those of the axes.
COLUMNS = (
    "quantity", "model", "frequency", "index", "value", "value_im", "uncertainty", "unit",
    "status", "reason",
)  # fmt: skip


@dataclass(frozen=True)
class Record:
    """One number of a study.

    Attributes
    ----------
    frequency : float or None
        In Hz, of a response.
    index : int or None
        Of a mode its number from 1; of a matrix over the ports the place row by row from 1.
    value, value_im, uncertainty : float or None
        None where there is no answer; `value_im` None of real numbers.
    """

    point: dict[str, Any]
    quantity: str
    model: str
    frequency: float | None
    index: int | None
    value: float | None
    value_im: float | None
    error: float | None
    unit: str
    status: str
    reason: str

    @property
    def cells(self) -> tuple[Any, ...]:
        """What a row of the table holds."""
        return (
            *self.point.values(),
            *(getattr(self, "error" if name == "uncertainty" else name) for name in COLUMNS),
        )


def records(study: Study) -> Iterator[Record]:
    """Yield every number of a study; of an answer that is missing one row a quantity."""
    for point, model, answer in study.rows:
        for name in study.statement.quantities:
            if gives(model, name):
                yield from records_of(point, model, name, answer)


def records_of(point: dict[str, Any], model: str, name: str, answer: Answer) -> Iterator[Record]:
    """Yield every number of one quantity by one model at one point."""
    found = next((q for q in answer.quantities if q.name == name), None)
    if found is None:
        unit = QUANTITIES[name].unit
        yield Record(point, name, model, None, None, None, None, None, unit, answer.status,
                     answer.reason)  # fmt: skip
        return
    complex_valued = np.iscomplexobj(found.value)
    bars = np.broadcast_to(found.error, found.value.shape)
    for place in itertools.product(*(range(size) for size in found.value.shape)):
        frequency, index = _labels(found, place)
        value = found.value[place]
        yield Record(
            point, name, model, frequency, index, float(value.real),
            float(value.imag) if complex_valued else None,
            float(bars[place]),
            found.unit, answer.status, answer.reason,
        )  # fmt: skip


def _labels(found: Quantity, place: tuple[int, ...]) -> tuple[float | None, int | None]:
    """Return frequency and index of one place in a quantity's array."""
    if found.frequency is None:
        return None, place[0] + 1 if place else None
    rest = place[1:]
    index = int(np.ravel_multi_index(rest, found.value.shape[1:])) + 1 if rest else None
    return found.frequency[place[0]], index


def write_tidy(folder: Path, study: Study) -> Path:
    """Write the table as CSV (RFC 4180, UTF-8), whole or not at all.

    Numbers are written so that reading gives the same double; what is missing is empty.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([*(axis.label for axis in study.statement.axes), *COLUMNS])
    table.writerows(record.cells for record in records(study))
    return write_text(folder / FILE, text.getvalue())
