"""Table of answers: one row a number, written for screen, JSON, CSV and netCDF.

Numbers are in SI units; complex ones are peak amplitudes, apart in real and imaginary part.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.files import write_text, written_whole
from tactgen.geometry.formats import engineering, share, with_error
from tactgen.geometry.store.values import storable
from tactgen.validation.catalogue.models import gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.models.model import Quantity

Array = NDArray[Any]

#: Statuses by their number in a netCDF file.
STATUSES = ("ok", "failed", "refused")
#: Frequencies of a response on the screen, at most.
_FREQUENCIES = 12
#: Digits of a value on the screen.
_DIGITS = 7


@storable
@dataclass(frozen=True)
class Answer:
    """Quantities of one scene by one model, or why there are none."""

    #: ``ok``; ``failed`` if the model could not solve the scene; ``refused`` if the values do not
    #: make a scene
    status: str
    reason: str  #: Why there are no quantities, in one sentence
    quantities: tuple[Quantity, ...] = ()  #: With their errors
    warnings: tuple[str, ...] = ()  #: Limits of their validity
    seconds: float = 0.0  #: Cost of the computation

    def get(self, name: str) -> Quantity | None:
        """One quantity by name, None if there is none."""
        return next((q for q in self.quantities if q.name == name), None)


#: Columns after those of the point.  `frequency` (Hz) is that of a response; `index` the number of
#: a mode, or the place in a matrix over the ports row by row, from 1.  Numbers are None where there
#: is no answer.
COLUMNS = (
    "quantity", "model", "frequency", "index", "value", "value_im", "uncertainty", "unit",
    "status", "reason",
)  # fmt: skip
#: One number of the table, in the order of :data:`COLUMNS`.
Row = tuple[Any, ...]


def rows(model: str, names: Iterable[str], answer: Answer) -> Iterator[Row]:
    """Yield every number of an answer; one row for a quantity that is missing."""
    for name in names:
        found = answer.get(name)
        if found is not None:
            yield from quantity_rows(found, answer.status, answer.reason)
        elif gives(model, name):
            none = (None,) * 5
            yield name, model, *none, QUANTITIES[name].unit, answer.status, answer.reason


def quantity_rows(q: Quantity, status: str = "ok", reason: str = "") -> Iterator[Row]:
    """Yield every number of a quantity."""
    errors, imaginary = np.broadcast_to(q.error, q.value.shape), np.iscomplexobj(q.value)
    for place in itertools.product(*map(range, q.value.shape)):
        value, (frequency, index) = q.value[place], _labels(q, place)
        parts = float(value.real), float(value.imag) if imaginary else None, float(errors[place])
        yield q.name, q.model, frequency, index, *parts, q.unit, status, reason


def _labels(q: Quantity, place: tuple[int, ...]) -> tuple[float | None, int | None]:
    """Frequency and index of one place in a quantity's array."""
    if q.frequency is None:
        return None, place[0] + 1 if place else None
    inner = place[1:]
    index = int(np.ravel_multi_index(inner, q.value.shape[1:])) + 1 if inner else None
    return q.frequency[place[0]], index


def write_csv(path: Path, axes: Iterable[str], table: Iterable[Sequence[Any]]) -> Path:
    """Write rows that start with the values of axes, whole or not at all (RFC 4180, UTF-8).

    Numbers are written so that reading gives the same double; what is missing is empty.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*axes, *COLUMNS])
    writer.writerows(table)
    return write_text(path, text.getvalue())


# ---- JSON ----


def quantity_json(q: Quantity) -> dict[str, Any]:
    """Quantity as plain JSON values; complex numbers as [re, im], no value as null."""
    parts = np.stack([q.value.real, q.value.imag], axis=-1) if np.iscomplexobj(q.value) else q.value
    return {
        "name": q.name,
        "model": q.model,
        "value": plain(parts),
        "unit": q.unit,
        "uncertainty": plain(q.error),
        "uncertainty_method": q.method,
        "seconds": q.seconds,
        **({} if q.frequency is None else {"frequency": list(q.frequency)}),
        **({} if q.classes is None else {"classes": list(q.classes)}),
    }


def quantity_from_json(entry: Mapping[str, Any]) -> Quantity:
    """Quantity that :func:`quantity_json` wrote; null is nan."""
    value, error = (np.array(entry[name], dtype=float) for name in ("value", "uncertainty"))
    if value.ndim == error.ndim + 1:
        value = value[..., 0] + 1j * value[..., 1]
    frequency, classes = entry.get("frequency"), entry.get("classes")
    return Quantity(
        name=entry["name"], model=entry["model"], unit=entry["unit"], value=value, error=error,
        method=entry["uncertainty_method"], seconds=entry["seconds"],
        frequency=None if frequency is None else tuple(frequency),
        classes=None if classes is None else tuple(classes),
    )  # fmt: skip


def answer_json(answer: Answer) -> dict[str, Any]:
    """Answer as plain JSON values."""
    return {
        "status": answer.status, "reason": answer.reason, "seconds": answer.seconds,
        "quantities": [quantity_json(q) for q in answer.quantities],
        "warnings": list(answer.warnings),
    }  # fmt: skip


def plain(value: Any) -> Any:
    """Dataclasses as dicts, arrays as lists, and None for numbers that are not finite."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            value = np.where(np.isfinite(value), value.astype(object), np.array(None))
        return value.tolist()
    if isinstance(value, np.generic):
        return plain(value.item())
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


# ---- screen ----


def format_value(value: Any, unit: str) -> str:
    """Real number with its unit, or magnitude and phase of a complex one."""
    if np.iscomplexobj(value):
        phase = math.degrees(math.atan2(value.imag, value.real))
        return f"{engineering(abs(value), unit, _DIGITS)} ∠ {phase:.2f}°"
    return "no value" if math.isnan(value) else engineering(float(value), unit, _DIGITS)


def format_error(value: Any, error: float, unit: str) -> str:
    """Error as a share of its value, in the value's unit where that is zero."""
    size = float(abs(value))
    if math.isnan(error) or math.isnan(size):
        return "-"
    return share(error / size) if size > 0.0 else engineering(error, unit, 2)


def screen_lines(quantities: Iterable[Quantity]) -> Iterator[str]:
    """Yield the table for people, a line a number; responses are thinned out."""
    yield f"{'quantity':26} {'model':12} {'at':>10}  {'value':>28}  {'+/-':>9}"
    for q in quantities:
        for label, value, error in _screen_cells(q):
            yield f"{q.name:26} {q.model:12} {label:>10}  {value:>28}  {error:>9}"


def _screen_cells(q: Quantity) -> Iterator[tuple[str, str, str]]:
    if q.value.ndim > 1:
        yield "", f"5x5 at {len(q.frequency or ())} frequencies: --json", ""
        return
    labels = [""]
    if q.value.ndim == 1:
        classes = [c.replace("bending_", "bend ") for c in q.classes or ()]
        labels = classes or [engineering(f, "Hz") for f in q.frequency or ()]
    values, errors = np.atleast_1d(q.value), np.atleast_1d(q.error)
    shown = min(len(labels), _FREQUENCIES)
    for i in np.unique(np.linspace(0, len(labels) - 1, shown).astype(int)):
        error = format_error(values[i], float(errors[i]), q.unit)
        yield labels[i], format_value(values[i], q.unit), error


@dataclass(frozen=True)
class Representative:
    """The one number (SI) that stands for a quantity, with its error."""

    value: float
    error: float
    unit: str
    #: ``first`` mode, ``size of the first`` pole, ``largest`` magnitude of a response, or nothing
    #: of a single number
    what: str
    at: float | None = None  #: Frequency (Hz) of the largest

    @property
    def text(self) -> str:
        """As people read it."""
        if np.isnan(self.value):
            return "no value"
        where = f" at {self.at:g} Hz" if self.at is not None else ""
        if np.isnan(self.error):
            return engineering(self.value, self.unit) + where
        return with_error(self.value, self.error, self.unit) + where


def representative(q: Quantity) -> Representative:
    """Number itself, of modes and poles the first, of a response the largest magnitude.

    Of what is complex it is the magnitude: a pole's is its natural angular frequency.
    Of one frequency it is the magnitude there, of a matrix its largest entry, without an error.
    """
    errors = np.broadcast_to(q.error, q.value.shape)
    if q.frequency is None:
        place: Any = (0,) * q.value.ndim
        what, value = "first" if q.value.ndim else "", q.value[place]
        if np.iscomplexobj(value):
            what, value = "size of the first", np.abs(value)
        return Representative(float(value), float(errors[place]), q.unit, what)
    size = np.abs(q.value)
    if not np.isfinite(size).any():
        return Representative(np.nan, np.nan, q.unit, "largest")
    place = np.unravel_index(int(np.nanargmax(size)), size.shape)
    several, matrix = len(q.frequency) > 1, q.value.ndim > 1
    return Representative(
        float(size[place]), np.nan if matrix else float(errors[place]), q.unit,
        "largest entry" if matrix else "largest" if several else "",
        q.frequency[int(place[0])] if several else None,
    )  # fmt: skip


# ---- arrays over the axes of a study, and netCDF ----


class Variable(NamedTuple):
    """An array with the names of its dimensions, its unit and its meaning."""

    dimensions: tuple[str, ...]
    values: Array
    unit: str
    meaning: str


@dataclass(frozen=True)
class Dataset:
    """Answers as arrays; quantities are over model, the axes' dimensions and their own."""

    #: Values of the axes, models, and what the quantities are over besides
    coordinates: dict[str, Variable]
    #: Quantities (complex ones in one array) by name, their errors as ``NAME_uncertainty``; nan
    #: where there is no answer.  And `status` (places in :data:`STATUSES`), `reason`, `seconds`
    variables: dict[str, Variable]


def dataset(
    axes: Mapping[str, Variable],
    shape: Mapping[str, int],
    quantities: Sequence[str],
    answers: Sequence[Mapping[str, Answer]],
) -> Dataset:
    """Answers as arrays.

    Parameters
    ----------
    axes : dict of str to Variable
        Coordinates by scene key.
    shape : dict of str to int
        Dimensions of the points with their sizes.
    quantities : sequence of str
        Names.
    answers : sequence of dict
        By model, one for each point (in C order over `shape`).
    """
    models = list(answers[0])
    over, sizes = ("model", *shape), (len(models), *shape.values())
    coordinates = {**axes, "model": Variable(("model",), np.array(models), "", "model")}
    variables: dict[str, Variable] = {}
    for name in quantities:
        found = [[answer[m].get(name) for answer in answers] for m in models]
        known = [q for each in found for q in each if q is not None]
        if not known:
            continue
        value, error = _filled(found, known)
        names = _inner_dimensions(known[0])
        if names[:1] == ("frequency",) and "frequency" in axes:
            value, error, names = value[:, :, 0], error[:, :, 0], names[1:]
        inner = value.shape[2:]
        _add_coordinates(names, inner, known[0], coordinates)
        row, dimensions = QUANTITIES[name], (*over, *names)
        variables[name] = Variable(dimensions, value.reshape(*sizes, *inner), row.unit, row.meaning)
        variables[f"{name}_uncertainty"] = Variable(
            dimensions, error.reshape(*sizes, *inner), row.unit,
            f"numerical error bar of {name}, absolute, of the magnitude",
        )  # fmt: skip

    def each(of: Callable[[Answer], Any], kind: Any, unit: str, meaning: str) -> Variable:
        values = [[of(answer[m]) for answer in answers] for m in models]
        return Variable(over, np.array(values, dtype=kind).reshape(sizes), unit, meaning)

    variables |= {
        "status": each(lambda a: STATUSES.index(a.status), np.int8, "", "whether answered"),
        "reason": each(lambda a: a.reason, np.str_, "", "why there is no answer"),
        "seconds": each(lambda a: a.seconds, float, "s", "cost of the answer when it was computed"),
    }  # fmt: skip
    return Dataset(coordinates, variables)


def _filled(found: list[list[Quantity | None]], known: list[Quantity]) -> tuple[Array, Array]:
    """Values and errors over model and point, nan where there are none."""
    inner = tuple(max(sizes) for sizes in zip(*(q.value.shape for q in known), strict=True))
    kind = np.result_type(*(q.value for q in known))
    value = np.full((len(found), len(found[0]), *inner), np.nan, kind)
    error = np.full(value.shape, np.nan)
    for m, n in np.ndindex(value.shape[:2]):
        q = found[m][n]
        if q is not None:
            place: Any = (m, n, *(slice(size) for size in q.value.shape))
            value[place], error[place] = q.value, q.error
    return value, error


def _inner_dimensions(first: Quantity) -> tuple[str, ...]:
    """Dimensions of a quantity itself."""
    if first.frequency is None:
        return ("mode",) if first.value.ndim else ()
    return ("frequency", "effort", "motion")[: first.value.ndim]


def _add_coordinates(
    names: tuple[str, ...], sizes: tuple[int, ...], first: Quantity, to: dict[str, Variable]
) -> None:
    """Add the coordinates that a quantity is over besides the axes."""
    of_matrix = "place in the matrix over the ports, from 1"
    meanings = {"mode": "number of the mode, from 1", "effort": of_matrix, "motion": of_matrix}
    for name, size in zip(names, sizes, strict=True):
        if name == "frequency":
            values = np.array(first.frequency)
            to[name] = Variable((name,), values, "Hz", "frequency of the drive")
        elif name not in to or to[name].values.size < size:
            to[name] = Variable((name,), np.arange(1, size + 1), "", meanings[name])


def write_netcdf(path: Path, found: Dataset, attributes: Mapping[str, str]) -> Path:
    """Write arrays with units, errors and provenance as netCDF 3, whole or not at all.

    Raises InputError if the file cannot be written.
    """
    from scipy.io import netcdf_file  # slow to import

    with written_whole(path) as temporary, netcdf_file(str(temporary), "w", version=2) as file:
        for name, text in attributes.items():
            setattr(file, name, text.encode())
        dimensions: dict[str, int] = {}
        for variable in (*found.coordinates.values(), *found.variables.values()):
            dimensions.update(zip(variable.dimensions, variable.values.shape, strict=True))
        for name, size in dimensions.items():
            file.createDimension(name, size)
        for name, variable in found.coordinates.items():
            _add_variable(file, name, variable)
        auxiliary = " ".join(key for key, v in found.coordinates.items() if (key,) != v.dimensions)
        for name, variable in _real_parts(found.variables):
            made = _add_variable(file, name, variable)
            if auxiliary:
                made.coordinates = auxiliary.encode()
    return path


def _real_parts(variables: Mapping[str, Variable]) -> Iterator[tuple[str, Variable]]:
    """Yield the variables with real and imaginary parts apart: netCDF knows no complex numbers."""
    for name, v in variables.items():
        if np.iscomplexobj(v.values):
            yield f"{name}_re", v._replace(values=v.values.real, meaning=f"real part: {v.meaning}")
            imaginary = f"imaginary part: {v.meaning}"
            yield f"{name}_im", v._replace(values=v.values.imag, meaning=imaginary)
        else:
            yield name, v


def _add_variable(file: Any, name: str, variable: Variable) -> Any:
    """Add a variable to an open file; texts as arrays of characters."""
    dimensions, values, unit, meaning = variable
    if values.dtype.kind == "U":
        encoded = np.char.encode(values, "utf-8")
        length = max(1, encoded.dtype.itemsize)
        file.createDimension(f"{name}_length", length)
        made = file.createVariable(name, "S1", (*dimensions, f"{name}_length"))
        values, made._Encoding = encoded.astype(f"S{length}")[..., None].view("S1"), b"utf-8"
    else:
        kind = "i1" if values.dtype == np.int8 else {"f": "f8", "i": "i4"}[values.dtype.kind]
        made = file.createVariable(name, kind, dimensions)
    made[:] = values
    made.long_name = meaning.encode()
    if unit:
        made.units = unit.encode()
    if name == "status":
        made.flag_values = np.arange(len(STATUSES), dtype=np.int8)
        made.flag_meanings = " ".join(STATUSES).encode()
    return made
