"""The language of aims: arithmetic on quantities and scene keys with units, a condition or a goal.

    min_over(tip_displacement / threshold) >= 1
    first(short_circuit_frequencies) > 400 Hz
    maximise first(short_circuit_frequencies)
    minimise bimorph.length * bimorph.width

Nothing is ever evaluated but what the grammar knows.  Units are checked: lengths are compared with
lengths.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import FINE, engineering, with_error
from tactgen.geometry.synonyms import nearest
from tactgen.geometry.units import quoted, unit_registry
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD, ThresholdCurve
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.keys import declaration, is_scene_key, scene_keys
from tactgen.validation.scene.tolerances import unit_of

#: A scene key with a dot, a layer's size among them.
_KEY = re.compile(r"[^\W\d]\w*\.(?:layers\.\d+(?:\+\d+)*\.\w+|[^\W\d]\w*)")
#: A number, perhaps with a unit.
_NUMBER = re.compile(r"(?<![\w.])(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+)(?:\s*(%|[^\W\d]\w*))?")
_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
}  # fmt: skip
_COMPARISONS: dict[type[ast.cmpop], float] = {
    ast.GtE: 1.0, ast.Gt: 1.0, ast.LtE: -1.0, ast.Lt: -1.0,
}  # fmt: skip
_GOALS = {"maximise": 1.0, "maximize": 1.0, "minimise": -1.0, "minimize": -1.0}
_EXAMPLE = 'write for example "min_over(tip_displacement / threshold) >= 1"'
#: The name of the detection threshold.
THRESHOLD = "threshold"

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


class Peak(NamedTuple):
    """Frequency (Hz) of a largest or least value, and whether the band ends there."""

    frequency: float
    at_end: bool


@dataclass(frozen=True)
class Aim:
    """A condition or a goal."""

    text: str  #: As it was written
    kind: Literal["condition", "goal"]  #: Whether it is met or not, or is to be as good as possible
    sign: float  #: 1 if more is better, -1 if less is
    quantities: tuple[str, ...]  #: What must be known of a point
    keys: tuple[str, ...]  #: Scene keys whose values are wanted besides
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
            name: _quantity(name, np.ones(1), QUANTITIES[name].unit) for name in self.quantities
        } | {key: of_key(key, 1.0) for key in self.keys}
        found = self.left(at_threshold(ones, DISPLAY_THRESHOLD))
        if found.dimensionless:
            return "1"
        units = (ones[name].unit for name in (*self.quantities, *self.keys))
        base = f"{found.to_base_units().units:~C}"
        return next((unit for unit in units if found.check(unit_registry()(unit))), base)

    @property
    def takes_prefix(self) -> bool:
        """Whether its unit is one of a quantity: base units take no prefix."""
        return self.unit in {row.unit for row in QUANTITIES.values()}

    def judged(self, known: dict[str, Quantity]) -> Margin:
        """Margin of a point with its errors: each quantity moved by its own, added."""
        bar, modelling = (
            self._moved(known, of) for of in (lambda q: q.error, lambda q: q.modelling_error)
        )
        return Margin(self, self.margin(known), bar, modelling, self._peak(known))

    def _peak(self, known: dict[str, Quantity]) -> Peak | None:
        """Where the first largest or least value over the band that it names was found."""
        for name in self.quantities:
            q = known[name]
            searched = _searched(name)
            named = searched and re.search(rf"\b{searched}\(\s*{name}\s*\)", self.text)
            if q.extreme is not None and named:
                return Peak(q.extreme.frequency, q.extreme_at_end)
        return None

    def _moved(self, known: dict[str, Quantity], by: Callable[[Quantity], Any]) -> float:
        """How far errors of all values and their extremes move the margin, added."""
        margin, found = self.margin(known), 0.0
        for name in self.quantities:
            q, error = known[name], by(known[name])
            of_extreme = by(q.alone_at_extreme) if q.extreme else 0.0
            moved = [
                self.margin({**known, name: _shifted(q, s * error, s * of_extreme)}) - margin
                for s in (1.0, -1.0)
            ]
            found += max(abs(change) for change in moved)
        return found


class Margin(NamedTuple):
    """Margin of a point to a condition, or value of a goal, with its errors, in SI units."""

    aim: Aim
    value: float
    bar: float  #: Numerical error
    modelling: float = 0.0  #: Possible distance from that by the most detailed models, maybe nan
    peak: Peak | None = None  #: Where what the aim asks for is largest over the band

    @property
    def near(self) -> bool:
        """Whether it is less than its modelling error, and more than its bar."""
        return self.bar < abs(self.value) <= self.modelling

    @property
    def text(self) -> str:
        """As people read it, with both errors."""
        aim, unit = self.aim, self.aim.unit if self.aim.takes_prefix else "1"
        value = aim.sign * self.value if aim.kind == "goal" else self.value
        fine = self.bar < FINE * abs(value)
        text = engineering(value, unit) if fine else with_error(value, self.bar, unit)
        if unit != aim.unit:
            text += f" {aim.unit}"
        if aim.kind == "condition":
            text = f"margin {text}"
        if self.modelling:
            unknown = math.isnan(self.modelling)
            text += " (?)" if unknown else f" (± {engineering(self.modelling, unit, 2)})"
        if self.peak is None:
            return text
        end = ", an end of the band" if self.peak.at_end else ""
        return f"{text} at {engineering(self.peak.frequency, 'Hz', 4)}{end}"


def _shifted(q: Quantity, by: Any, extreme_by: float) -> Quantity:
    size = np.abs(q.value) if np.iscomplexobj(q.value) else q.value
    peak = q.extreme and replace(q.extreme, value=q.extreme.value + extreme_by)
    return replace(q, value=np.asarray(size + by), extreme=peak)


def parse_aim(text: str) -> Aim:
    """Aim that a text states.

    Raises InputError if it is not of the grammar.
    """
    first, _, goal = text.strip().partition(" ")
    sign = _GOALS.get(first, 0.0)
    names: dict[str, None] = {}
    right: Node | None = None
    try:
        # Python's grammar but for units, which are written as an index, 2 um as 2["um"], and keys,
        # which are written as texts
        source = _NUMBER.sub(
            lambda m: f'{m[1]}["{m[2]}"]' if m[2] else m[1],
            _KEY.sub(lambda m: f'"{m[0]}"', goal if sign else text),
        )
        match ast.parse(source.strip(), mode="eval").body:
            case ast.Compare(left=left, ops=[compared], comparators=[other]) if (
                not sign and type(compared) in _COMPARISONS
            ):
                value, right = _node(left, names), _node(other, names)
                kind: Literal["condition", "goal"] = "condition"
                sign = _COMPARISONS[type(compared)]
            case tree if sign:
                value, kind = _node(tree, names), "goal"
            case _:
                raise InputError("has no comparison; add >= or <= and a value, or begin with "
                                 "maximise or minimise")  # fmt: skip
        if not names:
            raise InputError(f"names neither quantity nor scene key; {_EXAMPLE}")
    except InputError as error:
        raise InputError(f"the aim {quoted(text)} {error}") from None
    except (SyntaxError, ValueError, OverflowError, RecursionError, MemoryError):
        raise InputError(
            f"the aim {quoted(text)} is not an arithmetic expression; {_EXAMPLE}"
        ) from None
    quantities, keys = (
        tuple(name for name in names if (name in QUANTITIES) == known) for known in (True, False)
    )
    return Aim(text, kind, sign, quantities, keys, value, right)


def _node(tree: ast.expr, names: dict[str, None]) -> Node:
    """Evaluation of arithmetic; `names` gathers the quantities and keys in it."""
    match tree:
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            join, before, after = _OPERATORS[type(op)], _node(left, names), _node(right, names)
            return lambda known: join(before(known), after(known))
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            negated = _node(inner, names)
            return lambda known: -negated(known)
        case ast.Call(func=ast.Name(id=name), args=[inner], keywords=[]):
            if name not in _FUNCTIONS:
                raise InputError(f"calls {quoted(name)}{nearest(name, _FUNCTIONS)}; known are "
                                 f"{', '.join(_FUNCTIONS)}")  # fmt: skip
            argument = _node(inner, names)
            if isinstance(inner, ast.Name) and inner.id in QUANTITIES:
                return lambda known: _over_band(name, known[inner.id], argument(known))
            return lambda known: _FUNCTIONS[name](argument(known))
        case ast.Subscript(
            value=ast.Constant(value=int() | float() as number), slice=ast.Constant(value=str(unit))
        ):
            size = np.float64(number) * _unit(unit)
            return lambda _: size
        case ast.Constant(value=int() | float() as number):
            plain = np.float64(number) * unit_registry().dimensionless
            return lambda _: plain
        case ast.Name(id=name) | ast.Constant(value=str() as name):
            return _named(name, names)
    raise InputError(f"has a part that is not an arithmetic expression of quantities; {_EXAMPLE}")


def _over_band(function: str, q: Quantity, value: Any) -> Any:
    """Function of one quantity; its searched extreme where the function asks for that one."""
    if function == _searched(q.name) and q.extreme is not None:
        return q.extreme.value * value.units
    return _FUNCTIONS[function](value)


def _searched(name: str) -> str:
    """Function that asks for a quantity's searched extreme, "" if none does."""
    row = QUANTITIES[name]
    return "" if row.peak_of else "min_over" if row.is_limit else "max_over"


def _unit(name: str) -> Any:
    if name == "%":
        return 0.01 * unit_registry().dimensionless
    try:
        return 1.0 * unit_registry().parse_units(name)
    except Exception:  # noqa: BLE001  (pint raises whatever Python's tokenizer does)
        raise InputError(f"has the unknown unit {quoted(name)}; {_EXAMPLE}") from None


def _named(name: str, names: dict[str, None]) -> Node:
    if name == THRESHOLD:
        return lambda known: _value(known[THRESHOLD])
    if name not in QUANTITIES and not is_scene_key(name):
        close = nearest(name, (*QUANTITIES, THRESHOLD, *scene_keys()))
        raise InputError(
            f"names {quoted(name)}{close}; name a quantity of tactgen solve, a scene key with a "
            "number, or threshold"
        )
    if name not in QUANTITIES and unit_of(declaration(name)) is None:
        raise InputError(f"names {name}, which is a choice; name a scene key with a number")
    if name in QUANTITIES and QUANTITIES[name].unit == "SI":
        raise InputError(f"names {name}, whose entries have no common unit; {_EXAMPLE}")
    names[name] = None
    return lambda known: _value(known[name])


def _value(q: Quantity) -> Any:
    """Quantity with its unit; of complex ones the magnitude."""
    size = np.abs(q.value) if np.iscomplexobj(q.value) else q.value
    unit = unit_registry().parse_units("" if q.unit == "1" else q.unit)
    return np.asarray(size, dtype=float) * unit


def of_key(key: str, value: float) -> Quantity:
    """Value of a scene key (SI) as a quantity without error."""
    unit = unit_of(declaration(key))
    assert unit is not None
    return _quantity(key, np.array([value]), unit.si)


def at_threshold(known: dict[str, Quantity], curve: ThresholdCurve) -> dict[str, Quantity]:
    """Quantities with the detection threshold at their frequencies among them."""
    frequencies: tuple[float, ...] = next(
        (q.frequency for q in known.values() if q.frequency is not None), ()
    )
    level = curve.at(np.array(frequencies))
    return {**known, THRESHOLD: _quantity(THRESHOLD, level, "m")}


def _quantity(name: str, value: Floats, unit: str) -> Quantity:
    return Quantity(
        name=name, model="", value=value, unit=unit, error=np.zeros(value.shape), method=""
    )
