"""Printed targets that are wrong or coarse, beside the right ones.

Every row is the printed number; it differs, and the row says why.  A row that came to agree would
fail: then the explanation would be wrong.
"""

from __future__ import annotations

import math
from functools import cache, partial
from typing import Any

from tactgen.tmm.beam.printed_formulas import MISPRINTS
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.cases.audit import audit
from tactgen.validation.evidence.cases.elastic import THIN, cantilever_plate, free_plate
from tactgen.validation.evidence.cases.laminates import pvdf_deflection
from tactgen.validation.evidence.cases.oscillators import period_of_vm156
from tactgen.validation.evidence.cases.resonators import CUBE
from tactgen.validation.scene.load import load_scene

# --- the paper's Appendix A --------------------------------------------------------------------


_audit = cache(lambda: audit(load_scene("paper")[0]))


def _as_printed(equation: int) -> float:
    """Printed over exact formula; of σ by its effect at 10 Hz.

    σ's denominator is so far off that the tip hardly moves: there the effect is stated.
    """
    row: Any = _audit().row(equation)  # of a misprint, which has both
    return 1.0 + float(row.velocity[0] if equation == 39 else row.deviation)


#: Relative deviation of each printed formula from 80-digit arithmetic, as it was when explained.
_DEVIATIONS = {
    24: 0.83333, 36: 2.0, 39: 0.9979, 41: 1.0, 47: 2.7416e-4, 49: 1.36226, 55: 0.0728094,
}  # fmt: skip

_APPENDIX = case(
    "EQ", "The paper's Appendix A as printed",
    "Each printed formula of the transfer matrix against the beam's differential equations in "
    "80-digit arithmetic, on the paper's 20 mm bimorph at 10 Hz.",
    [
        Check(
            f"Equation {equation} as printed is that of the beam's differential equations.",
            1.0, "1", partial(_as_printed, equation),
            explained=f"printed {MISPRINTS[equation].printed}; "
            f"right: {MISPRINTS[equation].correct}",
            known=deviation,
        )
        for equation, deviation in _DEVIATIONS.items()
    ],
    model="the audit of the printed formulas, of which notebook 2 shows what each does",
    source="the paper's Appendix A, equations 13 to 55", tolerance=1e-9,
    reason="what is right as printed agrees to 1e-11", tier="validation",
)  # fmt: skip

# --- benchmarks --------------------------------------------------------------------------------

_EXCHANGED = (
    "two digits exchanged: the closed form that gives all other entries of the table has 0.1242"
)
_HWANG = case(
    "HP", "PVDF bimorph (Tzou 1989, Hwang and Park 1993)",
    "100 x 5 x 1 mm, two layers of PVDF poled oppositely, E = 2 GPa, ν = 0, e31 = 0.046 C/m², 1 V "
    "across both, one end clamped: deflection along it, as most papers on piezoelectric elements "
    "tabulate it.",
    [
        Check(f"At {z} mm the table has {value} um.", value * 1e-6, "m",
               partial(pvdf_deflection, z * 1e-3, True), explained=_EXCHANGED if z == 60 else "",
               known=0.0147 if z == 60 else 0.0)
        for z, value in ((20, 0.0138), (40, 0.0552), (60, 0.1224), (80, 0.2208))
    ] + [
        Check("At 200 V the tip is printed to move by 69.00 um.", 69.00e-6, "m",
               lambda: 200.0 * pvdf_deflection(0.1, True)),
    ],
    model="bricks of the model solid, potential linear through the thickness",
    source="W.-S. Hwang, H. C. Park, AIAA J. 31 (1993) 930, table; 1.5 e31 V/E (z/h)² in closed "
    "form",
    tolerance=4e-3, reason="three printed digits in the first number", tier="validation",
)  # fmt: skip

_FEW_TERMS = (
    "a Ritz series with few terms is too stiff; converged thin-plate values are lower by as much"
)
_RITZ = (
    "the first five targets are the Ritz values of 1950 and 1951 (D. Young; M. V. Barton: λ² = "
    "3.494, 8.547, 21.44, 27.46, 31.17), the sixth (54.44) is as A. W. Leissa's of 1973; "
    + _FEW_TERMS
)


def _in_hertz(number: int) -> float:
    """Frequency (Hz) of the cantilevered plate."""
    return float(cantilever_plate()[number]) * THIN / (2.0 * math.pi)


_FV16 = case(
    "FV16M", "Cantilevered thin square plate: NAFEMS' targets",
    "The plate of case FV16, 10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, clamped along "
    "one edge: frequencies in hertz.",
    [
        Check(f"Target {at + 1} is {value} Hz.", value, "Hz", partial(_in_hertz, at),
               explained=_RITZ, known=known)
        for at, (value, known) in enumerate((
            (0.421, -0.0073), (1.029, -0.0056), (2.582, -0.0077),
            (3.306, -0.0102), (3.753, -0.0076), (6.555, -0.0060),
        ))
    ],
    model="bricks of the model solid, graded towards the clamp", source="NAFEMS R0015, test FV16",
    tolerance=2e-3, reason="four printed digits; a plate of h/a = 1/200", tier="validation",
)  # fmt: skip

_FV12 = case(
    "FV12M", "Free thin square plate: NAFEMS' closed-form targets",
    "The plate of case FV12, 10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, without "
    "supports: modes 7, 8 and 9.",
    [
        Check(f"The target of {mode} is {value} Hz.", value, "Hz",
               nth(free_plate, index), known=known,
               explained="the target is as that of a short series: " + _FEW_TERMS)
        for mode, index, value, known in (
            ("modes 7 and 8", 3, 4.233, -0.0104), ("mode 9", 5, 7.416, -0.0083),
        )
    ],
    model="bricks of the model solid", source="NAFEMS R0015, test FV12, column f*", tolerance=2e-3,
    reason="four printed digits; a plate of h/a = 1/200", tier="validation",
)  # fmt: skip

_VM156 = case(
    "VM156M", "Period on a hardening spring: ANSYS VM156's target",
    "2588e-6 on a spring of 2 x + 4 x³, let go at 1.",
    [
        Check("The period is 0.1447 s.", 0.1447, "s", period_of_vm156,
               explained="the elliptic integral of rows MOT-1 and HB-2 is the reference "
               "there, and the target is longer by this deviation", known=-4.53e-3),
    ],
    model="harmonic balance", source="ANSYS Verification Manual, VM156", tolerance=5e-4,
    reason="four printed digits", tier="validation",
)  # fmt: skip

CASES: tuple[Case, ...] = (_APPENDIX, _HWANG, CUBE, _FV16, _FV12, _VM156)
