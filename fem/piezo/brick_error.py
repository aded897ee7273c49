"""Hierarchical error of bricks: residual against polynomials of one degree more.

A solution x of a(x, v) = f(v) on bricks leaves a residual r(w) = f(w) − a(x, w) against the
products of polynomials that the same bricks of one degree more have besides.  With the stiffness
of these alone, K e = r gives what x lacks: the hierarchical estimator of Bank and Smith (SIAM J.
Numer. Anal. 30, 1993).  An answer is a product of two solutions, and changes by r_iᵀ e_j.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactgen.fem.piezo.bricks import brick_matrices, quarter_unknowns, seen_functionals
from tactgen.fem.piezo.modal_model import Motion
from tactgen.fem.piezo.symmetry import PORTS, Unknowns
from tactgen.fem.piezo.system import materials, volts_per_unit
from tactgen.fem.solvers.linear_solver import Factor, factorise
from tactgen.geometry.arrays import Floats, Ints, Numbers, Sparse
from tactgen.geometry.bimorph.bricks import Axis, Bricks
from tactgen.geometry.device.parameters import Device


@dataclass(frozen=True)
class MotionEstimator:
    """The functions that one class of motion lacks, w of them, against the (4 n) it has."""

    unknowns: Unknowns  #: What the bricks' own unknowns y (m + 3) are among the values on them
    place: Ints  #: (4 n,) Where these values are among those of one degree more
    #: (w, 4 n⁺) Lacking functions against all of one degree more; the stiffness complex where it
    #: has losses
    stiffness: Sparse
    mass: Sparse
    lacking: Ints  #: (w,) Which of these they are
    #: (w, t) What they add to the tip's displacement and rotation, and to the displacement at the
    #: place of measurement, if there is one
    seen: Floats

    def residuals(self, states: Numbers) -> tuple[Numbers, Numbers]:
        """K x and M x (w, k) of states (m + 3, k); the residual is f − K x + Ω² M x.

        A solid with losses needs K with them: a share 1/Q of K x alone may exceed the residual.
        """
        values = self.unknowns.ports @ states[-PORTS:]
        values[self.unknowns.index] += states[:-PORTS]
        spread = np.zeros((self.stiffness.shape[1], states.shape[1]), dtype=states.dtype)
        spread[self.place] = values
        return self.stiffness @ spread, self.mass @ spread

    def products(self, residuals: Numbers) -> tuple[Numbers, Numbers]:
        """R_iᵀ K⁻¹ r_j (k, k) of residuals (w, k), K the lacking functions' stiffness.

        Of displacements, and of potentials, whose K counts as positive.  An estimate needs no
        losses in this K.
        """
        potential = self.lacking % 4 == 3
        moved, charged = (
            _product(factor, residuals[of])
            for of, factor in zip((~potential, potential), self._factors, strict=True)
        )
        return moved, -charged

    @cached_property
    def _factors(self) -> tuple[Factor, Factor | None]:
        """Factors of the lacking functions' own stiffness: of displacements, of potentials if any.

        Taken apart, since what the two miss is of opposite sign in energy and may cancel.
        """
        own, potential = self.stiffness[:, self.lacking].real, self.lacking % 4 == 3
        moving, charging = (own[of][:, of].tocsr() for of in (~potential, potential))
        return factorise(moving), factorise(charging) if potential.any() else None


class BrickEstimator:
    """All products that bricks of one degree more have besides; hierarchic, with plain sections."""

    def __init__(self, device: Device, bricks: Bricks, *, lossy: bool = False) -> None:
        known = materials(device, bricks.regions, device.piezo.ceramic(), lossy=lossy)
        self._bricks, self._richer = bricks, _one_degree_more(bricks)
        self._below = device.measurement.below_tip
        self._unit = volts_per_unit(known)
        axes = zip(bricks.axes, self._richer.axes, strict=True)
        places = [_places(own, more) for own, more in axes]
        place = np.ravel_multi_index(np.ix_(*places), self._richer.shape).ravel()
        self._place = (4 * place[:, None] + np.arange(4)).ravel()
        tested = self._richer.products().ravel()
        tested[place[bricks.products().ravel()]] = False
        self._stiffness, self._mass = brick_matrices(
            self._richer, known, self._unit, tested.reshape(self._richer.shape)
        )

    def of(self, motion: Motion) -> MotionEstimator:
        """Hierarchical error of one class of motion."""
        unknowns, more = (
            quarter_unknowns(bricks, motion, self._unit) for bricks in (self._bricks, self._richer)
        )
        lacks = more.free.ravel().copy()
        lacks[self._place[unknowns.index]] = False
        lacking = np.flatnonzero(lacks)
        return MotionEstimator(
            unknowns=unknowns,
            place=self._place,
            stiffness=self._stiffness[lacking],
            mass=self._mass[lacking],
            lacking=lacking,
            seen=seen_functionals(self._richer, self._below)[lacking],
        )


def _product(factor: Factor | None, residuals: Numbers) -> Numbers:
    """Rᵀ K⁻¹ r of a real factor and residuals (w, k) that may be complex; 0 without functions."""
    if factor is None:
        return residuals.T @ residuals
    if not np.iscomplexobj(residuals):
        return np.asarray(residuals.T @ factor.solve(residuals))
    parts = factor.solve(np.hstack([residuals.real, residuals.imag]))
    real, imaginary = np.hsplit(parts, 2)
    return np.asarray(residuals.T @ (real + 1j * imaginary))


def _one_degree_more(bricks: Bricks) -> Bricks:
    x, y, z = (Axis(a.breaks, a.degree + 1, hierarchic=True) for a in bricks.axes)
    return replace(bricks, x=x, y=y, z=z)


def _places(own: Axis, more: Axis) -> Ints:
    """Where the functions (n,) of an axis are among those of a higher degree."""
    number = np.arange(own.nodes.size)
    return np.asarray(number // own.degree * more.degree + number % own.degree)
