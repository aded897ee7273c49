"""The paper's matrix A (Appendix A), corrected, and each entry as it was printed.

Kept as the witness for the printed formulas: the production model is
:mod:`tmm.transfer_matrix`, which does not lose digits at low or high frequency.
State [v, ψ̇, M, F, U] at the lower end to [v, ψ̇, M, F, I] at the upper end,
v and ψ̇ velocities, M and F internal, time factor e^{+jΩt}.

Of the equations around the appendix: the fifth entry of the state above in eq 9 is the
current I, printed U; the second "=" of eq 12 stands for a product, [L_m, 1] · A · [R_m, 1];
table 1's q1 … q3 carry degrees (° s³, ° s², ° s); c_sl is in N/m, printed Nm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Complex, Floats
from geometry.materials import EPS0
from geometry.parameters import Device
from tmm.section import Section


@dataclass(frozen=True)
class Misprint:
    """One entry of Appendix A that does not follow from the beam's equations."""

    equation: str
    printed: str
    correct: str


#: What is wrong in the printed text (whether the authors' or the typesetting's slip is
#: not known).
MISPRINTS: dict[int, Misprint] = {
    24: Misprint(
        "24", "A14 = -jW a l C3/b4 (-s C1 + C3 (b4 + s^2))", "without the first factor C3"
    ),
    36: Misprint("36", "A45 = -b4/l K C3", "+b4/l K C3 (reciprocity with A51)"),
    39: Misprint(
        "39, 41",
        "s = m W^2 l^2/EI, t = rhoI W^2 l^2/GA",
        "denominators exchanged: s = m W^2 l^2/GA, t = rhoI W^2 l^2/EI",
    ),
    47: Misprint("47", "-+ (s - t)/2 outside the inner root", "-+ (s + t)/2 outside"),
    49: Misprint("49", "(h_p + h_s/s)^3", "(h_p + h_s/2)^3"),
    55: Misprint("55", "eps^T (1 + j tan d)", "eps^T (1 - j tan d) for exp(+jWt)"),
}


def printed_section(beam: Section, device: Device, misprints: frozenset[int]) -> Section:
    """Return the section with eqs 49 and 55 as printed where asked for.

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
    beam: Section,
    length: float,
    frequencies: Floats,
    misprints: frozenset[int] = frozenset(),
) -> Complex:
    """Return A (n, 5, 5) of paper eqs 13-48, with the named equations as printed.

    Parameters
    ----------
    beam : Section
        Section constants; see :func:`printed_section` for eqs 49 and 55.
    length : float
        Beam length (m).
    frequencies : (n,) array
        Frequencies (Hz), greater than 0.
    misprints : frozenset of int
        Equations to take as printed (24, 36, 39 with 41, 47).
    """
    jw = 2j * np.pi * np.asarray(frequencies, dtype=float)
    o2, l, k, a = (jw.imag) ** 2, length, beam.K, length**2 / beam.EI
    beta4 = beam.m * o2 * l**4 / beam.EI + 0j
    stiff, shear = (beam.GA, beam.EI) if 39 not in misprints else (beam.EI, beam.GA)
    sigma = beam.m * o2 * l**2 / stiff + 0j
    tau = beam.rhoI * o2 * l**2 / shear + 0j
    c0, c1, c2, c3, c4, c5 = _functions(sigma, tau, beta4, as_printed=47 in misprints)

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


def _functions(
    sigma: Complex, tau: Complex, beta4: Complex, *, as_printed: bool
) -> tuple[Complex, ...]:
    """Return C0 … C5 (paper eqs 38-48)."""
    inner = np.sqrt(beta4 + 0.25 * (sigma - tau) ** 2)
    outer = 0.5 * ((sigma - tau) if as_printed else (sigma + tau))
    x, y = np.sqrt(inner - outer), np.sqrt(inner + outer)
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
    """Return the transfer matrix A (n, 5, 5) that belongs to D(Ω): a change of variables.

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
