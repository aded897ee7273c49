"""Natural frequencies of one beam from slender to all shear, against 80 digits.

EI/(GA l²) is φ of :mod:`tmm.beam.transfer.span`: 10⁻⁴ in a bimorph of use, 10⁹ where the beam
does nothing but shear.  Held ends keep every digit; a free beam loses one with every decade of φ
and says so, until its rounding cannot be told any more and it is refused.
"""

from __future__ import annotations

from itertools import product

import mpmath as mp

from tactgen.geometry.bimorph.ends import Ends, Springs
from tactgen.tmm.beam.modes import natural_frequencies
from tactgen.tmm.beam.section.section import Section
from tactgen.validation.checks.cases import reference_beam as reference
from tactgen.validation.checks.stress.answers import REFUSALS, Family
from tactgen.validation.checks.stress.result import Row, answered

_ENDS = {
    "clamped": Ends(),
    "on springs": Ends(Springs(3.0, 0.24)),
    "free": Ends(Springs(0.0, 0.0)),
}
_MODES = 3
#: Relative step of the secant that finds how far a frequency is from its root.
_STEP = mp.mpf("1e-9")


def row(quick: bool) -> Row:
    """Vary φ over 28 decades and the rotary inertia over 8, at three kinds of ends."""
    family = Family()
    powers = (-12, -4, 4, 8, 16) if quick else range(-12, 17, 2)
    inertias = (1e-3,) if quick else (1e-8, 1e-3, 1.0)
    for power, rho_i, (name, ends) in product(powers, inertias, _ENDS.items()):
        beam = Section(EI=1.0, GA=10.0**-power, m=1.0, rhoI=rho_i)
        try:
            found = natural_frequencies([(beam, 1.0)], ends, _MODES, open_circuit=False)
        except REFUSALS as error:
            family.refuse(error)
            continue
        for frequency, bar in zip(found.frequencies, found.rounding, strict=True):
            where = f"φ 1e{power}, ρI/ml² {rho_i:g}, {name}"
            family.add(where, abs(offset(beam, ends, float(frequency))), float(bar))
    return answered(
        "natural frequencies: slenderness",
        "three modes, EI/(GA l²) 1e-12 to 1e16, clamped, on springs and free, against 80 digits",
        family.points, family.refusals,
    )  # fmt: skip


def offset(beam: Section, ends: Ends, frequency: float) -> float:
    """Return how far (relative) a frequency lies from the root next to it, by one secant."""
    with mp.workdps(80):
        low, high = (
            _determinant(beam, ends, mp.mpf(frequency) * (1 + step)) for step in (-_STEP, _STEP)
        )
        return float(_STEP * (high + low) / (high - low))


def _determinant(beam: Section, ends: Ends, frequency: mp.mpf) -> mp.mpf:
    """Return the determinant of [M, F] at the free upper end; states [w, ψ, M, F, q, U]."""
    omega = 2 * mp.pi * frequency
    state = mp.zeros(6, 2)
    if ends.base is None:
        state[2, 0] = state[3, 1] = 1
    else:
        state[0, 0] = state[1, 1] = 1
        state[3, 0] = mp.mpf(ends.base.lateral_stiffness)
        state[2, 1] = mp.mpf(ends.base.rotational_stiffness)
    above = reference.transfer(reference.constants(beam), mp.mpf(1), omega) * state
    return mp.re(mp.det(above[2:4, :]))
