"""All lossless bending modes of a row of beams, none missed (Wittrick-Williams count).

Each beam is cut so short that no cut piece can vibrate with its ends held; then the
number of negative eigenvalues of the assembled exact dynamic stiffness *is* the number
of natural frequencies below Ω (Wittrick and Williams 1971), and counting brackets every
mode with certainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Ints
from tmm.multiport import symmetric_form
from tmm.section import Section
from tmm.timoshenko import dynamic_stiffness, wavenumbers

#: Largest |λ| of a cut piece; held at both ends a beam first vibrates above λ = 3.
_LONGEST_WAVE = 1.5
#: Trial frequencies per counting pass; each pass narrows the bracket by this factor.
_TRIALS = 15


@dataclass(frozen=True)
class Fixture:
    """Lossless constants attached to the ends; `clamped` overrides the base springs."""

    clamped: bool
    lateral_stiffness: float = 0.0
    rotational_stiffness: float = 0.0
    rotational_inertia: float = 0.0
    tip_stiffness: float = 0.0
    tip_mass: float = 0.0


def bending_frequencies(
    pieces: Sequence[tuple[Section, float]], fixture: Fixture, count: int, *, open_circuit: bool
) -> Floats:
    """Return the lowest `count` natural frequencies (Hz), ascending, of lossless pieces.

    Rigid-body motion at 0 Hz is not counted.  Converged to the last digits that
    counting can tell apart (a few units in 1e-14).
    """
    found = []
    low, high = 0.0, _first_guess(pieces)
    rigid = _rigid_motions(fixture)
    for wanted in range(rigid, rigid + count):
        while _count(pieces, fixture, np.array([high]), open_circuit=open_circuit)[0] <= wanted:
            low, high = high, 2.0 * high
        found.append(_bisect(pieces, fixture, wanted, low, high, open_circuit=open_circuit))
        low, high = found[-1] * (1.0 - 1e-9), max(high, found[-1] * 1.5)
    return np.array(found)


def _bisect(
    pieces: Sequence[tuple[Section, float]],
    fixture: Fixture,
    wanted: int,
    low: float,
    high: float,
    *,
    open_circuit: bool,
) -> float:
    while high - low > 4.0 * np.finfo(float).eps * high:
        trials = np.linspace(low, high, _TRIALS + 2)[1:-1]
        below = _count(pieces, fixture, trials, open_circuit=open_circuit) <= wanted
        last = int(np.flatnonzero(below)[-1]) if below.any() else -1
        bracket = np.concatenate(([low], trials, [high]))
        if bracket[last + 1] == low and bracket[last + 2] == high:
            break
        low, high = float(bracket[last + 1]), float(bracket[last + 2])
    return 0.5 * (low + high)


def _rigid_motions(fixture: Fixture) -> int:
    """Return how many motions the fixture leaves free of any stiffness (modes at 0 Hz)."""
    if fixture.clamped:
        return 0
    held = (fixture.lateral_stiffness, fixture.rotational_stiffness, fixture.tip_stiffness)
    return max(0, 2 - sum(stiffness > 0.0 for stiffness in held))


def _first_guess(pieces: Sequence[tuple[Section, float]]) -> float:
    """Return a frequency (Hz) of the order of the first mode of the whole row."""
    length = sum(piece_length for _, piece_length in pieces)
    beam = pieces[-1][0]
    return float(np.sqrt(complex(beam.EI).real / beam.m) / length**2 / (2.0 * np.pi))


def _count(
    pieces: Sequence[tuple[Section, float]],
    fixture: Fixture,
    frequencies: Floats,
    *,
    open_circuit: bool,
) -> Ints:
    """Return how many natural frequencies (n,) lie below each frequency (Hz)."""
    omega = 2.0 * np.pi * frequencies
    cuts = [_cut(beam, length, float(omega.max())) for beam, length in pieces]
    n = 2 * (sum(cuts) + 1) + 1
    s = np.zeros((omega.size, n, n))
    at = 0
    for (beam, length), number in zip(pieces, cuts, strict=True):
        block = symmetric_form(dynamic_stiffness(beam, length / number, omega)).real
        for _ in range(number):
            ports = [at, at + 1, at + 2, at + 3, n - 1]
            s[np.ix_(range(omega.size), ports, ports)] += block
            at += 2
    s[:, at, at] += fixture.tip_stiffness - omega**2 * fixture.tip_mass
    s[:, 0, 0] += fixture.lateral_stiffness
    s[:, 1, 1] += fixture.rotational_stiffness - omega**2 * fixture.rotational_inertia
    first, last = (2 if fixture.clamped else 0), (n if open_circuit else n - 1)
    s = s[:, first:last, first:last]
    scale = 1.0 / np.sqrt(np.abs(np.einsum("nii->ni", s)) + np.finfo(float).tiny)
    eigenvalues = np.linalg.eigvalsh(s * scale[:, :, None] * scale[:, None, :])
    # with the voltage as an unknown, the capacitance adds one negative eigenvalue
    return np.asarray((eigenvalues < 0.0).sum(axis=1) - int(open_circuit))


def _cut(beam: Section, length: float, omega: float) -> int:
    first, second = wavenumbers(beam, length, np.array([omega]))
    return 1 + int(max(first[0], second[0]) / _LONGEST_WAVE)
