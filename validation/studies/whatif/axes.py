"""Axes of a study: which scene key takes which values, as a user writes them.

``KEY=START:STOP:N[:log]`` and ``KEY=a,b,c`` are steps; ``KEY=START:STOP[:log]``,
``KEY=normal(MEAN,DEVIATION)`` and ``KEY=lognormal(MEDIAN,SHARE)`` are drawn from.  Values are
checked here as a scene checks them.
"""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated, Any

import numpy as np
from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from tactgen.geometry import units as u
from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import Unit, WholeNumber, quoted
from tactgen.validation.scene.files import parse_frequencies, sentence
from tactgen.validation.scene.keys import check_key, declaration
from tactgen.validation.scene.tolerances import unit_of

#: Most values of one axis, and most points of one study.
MOST = 1_000_000
#: Keys that say what is asked, not what the device is.
_ASKED = {"name": "", "description": "", "models": "--model", "quantities": "--quantity"}
_EXAMPLE = "--vary bimorph.length=14mm:22mm:5"
_CALL = re.compile(r"([a-z]+)\s*\(([^()]*)\)")


@dataclass(frozen=True)
class SceneField:
    """Reader of the values of one scene key."""

    key: str  #: The scene key
    info: FieldInfo  #: Its declaration
    scale: Unit | None  #: Its unit, if it is a number on a scale

    @property
    def unit(self) -> str:
        """SI unit of its numbers, empty if there is none."""
        return self.scale.si if self.scale else ""

    @property
    def label(self) -> str:
        """Key and unit, as a column or an axis is headed."""
        return f"{self.key} ({self.unit})" if self.unit else self.key

    @property
    def whole(self) -> bool:
        """Whether its values are whole numbers."""
        return any(
            isinstance(part, WholeNumber)
            for validator in self.info.metadata
            for part in (validator, getattr(validator, "func", None))
        )

    @property
    def numeric(self) -> bool:
        """Whether its values are numbers."""
        return self.scale is not None or self.whole

    @property
    def separator(self) -> str:
        """What parts two of its values, one of which may hold commas."""
        return ";" if self.key.endswith("_profile") else ","

    def read(self, text: str, where: str = "") -> Any:
        """Value as SI number, whole number or choice.

        Raises InputError, which says `where` the text is from, if it cannot be one.
        """
        text, where = text.strip(), where or f"--vary {self.key}"
        try:
            if self.key == "frequency":
                return parse_frequencies([text])[0]
            if self.separator == ";":  # what it must fit, the length, is known at the point only
                return text
            found = self._adapter.validate_python(text, context={"units_required": True})
        except ValidationError as error:
            cause = error.errors()[0].get("ctx", {}).get("error")
            words = str(cause or sentence(error)).removeprefix(f" = {quoted(text)} ")
            raise InputError(f"{where}: {quoted(text)} {words}") from None
        except ValueError as error:
            raise InputError(f"{where}: {quoted(text)} {error}") from None
        return found if self.numeric else text

    def show(self, value: Any) -> str:
        """Value as people write it."""
        return self.scale.show(value) if self.scale and value is not None else str(value)

    @cached_property
    def _adapter(self) -> TypeAdapter[Any]:
        kind: Any = self.info.annotation
        for part in self.info.metadata:
            kind = Annotated[kind, part]
        return TypeAdapter(kind)


@cache
def scene_field(key: str) -> SceneField:
    """Field of a scene key that exists."""
    info = declaration(key)
    return SceneField(key, info, u.FREQUENCY if key == "frequency" else unit_of(info))


#: Digits of a value that was drawn, as people read it.
_DIGITS = 6


def shown_value(key: str, value: Any) -> str:
    """Value of an axis as people read it."""
    if isinstance(value, float):
        value = float(f"{value:.{_DIGITS}g}")
    return scene_field(key).show(value)


def shown_point(point: Mapping[str, Any]) -> str:
    """Values of all axes at a point as people read them."""
    return ", ".join(f"{key} = {shown_value(key, value)}" for key, value in point.items())


def as_stated(point: Mapping[str, Any]) -> dict[str, Any]:
    """Values of axes at a point as a scene takes them: numbers as SI, whatever asks for units."""
    found = {k: u.SI(v) if isinstance(v, float) else v for k, v in point.items()}
    return found | ({"frequency": [point["frequency"]]} if "frequency" in point else {})


@dataclass(frozen=True)
class Distribution:
    """Distribution of one number (SI): its ends, or its middle and deviation."""

    kind: str  #: ``uniform`` or ``loguniform`` between two ends, ``normal`` or ``lognormal``
    first: float
    second: float

    def at(self, share: float) -> float:
        """Value at a share from 0 to 1 of the way between two ends."""
        share = min(max(share, 0.0), 1.0)
        if share in (0.0, 1.0):  # to the last bit
            return self.second if share else self.first
        if self.kind == "loguniform":
            return float(self.first * (self.second / self.first) ** share)
        return float(self.first + share * (self.second - self.first))

    def share(self, value: float) -> float:
        """Share of the way at which a value lies, or the nearer end."""
        if self.kind == "loguniform":
            way = math.log(self.second / self.first)
            found = math.log(max(value, self.first) / self.first) / way
        else:
            found = (value - self.first) / (self.second - self.first)
        return min(max(found, 0.0), 1.0)

    def draw(self, count: int, seed: int, key: str) -> Floats:
        """`count` independent values.

        The first of more draws are those of fewer, and another axis changes nothing, so a study
        can grow.
        """
        random = np.random.default_rng([seed, zlib.crc32(key.encode())])
        match self.kind:
            case "normal":
                return np.asarray(random.normal(self.first, self.second, count))
            case "lognormal":
                return np.asarray(self.first * np.exp(random.normal(0.0, self.second, count)))
            case "loguniform":
                ends = np.log(self.first), np.log(self.second)
                return np.asarray(np.exp(random.uniform(*ends, count)))
            case _:
                return np.asarray(random.uniform(self.first, self.second, count))


@dataclass(frozen=True)
class Axis:
    """One scene key that takes several values."""

    key: str  #: The scene key
    text: str  #: What was written for it, to be written down again
    unit: str  #: SI unit of its numbers, empty for choices and pure numbers
    values: tuple[Any, ...]  #: Numbers in SI units or choices; none if they are drawn
    drawn: Distribution | None = None  #: What its values are drawn from

    @property
    def numeric(self) -> bool:
        """Whether its values are numbers."""
        return self.drawn is not None or not isinstance(self.values[0], str)


def parse_axes(texts: Sequence[str], *, sampled: bool) -> tuple[Axis, ...]:
    """Axes that ``--vary`` states, in order; if `sampled`, ranges without a count are drawn from.

    Raises InputError in one sentence, for anything that cannot be an axis.
    """
    if not texts:
        raise InputError(f"nothing is varied; write for example {_EXAMPLE}")
    axes = tuple(map(_axis, texts))
    keys = [axis.key for axis in axes]
    for axis in axes:
        if keys.count(axis.key) > 1:
            raise InputError(f"--vary {axis.key} is stated several times; join its values")
        if axis.drawn and not sampled:
            raise InputError(
                f"--vary {axis.key} = {quoted(axis.text)} does not say at how many values; add for "
                "example --sample 16, or to a range a number of values, as START:STOP:5"
            )
    if sampled and not any(axis.drawn for axis in axes):
        raise InputError(
            "--sample is given, but no axis can be drawn from; write for example "
            '--vary "gap=normal(200um,10um)"'
        )
    return axes


def _axis(text: str) -> Axis:
    key, _, stated = (part.strip() for part in text.partition("="))
    if not (key and stated):
        raise InputError(f"--vary {quoted(text)} is not KEY=VALUES; write for example {_EXAMPLE}")
    check_key(key)
    if key in _ASKED:
        instead = f"; use {_ASKED[key]}, which may be repeated" if _ASKED[key] else ""
        raise InputError(f"--vary {key} is not a property of the device{instead}; vary another key")
    field = scene_field(key)
    values: list[Any] = []
    drawn = None
    if call := _CALL.fullmatch(stated):
        drawn = _distribution(field, stated, *call.groups())
    elif field.numeric and ":" in stated:
        values, drawn = _range(field, stated)
    else:
        values = [field.read(part) for part in stated.split(field.separator)]
        if len(set(values)) < len(values):
            raise InputError(f"--vary {key} = {quoted(stated)} names a value twice; name each once")
    return Axis(key, stated, field.unit, tuple(values), drawn)


def _range(field: SceneField, text: str) -> tuple[list[Any], Distribution | None]:
    """Values of a range with their number, distribution of one without."""
    where = f"--vary {field.key} = {quoted(text)}"
    parts = [part.strip() for part in text.split(":")]
    logarithmic = parts[-1] == "log"
    ends, count = parts[:2], parts[2 : len(parts) - logarithmic]
    if len(count) > 1:
        raise InputError(f"{where} is not START:STOP:N or START:STOP:N:log; write for example "
                         f"{_EXAMPLE}")  # fmt: skip
    start, stop = map(field.read, ends)
    if not start < stop:
        raise InputError(f"{where} is empty or runs backwards; write the smaller value first, or "
                         "one value alone")  # fmt: skip
    if logarithmic and start <= 0.0:
        raise InputError(f"{where} cannot be spaced logarithmically; it must begin above 0")
    if not count:
        return [], Distribution("loguniform" if logarithmic else "uniform", start, stop)
    size = int(count[0]) if re.fullmatch(r"[0-9]{1,9}", count[0], re.ASCII) else 0
    if not 2 <= size <= MOST:
        raise InputError(f"{where} asks for {quoted(count[0])} values; give a whole number from 2 "
                         f"to {MOST}")  # fmt: skip
    spaced = np.geomspace if logarithmic else np.linspace
    # the ends are what was written; twelve digits between, so that a finer axis meets a coarser
    # one, and a list, in the same numbers
    values = [start, *(float(f"{value:.12g}") for value in spaced(start, stop, size)[1:-1]), stop]
    if field.whole:
        if any(abs(value - round(value)) > 1e-9 for value in values):
            raise InputError(f"{where} has values between whole numbers, but {field.key} is a "
                             "whole number; choose as many as there are in the range")  # fmt: skip
        values = [round(value) for value in values]
    return values, None


def _distribution(field: SceneField, text: str, name: str, arguments: str) -> Distribution:
    where = f"--vary {field.key} = {quoted(text)}"
    parts = [part.strip() for part in arguments.split(",")]
    if name not in ("normal", "lognormal") or len(parts) != 2:
        raise InputError(
            f"{where} is not a distribution; write normal(mean, standard "
            "deviation), lognormal(median, share) or a range START:STOP[:log]"
        )
    if field.scale is None:
        raise InputError(f"{where} cannot be sampled: {field.key} is not a number on a scale; "
                         "list its values, separated by commas")  # fmt: skip
    middle, relative = field.read(parts[0]), name == "lognormal"
    if relative and middle <= 0.0:
        raise InputError(f"{where} must begin above 0")
    try:
        if parts[1].endswith("%"):
            deviation = float(parts[1][:-1]) * 0.01 * (1.0 if relative else abs(middle))
        elif relative:
            raise ValueError("must be a share of the median, such as 5 %")
        else:
            deviation = field.scale.parse(parts[1])
        if not 0.0 < deviation < np.inf:
            raise ValueError("must be above 0; write for example 2%")
    except ValueError as error:
        raise InputError(f"{where}: the standard deviation {quoted(parts[1])} {error}") from None
    return Distribution(name, middle, deviation)
