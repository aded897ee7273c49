"""The lossless modes of a solid on any support, load and circuit, from one small system.

Held at its base (w_base = ψ_base = U = 0) the solid has modes φ.  What springs, a load and an
open circuit add is forces at the ports, f = (K − Ω² M) u: base motion b carries the body along,
u = R b with K R = 0, and loads it by its inertia, −Ω² (M R) b; the tip's force and the
electrode's charge act through one column each.

Functions that the mesh lacks move Ω² by what they make of a mode's residual r: displacements by
−rᵀ K⁻¹ r, potentials the other way.  The coupling factor is made of Ω² of both circuits, o over s,
and these miss nearly the same.  With modes of the same strain energy what is left of the difference
is the product (r_o − r_s)ᵀ K⁻¹ (r_o + r_s) of what is missing of the mode and what is missing of
that which the open circuit adds to it; the two may be next to orthogonal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, TipLoad
from tactgen.geometry.store.values import storable

#: The motions of a body with two planes of symmetry: bending in x is odd in x and even in
#: y, and the only one that the ports take part in.  ``all`` is a body taken whole.
Motion = Literal["all", "bending_x", "bending_y", "torsion", "axial"]
#: Class of a mode; ``mixed`` is none of the others by half.
ModeClass = Literal["bending_x", "bending_y", "torsion", "axial", "mixed"]


#: Shift Ω² (1/s²) of a body that is not held, as far below 0 Hz as 50 Hz is above.
SHIFT = (2.0 * np.pi * 50.0) ** 2


#: Slices along z in which a mode's sections are told apart.
_SLICES = 40


def classify(nodes: Floats, mass: Floats, displacement: Floats) -> tuple[ModeClass, float]:
    """Name a mode by the rigid section motion that holds most of its kinetic energy.

    Returns the class and its share of the energy (``mixed`` below one half).
    """
    motions = section_motions(nodes, mass, displacement[:, :, None])[:, :, 0]
    return strongest(motions, float((mass[:, None] * displacement**2).sum()))


def section_motions(nodes: Floats, mass: Floats, displacement: Floats) -> Floats:
    """Rigid motions (6, slices, k) of sections, each squared twice its kinetic energy over ω².

    Nodes (n, 3) in m of a `mass` (n,) in kg are gathered in slices along z; in each the
    displacement (n, 3, k) of k motions, in which the result is linear, is fitted by translations
    along x, y and z, by rotations in x and y and by twist.
    """
    z = nodes[:, 2]
    section = np.minimum((_SLICES * (z - z.min()) / np.ptp(z)).astype(int), _SLICES - 1)

    def gathered(values: Floats) -> Floats:
        return np.asarray(np.bincount(section, mass * values, minlength=_SLICES), dtype=float)

    weight = np.maximum(gathered(np.ones(z.size)), np.finfo(float).tiny)
    x, y = (nodes[:, i] - (gathered(nodes[:, i]) / weight)[section] for i in (0, 1))
    inertia_x, inertia_y = gathered(x**2), gathered(y**2)
    sizes = (weight, weight, weight, inertia_x, inertia_y, inertia_x + inertia_y)
    found = np.zeros((len(sizes), _SLICES, displacement.shape[2]))
    for number, (ux, uy, uz) in enumerate(displacement.transpose(2, 1, 0)):
        # least squares: what a section motion of this shape takes of u
        for row, values in enumerate((ux, uy, uz, x * uz, y * uz, x * uy - y * ux)):
            found[row, :, number] = gathered(values)
    size = np.array(sizes)
    return found / np.sqrt(np.where(size > 0.0, size, 1.0))[:, :, None]


def strongest(motions: Floats, total: float) -> tuple[ModeClass, float]:
    """Class that holds most of the energy `total`, and its share; `motions` are (6, slices)."""
    along_x, along_y, along_z, about_y, about_x, twist = (motions**2).sum(axis=1)
    energy: dict[ModeClass, float] = {
        "bending_x": along_x + about_y,
        "bending_y": along_y + about_x,
        "torsion": twist,
        "axial": along_z,
    }
    best = max(energy, key=lambda name: energy[name])
    share = float(energy[best] / total)
    return (best if share >= 0.5 else "mixed"), share


#: A tip this many times stiffer than the solid is held.
_HELD = 1e6


@storable
@dataclass(frozen=True)
class BareMode:
    """A natural mode without its shape: frequency (Hz), its class, and the class of the system."""

    frequency: float
    kind: ModeClass
    motion: Motion
    estimate: float = 0.0  #: Relative error of the frequency by an estimate, 0 where none was made


@storable
@dataclass(frozen=True)
class ModalModel:
    """Symmetric matrices over [q, w_base, ψ_base] at U = 0, nothing attached."""

    #: (k + 2, k + 2) K, where base motion needs no force, and M
    stiffness: Floats
    mass: Floats
    #: (k + 2, 2) Mean displacement (m) and rotation of the tip from the unknowns
    tip: Floats
    #: (k + 2,) Charge (C) from the unknowns
    charge: Floats
    #: Charge per voltage where nothing moves (F); 0 of motions across the width, which make none
    capacitance: float
    #: (6, slices, k + 2) Motions of sections, see :func:`section_motions`
    motions: Floats
    energy: Floats  #: (k + 2, k + 2) Nodal mass, for the share of a class in the energy
    motion: Motion  #: The motions that the solid can make
    #: (2, 2 k + 7, 2 k + 7) Products r_iᵀ K⁻¹ r_j of the residuals that functions the mesh lacks
    #: (:class:`fem.piezo.brick_error.MotionEstimator`) have with K x and with M x of the unknowns,
    #: with the charge and with both motions of the tip: of displacements, and of potentials
    surplus: Floats | None = None
    missing: Floats | None = None  #: (2 k + 7, 2 k + 7) Those of them that the modes are moved by

    def modes(self, ends: Ends, count: int, *, open_circuit: bool = False) -> list[BareMode]:
        """Lowest `count` modes, ascending, without damping and rigid motions."""
        squares, shapes = self._solved(ends, open_circuit=open_circuit)
        found = []
        for omega2, y in zip(squares[:count], shapes.T[:count], strict=True):
            if self.missing is not None:
                r = self._residual(y, omega2, ends, open_circuit=open_circuit)
                # of a mode that the mesh does not resolve half is left
                omega2 -= min(float(r @ self.missing @ r), 0.5 * omega2)
            found.append(
                BareMode(float(np.sqrt(omega2) / (2.0 * np.pi)), self._kind(y), self.motion)
            )
        return found

    def opened(self, ends: Ends) -> tuple[float, float]:
        """Relative error of Ω² open over short circuit, from the estimator space.

        Of the first mode that bends in x: the change, and the most that it can be with as much
        missing of either factor of its products (Cauchy, Schwarz).  Needs :attr:`surplus`.
        """
        assert self.surplus is not None
        (before, short), (after, opened) = (
            self._first_bending(ends, open_circuit=circuit) for circuit in (False, True)
        )
        if before @ self.mass @ after < 0.0:
            opened = -opened
        both = np.array([opened - short, opened + short])
        moved, charged = (both @ products @ both.T for products in self.surplus)
        bounds = (np.sqrt(max(of[0, 0] * of[1, 1], 0.0)) for of in (moved, charged))
        return float(charged[0, 1] - moved[0, 1]), float(sum(bounds))

    def _first_bending(self, ends: Ends, *, open_circuit: bool) -> tuple[Floats, Floats]:
        """First mode that bends in x (k + 2,), and its residual per root of energy."""
        squares, shapes = self._solved(ends, open_circuit=open_circuit)
        i = int(np.argmax([self._kind(y) == "bending_x" for y in shapes.T]))
        residual = self._residual(shapes[:, i], squares[i], ends, open_circuit=open_circuit)
        return shapes[:, i], residual / np.sqrt(squares[i])

    def _solved(self, ends: Ends, *, open_circuit: bool) -> tuple[Floats, Floats]:
        """Ω² (n,) of all modes but rigid motions, ascending, and the modes (k + 2, n)."""
        k, m = self.stiffness.copy(), self.mass.copy()
        base, load = ends.base, ends.conservative_tip
        if base is not None:
            k[-2:, -2:] += np.diag([base.lateral_stiffness, base.rotational_stiffness])
            m[-1, -1] += base.rotational_inertia
        seat, turn = self.tip @ load.arm, self.tip[:, 1]
        moved = np.outer(seat, seat)
        k += load.stiffness * moved
        m += load.mass * moved + load.inertia * np.outer(turn, turn)
        if open_circuit and self.capacitance:
            k += np.outer(self.charge, self.charge) / self.capacitance
        free = slice(None) if base is not None else slice(-2)
        k, m = k[free, free], m[free, free]
        shift = SHIFT if ends.rigid_motions else 0.0
        # the lowest modes are the largest values of the inverse, and right to rounding there
        lower = np.linalg.cholesky(m)
        inverse = lower.T @ np.linalg.solve(k + shift * m, lower)
        values, vectors = np.linalg.eigh(0.5 * (inverse + inverse.T))
        chosen = [i for i in reversed(range(values.size)) if values[i] > 0.0][ends.rigid_motions :]
        shapes = np.zeros((self.charge.size, len(chosen)))
        shapes[free] = np.linalg.solve(lower.T, vectors[:, chosen])
        return 1.0 / values[chosen] - shift, shapes

    def _kind(self, y: Floats) -> ModeClass:
        return strongest(self.motions @ y, float(y @ self.energy @ y))[0]

    def _residual(self, y: Floats, omega2: float, ends: Ends, *, open_circuit: bool) -> Floats:
        """Residual (2 k + 7,) of a mode in terms of :attr:`surplus`."""
        load = ends.conservative_tip
        opened = open_circuit and self.capacitance
        charge = float(self.charge @ y) / self.capacitance if opened else 0.0
        moved = self.tip.T @ y
        force = (load.stiffness - omega2 * load.mass) * float(load.arm @ moved)
        effort = force * load.arm
        effort[1] -= omega2 * load.inertia * moved[1]
        return np.concatenate([y, -omega2 * y, [charge], effort])

    def highest(self, count: int) -> list[BareMode]:
        """Modes that are, one by one, as high as any support, load and circuit has them."""
        k = self.stiffness[:-2, :-2]
        tip = self.tip[:-2, 0]
        stiffness = 1.0 / float(tip @ np.linalg.solve(k, tip))
        return self.modes(Ends(None, TipLoad(_HELD * stiffness)), count, open_circuit=True)
