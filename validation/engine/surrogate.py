"""Surrogate of any model: polynomials through its answers over a few numbers of a scene.

A few scenes, :func:`design_points`, are solved as any other; a :class:`Surrogate` of their answers
gives those of every other scene of the range in microseconds.  The design is Chebyshev points for
one number, and for several half as many points more than the polynomial has terms, of the same
density; all in the logarithm of a number unless it may be 0 or negative.  Modes are interpolated
within their class of motion, so that those which cross stay apart.

The error of an interpolated value is that of points left out of the fit and predicted from the
others, plus the model's own, interpolated, too.  Outside the range it grows as the polynomials do.

    ranges = {"bimorph.length": (14e-3, 40e-3)}
    surrogate = build_surrogate(scene, "solid", ("static_tip_displacement",), ranges)
    surrogate.answers({"bimorph.length": np.linspace(14e-3, 40e-3, 31)})
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Numbers
from tactgen.geometry.errors import InputError
from tactgen.tmm.chebyshev import weighted_powers
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import with_values

#: Range (SI) of each scene key that varies.
Ranges = Mapping[str, tuple[float, float]]
#: Values (n,) of each key.
Values = Mapping[str, Floats]
#: A model's answers at a point; None where it has none.
Answers = tuple[Quantity, ...] | None

#: Degree of the polynomial through the Chebyshev points of one number: one less than these.
_DEGREE_ALONE = 8
#: Largest total degree of several numbers, most terms, and points for each term.
_DEGREE, _MOST_TERMS, _POINTS_PER_TERM = 6, 84, 1.5
#: Most numbers that may vary.
MOST_KEYS = 8
#: Share of the design's points that may have no answer, since the parts do not fit there.
_MAY_FAIL = 0.15
#: Modes more than the scene asks for that are solved, since their order changes in the range.
_MORE_MODES = 2
#: Error per root mean square of what left-out points are missed by, and the part by rounding.
_SAFETY, _ROUNDING = 2.0, 1e-13
#: Degree of the interpolated logarithm of the model's own error.
_ERROR_DEGREE = 2


@dataclass(frozen=True)
class Box:
    """Ranges of scene keys as the cube from -1 to 1, with the polynomials over it."""

    ranges: Ranges

    def __post_init__(self) -> None:
        if not 0 < len(self.ranges) <= MOST_KEYS:
            raise InputError(
                f"a surrogate is made over 1 to {MOST_KEYS} numbers, not {len(self.ranges)}"
            )

    @property
    def degree(self) -> int:
        """Total degree of the polynomials."""
        keys = len(self.ranges)
        if keys == 1:
            return _DEGREE_ALONE
        return max(d for d in range(1, _DEGREE + 1) if math.comb(keys + d, d) <= _MOST_TERMS)

    def place(self, values: Values) -> Floats:
        """Places (n, keys) of values in the cube."""
        columns = []
        for key, (low, high) in self.ranges.items():
            at = np.asarray(values[key], dtype=float)
            if low > 0.0:
                with np.errstate(invalid="ignore", divide="ignore"):
                    at = np.log(at / low) / math.log(high / low)
            else:
                at = (at - low) / (high - low)
            columns.append(2.0 * at - 1.0)
        return np.column_stack(columns)

    def values(self, place: Floats) -> list[dict[str, float]]:
        """Values at places (n, keys) of the cube, by key."""
        columns = {}
        for (key, (low, high)), at in zip(self.ranges.items(), 0.5 * (place.T + 1.0), strict=True):
            columns[key] = low * (high / low) ** at if low > 0.0 else low + at * (high - low)
        return [{key: float(of[n]) for key, of in columns.items()} for n in range(len(place))]

    def design(self) -> Floats:
        """Places (n, keys) of the scenes to be solved."""
        keys = len(self.ranges)
        if keys == 1:
            share = (np.arange(_DEGREE_ALONE + 1)[:, None] + 0.5) / (_DEGREE_ALONE + 1)
        else:
            from scipy.stats.qmc import Sobol

            count = math.ceil(_POINTS_PER_TERM * math.comb(keys + self.degree, keys))
            size = math.ceil(math.log2(count))
            share = (Sobol(keys, scramble=False).random_base2(size)[:count] + 0.5 / 2**size) % 1.0
        return np.asarray(-np.cos(np.pi * share))

    def basis(self, place: Floats, degree: int) -> Floats:
        """Products of Chebyshev polynomials (n, terms) up to a total degree."""
        alone = np.polynomial.chebyshev.chebvander(place, degree)  # (n, keys, degree + 1)
        terms = weighted_powers([1.0] * place.shape[1], degree)
        found = np.ones((len(place), len(terms)))
        for key in range(place.shape[1]):
            found *= alone[:, key, terms[:, key]]
        return found


def design_points(ranges: Ranges) -> list[dict[str, float]]:
    """Values (SI) by key of the scenes that a surrogate is made from."""
    box = Box(ranges)
    return box.values(box.design())


def design_size(keys: int) -> int:
    """Number of scenes that a surrogate over so many keys is made from."""
    return len(Box({str(n): (1.0, 2.0) for n in range(keys)}).design())


# -- fits of one array of numbers over the design -----------------------------------------------

#: How values are interpolated: as their logarithm, as they are, or as their reciprocal.
_FORMS: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "logarithm": (lambda v: np.log(np.abs(v)), np.exp),
    "value": (lambda v: v, lambda t: t),
    "reciprocal": (lambda v: 1.0 / v, lambda t: 1.0 / t),
}


@dataclass(frozen=True)
class _Fit:
    """Numbers (n, m) of the design as polynomials, each in the form that predicts best.

    `spread` (m,) is the error of the form, `own` of the logarithm of the model's error.
    """

    box: Box
    degree: int
    forms: tuple[str, ...]
    sign: Floats
    coefficients: Numbers
    spread: Floats
    own: Floats
    least: Floats
    most: Floats

    @classmethod
    def of(cls, box: Box, place: Floats, values: Numbers, errors: Floats) -> _Fit:
        degree = box.degree
        while degree and len(place) < _needed(place.shape[1], degree):
            degree -= 1
        full = box.basis(place, degree)
        # through as many points as terms nothing can be left out: then of one degree less
        left = full if len(place) > full.shape[1] else box.basis(place, max(degree - 1, 0))
        one_sign = np.all(values.real > 0, axis=0) | np.all(values.real < 0, axis=0)
        able = {
            "logarithm": one_sign & np.all(values.imag == 0, axis=0),
            "value": np.ones(values.shape[1], dtype=bool),
            "reciprocal": np.all(values != 0, axis=0) & np.iscomplexobj(values),
        }
        best = np.full(values.shape[1], np.inf)
        forms = np.full(values.shape[1], "value", dtype=object)
        coefficients = np.zeros((full.shape[1], values.shape[1]), dtype=values.dtype)
        spread = np.zeros(values.shape[1])
        size = np.maximum(np.abs(values), np.finfo(float).tiny)
        sign = np.sign(values.real[0])
        for name, (forward, back) in _FORMS.items():
            with np.errstate(all="ignore"):
                moved = forward(values)
                missed = _left_out(left, moved)
                predicted = back(moved - missed) * (sign if name == "logarithm" else 1.0)
                away = np.sqrt(np.mean((np.abs(predicted - values) / size) ** 2, axis=0))
            better = able[name] & (away < best)
            best[better], forms[better] = away[better], name
            if better.any():
                coefficients[:, better] = np.linalg.lstsq(full, moved[:, better], rcond=None)[0]
                spread[better] = np.sqrt(np.mean(np.abs(missed[:, better]) ** 2, axis=0))
        logarithm = np.log(np.maximum(errors, np.finfo(float).tiny))
        few = box.basis(place, min(_ERROR_DEGREE, degree))
        own, *_ = np.linalg.lstsq(few, logarithm, rcond=None)
        own[0] += np.sqrt(np.mean((logarithm - few @ own) ** 2, axis=0))
        return cls(box, degree, tuple(forms), sign, coefficients,
                   _SAFETY * spread, own, logarithm.min(axis=0), logarithm.max(axis=0))  # fmt: skip

    def at(self, place: Floats) -> tuple[Numbers, Floats, Floats]:
        """Values, errors of interpolation, and the model's own errors, each (n, m)."""
        moved = self.box.basis(place, self.degree) @ self.coefficients
        values = np.empty_like(moved)
        scale = np.empty(moved.shape)
        for name, (_, back) in _FORMS.items():
            of = np.array(self.forms) == name
            values[:, of] = back(moved[:, of])
            size = np.abs(values[:, of])
            scale[:, of] = size ** {"logarithm": 1, "value": 0, "reciprocal": 2}[name]
            if name == "logarithm":
                values[:, of] *= self.sign[of]
        # beyond the range what is left out grows as the next polynomial
        beyond = np.maximum(np.abs(place), 1.0)
        growth = np.cosh((self.degree + 1) * np.arccosh(beyond)).prod(axis=1)[:, None]
        few = min(_ERROR_DEGREE, self.degree)
        own = self.box.basis(np.clip(place, -1.0, 1.0), few) @ self.own
        return (
            values,
            growth * scale * self.spread + _ROUNDING * np.abs(values),
            growth ** (1.0 / (self.degree + 1)) * np.exp(np.clip(own, self.least, self.most)),
        )


def _needed(keys: int, degree: int) -> int:
    """Number of points that a fit of a degree takes."""
    terms = math.comb(keys + degree, degree)
    return terms if keys == 1 and degree == _DEGREE_ALONE else math.ceil(1.2 * terms)


def _left_out(basis: Floats, values: Numbers) -> Numbers:
    """By how much each point is missed by the least squares of all others, (n, m)."""
    q, _ = np.linalg.qr(basis)
    kept = np.maximum(1.0 - (q**2).sum(axis=1), 1e-6)
    return np.asarray((values - q @ (q.T @ values)) / kept[:, None])


# -- the surrogate ------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Mode:
    """Modes of one class of motion and place within it: where they are known, and their fit."""

    motion: str
    known: Bools
    fit: _Fit


@dataclass(frozen=True)
class Surrogate:
    """Surrogate of a model within ranges of a scene's numbers."""

    scene: Scene  #: One of the scenes, for what does not vary
    box: Box  #: The ranges
    place: Floats  #: (n, keys) Where it was solved
    examples: Mapping[str, Quantity]  #: By quantity the answer at the first of these places
    fits: Mapping[str, _Fit | tuple[_Mode, ...]]  #: What is interpolated; modes one by one

    @property
    def method(self) -> str:
        """Description of the error estimate."""
        return (
            f"interpolated between {len(self.place)} solutions over {', '.join(self.box.ranges)}; "
            "the error is that of left-out points plus the model's own"
        )

    def answers(self, values: Values) -> list[tuple[Quantity, ...]]:
        """All quantities of each point, as a solution gives them; `values` (n,) are SI."""
        start = time.perf_counter()
        place = self.box.place(values)
        columns = [self._column(name, place) for name in self.fits]
        seconds = (time.perf_counter() - start) / max(len(place), 1)
        return [tuple(replace(q, seconds=seconds) for q in each)
                for each in zip(*columns, strict=True)]  # fmt: skip

    def interpolation_error(self, name: str) -> float:
        """Largest error of interpolation over the design, relative to the value."""
        fit = self.fits[name]
        fits = [mode.fit for mode in fit if mode.known.all()] if isinstance(fit, tuple) else [fit]
        return max((self._largest(each) for each in fits), default=0.0)

    def _largest(self, fit: _Fit) -> float:
        found, error, _ = fit.at(self.place)
        size = np.abs(found)
        if not np.iscomplexobj(found):  # what crosses zero is compared with the largest
            size = np.where(np.array(fit.forms) == "value", size.max(axis=0), size)
        share = np.where(error > 0.0, error / np.where(size > 0.0, size, np.inf), 0.0)
        return float(share.max(initial=0.0))

    def _column(self, name: str, place: Floats) -> list[Quantity]:
        example, fit = self.examples[name], self.fits[name]
        if isinstance(fit, tuple):
            rows = self._modes(fit, place)
        else:
            values, interpolated, own = fit.at(place)
            shape = example.value.shape
            rows = (
                (value.reshape(shape), error.reshape(shape), example.classes)
                for value, error in zip(values, interpolated + own, strict=True)
            )
        return [
            replace(example, value=value, error=error, method=self.method, extreme=None,
                    classes=None if example.classes is None else classes)
            for value, error, classes in rows
        ]  # fmt: skip

    def _modes(
        self, modes: tuple[_Mode, ...], place: Floats
    ) -> Iterator[tuple[Numbers, Floats, tuple[str, ...] | None]]:
        """Yield each point's lowest modes, their errors, and classes; up to the first in x."""
        nearest = np.argmin(((place[:, None, :] - self.place) ** 2).sum(axis=2), axis=1)
        found = np.full((len(place), len(modes)), np.inf)
        errors = np.zeros(found.shape)
        for column, mode in enumerate(modes):
            values, interpolated, own = mode.fit.at(place)
            known = mode.known[nearest]  # elsewhere it is above those that are wanted
            found[known, column] = values[known, 0].real
            errors[known, column] = (interpolated + own)[known, 0]
        for at, bar in zip(found, errors, strict=True):
            order = np.argsort(at, kind="stable")
            kinds = [modes[n].motion for n in order]
            first = kinds.index("bending_x") + 1 if "bending_x" in kinds else 0
            lowest = order[: min(max(self.scene.modes, first), np.isfinite(at).sum())]
            yield at[lowest], bar[lowest], tuple(kinds[: lowest.size])


def fit_surrogate(scene: Scene, ranges: Ranges, answers: Sequence[Answers]) -> Surrogate:
    """Surrogate through a model's answers at :func:`design_points`.

    Parameters
    ----------
    scene : Scene
        That whose answers are wanted, with other values of the keys.
    answers : sequence
        In the order of the points, of scenes from :func:`design_scene`; None where the parts do
        not fit.

    Raises InputError if too many have no answer, or a quantity has a value at some of the points
    only.
    """
    box = Box(ranges)
    place = box.design()
    there = [n for n, given in enumerate(answers) if given is not None]
    if len(there) < (1.0 - (_MAY_FAIL if len(ranges) > 1 else 0.0)) * len(place):
        raise InputError(
            f"{len(place) - len(there)} of the {len(place)} points of the range have no answer"
        )
    place = place[there]
    given = [{q.name: q for q in answers[n] or ()} for n in there]
    fits: dict[str, _Fit | tuple[_Mode, ...]] = {}
    for name in given[0]:
        column = [each[name] for each in given]
        fit = _mode_fits if _is_modal(name) else _array_fit
        fits[name] = fit(box, place, column)
    return Surrogate(scene, box, place, given[0], fits)


def design_scene(scene: Scene, quantities: Sequence[str]) -> Scene:
    """Scene as it is solved for a surrogate: with more modes, if these are wanted."""
    if not any(map(_is_modal, quantities)):
        return scene
    return scene.model_copy(update={"modes": scene.modes + _MORE_MODES})


def build_surrogate(
    scene: Scene,
    model: str,
    quantities: Sequence[str],
    ranges: Ranges,
    announce: Callable[[str], None] = lambda _: None,
) -> Surrogate:
    """Surrogate of a model, solved here and now, without checks of the values.

    Raises InputError as :func:`fit_surrogate`.
    """
    points = design_points(ranges)
    found: list[Answers] = []
    reuse = None
    for number, point in enumerate(points, start=1):
        announce(f"{model}: {number} of {len(points)} solutions over {', '.join(ranges)}")
        try:
            at = design_scene(with_values(scene, point), quantities)
            reuse = solve(at, (model,), quantities, reuse=reuse, modelling=False)
        except InputError:
            found.append(None)
            continue
        found.append(reuse.quantities)
    return fit_surrogate(scene, ranges, found)


def _is_modal(name: str) -> bool:
    """Whether a quantity is a list of natural frequencies."""
    row = QUANTITIES[name]
    return row.unit == "Hz" and bool({"modes_short", "modes_open"} & set(row.needs))


def _array_fit(box: Box, place: Floats, column: Sequence[Quantity]) -> _Fit:
    name = column[0].name
    if len({q.value.shape for q in column}) > 1:
        raise InputError(f"{name} has more values at some points of the range than at others")
    values = np.array([np.ravel(q.value) for q in column])
    errors = np.array([np.ravel(q.error) for q in column])
    if not (np.isfinite(values).all() and np.isfinite(errors).all()):
        raise InputError(f"{name} has no value, or no error, at some points of the range")
    return _Fit.of(box, place, values, errors)


def _mode_fits(box: Box, place: Floats, column: Sequence[Quantity]) -> tuple[_Mode, ...]:
    """Modes by class and place within it, each fitted where it is among the lowest."""
    tracks: dict[tuple[str, int], list[tuple[int, float, float]]] = {}
    for n, q in enumerate(column):
        seen: Counter[str] = Counter()
        for motion, value, error in zip(
            q.classes or [""] * q.value.size, q.value, q.error, strict=True
        ):
            tracks.setdefault((motion, seen[motion]), []).append((n, value, error))
            seen[motion] += 1
    found = []
    for (motion, _), rows in tracks.items():
        at, values, errors = (np.array(of) for of in zip(*rows, strict=True))
        known = np.zeros(len(place), dtype=bool)
        known[at] = True
        fit = _Fit.of(box, place[at], values[:, None], errors[:, None])
        found.append(_Mode(motion, known, fit))
    return tuple(found)
