"""Every check as one declarative row, in four tiers that are never mixed.

The test suite, the report and the documentation read the same rows.  A row that is known
not to agree says why; it is shown, not hidden, and not counted as passed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

from validation import measurements as m

Tier = Literal["code verification", "solution verification", "cross-model", "validation"]
Status = Literal["pass", "fail", "differs, explained"]


@dataclass(frozen=True)
class Check:
    """One requirement with its reference and its tolerance.

    Attributes
    ----------
    id, tier, requirement : str
        The requirement is a sentence.
    reference : float or (float, float)
        Reference value in `unit`, or the range in which the value must lie.
    tolerance : float
        Accepted relative deviation from the value, or beyond the range.
    reason : str
        Why the tolerance is what it is.
    measure : callable
        Computes the value.
    explained : str
        Why the row is known to differ; empty where it must pass.
    heavy : bool
        Whether it takes more than a few seconds.
    """

    id: str
    tier: Tier
    requirement: str
    reference: float | tuple[float, float]
    unit: str
    source: str
    tolerance: float
    reason: str
    measure: Callable[[], float]
    explained: str = ""
    heavy: bool = False


@dataclass(frozen=True)
class Outcome:
    """A check with what came out."""

    check: Check
    measured: float
    deviation: float
    status: Status


def run_check(check: Check) -> Outcome:
    """Measure one row."""
    measured = float(check.measure())
    deviation = _deviation(measured, check.reference)
    if abs(deviation) <= check.tolerance:
        status: Status = "pass"
    else:
        status = "differs, explained" if check.explained else "fail"
    return Outcome(check, measured, deviation, status)


def _deviation(measured: float, reference: float | tuple[float, float]) -> float:
    """Return the relative distance from a value, or from the nearer end of a range."""
    if not isinstance(reference, tuple):
        return measured / reference - 1.0
    nearest = min(max(measured, reference[0]), reference[1])
    return measured / nearest - 1.0


_EXACT = "60-digit solution of the beam's differential equations"
_FOUR_CODES = "consensus of four public finite element codes on identical meshes"
_J1_BAR = "the error wanted of this mesh level, plus the reference's own 3e-5"
_PRINT = "two printed digits, read off a figure by the authors"

CHECKS: tuple[Check, ...] = (
    Check(
        "TMM-1", "code verification",
        "The free 14 mm prototype at 1 V peaks at the frequency of the exact beam.",
        781.609168022148, "Hz", _EXACT, 1e-9, "the peak is located to 1e-9",
        m.prototype_peak_frequency,
    ),
    Check(
        "TMM-2", "code verification",
        "Its tip velocity at the peak is that of the exact beam.",
        0.0227950498840855, "m/s", _EXACT, 1e-9, "flat maximum, rounding only",
        m.prototype_peak_velocity,
    ),
    Check(
        "TMM-3", "code verification",
        "The clamped 20 mm bimorph's first short-circuit frequency is exact.",
        1044.1572903341285, "Hz", _EXACT, 1e-11, "rounding", m.clamped_short_circuit,
    ),
    Check(
        "TMM-4", "code verification",
        "The same at open circuit.",
        1097.2592983544860893, "Hz", _EXACT, 1e-11, "rounding", m.clamped_open_circuit,
    ),
    Check(
        "TMM-5", "code verification",
        "The clamped bimorph's static tip displacement per volt is -K l^2/(2 EI).",
        9.9110249742097564e-7, "m/V", "closed form", 1e-12, "rounding", m.clamped_static,
    ),
    Check(
        "FIN-1", "code verification",
        "The finger's fitted stiffness has its maximum where eqs 1-5 put it.",
        735.6, "N/m", "paper eqs 1-5, table 1", 1e-4, "four digits of the reference",
        m.finger_stiffness_maximum,
    ),
    Check(
        "BEA-1", "code verification",
        "Beam elements converge to the transfer-matrix model in their first frequency.",
        1044.1572903341285, "Hz", _EXACT, 1e-8, "20 elements of order five",
        m.beam_first_frequency,
    ),
    Check(
        "SOL-1", "code verification",
        "The solid's static tip deflection on job J1 (default mesh).",
        -6.7582e-7, "m/V", _FOUR_CODES, 1e-3, _J1_BAR, m.j1_default_deflection,
    ),
    Check(
        "SOL-2", "code verification",
        "The solid's first short-circuit frequency on job J1 (default mesh).",
        1065.96, "Hz", _FOUR_CODES, 1e-3, _J1_BAR, m.j1_default_first_frequency,
    ),
    Check(
        "SOL-3", "code verification",
        "The solid's static tip deflection on job J1 (fine mesh).",
        -6.7582e-7, "m/V", _FOUR_CODES, 2e-4, "the accuracy claimed for the fine mesh",
        m.j1_fine_deflection, heavy=True,
    ),
    *(
        Check(
            f"SOL-{4 + i}", "code verification",
            f"The solid's short-circuit frequency number {i + 1} on job J1 (fine mesh).",
            reference, "Hz", _FOUR_CODES, 2e-4, "the accuracy claimed for the fine mesh",
            partial(m.j1_fine_frequency, i), heavy=True,
        )
        for i, reference in enumerate((1065.96, 3329.10, 6642.85, 16267.0))
    ),
    Check(
        "X-1", "cross-model",
        "Lumped and transfer-matrix statics of the paper's bimorph are equal.",
        1.0, "1", "same theory", 1e-12, "rounding", m.lumped_over_tmm_static,
    ),
    Check(
        "X-2", "cross-model",
        "The lumped model's first frequency is close to the exact beam's.",
        1.0, "1", "model form: static shapes for the inertia", 0.01,
        "one element with consistent mass overestimates f1 by 0.5 % on a clamp",
        m.lumped_over_tmm_frequency,
    ),
    Check(
        "X-3", "cross-model",
        "A solid restricted to what a beam knows differs from TMM by the field's variation only.",
        1.0, "1", "closed form: layers stiffened by 1/(1 - k31^2)", 1e-3,
        "coarse mesh error plus the width of the clamp's end zone", m.bridge_unexplained,
    ),
    Check(
        "PAP-1", "validation",
        "The finger's stiffness maximum is about 750 N/m near 900 Hz.",
        750.0, "N/m", "paper section 7", 0.03, _PRINT, m.finger_stiffness_maximum,
    ),
    Check(
        "PAP-2", "validation",
        "The finger's damping starts at about 0.7 N s/m.",
        0.7, "N s/m", "paper section 7", 0.05, _PRINT, m.finger_damping_start,
        explained="the fit gives 0.82 N s/m at 10 Hz and passes 0.7 N s/m near 30 Hz; the text "
        "speaks of low frequencies in general",
    ),
    Check(
        "PAP-3", "validation",
        "At 10 Hz and 50 V the loaded 20 mm actuator deflects within the measured range "
        "with the normal actuator activated (13.6 to 72.4 um).",
        (13.6, 72.4), "um", "paper section 6, Fig 15 right", 0.0, "the measured range itself",
        m.paper_start_deflection,
    ),
    Check(
        "PAP-4", "validation",
        "Wired in series, it deflects within the range measured with the normal actuator "
        "not activated (3.1 to 24.8 um).",
        (3.1, 24.8), "um", "paper section 6, Fig 15 left", 0.0, "the measured range itself",
        m.series_start_deflection,
        explained="the paper does not state the wiring; series and parallel bracket its two ranges",
    ),
    Check(
        "PAP-5", "validation",
        "The voltage at which 2 um (threshold at the lowest frequency) is reached is about 8 V.",
        8.0, "V", "paper section 6, Fig 17", 0.1, _PRINT, m.threshold_voltage_start,
        explained="the model's finger was measured at 2.5 g preload with one pin; the display test "
        "pressed with 50 g on sixteen, and the rod's bearing was free to move: both take "
        "deflection away",
    ),
    Check(
        "PAP-6", "validation",
        "The voltage at which 0.2 um (the threshold at 250 Hz) is reached is about 3 V.",
        3.0, "V", "paper section 6, Fig 17", 0.1, _PRINT, m.threshold_voltage_250,
        explained="as PAP-5",
    ),
)  # fmt: skip
