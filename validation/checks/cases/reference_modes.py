"""Natural frequencies of a row of beams once more, from the equations of its state, to 80 digits.

As :mod:`.reference_beam` it owes nothing to :mod:`tmm`: states [w, ψ, M, F, q, U] are carried from
the base to the tip, and a determinant of what the ends ask for vanishes at a mode.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import mpmath as mp

from tactgen.geometry.bimorph.ends import Ends
from tactgen.validation.checks.cases import reference_beam as reference

#: Section constants (of mpmath or as doubles) or a joint's compliance, and the length (m).
Row: TypeAlias = Sequence[tuple[Any, Any]]

#: Relative step of the secant that finds the root next to a frequency.
_STEP = mp.mpf("1e-9")


def natural_frequency(row: Row, ends: Ends, near: Any, *, open_circuit: bool) -> mp.mpf:
    """Return the natural frequency (Hz) next to one that is right to some nine digits.

    One secant over a step of 1e-9: what it misses is the product of step and distance.
    """
    with mp.workdps(reference.DIGITS):
        near = mp.mpf(near)
        low, high = (
            _end_condition(row, ends, near * (1 + step), open_circuit=open_circuit)
            for step in (-_STEP, _STEP)
        )
        return near * (1 - _STEP * (high + low) / (high - low))


def offset(row: Row, ends: Ends, frequency: float, *, open_circuit: bool = False) -> float:
    """Return how far (relative) a frequency lies from the root next to it."""
    root = natural_frequency(row, ends, frequency, open_circuit=open_circuit)
    with mp.workdps(reference.DIGITS):
        return float(mp.mpf(frequency) / root - 1)


def _end_condition(row: Row, ends: Ends, frequency: Any, *, open_circuit: bool) -> Any:
    """Return the determinant of [M, F] at the loaded upper end; with an open circuit of q, too."""
    omega = 2 * mp.pi * frequency
    state = mp.zeros(6, 3)
    state[5, 2] = 1
    if ends.base is None:
        state[2, 0] = state[3, 1] = 1
    else:
        state[0, 0] = state[1, 1] = 1
        state[3, 0] = mp.mpf(ends.base.lateral_stiffness)
        state[2, 1] = ends.base.rotational_stiffness - omega**2 * mp.mpf(
            ends.base.rotational_inertia
        )
    for element, length in row:
        state = _transfer(element, length, omega) * state
    load = ends.conservative_tip
    tip = load.stiffness - omega**2 * mp.mpf(load.mass)
    unknowns = 3 if open_circuit else 2
    moment, charge = ([state[k, j] for j in range(unknowns)] for k in (2, 4))
    force = [state[3, j] + tip * state[0, j] for j in range(unknowns)]
    return mp.re(mp.det(mp.matrix([moment, force, charge][:unknowns])))


def _transfer(element: Any, length: Any, omega: Any) -> mp.matrix:
    if not hasattr(element, "compliance"):
        return reference.transfer(reference.constants(element), length, omega)
    across = mp.eye(6)
    for i in range(2):
        for j in range(2):  # [w, ψ] jump by the compliance times [F, M]
            across[i, 3 - j] += mp.mpf(float(element.compliance[i, j]))
    return across
