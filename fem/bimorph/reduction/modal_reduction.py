"""A solid reduced to its :class:`~fem.bimorph.reduction.modal_model.ModalModel`.

With the lowest held modes in the basis, the rest of (K − Ω² M)⁻¹ f is a series in Ω² K⁻¹ M
that converges fast below the modes left out; f are the loads by base motion, tip and charge.

Every vector x of the basis is K⁻¹ r of a known load r, so xᵢᵀ K xⱼ = xᵢᵀ rⱼ: bending, ten
million times softer than what it is assembled from, is never a difference of large terms.
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.bimorph.modes import eigenpairs
from tactgen.fem.bimorph.motions import section_motions
from tactgen.fem.bimorph.reduction.modal_model import ModalModel
from tactgen.fem.bimorph.system import SolidSystem
from tactgen.geometry.arrays import Floats, Sparse
from tactgen.geometry.bimorph.ends import Ends

#: Held modes in the basis beyond those wanted: a load and an open circuit each lift a mode past
#: one other at most, springs of the base none.
_MORE = 2
#: Blocks of the series for the modes left out: frequencies are then those of the mesh to 1e-9.
_BLOCKS = 4
#: A vector of which less than this is new is rounding.
_NOISE = 1e-8


def modal_model(system: SolidSystem, count: int) -> ModalModel:
    """Reduce a lossless solid to what its lowest `count` modes on any support need.

    Costs one search for modes with the factor of the statics.
    """
    n, factor, mass = system.inner, system.held_factor, system.mass.inner
    follows = -factor.solve(system.stiffness.border[:, :2])
    carried = mass @ follows + system.mass.border[:, :2]
    tip, charge = system.tip[:, 0], -system.stiffness.border[:, 2]
    basis = _Basis(mass, n)
    values, vectors = eigenpairs(system, Ends(), count + _MORE)
    basis.extend(np.column_stack(vectors), mass @ np.column_stack(vectors) * values)
    loads = np.column_stack([carried, tip[:n], charge])
    for _ in range(_BLOCKS):
        loads = mass @ basis.extend(factor.solve(loads), loads)
    shapes = np.vstack([np.column_stack([basis.shapes, follows]), np.zeros((2, basis.size + 2))])
    shapes[n:, basis.size :] = np.eye(2)
    stiffness, whole = np.zeros((2, basis.size + 2, basis.size + 2))
    stiffness[:-2, :-2] = basis.shapes.T @ basis.loads
    whole[:-2, :-2] = basis.shapes.T @ basis.weighed
    whole[:-2, -2:] = basis.shapes.T @ carried
    whole[-2:, :-2] = whole[:-2, -2:].T
    whole[-2:, -2:] = (
        follows.T @ carried + system.mass.border[:, :2].T @ follows + system.mass.corner[:2, :2]
    )
    nodal = system.nodal_displacement(shapes)
    flat = nodal.reshape(-1, shapes.shape[1])
    return ModalModel(
        stiffness=0.5 * (stiffness + stiffness.T),
        mass=0.5 * (whole + whole.T),
        tip=shapes.T @ tip[: n + 2],
        charge=shapes.T @ np.concatenate([charge, -system.stiffness.corner[:2, 2]]),
        capacitance=-float(system.stiffness.corner[2, 2]),
        motions=section_motions(system.nodes, system.node_mass, nodal),
        energy=flat.T @ (np.repeat(system.node_mass, 3)[:, None] * flat),
        motion=system.motion,
    )


class _Basis:
    """Vectors x of unit mass, orthogonal in it, each with its load K x and with M x."""

    def __init__(self, mass: Sparse, n: int) -> None:
        self._mass = mass
        self.shapes, self.loads, self.weighed = np.zeros((3, n, 0))

    @property
    def size(self) -> int:
        """Number of vectors."""
        return int(self.shapes.shape[1])

    def extend(self, shapes: Floats, loads: Floats) -> Floats:
        """Take in what is new in shapes (n, j), of which the loads are K times; return that."""
        before = self.size
        for x, load in zip(shapes.T, loads.T, strict=True):
            size = np.sqrt(x @ (self._mass @ x))
            if size == 0.0:  # moves nothing
                continue
            new, force = x / size, load / size
            for _ in range(2):  # twice is enough (Kahan, Parlett)
                known = self.weighed.T @ new
                new, force = new - self.shapes @ known, force - self.loads @ known
            left = np.sqrt(max(new @ (self._mass @ new), 0.0))
            if left > _NOISE:
                new, force = new / left, force / left
                self.shapes = np.column_stack([self.shapes, new])
                self.loads = np.column_stack([self.loads, force])
                self.weighed = np.column_stack([self.weighed, self._mass @ new])
        return self.shapes[:, before:]
