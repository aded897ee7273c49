"""A magnetic circuit shaped like a ladder, solved exactly: fluxes, co-energy, force.

Two iron rails carry the same flux up and down; rungs of air join them; a winding sits
between.  Here is the circuit, not the device: what becomes an iron element and what a
rung is decided in tmm.reluctance.network.

The fluxes φ_1 … φ_n of the cells minimise

    Π(φ) = Σ_e A_e l_e w(|φ|/A_e) + Σ_j R_j (φ_j − φ_{j+1})²/2 − i Σ_k N_k φ_k,   φ_0 = φ_{n+1} = 0,

with w(B) = ∫H dB of the iron: energy less the winding's i λ.  Π is strictly convex and its
Hessian tridiagonal.  At the minimum −Π is the co-energy W'(i, g), hence the flux linkage
λ = ∂W'/∂i = Σ N_k φ_k and the pull F = −∂W'/∂g = ∂Π/∂g at fixed fluxes: λ and F belong to
one function, with no difference quotient.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.device.magnetisation import MagnetisationCurve

#: Residual mmf of a cell, relative to the winding's whole mmf, at which it counts as balanced.
_RESIDUAL = 1e-12

#: Rounding of a sum of a few hundred terms.
_ROUNDING = 64.0 * float(np.finfo(float).eps)

#: Steps that Newton's method may take; a dozen is usual, a hundred is a fault.
_STEPS = 100
#: Times that a step is halved at most: by then it is below rounding.
_HALVINGS = 60
#: Flux density (T) at which the iron's reluctivity makes the first guess.
_GUESSED = 1.0


@dataclass(frozen=True)
class Ladder:
    """The circuit at m gaps: n cells, E iron elements; `d_` is the derivative by the gap.

    Iron without reluctance has no elements.
    """

    curve: MagnetisationCurve  #: The iron's
    area: Floats  #: (m, E) Cross-sections of the iron elements (m²)
    #: (m, E) Their lengths (m)
    length: Floats
    d_length: Floats
    cell: Ints  #: (E,) The cell whose flux each carries
    #: (m, n + 1) Rungs below the first cell, between the cells, above the last (1/H); 0 is a
    #: perfect joint
    reluctance: Floats
    d_reluctance: Floats
    #: (m, n) Turns whose mmf drives each cell
    turns: Floats
    d_turns: Floats


@dataclass(frozen=True)
class LadderSolution:
    """Circuit solution at c currents and m gaps; arrays (c, m), fluxes (c, m, n)."""

    flux: Floats  #: Of each cell (Wb)
    coenergy: Floats  #: W' (J)
    flux_linkage: Floats  #: λ = ∂W'/∂i (Wb), odd in the current
    force: Floats  #: F = −∂W'/∂g (N), positive when it closes the gap
    incremental_inductance: Floats  #: ∂λ/∂i (H)


def solve(ladder: Ladder, currents: Floats) -> LadderSolution:
    """Circuit's state at all `currents` (c,) and all gaps of the ladder.

    Newton's method with the exact Hessian; the step is halved until the energy falls, so
    it converges from any start, at any saturation.

    Raises ArithmeticError if the minimum was not reached, which a convex Π excludes short of
    overflow.
    """
    currents = np.asarray(currents, dtype=float)
    sign = np.sign(currents)[:, None]
    drive = np.abs(currents)[:, None, None] * ladder.turns
    flux = _first_guess(ladder, drive)
    for _ in range(_STEPS):
        gradient, tolerance = _gradient(ladder, flux, drive)
        moving = np.asarray((np.abs(gradient) > tolerance).any(axis=-1))
        if not moving.any():
            break
        step = -_tridiagonal(*_hessian(ladder, flux), gradient)
        flux = _descend(ladder, flux, step, drive, moving)
    else:
        raise ArithmeticError("the magnetic circuit did not settle")
    linkage = (ladder.turns * flux).sum(axis=-1)
    responses = _tridiagonal(*_hessian(ladder, flux), np.broadcast_to(ladder.turns, flux.shape))
    return LadderSolution(
        flux=sign[..., None] * flux,
        coenergy=-_energy(ladder, flux, drive)[0],
        flux_linkage=sign * linkage,
        force=_energy_slope(ladder, flux, np.abs(currents)),
        incremental_inductance=(ladder.turns * responses).sum(axis=-1),
    )


def _first_guess(ladder: Ladder, drive: Floats) -> Floats:
    """Fluxes with the iron's reluctivity as it is at one flux density."""
    diagonal, beside = _rungs(ladder, drive.shape)
    reluctivity = float(ladder.curve.field_strength(np.array(_GUESSED)))
    diagonal = diagonal + _to_cells(ladder, reluctivity * ladder.length / ladder.area)
    return _tridiagonal(diagonal, beside, drive)


def _descend(ladder: Ladder, flux: Floats, step: Floats, drive: Floats, moving: Bools) -> Floats:
    """Take Newton's step at the points still `moving`, each halved until its energy falls."""
    energy, rounding = _energy(ladder, flux, drive)
    factor = np.where(moving, 1.0, 0.0)
    for _ in range(_HALVINGS):
        trial, _ = _energy(ladder, flux + factor[..., None] * step, drive)
        rising = trial > energy + rounding
        if not rising.any():
            break
        factor = np.where(rising, 0.5 * factor, factor)
    return np.asarray(flux + factor[..., None] * step)


def _flux_density(ladder: Ladder, flux: Floats) -> Floats:
    """B (c, m, E), signed (T)."""
    return np.asarray(flux[..., ladder.cell] / ladder.area)


def _across_rungs(flux: Floats) -> Floats:
    """Flux through each rung (c, m, n + 1) (Wb)."""
    through = np.empty((*flux.shape[:-1], flux.shape[-1] + 1))
    through[..., 0], through[..., -1] = flux[..., 0], -flux[..., -1]
    np.subtract(flux[..., 1:], flux[..., :-1], out=through[..., 1:-1])
    return through


def _energy(ladder: Ladder, flux: Floats, drive: Floats) -> tuple[Floats, Floats]:
    """Π (c, m) and its rounding (c, m)."""
    stored = 0.5 * (ladder.reluctance * _across_rungs(flux) ** 2).sum(axis=-1)
    density = ladder.curve.energy_density(np.abs(_flux_density(ladder, flux)))
    stored = stored + (ladder.area * ladder.length * density).sum(axis=-1)
    supplied = (drive * flux).sum(axis=-1)
    return stored - supplied, _ROUNDING * (stored + np.abs(supplied))


def _energy_slope(ladder: Ladder, flux: Floats, currents: Floats) -> Floats:
    """∂Π/∂g (c, m) at fixed fluxes."""
    rungs = 0.5 * (ladder.d_reluctance * _across_rungs(flux) ** 2).sum(axis=-1)
    total = rungs - currents[:, None] * (ladder.d_turns * flux).sum(axis=-1)
    density = ladder.curve.energy_density(np.abs(_flux_density(ladder, flux)))
    return np.asarray(total + (ladder.area * ladder.d_length * density).sum(axis=-1))


def _gradient(ladder: Ladder, flux: Floats, drive: Floats) -> tuple[Floats, Floats]:
    """∂Π/∂φ (c, m, n), the residual mmf, and its tolerance (A)."""
    rungs = ladder.reluctance * _across_rungs(flux)
    b = _flux_density(ladder, flux)
    drop = np.sign(b) * ladder.curve.field_strength(np.abs(b)) * ladder.length
    gradient = rungs[..., :-1] - rungs[..., 1:] - drive + _to_cells(ladder, drop)
    # the flux through a rung is a small difference of large fluxes
    cancelled = np.abs(flux) * (ladder.reluctance[:, :-1] + ladder.reluctance[:, 1:])
    negligible = _RESIDUAL * drive.sum(axis=-1, keepdims=True) + _ROUNDING * cancelled
    return gradient, negligible


def _hessian(ladder: Ladder, flux: Floats) -> tuple[Floats, Floats]:
    """Diagonal (c, m, n) and off-diagonal (c, m, n − 1) of ∂²Π/∂φ²."""
    diagonal, beside = _rungs(ladder, flux.shape)
    slope = ladder.curve.slope(np.abs(_flux_density(ladder, flux)))
    return diagonal + _to_cells(ladder, slope * ladder.length / ladder.area), beside


def _rungs(ladder: Ladder, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
    r = ladder.reluctance
    diagonal = np.array(np.broadcast_to(r[:, :-1] + r[:, 1:], shape))
    return diagonal, np.broadcast_to(-r[:, 1:-1], (*shape[:-1], shape[-1] - 1))


def _to_cells(ladder: Ladder, values: Floats) -> Floats:
    """Sum the elements' `values` (..., E) over their cells, (..., n)."""
    cells, points = ladder.turns.shape[-1], math.prod(values.shape[:-1])
    place = (cells * np.arange(points)[:, None] + ladder.cell).ravel()
    found = np.bincount(place, values.ravel(), cells * points)
    return np.asarray(found, dtype=float).reshape(*values.shape[:-1], cells)


def _tridiagonal(diagonal: Floats, beside: Floats, right: Floats) -> Floats:
    """Solve symmetric positive definite tridiagonal systems, all points as one long system."""
    from scipy.linalg.lapack import dptsv

    joined = np.zeros(right.shape)  # nothing couples the last cell of a point to the next point
    joined[..., :-1] = beside
    # of a single unknown LAPACK's wrapper refuses that nothing couples it
    between = joined.ravel()[: max(1, joined.size - 1)]
    _, _, x, fault = dptsv(diagonal.ravel(), between, right.ravel())
    if fault:
        raise ArithmeticError("the magnetic circuit has no minimum that can be found")
    return np.asarray(x).reshape(right.shape)
