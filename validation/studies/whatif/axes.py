"""Axes of a study: which scene key takes which values, as a user writes them.

``KEY=START:STOP:N[:log]`` and ``KEY=a,b,c`` are steps; ``KEY=START:STOP`` and
``KEY=normal(MEAN,DEVIATION)`` are drawn from.  Values are checked here as a scene checks them.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.scene.scene import check_key
from tactgen.validation.studies.whatif.key_values import SceneField, scene_field

#: Distributions by name, with what their two numbers are.
DISTRIBUTIONS = {
    "normal": ("mean", "standard deviation"),
    "lognormal": ("median", "standard deviation of its logarithm"),
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
}


@dataclass(frozen=True)
class Distribution:
    """A distribution of one number (SI units); `first` and `second` as in DISTRIBUTIONS."""

    kind: str
    first: float
    second: float

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


#: Most values of one axis, and most points of one study.
MOST = 1_000_000
#: Keys that say what is asked, not what the device is.
_ASKED = {"name": "", "description": "", "models": "--model", "quantities": "--quantity"}
_EXAMPLE = "--vary bimorph.length=14mm:22mm:5"
_CALL = re.compile(r"\s*([a-z]+)\s*\(([^()]*)\)\s*")


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

    @property
    def label(self) -> str:
        """Key and unit, as a column or an axis is headed."""
        return f"{self.key} ({self.unit})" if self.unit else self.key


def parse_axes(texts: Sequence[str], *, sampled: bool) -> tuple[Axis, ...]:
    """Axes that ``--vary`` states, in order.

    Parameters
    ----------
    sampled : bool
        Whether a number of samples is stated, so that ranges without a count mean something.

    Raises InputError in one sentence, for anything that cannot be an axis.
    """
    if not texts:
        raise InputError(f"nothing is varied; write for example {_EXAMPLE}")
    axes = tuple(_axis(text, sampled=sampled) for text in texts)
    keys = [axis.key for axis in axes]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"--vary {key} is stated {keys.count(key)} times; join its values")
    if sampled and not any(axis.drawn for axis in axes):
        raise InputError(
            "--sample is given, but no axis can be drawn from; write for example "
            '--vary "gap=normal(200um,10um)"'
        )
    return axes


def _axis(text: str, *, sampled: bool) -> Axis:
    key, equals, stated = (part.strip() for part in text.partition("="))
    if not (key and equals and stated):
        raise InputError(f"--vary {quoted(text)} is not KEY=VALUES; write for example {_EXAMPLE}")
    check_key(key)
    if key in _ASKED:
        instead = f"; use {_ASKED[key]}, which may be repeated" if _ASKED[key] else ""
        raise InputError(f"--vary {key} is no property of the device{instead}; vary another key")
    field = scene_field(key)
    call = _CALL.fullmatch(stated)
    if call:
        return _distributed(field, stated, call[1], call[2], sampled=sampled)
    if field.numeric and ":" in stated:
        return _range(field, stated, sampled=sampled)
    parts = stated.split(";" if field.has_commas else ",")
    values = [_value(field, part) for part in parts]
    for value in values:
        if values.count(value) > 1:
            raise InputError(f"--vary {key} = {quoted(stated)} names {field.show(value)} twice; "
                             "name each value once")  # fmt: skip
    return Axis(key, stated, field.unit, tuple(values))


def _value(field: SceneField, text: str) -> Any:
    try:
        return field.read(text.strip())
    except ValueError as error:
        raise InputError(f"--vary {field.key}: {quoted(text.strip())} {error}") from None


def _range(field: SceneField, text: str, *, sampled: bool) -> Axis:
    where = f"--vary {field.key} = {quoted(text)}"
    parts = [part.strip() for part in text.split(":")]
    logarithmic = parts[-1] in ("log", "lin") and parts.pop() == "log"
    if len(parts) not in (2, 3):
        raise InputError(f"{where} is not START:STOP:N or START:STOP:N:log; write for example "
                         f"{_EXAMPLE}")  # fmt: skip
    start, stop = _value(field, parts[0]), _value(field, parts[1])
    if not start < stop:
        what = "is empty" if start == stop else "runs backwards"
        raise InputError(f"{where} {what}: it must begin below where it ends; write the smaller "
                         "value first, or one value alone")  # fmt: skip
    if logarithmic and start <= 0.0:
        raise InputError(f"{where} cannot be spaced logarithmically from {field.show(start)}; "
                         "begin above 0")  # fmt: skip
    if len(parts) == 2:
        if not sampled:
            raise InputError(f"{where} does not say at how many values; write "
                             f"{field.key}={parts[0]}:{parts[1]}:5, or add --sample N")  # fmt: skip
        kind: Literal["uniform", "loguniform"] = "loguniform" if logarithmic else "uniform"
        return Axis(field.key, text, field.unit, (), Distribution(kind, start, stop))
    count = int(parts[2]) if re.fullmatch(r"[0-9]{1,9}", parts[2], re.ASCII) else 0
    if not 2 <= count <= MOST:
        raise InputError(f"{where} asks for {quoted(parts[2])} values; give a whole number from 2 "
                         f"to {MOST}")  # fmt: skip
    spaced = np.geomspace if logarithmic else np.linspace
    # the ends are what was written; twelve digits between, so that a finer axis meets a coarser
    # one, and a list, in the same numbers
    values = [float(f"{value:.12g}") for value in spaced(start, stop, count)]
    return Axis(field.key, text, field.unit,
                tuple(field.checked(v, where) for v in (start, *values[1:-1], stop)))  # fmt: skip


def _distributed(field: SceneField, text: str, name: str, arguments: str, *, sampled: bool) -> Axis:
    where = f"--vary {field.key} = {quoted(text)}"
    known = ", ".join(f"{kind}({', '.join(names)})" for kind, names in DISTRIBUTIONS.items())
    parts = [part.strip() for part in arguments.split(",")]
    if name not in DISTRIBUTIONS or len(parts) != 2:
        raise InputError(f"{where} is no distribution; known are {known}")
    if not field.numeric or field.whole:
        raise InputError(f"{where} cannot be drawn: {field.key} is not a number on a scale; name "
                         "its values, parted by commas")  # fmt: skip
    if not sampled:
        raise InputError(f"{where} does not say how many are drawn; add for example --sample 16")
    first = _value(field, parts[0])
    if name in ("uniform", "loguniform"):
        second = _value(field, parts[1])
    else:
        second = _deviation(field, parts[1], first, relative=name == "lognormal")
    if name in ("uniform", "loguniform") and not first < second:
        raise InputError(f"{where} is empty or runs backwards; write the smaller value first")
    if name in ("lognormal", "loguniform") and first <= 0.0:
        raise InputError(f"{where} must begin above 0")
    return Axis(field.key, text, field.unit, (), Distribution(name, first, second))


def _deviation(field: SceneField, text: str, mean: float, *, relative: bool) -> float:
    """Standard deviation: in the key's unit, or as a share such as ``5 %``."""
    where = f"--vary {field.key}: the standard deviation {quoted(text)}"
    share = re.fullmatch(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e-?[0-9]+)?)\s*(%?)", text)
    try:
        if share and (share[2] or relative or not field.unit):
            number = float(share[1]) * (0.01 if share[2] else 1.0)
            found = number if relative else number * abs(mean) if share[2] else number
        elif relative:
            raise ValueError("must be a share of the median, such as 5 %")
        else:
            found = field.parse(text)
    except ValueError as error:
        raise InputError(f"{where} {error}") from None
    if not found > 0.0:
        raise InputError(f"{where} must be above 0; write for example 2%")
    return found
