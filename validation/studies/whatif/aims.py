"""The language of aims: arithmetic on quantities with units, a condition or a goal.

    min_over(tip_displacement / threshold) >= 1
    first(short_circuit_frequencies) > 400 Hz
    maximise first(short_circuit_frequencies)

Nothing is ever evaluated but what the grammar knows.  Units are checked: lengths are compared with
lengths.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.names import nearest
from tactgen.geometry.units import quoted, unit_registry
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD, ThresholdCurve
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.models.model import Quantity

_TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+)|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<sign><=|>=|[-+*/(),<>%]))"
)
_COMPARISONS: dict[str, float] = {">=": 1.0, ">": 1.0, "<=": -1.0, "<": -1.0}
_GOALS = {"maximise": 1.0, "maximize": 1.0, "minimise": -1.0, "minimize": -1.0}
_EXAMPLE = 'write for example "min_over(tip_displacement / threshold) >= 1"'
#: The name of the detection threshold.
THRESHOLD = "threshold"
#: Deepest nesting of parentheses and signs.
_DEEPEST = 50

#: Dividing by a quantity that is 0 at a point leaves that point without a value: no warning.
_UNSPOKEN = np.errstate(divide="ignore", invalid="ignore")

#: A value with its unit, from the quantities of one point by name.
Node = Callable[[dict[str, Quantity]], Any]


def _first(value: Any) -> Any:
    return value[0] if np.ndim(value.magnitude) else value


def _over(reduce: Callable[[Any], Any], value: Any) -> Any:
    """One number of an array, of its values that are known; nan if none is."""
    numbers = np.ravel(value.magnitude)
    known = numbers[np.isfinite(numbers)]
    return (reduce(known) if known.size else np.nan) * value.units


#: Functions by name: what they do with the values over frequency or mode.
_FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "min_over": lambda v: _over(np.min, v),
    "max_over": lambda v: _over(np.max, v),
    "mean_over": lambda v: _over(np.mean, v),
    "first": _first,
    "abs": abs,
    "sqrt": lambda v: v**0.5,
}


@dataclass(frozen=True)
class Aim:
    """A condition or a goal."""

    text: str  #: As it was written
    kind: Literal["condition", "goal"]  #: Whether it is met or not, or is to be as good as possible
    sign: float  #: 1 if more is better, -1 if less is
    quantities: tuple[str, ...]  #: What must be known of a point
    #: Both sides; of a goal `right` is None
    left: Node
    right: Node | None

    @_UNSPOKEN
    def margin(self, known: dict[str, Quantity]) -> float:
        """Margin of a point to a condition, or value of a goal, in SI units.

        Raises InputError if units do not fit, or an array is left where one number is wanted.
        """
        import pint

        try:
            found = self.left(known)
            if self.right is not None:
                found = found - self.right(known)
            number = np.asarray(found.to_base_units().magnitude)
        except pint.DimensionalityError as error:
            raise InputError(
                f'the aim "{self.text}" compares or adds {error.units1 or "a number"} and '
                f"{error.units2 or 'a number'}; write units that fit, such as 2 um"
            ) from None
        if number.size != 1:
            raise InputError(
                f'the aim "{self.text}" leaves {number.size} values where one is wanted; put '
                "min_over(...), max_over(...) or first(...) around it"
            )
        return self.sign * float(number.ravel()[0])

    @property
    @_UNSPOKEN
    def unit(self) -> str:
        """SI unit of the margin: as a quantity has it, else of base units; 1 for a pure number."""
        ones = {
            name: Quantity(
                name=name,
                model="",
                value=np.ones(1),
                unit=QUANTITIES[name].unit,
                error=np.zeros(1),
                method="",
                seconds=0.0,
            )
            for name in self.quantities
        }
        found = self.left(at_threshold(ones, DISPLAY_THRESHOLD))
        if found.dimensionless:
            return "1"
        units = (QUANTITIES[name].unit for name in self.quantities)
        base = f"{found.to_base_units().units:~C}"
        return next((unit for unit in units if found.check(unit_registry()(unit))), base)

    def margin_with_bar(self, known: dict[str, Quantity]) -> tuple[float, float]:
        """Margin and its numerical error bar: each quantity moved by its own, added."""
        margin, bar = self.margin(known), 0.0
        for name in self.quantities:
            q = known[name]
            moved = [self.margin({**known, name: _moved(q, sign)}) - margin for sign in (1.0, -1.0)]
            bar += max(abs(change) for change in moved)
        return margin, bar


def _moved(q: Quantity, sign: float) -> Quantity:
    size = np.abs(q.value) if np.iscomplexobj(q.value) else q.value
    return replace(q, value=np.asarray(size + sign * q.error))


def parse_aim(text: str) -> Aim:
    """Aim that a text states.

    Raises InputError if it is not of the grammar.
    """
    return _Parser(text).aim()


class _Parser:
    """Recursive descent: aim, sum, product, factor."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = self._split(text)
        self.place = self.depth = 0
        self.quantities: dict[str, None] = {}
        #: How many names have values of their own at each point: quantities and the threshold.
        self.named = 0

    def aim(self) -> Aim:
        goal = _GOALS.get(self._peek()[1])
        if goal is not None:
            self.place += 1
        left = self._sum()
        right: Node | None = None
        sign = goal or 0.0
        if goal is None:
            sign = _COMPARISONS.get(self._peek()[1], 0.0)
            if not sign:
                raise self._refused("has no comparison", "add >= or <= and a value, or begin with "
                                    "maximise or minimise")  # fmt: skip
            self.place += 1
            right = self._sum()
        if self._peek()[1]:
            raise self._refused(f"goes on with {quoted(self._peek()[1])} where it should end")
        if not self.quantities:
            raise self._refused("names no quantity")
        kind: Literal["condition", "goal"] = "condition" if goal is None else "goal"
        return Aim(self.text, kind, sign, tuple(self.quantities), left, right)

    def _split(self, text: str) -> list[tuple[str, str]]:
        found, place = [], 0
        while text[place:].strip():
            match = _TOKEN.match(text, place)
            if match is None:
                self.tokens = []
                raise self._refused(
                    f"has {quoted(text[place:].strip()[0])}, which is no part of it"
                )
            found.append((str(match.lastgroup), match[str(match.lastgroup)]))
            place = match.end()
        return found

    def _peek(self) -> tuple[str, str]:
        return self.tokens[self.place] if self.place < len(self.tokens) else ("end", "")

    def _take(self, sign: str) -> bool:
        if self._peek() == ("sign", sign):
            self.place += 1
            return True
        return False

    def _refused(self, what: str, remedy: str = _EXAMPLE) -> InputError:
        return InputError(f"the aim {quoted(self.text)} {what}; {remedy}")

    def _sum(self) -> Node:
        found = self._product()
        while self._peek()[1] in ("+", "-"):
            join = operator.add if self._peek()[1] == "+" else operator.sub
            self.place += 1
            found = _joined(join, found, self._product())
        return found

    def _product(self) -> Node:
        found = self._factor()
        while self._peek()[1] in ("*", "/"):
            if self._take("*"):
                found = _joined(operator.mul, found, self._factor())
            else:
                found = _joined(operator.truediv, found, self._divisor())
        return found

    def _divisor(self) -> Node:
        """Divisor; refused if it is 0 at every point."""
        import pint

        self.place += 1
        before = self.named
        found = self._factor()
        with suppress(pint.DimensionalityError):  # which the margin explains
            if self.named == before and not found({}).magnitude:
                raise self._refused("divides by 0", "write another value there")
        return found

    def _factor(self) -> Node:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise self._refused("is nested too deeply")
        found = self._inner_factor()
        self.depth -= 1
        return found

    def _inner_factor(self) -> Node:
        kind, token = self._peek()
        if self._take("-"):
            return _applied(operator.neg, self._factor())
        if self._take("("):
            inner = self._sum()
            self._close()
            return inner
        self.place += 1
        if kind == "number":
            return self._number(float(token))
        if kind == "name":
            return self._named(token)
        raise self._refused(
            f"has {quoted(token)} where a value is wanted" if token else "is not whole"
        )

    def _close(self) -> None:
        if not self._take(")"):
            raise self._refused("has a parenthesis that is not closed")

    def _number(self, value: float) -> Node:
        """Number, with the unit that follows it if one does, such as 2 um or 5 %."""
        unit = 1.0 * unit_registry().dimensionless
        if self._take("%"):
            unit = 0.01 * unit
        elif self._peek()[0] == "name":
            name = self._peek()[1]
            self.place += 1
            try:
                unit = 1.0 * unit_registry().parse_units(name)
            except Exception:  # noqa: BLE001  (pint raises whatever Python's tokenizer does)
                raise self._refused(f"has the unknown unit {quoted(name)}") from None
        return lambda _: value * unit

    def _named(self, name: str) -> Node:
        if self._take("("):
            if name not in _FUNCTIONS:
                raise self._refused(f"calls {quoted(name)}{nearest(name, _FUNCTIONS)}",
                                    f"known are {', '.join(_FUNCTIONS)}")  # fmt: skip
            inner = self._sum()
            self._close()
            return _applied(_FUNCTIONS[name], inner)
        self.named += 1
        if name == THRESHOLD:
            return _threshold
        if name not in QUANTITIES:
            known_names = (*QUANTITIES, THRESHOLD)
            raise self._refused(f"names {quoted(name)}{nearest(name, known_names)}",
                                "name a quantity of tactgen solve, or threshold")  # fmt: skip
        if QUANTITIES[name].unit == "SI":
            raise self._refused(f"names {name}, whose entries have no common unit")
        self.quantities[name] = None
        return lambda known: _value(known[name])


def _joined(join: Callable[[Any, Any], Any], left: Node, right: Node) -> Node:
    return lambda known: join(left(known), right(known))


def _applied(function: Callable[[Any], Any], inner: Node) -> Node:
    return lambda known: function(inner(known))


def _value(q: Quantity) -> Any:
    """Quantity with its unit; of complex ones the magnitude."""
    size = np.abs(q.value) if np.iscomplexobj(q.value) else q.value
    unit = unit_registry().parse_units("" if q.unit == "1" else q.unit)
    return np.asarray(size, dtype=float) * unit


def at_threshold(known: dict[str, Quantity], curve: ThresholdCurve) -> dict[str, Quantity]:
    """Quantities with the detection threshold at their frequencies among them."""
    frequencies: tuple[float, ...] = next(
        (q.frequency for q in known.values() if q.frequency is not None), ()
    )
    level = curve.at(np.array(frequencies))
    here = Quantity(
        name=THRESHOLD,
        model="",
        value=level,
        unit="m",
        error=np.zeros(level.shape),
        method="",
        seconds=0.0,
        frequency=frequencies,
    )
    return {**known, THRESHOLD: here}


def _threshold(known: dict[str, Quantity]) -> Any:
    """Detection threshold, the paper's unless another is known; nan where unknown."""
    if THRESHOLD not in known:
        known = at_threshold(known, DISPLAY_THRESHOLD)
    return _value(known[THRESHOLD])
