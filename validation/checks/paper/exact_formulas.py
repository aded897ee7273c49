"""Exact values, 80 digits, of the quantities that the paper's formulas stand for.

Nothing here uses those formulas.  The section constants are integrals over the layers.
The entries of A are those of the matrix exponential of the beam's differential equations,
and σ, τ, β⁴, λ and C0 … C5 are solved for from its entries, given only l, EI and K.
"""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np

from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam.printed_formulas import PLACES
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.ports.finger import finger_impedance
from tactgen.validation.checks.cases import reference_beam as reference


def section_formulas(device: Device, beam: Beam) -> dict[int, Any]:
    """Return ρI, GA, EI, s_EP, m, K and C_p by the paper's equation numbers."""
    with mp.workdps(reference.DIGITS):
        return _section_formulas(device, beam)


def frequency_formulas(
    support: Support, beam: Section, length: float, frequency: float
) -> dict[int, tuple[Any, ...]]:
    """Return the values of eqs 7, 8, 11 and 13-48 at a frequency (Hz), by equation number.

    Eqs 46 and 48 are left out without piezoelectric coupling.
    """
    with mp.workdps(reference.DIGITS):
        return _frequency_formulas(support, beam, length, frequency)


def _section_formulas(device: Device, beam: Beam) -> dict[int, Any]:
    piezo = device.piezo
    found = reference.bimorph_constants(reference.Layers.of(device, beam))
    compliance = mp.mpf(piezo.s11) / (1 + mp.j / mp.mpf(piezo.quality_factor))
    return {
        49: found.rhoI,
        50: found.GA,
        51: found.EI,
        52: compliance,
        53: found.m,
        54: found.K,
        55: found.C * mp.mpf(device.bimorph.length),
    }


def _frequency_formulas(
    support: Support, beam: Section, length: float, frequency: float
) -> dict[int, tuple[Any, ...]]:
    """Solve for them.

    From T over [w, ψ, M, F, q, U]: C2 = −T_wM/a, β⁴ = −T_Fψ a²/T_wM, C3 = T_FM l/β⁴,
    σ C3 = T_ψM l/a − T_MF/l, τ C3 = −T_Fw a l/β⁴ − T_MF/l, and so on; cosh λ₁ and cos λ₂
    from the traces of T and T².
    """
    f, l = mp.mpf(float(frequency)), mp.mpf(length)
    jw = 2j * mp.pi * f
    c = reference.constants(beam)
    t = reference.transfer(c, l, 2 * mp.pi * f)
    rates = (jw, jw, 1, 1, jw)
    places = (0, 1, 2, 3, 5)
    found: dict[int, tuple[Any, ...]] = {
        equation: (t[i, places[j]] * rates[i] / (1 if j in (2, 3, 4) else jw),)
        for equation, (i, j) in PLACES.items()
    }
    a = l**2 / c.EI
    beta4 = -t[3, 1] * a**2 / t[0, 2]
    c2, c3 = -t[0, 2] / a, t[3, 2] * l / beta4
    sigma = (t[1, 2] * l / a - t[2, 3] / l) / c3
    tau = (-t[3, 0] * a * l / beta4 - t[2, 3] / l) / c3
    c0, c1 = t[0, 0] + sigma * c2, t[2, 3] / l + c3 * (sigma + tau)
    half_trace = sum(t[i, i] for i in range(4)) / 2
    squares = sum(t[i, j] * t[j, i] for i in range(4) for j in range(4)) / 4 + 1
    # cosh λ₁ and cos λ₂ have this sum, and these squares' sum
    apart = mp.sqrt(2 * squares - half_trace**2)
    found |= {
        7: (mp.mpf(support.lateral_stiffness) / jw,),
        8: (
            jw * mp.mpf(support.rotational_inertia)
            + mp.mpf(support.rotational_damping)
            + mp.mpf(support.rotational_stiffness) / jw,
        ),
        11: (mp.mpmathify(complex(finger_impedance(np.array(frequency)))),),
        38: (c0,),
        39: (sigma,),
        40: (c1,),
        41: (tau,),
        42: (c2,),
        43: (beta4,),
        44: (c3,),
        45: (a,),
        47: (mp.acosh((half_trace + apart) / 2), mp.acos((half_trace - apart) / 2)),
    }
    if c.K != 0:  # the electrical entries alone hold C4 and C5
        found[46] = (t[1, 5] * l / (a * c.K) - c3 * sigma,)
        found[48] = (t[2, 5] / c.K + 1 - sigma * c2,)
    return found
