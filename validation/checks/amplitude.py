"""The checks of large amplitudes as declarative rows; see :mod:`validation.checks.row`."""

from __future__ import annotations

from functools import partial

from tactgen.validation.checks import amplitude_measurements as m
from tactgen.validation.checks.row import Check

_NLVIB = "NLvib, example 01 (Krack and Gross): digits that 7 and 15 harmonics share"
_ELLIPTIC = "closed form, elliptic integral of the first kind"

#: Ratio of the stiffnesses of a one-sided spring, with the error of so many harmonics.
_CONTACT = ((1e-2, 1e-8), (1e2, 1e-4), (1e6, 1e-3))

AMPLITUDE_CHECKS: tuple[Check, ...] = (
    Check(
        "HB-1", "code verification",
        "A mass on a linear and a cubic spring, five times as stiff at its turning point: its free "
        "angular frequency.",
        4.357461857, "rad/s", _ELLIPTIC, 3e-10, "ten digits of the reference",
        m.strong_cubic_frequency,
    ),
    Check(
        "HB-2", "code verification",
        "The period of the mass on a hardening spring of VM156 (its manual says 0.1447 s).",
        0.144043869, "s", _ELLIPTIC, 4e-9, "nine digits of the reference", m.vm156_period,
    ),
    Check(
        "HB-3", "code verification",
        "The driven Duffing oscillator's first harmonic at its peak.",
        2.83019806, "1", _NLVIB, 2e-9, "nine digits of the reference", m.duffing_peak_height,
    ),
    Check(
        "HB-4", "code verification",
        "The angular frequency of that peak.",
        1.26871674, "rad/s", _NLVIB, 4e-9, "nine digits of the reference", m.duffing_peak_place,
    ),
    *(
        Check(
            f"HB-{5 + i}", "code verification",
            f"The angular frequency at which the response jumps {way}.",
            reference, "rad/s", _NLVIB, 4e-6, "six digits of the reference",
            partial(m.duffing_fold, i),
        )
        for i, (reference, way) in enumerate(((1.26960, "down"), (1.11570, "up")))
    ),
    *(
        Check(
            f"HB-{7 + i}", "code verification",
            f"A spring {ratio:g} times stiffer on one side: its free angular frequency over the "
            "exact one.",
            1.0, "1", "closed form: half a period on each side", tolerance,
            "at most 160 harmonics of a force with a kink", partial(m.one_sided, ratio),
        )
        for i, (ratio, tolerance) in enumerate(_CONTACT)
    ),
)  # fmt: skip
