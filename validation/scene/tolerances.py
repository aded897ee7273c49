"""The tolerances that a scene states with its numbers, taken apart from them.

A scene may write a number with its tolerance (:mod:`geometry.tolerances`).  What is solved
reads the number alone; the tolerance travels beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, get_args

from pydantic.fields import FieldInfo

from tactgen.geometry.device.declaration import Parameters
from tactgen.geometry.device.materials import Spread
from tactgen.geometry.errors import InputError
from tactgen.geometry.tolerances import has_tolerance, read_tolerance
from tactgen.geometry.units import Unit, quoted

#: What says how something is solved, not what is built or done.
_SETTINGS = ("accuracy", "mesh")


@dataclass(frozen=True)
class Tolerance:
    """What a scene states of one of its numbers, and the number of which it states it (SI)."""

    value: float
    spread: Spread
    words: str


def split_tolerances(
    model: type[Parameters], values: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Tolerance]]:
    """Scene's values without their tolerances, and these by dotted key.

    Parameters
    ----------
    model : type
        The scene's class, which says what each key is.
    values : dict
        As they are written; not changed.

    Raises InputError in one sentence, for a tolerance that cannot be read or says nothing.
    """
    stated: dict[str, Tolerance] = {}
    return _split(model, values, "", stated), stated


def _split(
    model: type[Parameters], values: dict[str, Any], prefix: str, stated: dict[str, Tolerance]
) -> dict[str, Any]:
    plain = dict(values)
    for name, value in values.items():
        info, key = model.model_fields.get(name), f"{prefix}{name}"
        if info is None:
            continue
        inner = info.annotation
        if isinstance(value, dict) and isinstance(inner, type) and issubclass(inner, Parameters):
            plain[name] = _split(inner, value, f"{key}.", stated)
        elif isinstance(value, str) and has_tolerance(value):
            unit = unit_of(info)
            if unit is None:
                continue  # no number: what reads it says what it is
            plain[name], stated[key] = _read(key, value, unit)
    return plain


def _read(key: str, text: str, unit: Unit) -> tuple[str, Tolerance]:
    if key.partition(".")[0] in _SETTINGS:
        raise InputError(
            f"{key} = {quoted(text)} has a tolerance, but says how the scene is solved; "
            "write the value alone"
        )
    try:
        found = read_tolerance(text, unit)
    except ValueError as error:
        raise InputError(f"{key} = {quoted(text)} {error}") from None
    spread = Spread(found.low, found.high, f"stated: {found.words.strip('()')}", not found.relative)
    return found.value, Tolerance(unit.parse(found.value), spread, found.words)


def unit_of(info: FieldInfo) -> Unit | None:
    """Unit of a field that is a number on a scale."""
    nested = [part for arg in get_args(info.annotation) for part in get_args(arg)]
    return next((part for part in (*info.metadata, *nested) if isinstance(part, Unit)), None)
