"""Natural frequencies of one beam from slender to all shear, against 80 digits.

EI/(GA l²) is φ of :mod:`tmm.beam.span`: 10⁻⁴ in a bimorph of use, 10⁹ where the beam
does nothing but shear.  Held ends keep every digit; a free beam loses one with every decade of φ
and says so, until its rounding cannot be told any more and it is refused.
"""

from __future__ import annotations

from itertools import product

from tactgen.geometry.bimorph.ends import Ends, Springs
from tactgen.tmm.beam.modes import natural_frequencies
from tactgen.tmm.beam.sections import Section
from tactgen.validation.checks.cases.reference_modes import offset
from tactgen.validation.checks.stress.answers import REFUSALS, Family
from tactgen.validation.checks.stress.result import Row, answered

_ENDS = {
    "clamped": Ends(),
    "on springs": Ends(Springs(3.0, 0.24)),
    "free": Ends(Springs(0.0, 0.0)),
}
_MODES = 3


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
            family.add(where, abs(offset([(beam, 1.0)], ends, float(frequency))), float(bar))
    return answered(
        "natural frequencies: slenderness",
        "three modes, EI/(GA l²) 1e-12 to 1e16, clamped, on springs and free, against 80 digits",
        family.points, family.refusals,
    )  # fmt: skip
