"""The bimorph as modes over its moving base: what a discretised one becomes for time steps.

From second-order matrices over any unknowns, of which two are the base's w and ψ: the modes of
the held base, with the static answers to voltage, tip force and base acceleration among them, so
that slow motion is exact; and the rigid motions of the base (R. R. Craig and M. C. C. Bampton,
AIAA J. 6 (1968) 1313).  A constant loss factor is not causal; each mode instead has the viscous
damping that loses as much at its own frequency.  The loss in the dielectric is left out: it takes
part in the current alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints


@dataclass(frozen=True)
class BimorphModes:
    """k modes over a base that moves by [w, ψ].

    Attributes
    ----------
    omega : (k,) float
        Angular frequencies with the base held (rad/s).
    damping : (k,) float
        2 ζ ω (1/s).
    inertia : (k, 2) float
        What a base acceleration does to the modes (√kg, √kg m).
    rigid : (2, 2) float
        Mass matrix of the bimorph as a rigid body about its base (kg, kg m, kg m²).
    coupling : (k,) float
        Force on the modes per volt across each layer, and charge per mode.
    tip : (k + 2,) float
        Tip displacement (m) of base motions w and ψ, then of the modes.
    capacitance : float
        With all motion held (F).
    shapes : (n, k + 2) float
        The unknowns that the modes were made of, of base motions w and ψ, then of the modes.
    """

    omega: Floats
    damping: Floats
    inertia: Floats
    rigid: Floats
    coupling: Floats
    tip: Floats
    capacitance: float
    shapes: Floats


def bimorph_modes(
    stiffness: Complex,
    mass: Floats,
    coupling: Complex,
    capacitance: complex,
    base: Ints,
    tip: Floats,
    highest: float,
) -> BimorphModes:
    """Return the modes of a discretised bimorph.

    Parameters
    ----------
    stiffness, mass : (n, n)
        Lossy and lossless, free at both ends.
    coupling : (n,) complex
        Force per volt.
    capacitance : complex
        With all unknowns held (F).
    base : (2,) int
        Unknowns that are w and ψ of the base.
    tip : (n,) float
        Row that reads the tip's displacement.
    highest : float
        Modes above this frequency (Hz) are only there as statics.
    """
    from scipy.linalg import eigh

    inner = np.setdiff1d(np.arange(mass.shape[0]), base)
    k, m = stiffness[np.ix_(inner, inner)], mass[np.ix_(inner, inner)]
    follows = -np.linalg.solve(k.real, stiffness.real[np.ix_(inner, base)])
    dragged = m @ follows + mass[np.ix_(inner, base)]
    squares, shapes = eigh(k.real, m)
    kept = shapes[:, squares < (2.0 * np.pi * highest) ** 2]
    loads = np.column_stack([coupling.real[inner], tip[inner], dragged])
    # the part of the static answers that the modes do not have
    statics = np.linalg.solve(k.real, loads)
    statics -= kept @ (kept.T @ m @ statics)
    statics /= np.sqrt(np.einsum("ij,ik,kj->j", statics, m, statics))
    values, vectors = eigh(statics.T @ k.real @ statics, statics.T @ m @ statics)
    basis = np.hstack([kept, statics @ vectors])
    omega = np.sqrt(np.concatenate([squares[: kept.shape[1]], values]))
    whole = np.zeros((mass.shape[0], 2))
    whole[inner], whole[base] = follows, np.eye(2)
    moved = np.zeros((mass.shape[0], basis.shape[1]))
    moved[inner] = basis
    return BimorphModes(
        omega=omega,
        damping=np.einsum("ij,ik,kj->j", basis, k.imag, basis) / omega,
        inertia=basis.T @ dragged,
        rigid=whole.T @ mass @ whole,
        coupling=basis.T @ coupling.real[inner],
        tip=np.concatenate([tip @ whole, tip[inner] @ basis]),
        capacitance=float(capacitance.real),
        shapes=np.hstack([whole, moved]),
    )
