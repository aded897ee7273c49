"""The multiport that every model of the lateral actuator reduces to, and its algebra.

    [F_base, M_base, F_tip, M_tip, Q] = D(Ω) · [w_base, ψ_base, w_tip, ψ_tip, U]

Displacement and charge, complex peak amplitudes, time factor e^{+jΩt}.  Forces and
moments act on the model from outside, each work-conjugate to its displacement; the
shear angle is γ = w' + ψ, so ψ ≈ −w' for a slender beam and u_z = x ψ in a section.
Support, load and wiring are attached here, in a few operations per frequency, and
never need a new field solution.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Complex, Floats
from geometry.store.values import storable

#: Positions of the ports' displacement-like variables.
W_BASE, PSI_BASE, W_TIP, PSI_TIP, VOLTAGE = range(5)


@storable
@dataclass(frozen=True)
class Multiport:
    """Dynamic stiffness over the five ports.

    Attributes
    ----------
    frequencies : (n,) array
        Frequencies (Hz); 0 is allowed, the static limit is finite.
    stiffness : (n, 5, 5) complex array
        D(Ω): N/m, N, N m; the last row and column carry C/m, C and F.
    """

    frequencies: Floats
    stiffness: Complex

    @property
    def omega(self) -> Floats:
        """Angular frequencies (n,) in rad/s."""
        return 2.0 * np.pi * self.frequencies


@dataclass(frozen=True)
class Termination:
    """What is attached to the mechanical ports: dynamic stiffnesses, (n,) complex arrays.

    `base` is None for a rigid clamp, else (lateral N/m, rotational N m/rad).
    `tip` is the lateral dynamic stiffness of the load (N/m).
    """

    base: tuple[Complex, Complex] | None
    tip: Complex


@dataclass(frozen=True)
class Response:
    """Amplitudes at the ports under a drive voltage, (n,) complex arrays in SI units."""

    frequencies: Floats
    w_base: Complex
    psi_base: Complex
    w_tip: Complex
    psi_tip: Complex
    charge: Complex


def in_series(port: Multiport) -> Multiport:
    """Return the port seen when the two equal layers are wired in series.

    Each layer then takes half the voltage and both carry the same charge.  Exact for
    a device that is mirror-symmetric about x = 0.
    """
    half = np.array([1.0, 1.0, 1.0, 1.0, 0.5])
    return replace(port, stiffness=port.stiffness * half[:, None] * half)


def respond(port: Multiport, termination: Termination, voltage: float) -> Response:
    """Return the response to a voltage amplitude (V), free of other forces."""
    d = _terminated(port, termination)
    n = port.frequencies.size
    free = [W_TIP, PSI_TIP] if termination.base is None else [0, 1, 2, 3]
    x = np.zeros((n, 4), dtype=complex)
    x[:, free] = _balanced_solve(d[:, free][:, :, free], -d[:, free, VOLTAGE])
    charge = np.einsum("ni,ni->n", d[:, VOLTAGE, :4], x) + d[:, VOLTAGE, VOLTAGE]
    w_base, psi_base, w_tip, psi_tip = (x * voltage).T
    return Response(port.frequencies, w_base, psi_base, w_tip, psi_tip, charge * voltage)


def blocked_force(port: Multiport, termination: Termination, voltage: float) -> Complex:
    """Return the force (n,) in N that holds the tip at w = 0, its rotation left free.

    The force acts on the actuator, so its sign is opposite to the free motion's.
    """
    d = _terminated(port, termination)
    free = [PSI_TIP] if termination.base is None else [W_BASE, PSI_BASE, PSI_TIP]
    x = _balanced_solve(d[:, free][:, :, free], -d[:, free, VOLTAGE])
    force = np.einsum("ni,ni->n", port.stiffness[:, W_TIP][:, free], x)
    return np.asarray((force + port.stiffness[:, W_TIP, VOLTAGE]) * voltage)


def _terminated(port: Multiport, termination: Termination) -> Complex:
    d = port.stiffness.copy()
    if termination.base is not None:
        lateral, rotational = termination.base
        d[:, W_BASE, W_BASE] += lateral
        d[:, PSI_BASE, PSI_BASE] += rotational
    d[:, W_TIP, W_TIP] += termination.tip
    return d


def _balanced_solve(matrix: Complex, right: Complex) -> Complex:
    """Solve (n, k, k) systems after scaling rows and columns by the diagonal.

    Displacements (m) and rotations (rad) differ by the length of the beam; without the
    scaling the condition number is mostly a matter of units.
    """
    scale = _scale(matrix)
    scaled = matrix * scale[:, :, None] * scale[:, None, :]
    solution = np.linalg.solve(scaled, (right * scale)[..., None])[..., 0]
    return np.asarray(solution * scale)


def _scale(matrix: Complex) -> Floats:
    largest = np.abs(matrix).max(axis=2)
    return np.asarray(1.0 / np.sqrt(np.where(largest > 0.0, largest, 1.0)))


def round_off(port: Multiport, termination: Termination) -> Floats:
    """Return a relative round-off bound (n,): machine epsilon times the condition number.

    The condition number is that of the balanced matrix which :func:`respond` solves.
    """
    d = _terminated(port, termination)
    free = [W_TIP, PSI_TIP] if termination.base is None else [0, 1, 2, 3]
    matrix = d[:, free][:, :, free]
    scale = _scale(matrix)
    scaled = matrix * scale[:, :, None] * scale[:, None, :]
    return np.asarray(np.linalg.cond(scaled) * np.finfo(float).eps)


def passivity_margin(port: Multiport) -> Floats:
    """Return the smallest eigenvalue (n,) of the dissipation form, scaled to the largest.

    With S the symmetric form (the charge row of D negated) the mean power taken in is
    ½ Ω Im(xᴴ S x); a passive model has Im S positive semidefinite, so the margin is ≥ 0
    up to rounding.
    """
    s = symmetric_form(port.stiffness)
    scale = _scale(s)
    scaled = s * scale[:, :, None] * scale[:, None, :]
    eigenvalues = np.linalg.eigvalsh(0.5 * (scaled.imag + scaled.imag.transpose(0, 2, 1)))
    return np.asarray(eigenvalues[:, 0] / np.maximum(np.abs(eigenvalues).max(axis=1), 1e-300))


def symmetric_form(stiffness: Complex) -> Complex:
    """Return D with the charge row negated: symmetric if and only if D is reciprocal."""
    s = stiffness.copy()
    s[:, VOLTAGE] *= -1.0
    return s


def reciprocity_error(port: Multiport) -> Floats:
    """Return max |S − Sᵀ| (n,), each entry relative to its two diagonal neighbours."""
    s = symmetric_form(port.stiffness)
    size = np.sqrt(np.abs(np.einsum("nii->ni", s)))
    scale = np.maximum(size[:, :, None] * size[:, None, :], np.abs(s))
    return np.asarray((np.abs(s - s.transpose(0, 2, 1)) / scale).max(axis=(1, 2)))
