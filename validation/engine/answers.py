"""Table of answers: one row a number, written for screen and JSON.

Numbers are in SI units; complex ones are peak amplitudes, apart in real and imaginary part.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.formats import engineering, share, two_digits, with_share
from tactgen.geometry.store.values import storable
from tactgen.geometry.units import AMPLITUDES
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.models.model import Extreme, Modelling, Quantity

Array = NDArray[Any]

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


def quantity_rows(q: Quantity) -> Iterator[Row]:
    """Yield every number of a quantity."""
    errors, imaginary = np.broadcast_to(q.error, q.value.shape), np.iscomplexobj(q.value)
    modelling = np.broadcast_to(q.modelling_error, q.value.shape)
    over = 0 if q.frequency is None else 1  # how many dimensions are of frequency
    for place in np.ndindex(q.value.shape):
        value, inner = q.value[place], place[over:]
        frequency = None if q.frequency is None else q.frequency[place[0]]
        index = int(np.ravel_multi_index(inner, q.value.shape[over:])) + 1 if inner else None
        kind = q.classes[place[0]] if q.classes else None
        parts = (
            float(value.real), float(value.imag) if imaginary else None, float(errors[place]),
            float(modelling[place]) if np.isfinite(modelling[place]) else None,
        )  # fmt: skip
        yield q.name, q.model, frequency, index, kind, *parts, q.unit, "ok", ""


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
        "modelling": q.modelling
        and {
            "expected": _real_parts(np.asarray(q.modelling.expected)),
            "error": plain(np.asarray(q.modelling.error)),
            "method": q.modelling.method,
        },
        "seconds": q.seconds,
        **({} if q.frequency is None else {"frequency": list(q.frequency)}),
        **({} if q.classes is None else {"classes": list(q.classes)}),
        **({} if q.extreme is None else {"extreme": plain(q.extreme)}),
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
    """Modelling error of one value of a quantity as people read it.

    The known relative difference from the most detailed model, and its own error; of complex
    numbers the largest relative difference that is possible.
    """
    if q.modelling is None:
        return NONE if MODELS[q.model].detailed else NOT_KNOWN
    values = (q.value, q.modelling.expected, q.modelling.error)
    value, expected, error = (np.asarray(one)[place if np.ndim(one) else ()] for one in values)
    size, error = float(abs(expected)), float(error)
    if not (np.isfinite(size) and np.isfinite(error)) or not size:
        return NONE if value == expected and error == 0.0 else NOT_KNOWN
    if abs(value - expected) + error < _NOTHING * size:
        return NONE
    if np.iscomplexobj(value) or np.iscomplexobj(expected):
        return f"± {share((abs(value - expected) + error) / size)}"
    percent = 100.0 * (float(value) / float(expected) - 1.0)
    return f"{'' if value == expected else f'{two_digits(percent):+g} '}± {share(error / size)}"


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
    modelling: str = NOT_KNOWN  #: Modelling error as of :func:`modelling_at`

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
