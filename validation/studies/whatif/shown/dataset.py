"""A study as arrays over its axes, as a netCDF file and a picture need it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.results import Quantity
from tactgen.validation.studies.whatif.run import Study

Array = NDArray[Any]

#: Statuses by their number in the file.
STATUSES = ("ok", "failed", "refused")


@dataclass(frozen=True)
class Variable:
    """An array with the names of its dimensions, its unit and its meaning."""

    dimensions: tuple[str, ...]
    values: Array
    unit: str
    meaning: str


@dataclass(frozen=True)
class Dataset:
    """A study's arrays; quantities are over model, the axes' dimensions and their own.

    Attributes
    ----------
    coordinates : dict of str to Variable
        Values of the axes, models, and what the quantities are over besides.
    variables : dict of str to Variable
        Quantities (complex ones whole) by name, their error bars as ``NAME_uncertainty``;
        nan where there is no answer.
    status : Variable
        Places in :data:`STATUSES`.
    reason, seconds : Variable
        Why there is no answer; what the answer cost when it was computed.
    """

    coordinates: dict[str, Variable]
    variables: dict[str, Variable]
    status: Variable
    reason: Variable
    seconds: Variable


def dataset(study: Study) -> Dataset:
    """Return the study's arrays."""
    stated = study.statement
    over = ("model", *stated.shape)
    shape = (len(stated.models), *stated.shape.values())
    coordinates = {
        axis.key: Variable(
            (dimension,), np.array(values, dtype=None if axis.numeric else np.str_), axis.unit,
            f"scene key {axis.key}",
        )
        for axis in stated.axes
        for dimension, values in (stated.columns[axis.key],)
    }  # fmt: skip
    coordinates["model"] = Variable(("model",), np.array(stated.models), "", "model")

    def each(of: Callable[[Any], Any], kind: Any, unit: str, meaning: str) -> Variable:
        found = [[of(answers[m]) for answers in study.answers] for m in stated.models]
        return Variable(over, np.array(found, dtype=kind).reshape(shape), unit, meaning)

    variables: dict[str, Variable] = {}
    for name in stated.quantities:
        _add(study, name, over, shape, coordinates, variables)
    return Dataset(
        coordinates, variables,
        each(lambda a: STATUSES.index(a.status), np.int8, "", "whether there is an answer"),
        each(lambda a: a.reason, np.str_, "", "why there is no answer"),
        each(lambda a: a.seconds, float, "s", "cost of the answer when it was computed"),
    )  # fmt: skip


def _add(
    study: Study,
    name: str,
    over: tuple[str, ...],
    shape: tuple[int, ...],
    coordinates: dict[str, Variable],
    variables: dict[str, Variable],
) -> None:
    """Add one quantity and its bars, with the coordinates that it brings."""
    row, models = QUANTITIES[name], study.statement.models
    found = [
        [next((q for q in answers[m].quantities if q.name == name), None) for m in models]
        for answers in study.answers
    ]
    known = [q for each in found for q in each if q is not None]
    if not known:
        return
    inner = tuple(max(sizes) for sizes in zip(*(q.value.shape for q in known), strict=True))
    value = np.full((len(models), len(found), *inner), np.nan, np.result_type(*(
        q.value for q in known)))  # fmt: skip
    bar = np.full(value.shape, np.nan)
    for n, by_model in enumerate(found):
        for m, q in enumerate(by_model):
            if q is not None:
                place: Any = (m, n, *(slice(size) for size in q.value.shape))
                value[place], bar[place] = q.value, q.error
    names = _inner_dimensions(known)
    if names[:1] == ("frequency",) and "frequency" in study.statement.columns:
        value, bar, names, inner = value[:, :, 0], bar[:, :, 0], names[1:], inner[1:]
    _add_coordinates(names, inner, known[0], coordinates)
    whole = (*shape, *inner)
    variables[name] = Variable((*over, *names), value.reshape(whole), row.unit, row.meaning)
    variables[f"{name}_uncertainty"] = Variable(
        (*over, *names), bar.reshape(whole), row.unit,
        f"numerical error bar of {name}, absolute, of the magnitude",
    )  # fmt: skip


def _inner_dimensions(known: list[Quantity]) -> tuple[str, ...]:
    """Return the dimensions of a quantity itself."""
    first = known[0]
    if first.frequency is None:
        return ("mode",) if first.value.ndim else ()
    return ("frequency", "effort", "motion")[: first.value.ndim]


def _add_coordinates(
    names: tuple[str, ...],
    sizes: tuple[int, ...],
    first: Quantity,
    coordinates: dict[str, Variable],
) -> None:
    """Add the coordinates that a quantity is over besides the axes."""
    of_matrix = "place in the matrix over the ports, from 1"
    meanings = {"mode": "number of the mode, from 1", "effort": of_matrix, "motion": of_matrix}
    for name, size in zip(names, sizes, strict=True):
        if name == "frequency":
            values = np.array(first.frequency)
            coordinates[name] = Variable((name,), values, "Hz", "frequency of the drive")
        elif name not in coordinates or coordinates[name].values.size < size:
            coordinates[name] = Variable((name,), np.arange(1, size + 1), "", meanings[name])
