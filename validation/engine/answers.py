"""Table of answers: one row a number, written for screen, JSON, CSV and netCDF.

Numbers are in SI units; complex ones are peak amplitudes, apart in real and imaginary part.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.files import write_text, written_whole
from tactgen.geometry.formats import engineering, share, two_digits, with_share
from tactgen.geometry.store.values import storable
from tactgen.geometry.units import AMPLITUDES
from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.models.model import Extreme, Modelling, Quantity

if TYPE_CHECKING:
    from xarray import Dataset

Array = NDArray[Any]

#: Statuses by their number in a netCDF file.
STATUSES = ("ok", "failed", "refused")
#: Frequencies of a response on the screen, at most.
_FREQUENCIES = 12
#: Relative modelling error that is rounding.
_NOTHING = 1e-9
#: Said of the modelling error of the most detailed model, and where it is not known.
NONE, NOT_KNOWN = "none", "not known"
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
#: a mode, or the place in a matrix over the ports row by row, from 1; `class` that of the mode's
#: motion.  Numbers are None where there is no answer.
COLUMNS = (
    "quantity", "model", "frequency", "index", "class", "value", "value_im", "uncertainty",
    "modelling_error", "unit", "status", "reason",
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
            none = (None,) * 7
            yield name, model, *none, QUANTITIES[name].unit, answer.status, answer.reason


def quantity_rows(q: Quantity, status: str = "ok", reason: str = "") -> Iterator[Row]:
    """Yield every number of a quantity."""
    errors, imaginary = np.broadcast_to(q.error, q.value.shape), np.iscomplexobj(q.value)
    modelling = np.broadcast_to(q.modelling_error, q.value.shape)
    for place in itertools.product(*map(range, q.value.shape)):
        value, (frequency, index) = q.value[place], _labels(q, place)
        kind = q.classes[place[0]] if q.classes else None
        parts = (
            float(value.real), float(value.imag) if imaginary else None, float(errors[place]),
            float(modelling[place]) if np.isfinite(modelling[place]) else None,
        )  # fmt: skip
        yield q.name, q.model, frequency, index, kind, *parts, q.unit, status, reason


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


def stated_as(q: Quantity, way: str) -> Quantity:
    """Quantity with its amplitudes peak to peak (``pp``) or ``rms``, which its unit then names."""
    if way == "peak" or not QUANTITIES[q.name].is_amplitude:
        return q
    factor = 1.0 / AMPLITUDES[way]
    modelling, extreme = q.modelling, q.extreme
    if modelling is not None:
        expected, error = factor * modelling.expected, factor * modelling.error
        modelling = replace(modelling, expected=expected, error=error)
    if extreme is not None:
        sizes = {f.name: factor * getattr(extreme, f.name) for f in fields(extreme)}
        extreme = replace(extreme, **sizes | {"frequency": extreme.frequency})
    return replace(
        q, value=factor * q.value, error=factor * q.error, unit=f"{q.unit} {way}",
        modelling=modelling, extreme=extreme,
    )  # fmt: skip


# ---- JSON ----


def quantity_json(q: Quantity) -> dict[str, Any]:
    """Quantity as plain JSON values; complex numbers as [re, im], no value as null."""
    return {
        "name": q.name,
        "model": q.model,
        "value": _real_parts(q.value),
        "unit": q.unit,
        "uncertainty": plain(q.error),
        "uncertainty_method": q.method,
        "modelling_error": plain(q.modelling_error),
        "modelling": _modelling_json(q),
        "seconds": q.seconds,
        **({} if q.frequency is None else {"frequency": list(q.frequency)}),
        **({} if q.classes is None else {"classes": list(q.classes)}),
        **({} if q.extreme is None else {"extreme": plain(q.extreme)}),
    }


def _modelling_json(q: Quantity) -> dict[str, Any] | None:
    """Value that the most detailed model is expected to give, its error and their origin."""
    if q.modelling is None:
        return None
    return {
        "expected": _real_parts(np.asarray(q.modelling.expected)),
        "error": plain(np.asarray(q.modelling.error)),
        "method": q.modelling.method,
    }


def _real_parts(value: Array) -> Any:
    """Plain list of numbers; of complex ones [re, im]."""
    return plain(np.stack([value.real, value.imag], -1) if np.iscomplexobj(value) else value)


def _numbers(value: Any, error: Any) -> tuple[Array, Array]:
    """Values that :func:`_real_parts` wrote and their errors, which are real."""
    found, bar = np.array(value, dtype=float), np.array(error, dtype=float)
    return (found[..., 0] + 1j * found[..., 1] if found.ndim == bar.ndim + 1 else found), bar


def quantity_from_json(entry: Mapping[str, Any]) -> Quantity:
    """Quantity that :func:`quantity_json` wrote; null is nan."""
    value, error = _numbers(entry["value"], entry["uncertainty"])
    frequency, classes = entry.get("frequency"), entry.get("classes")
    extreme, beside = entry.get("extreme"), entry.get("modelling")
    sizes = {name: np.nan if size is None else size for name, size in (extreme or {}).items()}
    return Quantity(
        name=entry["name"], model=entry["model"], unit=entry["unit"], value=value, error=error,
        method=entry["uncertainty_method"], seconds=entry["seconds"],
        frequency=None if frequency is None else tuple(frequency),
        classes=None if classes is None else tuple(classes),
        extreme=None if extreme is None else Extreme(**sizes),
        modelling=beside and Modelling(
            *_numbers(beside["expected"], beside["error"]), beside["method"]
        ),
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
    yield f"{'':26} {'':12} {'':10}  {'':28}  {'numerical':>9}  {'modelling':>16}"
    yield f"{'quantity':26} {'model':12} {'at':>10}  {'value':>28}  {'error':>9}  {'error':>16}"
    for q in quantities:
        for label, value, error, modelling in _screen_cells(q):
            yield f"{q.name:26} {q.model:12} {label:>10}  {value:>28}  {error:>9}  {modelling:>16}"


def format_modelling(value: Any, expected: Any, error: float) -> str:
    """Known relative difference from the most detailed model, and its own error.

    Of complex numbers the largest relative difference that is possible.
    """
    size = float(abs(expected))
    if not (np.isfinite(size) and np.isfinite(error)) or not size:
        return NONE if value == expected and error == 0.0 else NOT_KNOWN
    if abs(value - expected) + error < _NOTHING * size:
        return NONE
    if np.iscomplexobj(value) or np.iscomplexobj(expected):
        return f"± {share((abs(value - expected) + error) / size)}"
    percent = 100.0 * (float(value) / float(expected) - 1.0)
    return f"{'' if value == expected else f'{two_digits(percent):+g} '}± {share(error / size)}"


def _screen_cells(q: Quantity) -> Iterator[tuple[str, str, str, str]]:
    if q.value.ndim > 1:
        yield "", f"5x5 at {len(q.frequency or ())} frequencies: --json", "", ""
        return
    labels = [""]
    if q.value.ndim == 1:
        classes = [c.replace("bending_", "bend ") for c in q.classes or ()]
        labels = classes or [engineering(f, "Hz") for f in q.frequency or ()]
    values, errors = np.atleast_1d(q.value), np.atleast_1d(q.error)
    shown = len(labels) if q.classes else min(len(labels), _FREQUENCIES)
    for i in np.unique(np.linspace(0, len(labels) - 1, shown).astype(int)):
        error = format_error(values[i], float(errors[i]), q.unit)
        yield labels[i], format_value(values[i], q.unit), error, modelling_at(q, i)
    if q.extreme is not None:
        peak = representative(q)
        at = engineering(q.extreme.frequency, "Hz")
        value = f"{engineering(peak.value, q.unit, _DIGITS)} at {at}"
        yield peak.what, value, format_error(peak.value, peak.error, q.unit), peak.modelling


def modelling_at(q: Quantity, place: Any) -> str:
    """Modelling error of one value of a quantity as people read it."""
    if q.modelling is None:
        return NONE if MODELS[q.model].detailed else NOT_KNOWN
    values = (q.value, q.modelling.expected, q.modelling.error)
    value, expected, error = (np.asarray(one)[place if np.ndim(one) else ()] for one in values)
    return format_modelling(value, expected, float(error))


def bracketed(modelling: str) -> str:
    """Modelling error behind a value: nothing of the most detailed model's, ? if not known."""
    return {NONE: "", NOT_KNOWN: " (?)"}.get(modelling, f" ({modelling})")


#: Classes of motion that go without saying.
_USUAL = ("bending_x", "decays")


def class_suffix(q: Quantity, at: int) -> str:
    """Class of one of a list of modes after a space, nothing if it goes without saying."""
    if not q.classes or q.classes[at] in _USUAL:
        return ""
    return f" {q.classes[at].replace('bending_', '')}"


@dataclass(frozen=True)
class Representative:
    """The one number (SI) that stands for a quantity, with its error."""

    value: float
    error: float
    unit: str
    #: ``first`` mode, ``size of the first`` pole, ``largest`` magnitude of a response, ``least`` of
    #: a limit, or nothing of a single number
    what: str
    at: float | None = None  #: Frequency (Hz) of the largest or least
    suffix: str = ""  #: The mode's class as of :func:`class_suffix`
    modelling: str = NOT_KNOWN  #: Modelling error as of :func:`format_modelling`

    @property
    def text(self) -> str:
        """As people read it."""
        where = f" at {engineering(self.at, 'Hz', 4)}" if self.at is not None else ""
        value = with_share(self.value, self.error, self.unit) + self.suffix
        return f"{value}{bracketed(self.modelling)}{where}"


def representative(q: Quantity) -> Representative:
    """Number itself, of modes and poles the first, of a response its extreme.

    That is the largest magnitude, of a limit the least, over the band of a sweep.
    Of what is complex it is the magnitude: a pole's is its natural angular frequency.
    Of one frequency it is the magnitude there, of a matrix its largest entry, without an error.
    """
    errors = np.broadcast_to(q.error, q.value.shape)
    if q.frequency is None:
        place: Any = (0,) * q.value.ndim
        what, value = "first" if q.value.ndim else "", q.value[place]
        if np.iscomplexobj(value):
            what, value = "size of the first", np.abs(value)
        suffix = class_suffix(q, 0)
        return Representative(
            float(value), float(errors[place]), q.unit, what, suffix=suffix,
            modelling=modelling_at(q, place),
        )  # fmt: skip
    what, size = "least" if QUANTITIES[q.name].is_limit else "largest", np.abs(q.value)
    if q.extreme is not None:
        found, other = q.extreme, QUANTITIES[q.name].peak_of
        what = f"at largest {QUANTITIES[other].label}" if other else what
        return Representative(
            found.value, found.error, q.unit, what, found.frequency,
            modelling=modelling_at(q.alone_at_extreme, ()),
        )  # fmt: skip
    if not np.isfinite(size).any():
        return Representative(np.nan, np.nan, q.unit, what)
    best = np.nanargmin if what == "least" else np.nanargmax
    place = np.unravel_index(int(best(size)), size.shape)
    several, matrix = len(q.frequency) > 1, q.value.ndim > 1
    return Representative(
        float(size[place]), np.nan if matrix else float(errors[place]), q.unit,
        "largest entry" if matrix else what if several else "",
        q.frequency[int(place[0])] if several else None,
        modelling=NOT_KNOWN if matrix else modelling_at(q, place),
    )  # fmt: skip


# ---- arrays over the axes of a study, and netCDF ----

#: An array with the names of its dimensions, its unit and its meaning.
Variable = tuple[tuple[str, ...], Array, dict[str, Any]]


def variable(dimensions: tuple[str, ...], values: Any, meaning: str, unit: str = "") -> Variable:
    """Array over named dimensions, as xarray takes it."""
    return (
        dimensions,
        np.asarray(values),
        {"long_name": meaning} | ({"units": unit} if unit else {}),
    )


def dataset(
    axes: Mapping[str, Variable],
    shape: Mapping[str, int],
    quantities: Sequence[str],
    answers: Sequence[Mapping[str, Answer]],
) -> Dataset:
    """Answers over model, the axes' dimensions and their own; nan where there is none.

    With errors as ``NAME_uncertainty``, `status` (places in :data:`STATUSES`), `reason`, `seconds`.

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
    from xarray import Dataset  # slow to import

    models = list(answers[0])
    over, sizes = ("model", *shape), (len(models), *shape.values())
    coordinates = {**axes, "model": variable(("model",), models, "model")}
    variables: dict[str, Variable] = {}
    for name in quantities:
        found = [[answer[m].get(name) for answer in answers] for m in models]
        known = [q for each in found for q in each if q is not None]
        if not known:
            continue
        value, error, modelling = _filled(found, known)
        names: tuple[str, ...] = ("mode",) if known[0].value.ndim else ()
        if known[0].frequency is not None:
            names = ("frequency", "effort", "motion")[: known[0].value.ndim]
            if "frequency" in axes:
                value, error, names = value[:, :, 0], error[:, :, 0], names[1:]
                modelling = modelling[:, :, 0]
        inner = value.shape[2:]
        for own, size in zip(names, inner, strict=True):
            if own == "frequency":
                values: Any = known[0].frequency
                coordinates[own] = variable((own,), values, "frequency of the drive", "Hz")
            elif own not in coordinates or coordinates[own][1].size < size:
                counted = "number, from 1, of the mode or of the row or column of the port matrix"
                coordinates[own] = variable((own,), np.arange(1, size + 1), counted)
        row, dimensions, of = QUANTITIES[name], (*over, *names), (*sizes, *inner)
        variables[name] = variable(dimensions, value.reshape(of), row.meaning, row.unit)
        bars = f"numerical error bar of {name}, absolute, of the magnitude"
        variables[f"{name}_uncertainty"] = variable(dimensions, error.reshape(of), bars, row.unit)
        beside = f"modelling error of {name}, absolute, beside the most detailed model"
        variables[f"{name}_modelling_error"] = variable(
            dimensions, modelling.reshape(of), beside, row.unit
        )
        if any(q.classes for q in known):
            kinds = _classes(found, value.shape).reshape(of)
            variables[f"{name}_class"] = variable(dimensions, kinds, "class of the mode's motion")

    def each(of: Callable[[Answer], Any], kind: Any, meaning: str, unit: str = "") -> Variable:
        values = [[of(answer[m]) for answer in answers] for m in models]
        return variable(over, np.array(values, dtype=kind).reshape(sizes), meaning, unit)

    variables |= {
        "status": each(lambda a: STATUSES.index(a.status), np.int8, "whether answered"),
        "reason": each(lambda a: a.reason, np.str_, "why there is no answer"),
        "seconds": each(lambda a: a.seconds, float, "cost of the answer when it was computed", "s"),
    }
    flags = {"flag_values": np.arange(len(STATUSES), dtype=np.int8)}
    variables["status"][2].update(flags, flag_meanings=" ".join(STATUSES))
    return Dataset(variables, coordinates)


def _filled(
    found: list[list[Quantity | None]], known: list[Quantity]
) -> tuple[Array, Array, Array]:
    """Values, errors and modelling errors over model and point, nan where there are none."""
    inner = tuple(max(sizes) for sizes in zip(*(q.value.shape for q in known), strict=True))
    kind = np.result_type(*(q.value for q in known))
    value = np.full((len(found), len(found[0]), *inner), np.nan, kind)
    error, modelling = np.full(value.shape, np.nan), np.full(value.shape, np.nan)
    for m, n in np.ndindex(value.shape[:2]):
        q = found[m][n]
        if q is not None:
            place: Any = (m, n, *(slice(size) for size in q.value.shape))
            value[place], error[place], modelling[place] = q.value, q.error, q.modelling_error
    return value, error, modelling


def _classes(found: list[list[Quantity | None]], shape: tuple[int, ...]) -> Array:
    """Class of each mode over model, point and mode; empty where there is none."""
    kinds = np.full(shape, "", dtype=object)
    for m, n in np.ndindex(shape[:2]):
        q = found[m][n]
        if q is not None and q.classes:
            kinds[m, n, : len(q.classes)] = q.classes
    return kinds.astype(np.str_)


def write_netcdf(path: Path, found: Dataset, attributes: Mapping[str, str]) -> Path:
    """Write arrays with units, errors and provenance as netCDF 3, whole or not at all.

    Real and imaginary parts apart: netCDF knows no complex numbers.

    Raises InputError if the file cannot be written.
    """
    for name, values in found.data_vars.items():
        if np.iscomplexobj(values):
            parts = {f"{name}_re": values.real, f"{name}_im": values.imag}
            found = found.drop_vars([name]).assign(
                {part: of.assign_attrs(values.attrs) for part, of in parts.items()}
            )
    with written_whole(path) as temporary:
        found.assign_attrs(attributes).to_netcdf(temporary, engine="scipy")
    return path
