"""Parameters of a fit: ``--fit NAME[=START][:LOW..HIGH]``, and what came of each.

Values are read by the scene's own units.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, TypeAdapter, ValidationError

from tactgen.geometry.errors import InputError
from tactgen.geometry.names import nearest
from tactgen.geometry.units import Unit, quoted
from tactgen.tmm.beam.parametric import check_length_free
from tactgen.validation.scene.files import one_line
from tactgen.validation.scene.nearby import SYMBOLS, value_of
from tactgen.validation.scene.scene import Scene, scene_keys

#: Bounds where none are given: this factor below and above the start.
_REACH = 100.0
_REMEDY = (
    "write for example --fit c_s=0.2N*m/rad:0.05..2N*m/rad, --fit c_s:0.05..2N*m/rad or --fit c_s"
)
_LEADING_NUMBER = re.compile(r"[+-]?[\d.]+(?:e[+-]?\d+)?", re.IGNORECASE | re.ASCII)


@dataclass(frozen=True)
class FitParameter:
    """One number of a scene that is fitted, SI units.

    `start`, `low` and `high` have one sign and none is 0, for the fit runs over the
    logarithm of the magnitude; ``|low| < |high|``.
    """

    key: str
    unit: Unit
    start: float
    low: float
    high: float

    @property
    def symbol(self) -> str:
        """The paper's symbol, or the key."""
        return next((s for s, key in SYMBOLS.items() if key == self.key), self.key)


@dataclass(frozen=True)
class FittedParameter:
    """One fitted parameter, SI units.

    `interval` is the 95 % confidence interval; `opened` names the ends of it (``low``, ``high``)
    that are only bounds of the search, `edge` the bound that the value itself is at.
    """

    parameter: FitParameter
    value: float
    interval: tuple[float, float]
    opened: tuple[str, ...]
    edge: str

    @property
    def half_width(self) -> float:
        """Half width of the interval of ln(value)."""
        return abs(float(np.log(self.interval[1] / self.interval[0]))) / 2.0


def fit_parameter(scene: Scene, text: str) -> FitParameter:
    """Read ``NAME[=START][:LOW..HIGH]``; NAME is a scene key or a symbol of the paper.

    The start is the scene's value unless given, the bounds a factor 100 either side of it.  A LOW
    without a unit has that of HIGH.

    Raises InputError if the name, a value or its unit cannot be used.
    """
    head, colon, bounds = text.partition(":")
    name, equals, start_text = (part.strip() for part in head.partition("="))
    low_text, dots, high_text = (part.strip() for part in bounds.partition(".."))
    if not name or (equals and not start_text) or (colon and not (low_text and high_text and dots)):
        raise InputError(
            f"--fit {quoted(text)} is not of the form NAME[=START][:LOW..HIGH]; {_REMEDY}"
        )
    key = SYMBOLS.get(name, name)
    unit = _unit(scene, key, name)
    if key == "bimorph.length":
        check_length_free(scene.bimorph)
    start = _read(key, start_text, unit) if equals else float(value_of(scene, key))
    if start == 0.0:
        raise InputError(
            f"{key} = {unit.show(0.0)} cannot be where a fit starts; give a value that is not 0, "
            f'for example --fit "{name}={unit.example}"'
        )
    if colon:
        if _LEADING_NUMBER.fullmatch(low_text):
            low_text += _LEADING_NUMBER.sub("", high_text, count=1)
        low, high = sorted((_read(key, end, unit) for end in (low_text, high_text)), key=abs)
    else:
        least, most = unit.limits or (0.0, math.inf)
        low, high = (
            math.copysign(min(max(abs(end), least), most), start)
            for end in (start / _REACH, start * _REACH)
        )
    if low * start <= 0.0 or not abs(low) <= abs(start) <= abs(high) or abs(low) == abs(high):
        raise InputError(
            f"--fit {quoted(text)} starts {key} at {unit.show(start)}, outside its bounds "
            f"{unit.show(low)} to {unit.show(high)}; give LOW and HIGH of one sign, not 0, with "
            "the start between them"
        )
    return FitParameter(key, unit, start, low, high)


def _read(key: str, text: str, unit: Unit) -> float:
    """SI value as the scene would read it."""
    reader: TypeAdapter[float] = TypeAdapter(Annotated[float, BeforeValidator(unit)])
    try:
        return reader.validate_python(text, context={"units_required": True})
    except ValidationError as error:
        reason = error.errors()[0]["ctx"]["error"]
        raise InputError(one_line(f"--fit: {key} = {quoted(text)} {reason}")) from None


def _unit(scene: Scene, key: str, name: str) -> Unit:
    if key not in scene_keys():
        raise InputError(
            f"--fit {quoted(name)} is not a scene key{nearest(name, (*SYMBOLS, *scene_keys()))}; "
            f"use {', '.join(SYMBOLS)} or a key that tactgen init FILE.toml writes"
        )
    group, _, last = key.rpartition(".")
    holder: Any = value_of(scene, group) if group else scene
    metadata = type(holder).model_fields[last].metadata
    unit = next((m for m in metadata if isinstance(m, Unit)), None)
    if unit is None or getattr(holder, last) is None:
        raise InputError(
            f"--fit {key} is not a number that can be fitted; use for example {', '.join(SYMBOLS)}"
        )
    return unit
