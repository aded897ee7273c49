"""Every numbered formula of the paper's model, as printed, against the exact one.

Two questions per formula.  Is it right: its value as printed, in double precision and with
everything else right, against the 80-digit solution of the beam's differential equations
(:mod:`validation.evidence.cases.exact_beam`); a right one leaves rounding.  Does it matter: what
it does, alone as printed, to tip velocity and current of the actuator under the finger,
computed as the paper does it, with transfer matrices (eqs 6-12).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mpmath as mp
import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam.printed_formulas import (
    FORMULAS,
    MISPRINTS,
    PLACES,
    Formula,
    eigenvalues,
    functions,
    matrix_a,
    printed_section,
    wave_parameters,
)
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.beam.sections import section as section_constants
from tactgen.tmm.ports.finger_and_pad import finger_impedance
from tactgen.tmm.ports.supports_and_loads import base_stiffness, ends_of, tip_stiffness
from tactgen.validation.evidence.cases import exact_beam as reference
from tactgen.validation.evidence.cases import textbook_beam
from tactgen.validation.scene.scene import Scene


def _section_errors(device: Device, beam: Section, assumed: Beam) -> dict[int, float]:
    """Relative errors of eqs 49-55 as printed: ρI, GA, EI, s_EP, m, K and C_p."""
    piezo, length = device.piezo, device.bimorph.length
    exact = reference.bimorph_constants(device, assumed)
    compliance = mp.mpf(piezo.s11) / (1 + mp.j / mp.mpf(piezo.quality_factor))
    inertia, capacitor = (printed_section(beam, device, frozenset({n})) for n in (49, 55))
    printed_and_exact = {
        49: (inertia.rhoI, exact.rhoI),
        50: (beam.GA, exact.GA),
        51: (beam.EI, exact.EI),
        52: (piezo.s11 / (1.0 + 1j / piezo.quality_factor), compliance),
        53: (beam.m, exact.m),
        54: (-device.bimorph.poling_sign * beam.K, exact.K),  # printed for poling towards −x
        55: (capacitor.C * length, exact.C * mp.mpf(length)),
    }
    return {n: reference.relative_error(*both) for n, both in printed_and_exact.items()}


def _exact_formulas(
    support: Support, beam: Section, length: float, frequency: float
) -> dict[int, tuple[Any, ...]]:
    """Values of eqs 7, 8, 11 and 13-48 at a frequency (Hz), by equation number.

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
    entries = {
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
    return entries | {
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
        46: (t[1, 5] * l / (a * c.K) - c3 * sigma,),
        47: (mp.acosh((half_trace + apart) / 2), mp.acos((half_trace - apart) / 2)),
        48: (t[2, 5] / c.K + 1 - sigma * c2,),
    }


#: Frequencies at which the effects are stated (Hz).
AT = np.array([10.0, 100.0, 500.0, 1000.0])
#: Frequencies at which formulas are held against the exact solution (Hz).
_COMPARED = np.unique(np.concatenate([AT, np.geomspace(10.0, 1000.0, 9)]))


@dataclass(frozen=True)
class AuditRow:
    """Formula with its error and its effect."""

    formula: Formula  #: Equation number, symbol, printed and correct form
    #: Largest relative deviation of the printed formula from the exact value over 10 to 1000 Hz;
    #: None where it is a matrix of other formulas
    deviation: float | None
    #: (n,) Relative size of the complex change of tip velocity and current at :data:`AT` when this
    #: formula alone is taken as printed; None where it is right
    velocity: Floats | None = None
    current: Floats | None = None


@dataclass(frozen=True)
class Audit:
    """All formulas, the effect of all misprints, and the rest without them.

    `residual` is the largest relative deviation of the corrected chain's tip velocity and
    current from the 80-digit solution at :data:`AT`.
    """

    rows: tuple[AuditRow, ...]
    velocity: Floats  #: (n,) Relative size of the change that all misprints make
    residual: float

    def row(self, equation: int) -> AuditRow:
        """Row of an equation."""
        return next(row for row in self.rows if row.formula.equation == equation)


def audit(scene: Scene) -> Audit:
    """Hold every formula against the exact one, for the scene's uniform bimorph.

    As the paper has it: on the springs (the paper's, unless the scene states its own), under the
    finger.
    """
    length = scene.bimorph.length
    beam = section_constants(Piece("bimorph", length), scene.device, scene.beam, lossy=True)
    correct = _response(scene, beam, frozenset())

    def change(*misprints: int) -> Floats:
        """Relative size (2, n) of the change of tip velocity and current."""
        return np.asarray(np.abs(_response(scene, beam, frozenset(misprints)) / correct - 1.0))

    with mp.workdps(reference.DIGITS):
        deviations = _deviations(scene, beam)
    rows = []
    for formula in FORMULAS:
        number = formula.equation
        effect = change(number) if number in MISPRINTS else (None, None)
        rows.append(AuditRow(formula, deviations.get(number), *effect))
    return Audit(tuple(rows), change(*MISPRINTS)[0], _residual(scene, beam, correct))


def _response(scene: Scene, beam: Section, misprints: frozenset[int]) -> Complex:
    """Tip velocity and current (2, n) per volt from A with springs and finger."""
    beam = printed_section(beam, scene.device, misprints)
    a = matrix_a(beam, scene.bimorph.length, AT, misprints)
    lateral, rotational, load = _ends(scene, AT)
    return textbook_beam.response(a, AT, base=(lateral, rotational), tip=load)


def _ends(scene: Scene, frequencies: Floats) -> tuple[Complex, Complex, Complex]:
    """Springs' two dynamic stiffnesses and the finger's, (n,) each."""
    support = scene.support.model_copy(update={"kind": "spring"})
    load = scene.load.model_copy(update={"kind": "finger"})
    ends = ends_of(support, load)
    assert ends.base is not None
    return *base_stiffness(ends.base, frequencies), tip_stiffness(ends.tip, frequencies)


def _residual(scene: Scene, beam: Section, correct: Complex) -> float:
    errors = []
    for i, frequency in enumerate(AT):
        omega = 2 * mp.pi * mp.mpf(float(frequency))
        d = reference.dynamic_stiffness(reference.constants(beam), scene.bimorph.length, omega)
        lateral, rotational, load = (complex(v[0]) for v in _ends(scene, AT[i : i + 1]))
        exactly = reference.tip_motion(d, (lateral, rotational), load)[:2]
        for value, exact in zip(correct[:, i], exactly, strict=True):
            errors.append(reference.relative_error(value, mp.j * omega * exact))
    return max(errors)


def _deviations(scene: Scene, beam: Section) -> dict[int, float]:
    """Largest relative deviation of each formula as printed."""
    found = _section_errors(scene.device, beam, scene.beam)
    by_frequency = _printed_formulas(scene, beam)
    for i, frequency in enumerate(_COMPARED):
        exact_here = _exact_formulas(scene.support, beam, scene.bimorph.length, frequency)
        for equation, exacts in exact_here.items():
            here = [
                reference.relative_error(value[i], exact)
                for value, exact in zip(by_frequency[equation], exacts, strict=True)
            ]
            found[equation] = max(found.get(equation, 0.0), *here)
    return found


def _printed_formulas(scene: Scene, beam: Section) -> dict[int, tuple[Complex, ...]]:
    """Values (n,) of eqs 7-48 as printed, each with all others right."""
    f, length = _COMPARED, scene.bimorph.length
    jw = 2j * np.pi * f
    lateral, rotational, load = _ends(scene, f)
    right = wave_parameters(beam, length, f)
    found: dict[int, tuple[Complex, ...]] = {
        7: (lateral / jw,), 8: (rotational / jw,), 11: (load / jw,),
        39: (wave_parameters(beam, length, f, frozenset({39}))[0],),
        41: (wave_parameters(beam, length, f, frozenset({41}))[1],),
        43: (right[2],),
        45: (np.full(f.size, length**2 / beam.EI),),
        47: eigenvalues(*right, as_printed=True),
    }  # fmt: skip
    for equation, value in zip((38, 40, 42, 44, 46, 48), functions(*right), strict=True):
        found[equation] = (value,)
    for equation, (i, j) in PLACES.items():
        misprint = frozenset({equation}) & set(MISPRINTS)
        found[equation] = (matrix_a(beam, length, f, misprint)[:, i, j],)
    return found
