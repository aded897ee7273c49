"""A family of orbits followed over the frequency or the drive, round its folds.

Pseudo-arclength continuation: a step along the tangent, then Newton's method in the plane across
it (Keller 1977).  Lengths are measured with each coordinate relative to the largest motion met so
far and the parameter relative to its range.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.harmonic_balance.balance import (
    NoConvergence,
    Orbit,
    Oscillator,
    balance,
    complex_spectrum,
    converge,
    missing_motion,
    real_vector,
)
from tactgen.tmm.harmonic_balance.steady import Resolution, at_fixed_drive, equilibrium, resolved

Parameter = Literal["omega", "level"]
_RESOLUTION = Resolution()

#: First, longest and shortest step, in lengths of which the whole range is 1.
_FIRST, _LONGEST, _SHORTEST = 5e-3, 0.03, 1e-7
#: Newton steps of a correction; how many are as they should be, how many fewer or more double or
#: halve the next step, and the least that is left of a step.
_STEPS, _USUAL, _TO_DOUBLE, _LEAST = 10, 4, 3, 0.3
#: Growth of the motion up to which the sizes it is measured in stay.
_GROWN = 1.2
#: Share of what may be missing below which harmonics are given up, to this share of them.
_PLENTY, _KEPT = 1e-3, 0.75
#: A step is repeated with half its length when the tangent turned by more than this (cosine).
_TURN = 0.9


@dataclass(frozen=True)
class Course:
    """The metric of a continuation, and where it may go."""

    parameter: Parameter  #: What varies besides the orbit
    #: Its range
    low: float
    high: float
    scales: Floats  #: (k,) Size of each coordinate

    def weights(self, harmonics: int) -> Floats:
        """Size (m + 1,) of each unknown, the parameter last."""
        return np.append(np.tile(self.scales, 2 * harmonics + 1), self.high - self.low)

    def pack(self, orbit: Orbit) -> Floats:
        """Orbit's unknowns with the parameter, each over its size."""
        y = np.append(real_vector(orbit.spectrum), getattr(orbit, self.parameter))
        return np.asarray(y / self.weights(orbit.harmonics))

    def unpack(self, scaled: Floats, like: Orbit) -> Orbit:
        """Orbit of scaled unknowns; the other parameter is that of `like`."""
        k = self.scales.size
        harmonics = ((scaled.size - 1) // k - 1) // 2
        y = scaled * self.weights(harmonics)
        changed = {self.parameter: float(y[-1])}
        return replace(like, spectrum=complex_spectrum(y[:-1], k), **changed)


@dataclass(frozen=True)
class Step:
    """A point of a branch and the way on."""

    orbit: Orbit  #: The orbit
    tangent: Floats  #: (m + 1,) Unit tangent in scaled unknowns
    course: Course  #: Their sizes
    length: float  #: Length of the step to the next point

    def at(self, oscillator: Oscillator, length: float) -> Step:
        """Point at another length along the branch, as Newton's method finds it."""
        return _advance(oscillator, self, length)[0]


@dataclass(frozen=True)
class Branch:
    """Orbits in the order in which they were met."""

    steps: tuple[Step, ...]  #: The points
    ended: str  #: Why it ended inside the range; empty where it reached an end
    missing: float  #: Largest share of a motion that its harmonics left out

    @property
    def orbits(self) -> tuple[Orbit, ...]:
        """The orbits."""
        return tuple(step.orbit for step in self.steps)


def follow(
    oscillator: Oscillator,
    start: Orbit,
    parameter: Parameter,
    low: float,
    high: float,
    *,
    resolution: Resolution = _RESOLUTION,
    direction: int = 1,
    most: int = 3000,
    announce: Callable[[Orbit], None] = lambda _: None,
) -> Branch:
    """Branch through an orbit, until the parameter leaves its range.

    Parameters
    ----------
    start : Orbit
        A solved orbit.
    parameter : {"omega", "level"}
        What varies, between `low` and `high`.
    direction : {1, -1}
        Whether the parameter first grows or falls.
    most : int
        Points after which it ends.
    announce : callable
        Told each orbit.
    """
    course = Course(parameter, low, high, _sizes(oscillator, start))
    step = Step(start, _tangent(oscillator, start, course, direction), course, _FIRST)
    steps, missing, length, ended = [step], missing_motion(oscillator, start), _FIRST, ""
    while len(steps) < most:
        try:
            after, count, left = _advance_resolved(oscillator, step, length, resolution)
        except NoConvergence as error:
            length *= 0.5
            if length < _SHORTEST:
                ended = f"the branch could not be followed further: {error}"
                break
            continue
        if after.tangent @ _padded(step.tangent, after.tangent.size) < _TURN:
            length *= 0.5
            if length >= _SHORTEST:
                continue
        steps[-1] = replace(step, length=length)
        value = getattr(after.orbit, parameter)
        if not low <= value <= high:
            steps.append(_at_end(oscillator, step, after, low if value < low else high))
            break
        eased = length * 2.0 ** ((_USUAL - count) / _TO_DOUBLE)
        length = float(np.clip(eased, _LEAST * length, _LONGEST))
        missing = max(missing, left)
        step = _rescaled(oscillator, after)
        steps.append(step)
        announce(step.orbit)
    else:
        ended = f"the branch was left after {most} points"
    return Branch(tuple(steps), ended, missing)


def _sizes(oscillator: Oscillator, orbit: Orbit) -> Floats:
    return np.asarray(np.maximum(oscillator.scales, np.abs(orbit.spectrum).max(axis=0)))


def _rescaled(oscillator: Oscillator, step: Step) -> Step:
    """Point in sizes that have grown with the motion."""
    scales = np.maximum(step.course.scales, _sizes(oscillator, step.orbit))
    if (scales <= _GROWN * step.course.scales).all():
        return step
    course = replace(step.course, scales=scales)
    old, new = (c.weights(step.orbit.harmonics) for c in (step.course, course))
    tangent = step.tangent * old / new
    return replace(step, course=course, tangent=tangent / np.linalg.norm(tangent))


def _bordered(
    oscillator: Oscillator, orbit: Orbit, course: Course, row: Floats
) -> tuple[Floats, Floats]:
    """Residual (m,) and the scaled Jacobian (m + 1, m + 1) with `row` below it."""
    found = balance(oscillator, orbit)
    by_parameter = found.by_omega if course.parameter == "omega" else found.by_level
    jacobian = np.column_stack([found.jacobian, by_parameter]) * course.weights(orbit.harmonics)
    return found.residual, np.vstack([jacobian, row])


def _tangent(oscillator: Oscillator, orbit: Orbit, course: Course, direction: int) -> Floats:
    """Tangent along which the parameter grows, or with direction −1 falls."""
    row = np.eye(course.weights(orbit.harmonics).size)[-1] * direction
    return _solved_tangent(_bordered(oscillator, orbit, course, row)[1])


def _solved_tangent(bordered: Floats) -> Floats:
    """Unit tangent from the scaled Jacobian with the direction of the way below it."""
    try:
        tangent = np.linalg.solve(bordered, np.eye(bordered.shape[0])[-1])
    except np.linalg.LinAlgError:
        raise NoConvergence("the branch has no tangent") from None
    return np.asarray(tangent / np.linalg.norm(tangent))


def _padded(tangent: Floats, size: int) -> Floats:
    """Tangent over more or fewer harmonics; the parameter stays last."""
    unknowns = np.zeros(size - 1)
    kept = min(size, tangent.size) - 1
    unknowns[:kept] = tangent[:kept]
    return np.append(unknowns, tangent[-1])


def _advance(oscillator: Oscillator, step: Step, length: float) -> tuple[Step, int]:
    course, tangent = step.course, step.tangent
    predicted = course.pack(step.orbit) + length * tangent

    def evaluate(y: Floats) -> tuple[Floats, Floats]:
        orbit = course.unpack(y, step.orbit)
        if orbit.omega <= 0.0:
            raise NoConvergence("the step led to a negative frequency")
        residual, jacobian = _bordered(oscillator, orbit, course, tangent)
        return np.append(residual, tangent @ (y - predicted)), jacobian

    found, count, jacobian = converge(evaluate, predicted, np.ones(predicted.size), _STEPS)
    orbit = course.unpack(found, step.orbit)
    return Step(orbit, _solved_tangent(jacobian), course, length), count


def _advance_resolved(
    oscillator: Oscillator, step: Step, length: float, resolution: Resolution
) -> tuple[Step, int, float]:
    """Next point with enough harmonics, the Newton steps, and the residual."""
    after, count = _advance(oscillator, step, length)
    left = missing_motion(oscillator, after.orbit)
    while left > resolution.missing and after.orbit.harmonics < resolution.most:
        step = with_harmonics(step, resolution.more(after.orbit.harmonics))
        after, _ = _advance(oscillator, step, length)
        left = missing_motion(oscillator, after.orbit)
    fewer = int(_KEPT * after.orbit.harmonics)
    if left < _PLENTY * resolution.missing and fewer >= resolution.least:
        after = with_harmonics(after, fewer)
    return after, count, left


def with_harmonics(step: Step, harmonics: int) -> Step:
    """Point over more harmonics, which are 0, or fewer."""
    orbit = step.orbit.with_harmonics(harmonics)
    size = step.course.weights(harmonics).size
    tangent = _padded(step.tangent, size)
    return replace(step, orbit=orbit, tangent=tangent / np.linalg.norm(tangent))


def _at_end(oscillator: Oscillator, step: Step, after: Step, end: float) -> Step:
    """Point at the end of the range, between two points of the branch."""
    name = after.course.parameter
    before = step.orbit.with_harmonics(after.orbit.harmonics)
    first, last = getattr(before, name), getattr(after.orbit, name)
    share = (end - first) / (last - first)
    spectrum = before.spectrum + share * (after.orbit.spectrum - before.spectrum)
    guess = replace(after.orbit, spectrum=spectrum, **{name: end})
    return replace(after, orbit=at_fixed_drive(oscillator, guess), length=0.0)


#: A complex amplitude that is read off an orbit.
Readout: TypeAlias = Callable[[Orbit], complex]

#: Step of the derivative along the branch, relative to its length of 1.
_STEP = 1e-5


@dataclass(frozen=True)
class SpecialPoint:
    """An orbit between two points of a branch."""

    orbit: Orbit  #: The orbit
    after: int  #: Index of the point before it


def folds(oscillator: Oscillator, branch: Branch) -> tuple[SpecialPoint, ...]:
    """Where the parameter turns back."""
    return _zeros(oscillator, branch, lambda step: float(step.tangent[-1]), falling=False)


def peaks(oscillator: Oscillator, branch: Branch, amplitude: Readout) -> tuple[SpecialPoint, ...]:
    """Where the magnitude of an amplitude is largest along the branch."""

    def slope(step: Step) -> float:
        y, course = step.course.pack(step.orbit), step.course
        ahead, behind = (
            abs(amplitude(course.unpack(y + s * step.tangent, step.orbit))) for s in (_STEP, -_STEP)
        )
        return float(ahead - behind)

    return _zeros(oscillator, branch, slope, falling=True)


def _zeros(
    oscillator: Oscillator, branch: Branch, of: Callable[[Step], float], *, falling: bool
) -> tuple[SpecialPoint, ...]:
    from scipy.optimize import brentq

    found = []
    values = [of(step) for step in branch.steps]
    pairs = zip(branch.steps, branch.steps[1:], values, values[1:], strict=False)
    for index, (step, after, here, there) in enumerate(pairs):
        if here * there >= 0.0 or (falling and here < 0.0) or after.length == 0.0:
            continue
        begin = with_harmonics(step, max(step.orbit.harmonics, after.orbit.harmonics))
        begin = begin.at(oscillator, 0.0)
        ends = [of(begin), of(begin.at(oscillator, step.length))]
        if ends[0] * ends[1] >= 0.0:  # the zero lies beside a point, by rounding
            nearer = step.orbit if abs(here) < abs(there) else after.orbit
            found.append(SpecialPoint(nearer, index))
            continue
        length = brentq(
            lambda s, begin=begin: of(begin.at(oscillator, s)), 0.0, step.length, xtol=1e-12
        )
        found.append(SpecialPoint(begin.at(oscillator, float(length)).orbit, index))
    return tuple(found)


#: Points of a branch from rest after which the search ends.
_MOST = 300


def steady_orbit(
    oscillator: Oscillator, omega: float, level: float, *, resolution: Resolution = _RESOLUTION
) -> Orbit:
    """Orbit at a frequency (rad/s) to which the drive leads when it is raised from rest.

    Round folds if there are any; where several orbits exist it is one of them.

    Raises NoConvergence if none is found.
    """
    rest = Orbit(omega, 0.0, equilibrium(oscillator).spectrum).with_harmonics(resolution.least)
    try:
        return resolved(oscillator, Orbit(omega, level, rest.spectrum), resolution)
    except NoConvergence:
        branch = follow(oscillator, rest, "level", 0.0, level, resolution=resolution, most=_MOST)
    reached = branch.orbits[-1]
    if branch.ended or reached.level < level:
        why = branch.ended or "the branch from rest leads back to rest"
        raise NoConvergence(
            f"at {omega / (2.0 * np.pi):.6g} Hz no orbit was found at a drive of {level:.6g}, "
            f"the highest met being {max(o.level for o in branch.orbits):.6g}: {why}"
        )
    return reached
