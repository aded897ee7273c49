"""All lossless bending modes of a row of beams, none missed (Wittrick-Williams count).

The row is divided into parts so short that none can vibrate with its ends held; then the
number of negative eigenvalues of the assembled exact dynamic stiffness *is* the number
of natural frequencies below Ω (Wittrick and Williams 1971), and counting brackets every
mode with certainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from geometry.arrays import Floats, Ints
from tmm.multiport import symmetric_form
from tmm.scattering import Element, joined
from tmm.section import Joint, Section
from tmm.timoshenko import wavenumbers

Row: TypeAlias = Sequence[Element]

#: Largest |λ| of a part; held at both ends a beam first vibrates above λ = 3.
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


def bending_frequencies(row: Row, fixture: Fixture, count: int, *, open_circuit: bool) -> Floats:
    """Return the lowest `count` natural frequencies (Hz), ascending, of a lossless row.

    Rigid-body motion at 0 Hz is not counted.  Converged to the last digits that
    counting can tell apart (a few units in 1e-14).
    """
    found = []
    low, high = 0.0, _first_guess(row)
    rigid = _rigid_motions(fixture)
    parts = _short_parts(row, high)
    for wanted in range(rigid, rigid + count):
        while _count(parts, fixture, np.array([high]), open_circuit=open_circuit)[0] <= wanted:
            low, high = high, 2.0 * high
            parts = _short_parts(row, high)
        found.append(_bisect(parts, fixture, wanted, low, high, open_circuit=open_circuit))
        low, high = found[-1] * (1.0 - 1e-9), max(high, found[-1] * 1.5)
        parts = _short_parts(row, high)
    return np.array(found)


def _bisect(
    parts: Sequence[Row],
    fixture: Fixture,
    wanted: int,
    low: float,
    high: float,
    *,
    open_circuit: bool,
) -> float:
    while high - low > 4.0 * np.finfo(float).eps * high:
        trials = np.linspace(low, high, _TRIALS + 2)[1:-1]
        below = _count(parts, fixture, trials, open_circuit=open_circuit) <= wanted
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


def _first_guess(row: Row) -> float:
    """Return a frequency (Hz) of the order of the first mode of the whole row."""
    length = sum(element_length for _, element_length in row)
    beam = next(element for element, _ in reversed(row) if isinstance(element, Section))
    return float(np.sqrt(complex(beam.EI).real / beam.m) / length**2 / (2.0 * np.pi))


def _count(
    parts: Sequence[Row],
    fixture: Fixture,
    frequencies: Floats,
    *,
    open_circuit: bool,
) -> Ints:
    """Return how many natural frequencies (n,) lie below each frequency (Hz).

    No part may vibrate by itself at any of them.
    """
    omega = 2.0 * np.pi * frequencies
    blocks = {id(part): symmetric_form(joined(part, omega)).real for part in parts}
    n = 2 * (len(parts) + 1) + 1
    s = np.zeros((omega.size, n, n))
    at = 0
    for part in parts:
        ports = [at, at + 1, at + 2, at + 3, n - 1]
        s[np.ix_(range(omega.size), ports, ports)] += blocks[id(part)]
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


def _short_parts(row: Row, highest: float) -> list[Row]:
    """Divide the row into parts none of which, its ends held, can vibrate up to `highest` Hz.

    A long beam is cut.  Short ones are taken together while a uniform beam that is as soft
    and as heavy as any of them would not vibrate either (Rayleigh): many short parts would
    cost time and, in their stiffness matrices, digits.  A joint has no mass.
    """
    parts: list[Row] = []
    omega = 2.0 * np.pi * highest
    worst, total = None, 0.0
    for entry in row:
        element, length = entry
        if isinstance(element, Joint):
            parts.append([entry])
            worst = None
            continue
        number = 1 + int(_longest_wave(element, length, omega) / _LONGEST_WAVE)
        if number > 1:
            parts += [[(element, length / number)]] * number
            worst = None
            continue
        both = _softer(worst, element) if worst else element
        if worst and _longest_wave(both, total + length, omega) < _LONGEST_WAVE:
            parts[-1] = [*parts[-1], entry]
            worst, total = both, total + length
        else:
            parts.append([entry])
            worst, total = element, length
    return parts


def _softer(one: Section, other: Section) -> Section:
    """Return a section as soft as the softer and as heavy as the heavier of two."""
    return Section(
        EI=min(complex(one.EI).real, complex(other.EI).real),
        GA=min(one.GA, other.GA),
        m=max(one.m, other.m),
        rhoI=max(one.rhoI, other.rhoI),
    )


def _longest_wave(beam: Section, length: float, omega: float) -> float:
    first, second = wavenumbers(beam, length, np.array([omega]))
    return float(max(first[0], second[0]))
