"""All lossless bending modes of a row of beams, none missed, to the rounding of the row.

With its ends attached and in the units of :mod:`tmm.beam.scattering`, a lossless row has a
real symmetric dynamic stiffness E(Ω).  Its eigenvalues e_i fall with frequency; each is taken as an
angle, e_i = cot θ_i, and followed through infinity, where the row vibrates with its ends held:

    Θ = Σ θ_i + π (modes with ends held),   modes below Ω = (Θ − Σ θ_i)/π + #(e_i < 0)

(Wittrick and Williams 1971).  With all ends held Θ counts just those modes.  Neither Θ nor
R = (E + j)⁻¹ has a pole, both are built up from the elements, and each step changes Θ by a
known angle, so that no turn can be lost:

* an element too short to vibrate with its ends held, S = 1 − 2j R with eigenvalues e^{−2jθ};
* two elements joined, Θ = Θ₀ + Θ₁ − π + arg det(1 − R₁ R₀), the reflections at the joint;
* a stiffness d v vᵀ attached, Θ' = Θ + arg(1 + d vᵀR v): since Im R is negative definite the
  argument lies between 0 and −π for d > 0, and between 0 and π for d < 0.

The smallest angle π/2 − θ_i tells how far the next mode is; it is smooth and vanishes there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import TypeAlias

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.tmm.beam.scattering import THROUGH, Element, in_waves, neighbours, star
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.beam.span import wavenumbers

Row: TypeAlias = Sequence[Element]

_EPS = float(np.finfo(float).eps)
#: Largest |λ| of an element; held at both ends a beam first vibrates above λ = 3.
_LONGEST_WAVE = 1.5
#: Points to a mode of the first look, how much further two more lie where that was not far enough,
#: and how far a count may be from a whole number.
_TO_A_MODE, _FURTHER, _WHOLE = 4, (2.0, 4.0), 0.1
#: Size of X below which S keeps its eigenvalues near those of an element without length.
_SMALL = 0.5
#: Compliance, or angle θ, taken for none: those of an infinite stiffness but for rounding.
_NOTHING = 1e-9
#: Least rounding of an angle in units of machine epsilon, and what is added of the change
#: seen in other units.  Of 114 frequencies of 38 rows held against 60 digits, foils at 10⁻⁷
#: of the stiffness among them, none had more than a third of the error so estimated.
_ROUNDINGS, _SAFETY = 4.0, 4.0
#: Relative width of a bracket that is interpolated: its square, which a straight line misses,
#: is nothing beside rounding, and the angles' signs are right at its ends.
_NARROW = 1e-10
#: Trials: bisection alone takes 34, and one more for each factor of two by which the root lies
#: below the lowest frequency looked at.
_MOST_TRIALS = 200
#: Reference stiffness in those, and the relative step of a difference quotient.
_OTHER_UNIT, _STEP = 5.0, 1e-5
#: Rounding from which it cannot be told: what moves is then of the size of the step.
_TOLD = 0.1 * _STEP


@dataclass(frozen=True)
class NaturalFrequencies:
    """Natural frequencies (Hz), ascending, and the relative rounding error of each."""

    frequencies: Floats
    rounding: Floats


def bending_frequencies(row: Row, ends: Ends, count: int, *, open_circuit: bool) -> Floats:
    """Lowest `count` natural frequencies (Hz), ascending, of a lossless row.

    Damping at the ends is left out; rigid-body motion at 0 Hz is not counted.
    """
    return natural_frequencies(row, ends, count, open_circuit=open_circuit).frequencies


def natural_frequencies(
    row: Row,
    ends: Ends,
    count: int,
    *,
    open_circuit: bool,
    of_row: Callable[[Floats], Floats] = lambda frequencies: frequencies,
) -> NaturalFrequencies:
    """Lowest `count` natural frequencies of a lossless row with their rounding.

    `of_row`, rising, gives the frequencies (Hz) at which the row without its ends moves as the body
    does that it stands for.

    Raises ArithmeticError if the count of modes, or their rounding, is not certain (section
    constants beyond all proportion).
    """
    first = ends.rigid_motions
    wanted = np.arange(first, first + count)
    attached = _Attached(row, ends, of_row, open_circuit=open_circuit)
    # frequencies grow like (n + 1/2)²
    highest = _first_guess(row) * (wanted[-1] + 1.5) ** 2
    looks = _TO_A_MODE * (wanted[-1] + 1)
    shares = (np.arange(1, looks + 1) / looks) ** 2
    points = highest * shares
    counts, angles = attached.count(points)
    while counts[-1] <= wanted[-1]:
        more = points[-1] * np.array(_FURTHER)
        found = attached.count(more)
        points = np.append(points, more)
        counts = np.append(counts, found[0])
        angles = np.concatenate([angles, found[1]])
    at = _roots(attached, wanted, points, counts, angles)
    rounding = _rounding(attached, at)
    if not (rounding < _TOLD).all():
        raise ArithmeticError(
            "the natural frequencies of this row are lost in rounding: its section constants are "
            "out of all proportion (a beam far shorter than thick, or a foil)"
        )
    return NaturalFrequencies(at, rounding)


def _rounding(attached: _Attached, at: Floats) -> Floats:
    """Relative rounding error of roots (n,).

    In other units, and with the last digits of the frequency changed, everything is rounded
    anew: how far the root then moves shows what rounding does to it.
    """
    steps = np.array([0.0, 1e3 * _EPS, 2e3 * _EPS, 3e3 * _EPS, _STEP])
    trials = (at[:, None] * (1.0 + steps)).ravel()
    left = attached.nearest(trials, _OTHER_UNIT).reshape(at.size, steps.size)
    slope = (left[:, -1] - left[:, 0]) / _STEP
    moved = np.abs(left[:, :-1] / slope[:, None] - steps[:-1]).max(axis=1)
    return np.asarray(_SAFETY * moved + _EPS * (1.0 + _ROUNDINGS / np.abs(slope)))


def _roots(
    attached: _Attached, wanted: Ints, points: Floats, counts: Ints, angles: Floats
) -> Floats:
    """Where the count passes each wanted number, by Chandrupatla's method.

    T. R. Chandrupatla, Adv. Eng. Software 28 (1997) 145.
    """
    above = np.array([int(np.flatnonzero(counts > n)[0]) for n in wanted])
    b, fb = points[above], _signed(counts[above], angles[above], wanted)
    a = np.where(above > 0, points[above - 1], 0.0)
    fa = np.where(above > 0, _signed(counts[above - 1], angles[above - 1], wanted), 0.5 * np.pi)
    share = np.full(wanted.size, 0.5)
    for _ in range(_MOST_TRIALS):
        x = a + share * (b - a)
        f = _signed(*attached.count(x), wanted)
        same = (f > 0.0) == (fa > 0.0)
        c, fc = np.where(same, a, b), np.where(same, fa, fb)
        b, fb = np.where(same, b, a), np.where(same, fb, fa)
        a, fa = x, f
        width = np.abs(b - a) / np.maximum(a, b)
        if (width < _NARROW).all():
            return np.asarray(a + fa / (fa - fb) * (b - a))
        least = 0.5 * _NARROW / np.maximum(width, _NARROW)
        with np.errstate(divide="ignore", invalid="ignore"):  # two equal: bisection
            xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
            inverse = fa / (fb - fa) * fc / (fb - fc)
            inverse += (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        smooth = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        share = np.clip(np.where(smooth, inverse, 0.5), least, 1.0 - least)
    raise ArithmeticError(
        f"a natural frequency of this row was not found in {_MOST_TRIALS} trials: it is next to "
        "0 Hz; leave out springs that hold nothing, or masses out of all proportion"
    )


def _signed(counts: Ints, angles: Floats, wanted: Ints) -> Floats:
    """Angle left to a wanted mode, positive below it and negative above."""
    below = counts <= wanted
    side = np.where(below[:, None], angles, -angles)
    # an angle of nought has a side all the same
    left = np.where(side >= 0.0, np.maximum(side, 1e-30), 0.5 * np.pi).min(axis=1)
    return np.asarray(np.where(below, left, -left))


class _Attached:
    """A row with both ends attached and its circuit open or closed."""

    def __init__(
        self, row: Row, ends: Ends, of_row: Callable[[Floats], Floats], *, open_circuit: bool
    ) -> None:
        self._row, self._ends, self._of_row, self._open = row, ends, of_row, open_circuit

    def nearest(self, frequencies: Floats, unit: float) -> Floats:
        """Angle (n,) that is nearest to zero; see :meth:`count`."""
        angles = self.count(frequencies, unit)[1]
        at = np.abs(angles).argmin(axis=1)
        return np.asarray(np.take_along_axis(angles, at[:, None], axis=1)[:, 0])

    def count(self, frequencies: Floats, unit: float = 1.0) -> tuple[Ints, Floats]:
        """Number (n,) of modes below each frequency (Hz) and angles π/2 − θ (n, k).

        `unit` changes the reference stiffness, and nothing but rounding and the angles' size.
        """
        omega, inside = 2.0 * np.pi * frequencies, 2.0 * np.pi * self._of_row(frequencies)
        made, order, reference = in_waves(_cut(self._row, float(inside.max())), inside, unit)
        x, turned = _joined(made, order)
        r = (np.eye(4) - THROUGH[:, :4] - x[:, :4, :4]) / 2j
        if self._open and x[:, :4, 4].any():
            # no charge: k kᵀ/C attached, k the forces per volt; x has R k, −kᵀR and C + kᵀR k
            turned = turned - _descent(x[:, 4, 4])
            r = r + x[:, :4, 4:] * x[:, 4:, :4] / (2j * x[:, 4:, 4:])
        displacement, force = reference.units()
        free = [0, 1, 2, 3]
        for port in (0, 1) if self._ends.base is None else ():
            column = r[:, port]
            free.remove(port)
            turned = turned - _descent(column[:, port])
            r = r - column[:, :, None] * column[:, None, :] / column[:, port, None, None]
        power = (displacement * force)[:, 0]  # of both pairs
        for lever, stiffness in self._stiffnesses(omega):
            moved = np.tile(displacement, 2) * lever
            column = (r @ moved[:, :, None])[:, :, 0]
            d = stiffness / power
            whole = 1.0 + d * (moved * column).sum(axis=1)
            turned = turned + np.where(d > 0.0, -_descent(whole), _descent(whole.conj()))
            r = r - (d / whole)[:, None, None] * column[:, :, None] * column[:, None, :]
        g = np.linalg.eigvals(r[:, free][:, :, free])
        # an infinite stiffness is no turn, whatever its rounding
        g = np.where(np.abs(g) < _NOTHING, _NOTHING, g)
        angles = np.arctan2(g.real, -g.imag)
        turns = (turned - (np.copysign(0.5 * np.pi, angles) - angles).sum(axis=1)) / np.pi
        counts = np.rint(turns)
        if not (np.abs(turns - counts) < _WHOLE).all():
            raise ArithmeticError("the natural frequencies of this row cannot be counted")
        return counts.astype(int), np.asarray(angles)

    def _stiffnesses(self, omega: Floats) -> list[tuple[Floats, Floats]]:
        """What is attached (n,), each with the motion (4,) of its place per motion of a port."""
        springs, load, o2 = self._ends.base, self._ends.conservative_tip, omega**2
        w_base, psi_base, w_tip, psi_tip = np.eye(4)
        found = [
            (w_tip - load.offset * psi_tip, load.stiffness - o2 * load.mass),
            (psi_tip, -o2 * load.inertia),
        ]
        if springs is not None:
            rotational = springs.rotational_stiffness - o2 * springs.rotational_inertia
            found += [(w_base, np.full_like(o2, springs.lateral_stiffness)), (psi_base, rotational)]
        return [(lever, d) for lever, d in found if d.any()]


def _descent(value: Complex) -> Floats:
    """−arg (n,) of numbers in the lower half plane, between 0 and π but for rounding."""
    angle = -np.angle(value)
    return np.asarray(np.where(angle < -0.5 * np.pi, angle + 2.0 * np.pi, angle))


def _cut(row: Row, omega: float) -> list[Element]:
    """Divide elements that could vibrate with held ends up to Ω (rad/s)."""
    beams = {id(e): e for e, _ in row if isinstance(e, Section)}
    constants = (np.array([getattr(e, f.name) for e in beams.values()]) for f in fields(Section))
    waves = np.max(wavenumbers(Section(*constants), 1.0, np.array([omega])), axis=0)
    shortest = dict(zip(beams, waves, strict=True))
    parts: list[Element] = []
    for entry in row:
        element, length = entry
        number = 1 + int(shortest.get(id(element), 0.0) * length / _LONGEST_WAVE)
        parts += [entry] if number == 1 else [(element, length / number)] * number
    return parts


def _joined(made: Complex, order: list[int]) -> tuple[Complex, Floats]:
    """X (n, 5, 5) of the row and Θ (n,), from the X (k, n, 5, 5) of its entries.

    Neighbours are joined, then pairs of neighbours, and so on; equal pairs once.
    """
    turned = _turned(made[..., :4, :4])
    while len(order) > 1:
        lower, upper, left_over, order = neighbours(order)
        between = made[lower][..., 2:4, 2:4] @ made[upper][..., :2, :2]
        # reflections are below one, so that each eigenvalue of 1 − R₁ R₀ has a positive part
        angle = np.angle(1.0 - np.linalg.eigvals(between)).sum(axis=-1)
        both = turned[lower] + turned[upper] - np.pi + angle
        turned = np.concatenate([both, turned[left_over]])
        made = np.concatenate([star(made[lower], made[upper]), made[left_over]])
    return np.asarray(made[order[0]]), np.asarray(turned[order[0]])


def _turned(x: Complex) -> Floats:
    """Θ (k, n) of short elements from X (k, n, 4, 4)."""
    through = THROUGH[:, :4]
    # S of no length has the eigenvalues −1 and 1 twice, each θ a quarter turn and none
    turned = np.asarray(np.pi - 0.5 * np.angle(np.linalg.det(np.eye(4) + through @ x)))
    large = np.abs(x).sum(axis=-1).max(axis=-1) > _SMALL
    if large.any():
        theta = np.mod(-0.5 * np.angle(np.linalg.eigvals(through + x[large])), np.pi)
        theta = np.where(theta > np.pi - _NOTHING, theta - np.pi, theta)
        turned[large] = theta.sum(axis=-1)
    return turned


def _first_guess(row: Row) -> float:
    """Frequency (Hz) of the order of the first mode of the whole row."""
    length = sum(element_length for _, element_length in row)
    beam = next(element for element, _ in reversed(row) if isinstance(element, Section))
    bending = np.sqrt(complex(beam.EI).real / beam.m) / length**2
    shear = np.sqrt(complex(beam.GA).real / beam.m) / length
    return float(min(bending, shear) / (2.0 * np.pi))
