"""The paper's matrix A (Appendix A), corrected, and each entry as it was printed.

Kept as the witness for the printed formulas: the production model is
:mod:`tmm.beam.transfer_matrix`, which does not lose digits at low or high frequency.
State [v, ψ̇, M, F, U] at the lower end to [v, ψ̇, M, F, I] at the upper end,
v and ψ̇ velocities, M and F internal, time factor e^{+jΩt}.

Of the equations around the appendix: the fifth entry of the state above in eq 9 is the
current I, printed U; the second "=" of eq 12 stands for a product, [L_m, 1] · A · [R_m, 1];
table 1's q1 … q3 carry degrees (° s³, ° s², ° s); c_sl is in N/m, printed Nm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.beam.sections import Section


@dataclass(frozen=True)
class Formula:
    """Numbered equation: printed form and, if it is wrong, the right one."""

    equation: int
    symbol: str
    printed: str
    correct: str = ""


#: Where each equation's entry stands in A, from 0.
PLACES: dict[int, tuple[int, int]] = {
    13: (0, 0), 14: (0, 1), 15: (1, 0), 16: (1, 1), 17: (2, 0), 18: (2, 1), 19: (3, 0),
    20: (3, 1), 21: (4, 0), 22: (4, 1), 23: (0, 2), 24: (0, 3), 25: (1, 2), 26: (1, 3),
    27: (2, 2), 28: (2, 3), 29: (3, 2), 30: (3, 3), 31: (4, 2), 32: (4, 3), 33: (0, 4),
    34: (1, 4), 35: (2, 4), 36: (3, 4), 37: (4, 4),
}  # fmt: skip

#: The system's equations, the entries of A, their functions and the section constants, with
#: b4 for beta^4, s and t for sigma and tau, L1 and L2 for the eigenvalues, W for Omega.
FORMULAS: tuple[Formula, ...] = (
    Formula(6, "R_m", "unit matrix, R32 from psi' to M, R41 from v to F"),
    Formula(7, "R41", "c_sl/jW"),
    Formula(8, "R32", "jW theta + d_s + c_s/jW"),
    Formula(
        9, "A", "[v, psi', M, F, U] = A [v, psi', M, F, U]", "the fifth entry on the left is I"
    ),
    Formula(10, "L_m", "unit matrix, L41 from v to F"),
    Formula(11, "L41", "d(f) + c(f)/jW"),
    Formula(12, "system", "[L_m, 1] A x = [L_m, 1] R_m x", "a product: [L_m, 1] A [R_m, 1] x"),
    Formula(13, "A11", "C0 - s C2"),
    Formula(14, "A12", "-l (C1 - (s + t) C3)"),
    Formula(15, "A21", "-b4/l C3"),
    Formula(16, "A22", "C0 - t C2"),
    Formula(17, "A31", "-b4 C2/(jW a)"),
    Formula(18, "A32", "l/(jW a) (-t C1 + (b4 + t^2) C3)"),
    Formula(19, "A41", "-b4 (C1 - s C3)/(jW a l)"),
    Formula(20, "A42", "b4 C2/(jW a)"),
    Formula(21, "A51", "K/l (-b4 C3 + s (-C1 + C4 + C3 (s + t)))"),
    Formula(22, "A52", "K (C5 - 1 + C2 s)"),
    Formula(23, "A13", "-jW a C2"),
    Formula(24, "A14", "-jW a l C3/b4 (-s C1 + C3 (b4 + s^2))", "without the factor C3 in front"),
    Formula(25, "A23", "jW a/l (C1 - t C3)"),
    Formula(26, "A24", "jW a C2"),
    Formula(27, "A33", "C0 - t C2"),
    Formula(28, "A34", "l (C1 - C3 (s + t))"),
    Formula(29, "A43", "b4/l C3"),
    Formula(30, "A44", "C0 - s C2"),
    Formula(31, "A53", "jW a K/l (C4 + C3 s)"),
    Formula(32, "A54", "jW a K C2"),
    Formula(33, "A15", "-jW a K C2"),
    Formula(34, "A25", "jW a K/l (C4 + C3 s)"),
    Formula(35, "A35", "K (C5 - 1 + C2 s)"),
    Formula(36, "A45", "-b4/l K C3", "+b4/l K C3 (reciprocity with A51)"),
    Formula(37, "A55", "jW C_p + jW/l a K^2 (C4 + C3 s)"),
    Formula(38, "C0", "(L2^2 cosh L1 + L1^2 cos L2)/(L1^2 + L2^2)"),
    Formula(39, "sigma", "m W^2 l^2/EI", "m W^2 l^2/GA"),
    Formula(40, "C1", "(L2^2/L1 sinh L1 + L1^2/L2 sin L2)/(L1^2 + L2^2)"),
    Formula(41, "tau", "rhoI W^2 l^2/GA", "rhoI W^2 l^2/EI"),
    Formula(42, "C2", "(cosh L1 - cos L2)/(L1^2 + L2^2)"),
    Formula(43, "beta^4", "m W^2 l^4/EI"),
    Formula(44, "C3", "(sinh L1/L1 - sin L2/L2)/(L1^2 + L2^2)"),
    Formula(45, "a", "l^2/EI"),
    Formula(46, "C4", "(L1 sinh L1 + L2 sin L2)/(L1^2 + L2^2)"),
    Formula(
        47,
        "L1, L2",
        "sqrt(sqrt(b4 + (s - t)^2/4) -+ (s - t)/2)",
        "sqrt(sqrt(b4 + (s - t)^2/4) -+ (s + t)/2)",
    ),
    Formula(48, "C5", "(L1^2 cosh L1 + L2^2 cos L2)/(L1^2 + L2^2)"),
    Formula(
        49,
        "rhoI",
        "b rho_s h_s^3/12 + 2/3 b rho_p ((h_p + h_s/s)^3 - (h_s/2)^3)",
        "h_s/2 in place of h_s/s",
    ),
    Formula(50, "GA", "k^2 b (G h_s + 2 h_p/s55)"),
    Formula(51, "EI", "b (h_s^3/(12 s_ES) + 2/(3 s_EP) ((h_s/2 + h_p)^3 - (h_s/2)^3))"),
    Formula(52, "s_EP", "((1 + j/Q)/s11)^-1"),
    Formula(53, "m", "b (rho_s h_s + 2 rho_p h_p)"),
    Formula(54, "K", "b d31/s_EP (h_s + h_p)"),
    Formula(
        55, "C_p", "2 l b (eps (1 + j tan d) - d31^2/s_EP)/h_p", "eps (1 - j tan d) for exp(+jWt)"
    ),
)

#: What is wrong in the printed text and enters a number (whether the authors' or the
#: typesetting's slip is not known).
MISPRINTS: dict[int, Formula] = {
    f.equation: f for f in FORMULAS if f.correct and f.equation not in (9, 12)
}


def printed_section(beam: Section, device: Device, misprints: frozenset[int]) -> Section:
    """Section with eqs 49 and 55 as printed where asked for.

    Eq 49's "s" is read as 1, the only reading with which it has a value at all.
    """
    b, hp, hs = (
        device.bimorph.width,
        device.bimorph.piezo_thickness,
        device.bimorph.shim_thickness,
    )
    piezo = device.piezo
    if 49 in misprints:
        cubes = (hp + hs) ** 3 - (hs / 2.0) ** 3
        rho_i = b * (device.shim.density * hs**3 / 12.0 + 2.0 / 3.0 * piezo.density * cubes)
        beam = replace(beam, rhoI=rho_i)
    if 55 in misprints:
        active = 4j * b / hp * piezo.eps33 * EPS0 * piezo.loss_tangent
        beam = replace(beam, C=beam.C + active)
    return beam


def matrix_a(
    beam: Section, length: float, frequencies: Floats, misprints: frozenset[int] = frozenset()
) -> Complex:
    """A (n, 5, 5) of paper eqs 13-48, with the named equations as printed.

    Parameters
    ----------
    beam : Section
        Section constants; see :func:`printed_section` for eqs 49 and 55.
    length : float
        Beam length (m).
    frequencies : (n,) array
        Frequencies (Hz), greater than 0.
    misprints : frozenset of int
        Equations to take as printed (24, 36, 39, 41, 47).
    """
    jw = 2j * np.pi * np.asarray(frequencies, dtype=float)
    l, k, a = length, beam.K, length**2 / beam.EI
    sigma, tau, beta4 = wave_parameters(beam, length, frequencies, misprints)
    c0, c1, c2, c3, c4, c5 = functions(sigma, tau, beta4, as_printed=47 in misprints)

    out = np.empty((jw.size, 5, 5), dtype=complex)
    out[:, 0, 0] = out[:, 3, 3] = c0 - sigma * c2
    out[:, 0, 1] = -l * (c1 - (sigma + tau) * c3)
    out[:, 0, 2] = -jw * a * c2
    out[:, 0, 3] = -jw * a * l / beta4 * (-sigma * c1 + c3 * (beta4 + sigma**2))
    if 24 in misprints:
        out[:, 0, 3] *= c3
    out[:, 0, 4] = -jw * a * k * c2
    out[:, 1, 0] = -beta4 / l * c3
    out[:, 1, 1] = out[:, 2, 2] = c0 - tau * c2
    out[:, 1, 2] = jw * a / l * (c1 - tau * c3)
    out[:, 1, 3] = jw * a * c2
    out[:, 1, 4] = jw * a * k / l * (c4 + c3 * sigma)
    out[:, 2, 0] = -beta4 * c2 / (jw * a)
    out[:, 2, 1] = l / (jw * a) * (-tau * c1 + (beta4 + tau**2) * c3)
    out[:, 2, 3] = l * (c1 - c3 * (sigma + tau))
    out[:, 2, 4] = k * (c5 - 1.0 + c2 * sigma)
    out[:, 3, 0] = -beta4 * (c1 - sigma * c3) / (jw * a * l)
    out[:, 3, 1] = beta4 * c2 / (jw * a)
    out[:, 3, 2] = beta4 / l * c3
    out[:, 3, 4] = beta4 / l * k * c3 * (-1.0 if 36 in misprints else 1.0)
    out[:, 4, 0] = k / l * (-beta4 * c3 + sigma * (-c1 + c4 + c3 * (sigma + tau)))
    out[:, 4, 1] = k * (c5 - 1.0 + c2 * sigma)
    out[:, 4, 2] = jw * a * k / l * (c4 + c3 * sigma)
    out[:, 4, 3] = jw * a * k * c2
    out[:, 4, 4] = jw * beam.C * l + jw / l * a * k**2 * (c4 + c3 * sigma)
    return out


def wave_parameters(
    beam: Section, length: float, frequencies: Floats, misprints: frozenset[int] = frozenset()
) -> tuple[Complex, Complex, Complex]:
    """Σ, τ and β⁴ (n,) of paper eqs 39, 41 and 43."""
    o2 = (2.0 * np.pi * np.asarray(frequencies, dtype=float)) ** 2
    of_sigma = beam.EI if 39 in misprints else beam.GA
    of_tau = beam.GA if 41 in misprints else beam.EI
    return (
        beam.m * o2 * length**2 / of_sigma + 0j,
        beam.rhoI * o2 * length**2 / of_tau + 0j,
        beam.m * o2 * length**4 / beam.EI + 0j,
    )


def eigenvalues(
    sigma: Complex, tau: Complex, beta4: Complex, *, as_printed: bool = False
) -> tuple[Complex, Complex]:
    """Λ₁ and λ₂ (n,) of paper eq 47."""
    inner = np.sqrt(beta4 + 0.25 * (sigma - tau) ** 2)
    outer = 0.5 * ((sigma - tau) if as_printed else (sigma + tau))
    return np.sqrt(inner - outer), np.sqrt(inner + outer)


def functions(
    sigma: Complex, tau: Complex, beta4: Complex, *, as_printed: bool = False
) -> tuple[Complex, ...]:
    """C0 … C5 (n,), paper eqs 38-48; `as_printed` takes eq 47 so."""
    x, y = eigenvalues(sigma, tau, beta4, as_printed=as_printed)
    total = x**2 + y**2
    cosh, cos, sinh, sin = np.cosh(x), np.cos(y), np.sinh(x), np.sin(y)
    return (
        (y**2 * cosh + x**2 * cos) / total,
        (y**2 / x * sinh + x**2 / y * sin) / total,
        (cosh - cos) / total,
        (sinh / x - sin / y) / total,
        (x * sinh + y * sin) / total,
        (x**2 * cosh + y**2 * cos) / total,
    )


def from_dynamic_stiffness(stiffness: Complex, frequencies: Floats) -> Complex:
    """Transfer matrix A (n, 5, 5) that belongs to D(Ω): a change of variables.

    Internal force and moment at the lower end are minus the port's; velocities are jΩ
    times displacements, current jΩ times charge.
    """
    jw = 2j * np.pi * np.asarray(frequencies, dtype=float)
    # state z = [w, psi, M, F] below; unknown above; solve D for the upper state
    d = stiffness
    n = jw.size
    state = np.zeros((n, 5, 5), dtype=complex)  # columns: unit w, psi, M, F, U below
    minus = np.zeros((n, 2, 5), dtype=complex)
    minus[:, 0, 3] = minus[:, 1, 2] = -1.0  # F_base = -F(0), M_base = -M(0)
    known = np.zeros((n, 3, 5), dtype=complex)
    known[:, 0, 0] = known[:, 1, 1] = known[:, 2, 4] = 1.0
    cols = [0, 1, 4]
    top = np.linalg.solve(d[:, :2, 2:4], minus - d[:, :2][:, :, cols] @ known)
    forces = d[:, 2:4][:, :, cols] @ known + d[:, 2:4, 2:4] @ top
    charge = d[:, 4:][:, :, cols] @ known + d[:, 4:, 2:4] @ top
    state[:, :2], state[:, 2], state[:, 3] = top, forces[:, 1], forces[:, 0]
    state[:, 4] = charge[:, 0]
    left = np.ones((n, 5), dtype=complex)
    left[:, :2] = left[:, 4:] = jw[:, None]
    right = np.ones((n, 5), dtype=complex)
    right[:, :2] = 1.0 / jw[:, None]
    return np.asarray(left[:, :, None] * state * right[:, None, :])
