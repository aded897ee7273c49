"""One class of motion of a family on a basis: small matrices by terms, put together for a member.

Potentials have no mass and follow the displacements, so they are eliminated member by member;
what is left is symmetric and definite, like the large system.  Beside the matrices stand the
products of all terms with random shapes (:mod:`.sketch`), which give the residual of any
answer and with it a bound of its error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.body import Sections, rigid_motions, tip_weights
from tactgen.fem.bimorph.reduction.parametric.expansion import Coefficients, Expansion
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats
from tactgen.geometry.store.values import storable


@storable
@dataclass(frozen=True)
class BasisTerms:
    """Products of the terms with r rigid shapes and k displacements behind them, j potentials.

    Attributes
    ----------
    elastic, inertial : (terms, r + k, r + k) array
        Displacements against displacements: stiffness, mass.
    coupling : (terms, j, r + k) array
        Potentials against displacements.
    dielectric : (terms, j, j) array
        Potentials against potentials.
    tip : (functionals, r + k) array
        The tip's loads.
    """

    elastic: Floats
    coupling: Floats
    dielectric: Floats
    inertial: Floats
    tip: Floats


@storable
@dataclass(frozen=True)
class RandomTerms:
    """Products of the terms with s random shapes on the left.

    Attributes
    ----------
    elastic, coupling, inertial : (terms, s, r + k) array
        Of displacements: forces, charges, inertia.
    displacing, dielectric : (terms, s, j) array
        Of potentials: forces, charges.
    tip : (functionals, s) array
        The tip's loads.
    """

    elastic: Floats
    coupling: Floats
    displacing: Floats
    dielectric: Floats
    inertial: Floats
    tip: Floats


@storable
@dataclass(frozen=True)
class ReducedMotion:
    """A family in one class of motion on a basis of k displacements and j potentials.

    Attributes
    ----------
    motion : str
        Class of motion.
    has_ports : bool
        Whether base, tip and electrodes take part; then the first potential is that of a volt.
    modes : int
        How many modes the basis serves.
    rigid : int
        Number of rigid shapes before the basis.
    basis, random : BasisTerms, RandomTerms
        Products of the terms with the basis, and with random shapes.
    means : (means, pieces, 2, nz, rigid + k) array
        Motions of sections, see :func:`.body.section_means`.
    section_weights : (pieces, nz) array
        See :class:`.body.Sections`.
    margin : float
        Error bound per squared norm of the residual, as observed while the basis grew.
    """

    motion: Motion
    has_ports: bool
    modes: int
    rigid: int
    basis: BasisTerms
    random: RandomTerms
    means: Floats
    section_weights: Floats
    margin: float

    @property
    def size(self) -> int:
        """Number of displacements in the basis."""
        return int(self.basis.elastic.shape[-1]) - self.rigid

    def potentials(self, c: Coefficients) -> tuple[Floats, Floats]:
        """Return what follows displacements (n, free, k) and a volt (n, free, 1 or 0)."""
        return self._following(*self._fields(c))

    def _following(self, dielectric: Floats, coupling: Floats) -> tuple[Floats, Floats]:
        first = int(self.has_ports)
        loads = np.concatenate([coupling[:, first:], -dielectric[:, first:, :first]], axis=2)
        found = np.linalg.solve(dielectric[:, first:, first:], loads)
        return found[:, :, : self.size], found[:, :, self.size :]

    def _fields(self, c: Coefficients) -> tuple[Floats, Floats]:
        """Return permittivity (n, j, j) and coupling (n, j, k) over all potentials."""
        own = self.basis
        return (
            -_sum(c.dielectric, own.dielectric),
            _sum(c.coupling, own.coupling[:, :, self.rigid :]),
        )

    def members(self, terms: Expansion, c: Coefficients) -> Members:
        """Return the small systems of some members."""
        own, seen, r, first = self.basis, self.random, self.rigid, int(self.has_ports)
        dielectric, coupling = self._fields(c)
        follows, per_volt = self._following(dielectric, coupling)
        stiffness = _sum(c.elastic, own.elastic[:, r:, r:])
        stiffness = stiffness + np.swapaxes(coupling[:, first:], 1, 2) @ follows
        mass = _sum(c.inertial, own.inertial)
        seen_p = _sum(c.coupling, seen.displacing) + _sum(c.dielectric, seen.dielectric)
        residual = _sum(c.elastic, seen.elastic[:, :, r:])
        residual += _sum(c.coupling, seen.coupling[:, :, r:])
        residual += seen_p[:, :, first:] @ follows
        inertia = _sum(c.inertial, seen.inertial)
        ports = None
        if self.has_ports:
            moved, weights = rigid_motions(c), tip_weights(c)
            mass = _with_base(mass, moved)
            inertia = np.concatenate([inertia[:, :, r:], inertia[:, :, :r] @ moved], axis=2)
            on_volt = np.swapaxes(per_volt, 1, 2)
            ports = Ports(
                charge=(coupling[:, :1] + on_volt @ coupling[:, 1:])[:, 0],
                capacitance=(dielectric[:, :1, :1] + dielectric[:, :1, 1:] @ per_volt)[:, 0, 0],
                tip=_tip(weights, own.tip[:, r:], c),
                residual_of_volt=(seen_p[:, :, :1] + seen_p[:, :, 1:] @ per_volt)[:, :, 0],
                residual_of_tip=np.einsum("nfi,fs->nsi", weights, seen.tip),
            )
        return Members(self, terms, c, _symmetric(stiffness), mass, residual, inertia, ports)

    def projected(self, moving: Floats, field: Floats) -> ReducedMotion:
        """Return the family on fewer shapes: combinations (k, l) and (free potentials, m).

        Its residual is still that of the large system.
        """
        r, first = self.rigid, int(self.has_ports)
        u = np.zeros((r + moving.shape[0], r + moving.shape[1]))
        u[:r, :r], u[r:, r:] = np.eye(r), moving
        p = np.zeros((first + field.shape[0], first + field.shape[1]))
        p[:first, :first], p[first:, first:] = np.eye(first), field
        own, seen = self.basis, self.random
        return replace(
            self,
            basis=BasisTerms(
                elastic=u.T @ own.elastic @ u,
                coupling=p.T @ own.coupling @ u,
                dielectric=p.T @ own.dielectric @ p,
                inertial=u.T @ own.inertial @ u,
                tip=own.tip @ u,
            ),
            random=replace(
                seen,
                elastic=seen.elastic @ u,
                coupling=seen.coupling @ u,
                displacing=seen.displacing @ p,
                dielectric=seen.dielectric @ p,
                inertial=seen.inertial @ u,
            ),
            means=self.means @ u,
        )

    @property
    def sections(self) -> Sections:
        """The sections in which a mode is named."""
        return Sections(self.motion, self.section_weights)


@dataclass(frozen=True)
class Ports:
    """What base, tip and electrodes of n members do, potentials eliminated.

    Attributes
    ----------
    charge : (n, k) array
        Force on the basis per volt; minus the charge per motion.
    capacitance : (n,) array
        Charge per volt, all else held (F).
    tip : (n, k + 2, 2) array
        Mean displacement and rotation of the tip.
    residual_of_volt, residual_of_tip : (n, s), (n, s, 2) array
        Random shapes' products with the loads.
    """

    charge: Floats
    capacitance: Floats
    tip: Floats
    residual_of_volt: Floats
    residual_of_tip: Floats


@dataclass(frozen=True)
class Members:
    """Small systems of n members of a family in one class of motion.

    Attributes
    ----------
    stiffness : (n, k, k) array
        Potentials eliminated; base motion needs no force.
    mass : (n, k, k) or (n, k + 2, k + 2) array
        With the base's motions behind the basis if there are ports.
    residual, residual_of_mass : (n, s, k), (n, s, k) or (n, s, k + 2) array
        Random shapes' products with stiffness and mass.
    """

    reduced: ReducedMotion
    terms: Expansion
    coefficients: Coefficients
    stiffness: Floats
    mass: Floats
    residual: Floats
    residual_of_mass: Floats
    ports: Ports | None = None


def _sum(weights: Any, terms: Floats) -> Floats:
    """Return Σ weights (n, terms) · terms (terms, l, k), (n, l, k)."""
    count, left, right = terms.shape
    return np.asarray(weights @ terms.reshape(count, -1)).reshape(-1, left, right)


def _symmetric(matrix: Floats) -> Floats:
    return np.asarray(0.5 * (matrix + np.swapaxes(matrix, 1, 2)))


def _with_base(mass: Floats, moved: Floats) -> Floats:
    """Return the mass over [basis, base motion, base rotation]."""
    rigid = moved.shape[1]
    on_base = mass[:, rigid:, :rigid] @ moved
    corner = np.swapaxes(moved, 1, 2) @ mass[:, :rigid, :rigid] @ moved
    top = np.concatenate([mass[:, rigid:, rigid:], on_base], axis=2)
    return _symmetric(
        np.concatenate([top, np.concatenate([np.swapaxes(on_base, 1, 2), corner], axis=2)], axis=1)
    )


def _tip(weights: Floats, tip: Floats, c: Coefficients) -> Floats:
    """Return the tip's motion (n, k + 2, 2); u_x = w − z ψ of a rigid body is exact."""
    elastic = np.einsum("nfi,fk->nki", weights, tip)
    rigid = np.zeros((c.count, 2, 2))
    rigid[:, 0, 0] = rigid[:, 1, 1] = 1.0
    rigid[:, 1, 0] = -c.pieces.z.sum(axis=1)
    return np.concatenate([elastic, rigid], axis=1)
