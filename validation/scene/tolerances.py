"""The tolerances that a scene states with its numbers, taken apart from them.

A scene may write a number with its tolerance (:mod:`validation.scene.tolerances`).  What is solved
reads the number alone; the tolerance travels beside it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from typing import Any, get_args

from pydantic.fields import FieldInfo

from tactgen.geometry.device.laminate import single_sizes
from tactgen.geometry.device.materials import Spread
from tactgen.geometry.device.parameter_group import Parameters
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import NUMBER, Unit, quoted

#: Longest text that is looked at: no number with a tolerance is longer.
_LONGEST = 200
_UNIT = r"[^\s\d.,;=\[\]{}±][^,;=\[\]{}±]*?"
_SIGN = r"(?:±|\+/-|\+-)"
_PLUS_MINUS = re.compile(
    rf"\s*(?P<value>{NUMBER})\s*(?P<unit>{_UNIT})?\s*{_SIGN}\s*"
    rf"(?P<half>{NUMBER})\s*(?P<own>%|{_UNIT})?\s*",
    re.IGNORECASE | re.ASCII,
)
_RANGE = re.compile(
    rf"\s*(?P<value>{NUMBER})\s*(?P<unit>{_UNIT})?\s*"
    rf"\(\s*(?P<low>{NUMBER})\s*(?P<low_unit>{_UNIT})?\s*\.\.\s*"
    rf"(?P<high>{NUMBER})\s*(?P<high_unit>{_UNIT})?\s*\)\s*(?!\))(?P<after>{_UNIT})?\s*",
    re.IGNORECASE | re.ASCII,
)


#: Sizes of a layer by the word before them, and one with its tolerance in a layer's text.
_SIZES = {"": "thickness", "wide": "width", "from": "start", "to": "end", "pitch": "pitch"}
_SIZE_WITH_TOLERANCE = re.compile(
    rf"(?:\b(?P<after>wide|from|to|pitch)\s+)?(?<![\w.+-])(?P<text>(?P<value>{NUMBER})"
    rf"(?:\s*[a-zµμ]+)?\s*(?:{_SIGN}\s*{NUMBER}(?:\s*(?:%|[a-zµμ]+))?|\([^()]*\.\.[^()]*\)))",
    re.IGNORECASE | re.ASCII,
)

#: What says how something is solved, not what is built or done.
_SETTINGS = ("accuracy", "mesh")


@dataclass(frozen=True)
class Tolerance:
    """A number with the range in which it may lie, SI units."""

    text: str  #: The number without its tolerance, as it would be written
    value: float
    low: float
    high: float
    words: str  #: The tolerance as people write it after the value
    relative: bool = False  #: Whether it is a share of the value

    @property
    def spread(self) -> Spread:
        """Range that the scene states."""
        return Spread(self.low, self.high, f"stated: {self.words.strip('()')}", not self.relative)


def has_tolerance(text: str) -> bool:
    """Whether a text is meant as a number with a tolerance."""
    return len(text) <= _LONGEST and re.search(rf"{_SIGN}|\(.*\.\.", text) is not None


def read_tolerance(text: str, unit: Unit) -> Tolerance:
    """Number with its tolerance, read from a text; a unit that stands once holds for all numbers.

    Raises ValueError with a sentence that names the remedy, to follow the text.
    """
    if found := _PLUS_MINUS.fullmatch(text):
        tolerance = _plus_minus(found, unit)
    elif found := _RANGE.fullmatch(text):
        tolerance = _range(found, unit)
    else:
        number, _, name = unit.example.partition(" ")
        examples = f'"{unit.example} ± 5 %" or "{number} (LOW..HIGH) {name}'.rstrip() + '"'
        raise ValueError(f"has a tolerance that cannot be read; write for example {examples}")
    unit.check(tolerance.value)  # a value that is not possible says so by itself
    for end in (tolerance.low, tolerance.high):
        try:
            unit.check(end)
        except ValueError as error:
            words = str(error).partition("; write")[0]
            raise ValueError(
                f"has a tolerance that reaches {quoted(unit.show(end))}, which {words}; narrow it"
            ) from None
    return tolerance


def _written(number: str, name: str | None) -> str:
    return f"{number} {name or ''}".strip()


def _plus_minus(found: re.Match[str], unit: Unit) -> Tolerance:
    name, own = found["unit"], found["own"]
    share = own == "%"
    name = name or (None if share else own)
    text = _written(found["value"], name)
    value = unit.parse(text)
    if share:
        half = abs(value) * float(found["half"]) / 100.0
        if not value:
            raise ValueError("has a tolerance in percent of 0; write it as an amount")
    else:
        own = own or name
        # a difference: of a temperature in degC, degrees
        half = unit.parse(_written(found["half"], own)) - unit.parse(_written("0", own))
    if half < 0.0 or found["half"].startswith("-"):
        raise ValueError("has a negative tolerance; write the amount without a sign after ±")
    words = f"± {_written(found['half'], '%' if share else own)}"
    return Tolerance(text, value, value - half, value + half, words, share)


def _range(found: re.Match[str], unit: Unit) -> Tolerance:
    name = found["unit"] or found["after"] or found["high_unit"]
    high_unit = found["high_unit"] or name
    low_unit = found["low_unit"] or high_unit
    text = _written(found["value"], name)
    low, high = _written(found["low"], low_unit), _written(found["high"], high_unit)
    ends = unit.parse(low), unit.parse(high)
    value = unit.parse(text)
    if not ends[0] <= value <= ends[1]:
        raise ValueError(
            f"has a range from {unit.show(ends[0])} to {unit.show(ends[1])} in which "
            f"{unit.show(value)} does not lie; write the smaller end first, around the value"
        )
    return Tolerance(text, value, *ends, f"({low}..{high})")


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
    layers = values.get("layers")
    if isinstance(layers, list) and all(isinstance(layer, str) for layer in layers):
        layers = "; ".join(layers)
    if isinstance(layers, str):
        del plain["layers"]
        # a size that a key states, alone or with others, has none of the text
        stated_alone = {single for name in plain for single in single_sizes(name)}
        apart = _sizes_apart(layers)
        plain = {**{k: v for k, v in apart.items() if k not in stated_alone}, **plain}
    for name, value in tuple(plain.items()):
        key = f"{prefix}{name}"
        try:
            info = model.declaration(name)
        except KeyError:  # no key of a scene, which its validation says
            continue
        inner = info.annotation
        if isinstance(value, dict) and isinstance(inner, type) and issubclass(inner, Parameters):
            plain[name] = _split(inner, value, f"{key}.", stated)
        elif isinstance(value, str) and has_tolerance(value):
            unit = unit_of(info)
            if unit is None:
                continue  # no number: what reads it says what it is
            stated[key] = _read(key, value, unit)
            plain[name] = stated[key].text
    return plain


def _sizes_apart(layers: str) -> dict[str, str]:
    """Layers' text without tolerances, and the sizes that have one by keys of their own."""
    found = {}

    def kept(number: int, size: re.Match[str]) -> str:
        after, text = size["after"] or "", size["text"]
        found[f"layers.{number}.{_SIZES[after]}"] = text
        return f"{after} {size['value']} {''.join(re.findall('[a-zµμ]+', text)[-1:])}"

    texts = [
        _SIZE_WITH_TOLERANCE.sub(partial(kept, number), text)
        for number, text in enumerate(re.split("[;,]", layers), start=1)
    ]
    return {"layers": ";".join(texts) if found else layers, **found}


def _read(key: str, text: str, unit: Unit) -> Tolerance:
    if key.partition(".")[0] in _SETTINGS:
        raise InputError(
            f"{key} = {quoted(text)} has a tolerance, but says how the scene is solved; "
            "write the value alone"
        )
    try:
        return read_tolerance(text, unit)
    except ValueError as error:
        raise InputError(f"{key} = {quoted(text)} {error}") from None


def unit_of(info: FieldInfo) -> Unit | None:
    """Unit of a field that is a number on a scale."""
    nested = [part for arg in get_args(info.annotation) for part in get_args(arg)]
    return next((part for part in (*info.metadata, *nested) if isinstance(part, Unit)), None)
