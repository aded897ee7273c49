"""The piezoelectric solid by scikit-fem: ten-node tetrahedra, or hexahedra of twenty nodes.

scikit-fem gives elements, quadrature and numbering; all blocks of a cell are one product of
its Gram matrices G_ab = ∫ ∂_a N_i ∂_b N_j with the tensors.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from tactgen.fem.elements.pattern import BlockPattern
from tactgen.fem.elements.skfem_mesh import to_skfem
from tactgen.fem.piezo.modal_model import Motion
from tactgen.fem.piezo.symmetry import OTHERS, SIGNS, Expansion, Unknowns, lumped, mirror_signs
from tactgen.fem.piezo.system import Material, SolidSystem
from tactgen.fem.solvers.pardiso import nested_dissection
from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers, Sparse
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import MIRRORS, mirror_axes, mirrored_points

#: Cells worked on at a time: bounds the memory.
_CHUNK = 4000
#: Points along each side of the section over which a mean displacement is taken: Gauss's, more
#: than the cells are across.
_POINTS = 12


@dataclass(frozen=True)
class SkfemBody:
    """Unsupported body, common to all classes of motion."""

    mesh: Mesh
    known: dict[str, Material]
    unit: float
    below_tip: float = 0.0  #: Of the place where motion is measured (m)

    @cached_property
    def basis(self) -> Any:
        """scikit-fem's basis on all cells."""
        from skfem import Basis, ElementHexS2, ElementTetP2

        element = ElementHexS2() if self.mesh.kind == "hexahedron" else ElementTetP2()
        return Basis(to_skfem(self.mesh), element, intorder=4)

    @cached_property
    def pattern(self) -> BlockPattern:
        """Sparsity pattern of nodes that share a cell."""
        return BlockPattern(self.basis.element_dofs.T, self.basis.N)

    @cached_property
    def turns(self) -> Ints | None:
        """When each node is eliminated (n,): one nested dissection for all classes of motion."""
        order = nested_dissection(*self.pattern.upper())
        return None if order is None else np.argsort(order)

    @cached_property
    def matrices(self) -> tuple[Sparse, Sparse]:
        """Stiffness and mass (4 n, 4 n) of the whole, node by node over (u_x, u_y, u_z, φ)."""
        dtype = np.result_type(*(m.flux_tensor(self.unit) for m in self.known.values()))
        pattern = self.pattern
        stiffness = np.zeros((pattern.columns.size, 16), dtype=dtype)
        mass = np.zeros((pattern.columns.size, 1))
        for region, material in self.known.items():
            cells = self.basis.mesh.subdomains[region]
            tensor = material.flux_tensor(self.unit)
            for start in range(0, cells.size, _CHUNK):
                some = cells[start : start + _CHUNK]
                place = pattern.places(some)
                stiffness += place @ self._stiffness(some, tensor)
                mass += place @ (material.density * self._mass(some))
        copies = 2.0 ** len(mirror_axes(self.mesh))
        scalar = pattern.matrix(copies * mass)
        moving = sparse.csr_matrix(np.diag([1.0, 1.0, 1.0, 0.0]))
        return pattern.matrix(copies * stiffness), sparse.kron(scalar, moving, format="csr")

    def _stiffness(self, cells: Ints, tensor: Numbers) -> Numbers:
        """Blocks (cells · local · local, 16) of some cells."""
        if self.mesh.kind == "tetra":
            return self._straight_stiffness(cells, tensor)
        basis = self._on(cells)
        # (local, axis, cell, point)
        slopes = np.stack([field.grad for (field,) in basis.basis])
        n_local, _, n_cells, n_points = slopes.shape
        rows = slopes.transpose(2, 0, 1, 3).reshape(n_cells, 3 * n_local, n_points)
        gram = (rows * basis.dx[:, None, :]) @ rows.swapaxes(1, 2)
        pairs = gram.reshape(n_cells, n_local, 3, n_local, 3).swapaxes(2, 3).reshape(-1, 9)
        return np.asarray(pairs @ tensor.transpose(1, 3, 0, 2).reshape(9, 16))

    def _straight_stiffness(self, cells: Ints, tensor: Numbers) -> Numbers:
        """Stiffness of straight tetrahedra from one reference Gram matrix."""
        mapping = self.basis.mapping
        # slopes of quadratics are linear: order 2 is exact
        _, slopes, weights = self._reference(2)
        gram = np.einsum("ian,jbn,n->ijab", slopes, slopes, weights).reshape(-1, 9)
        inverse = mapping.invA[:, :, cells]
        turned = np.einsum("act,pcqd->tapqd", inverse, tensor, optimize=True)
        turned = np.einsum("bdt,tapqd,t->tabpq", inverse, turned, np.abs(mapping.detA[cells]))
        return np.asarray((gram @ turned.reshape(-1, 9, 16)).reshape(-1, 16))

    def _mass(self, cells: Ints) -> Floats:
        """∫ N_i N_j (cells · local · local, 1) of some cells."""
        if self.mesh.kind == "tetra":
            values, weights = self._reference(4)[0::2]
            products = np.einsum("in,jn,n->ij", values, values, weights)
            return np.outer(np.abs(self.basis.mapping.detA[cells]), products).reshape(-1, 1)
        basis = self._on(cells)
        values = np.stack([np.broadcast_to(field, basis.dx.shape) for (field,) in basis.basis])
        products = np.einsum("icn,jcn,cn->cij", values, values, basis.dx, optimize=True)
        return np.asarray(products).reshape(-1, 1)

    def _reference(self, order: int) -> tuple[Floats, Floats, Floats]:
        """Values (local, point), slopes (local, axis, point) and weights (point,).

        Those of the reference element, at the points of a rule that is exact to `order`.
        """
        from skfem.quadrature import get_quadrature

        element = self.basis.elem
        at, weights = get_quadrature(element.refdom, order)
        local = [element.lbasis(at, i) for i in range(len(self.basis.element_dofs))]
        return np.stack([v for v, _ in local]), np.stack([s for _, s in local]), weights

    def _on(self, cells: Ints) -> Any:
        from skfem import Basis

        return Basis(self.basis.mesh, self.basis.elem, intorder=4, elements=cells)

    def system(self, motion: Motion) -> SolidSystem:
        """System of one class of motion, of the whole body."""
        stiffness, mass = self.matrices
        unknowns = self._unknowns(motion)
        turns, place = self.turns, unknowns.index // 4
        nodal, scale = lumped(mass), np.array([1.0, 1.0, 1.0, self.unit])
        nodes: Floats = self.basis.doflocs.T
        source: Ints = np.arange(len(nodes))
        sign: Floats = np.ones((len(nodes), 4))
        if motion != "all":
            whole = mirrored_points(nodes, mirror_axes(self.mesh))
            nodes, source, sign = whole.points, whole.source, mirror_signs(motion, whole.turned)
        return SolidSystem(
            stiffness=unknowns.bordered(stiffness),
            mass=unknowns.bordered(mass),
            tip=unknowns.seen(self._tip_functionals()),
            measured=unknowns.seen(self._measured_functional()) if self.below_tip else None,
            expand=Expansion(unknowns, source, sign * scale),
            nodes=nodes,
            node_mass=nodal[source] / np.bincount(source)[source],
            volts_per_unit=self.unit,
            motion=motion,
            related=None if motion == "all" else self.system,
            others=OTHERS[len(mirror_axes(self.mesh))],
            elimination=None if turns is None else np.argsort(turns[place], kind="stable"),
            translation=unknowns.translation(np.ones(len(nodal))),
        )

    def _unknowns(self, motion: Motion) -> Unknowns:
        """Free unknowns, and those prescribed by base and electrodes."""
        (x, y, _), base = self.basis.doflocs, self._on_faces("base")
        piezo = np.zeros(self.basis.N, dtype=bool)
        for region, material in self.known.items():
            if material.piezo is not None:
                piezo[self.basis.element_dofs[:, self.basis.mesh.subdomains[region]]] = True
        outer, inner = (
            self._on_faces(*(name for name in self.mesh.faces if name.endswith(f"_{side}")))
            for side in ("outer", "inner")
        )
        field = piezo & ~outer & ~inner
        free = np.stack([~base, ~base, ~base, field], axis=-1)
        if motion != "all":
            for axis in mirror_axes(self.mesh):
                free[self._on_faces(MIRRORS[axis])] &= np.array(SIGNS[motion][axis]) > 0
        ports = np.zeros((*free.shape, 3))
        if motion in ("all", "bending_x"):
            ports[base, 0, 0] = 1.0
            ports[base, 2, 1] = x[base]
            ports[:, 3, 2] = outer / self.unit
        elif motion == "bending_y":
            ports[base, 1, 0] = 1.0
            ports[base, 2, 1] = y[base]
        return Unknowns(free, ports.reshape(-1, 3))

    def _on_faces(self, *names: str) -> Bools:
        """Mask of the nodes on named faces."""
        mask = np.zeros(self.basis.N, dtype=bool)
        for name in names:
            mask[self.basis.get_dofs(name).flatten()] = True
        return mask

    def _measured_functional(self) -> Floats:
        """(4 n, 1): mean u_x over the section at the place of measurement."""
        corners = self.mesh.points[self.mesh.cells]
        z = corners[..., 2]
        height = float(z.max()) - self.below_tip
        # no cell reaches out of the layers that there are at that height
        met = corners[(z.min(axis=1) < height) & (height <= z.max(axis=1))].reshape(-1, 3)
        share, line = np.polynomial.legendre.leggauss(_POINTS)
        x, y = (np.interp(share, [-1.0, 1.0], [met[:, k].min(), met[:, k].max()]) for k in (0, 1))
        points = np.stack([*map(np.ravel, np.meshgrid(x, y)), np.full(x.size * y.size, height)])
        weights = np.outer(line, line).ravel()
        out = np.zeros((self.basis.N, 4, 1))
        out[:, 0, 0] = weights @ self.basis.probes(points) / weights.sum()
        return out.reshape(-1, 1)

    def _tip_functionals(self) -> Floats:
        """(4 n, 2): mean u_x over the tip face, and mean rotation from u_z = (x − x̄) ψ.

        x̄ is the middle of the face, which need not be at x = 0: the bimorph's extension is no
        rotation.
        """
        from skfem import FacetBasis, LinearForm

        facets = self.basis.mesh.boundaries["tip"]
        basis = FacetBasis(self.basis.mesh, self.basis.elem, facets=facets, intorder=5)
        area = LinearForm(lambda v, _: v).assemble(basis)
        lever, second = (
            LinearForm(lambda v, w, power=power: w.x[0] ** power * v).assemble(basis)
            for power in (1, 2)
        )
        middle = 0.0 if 0 in mirror_axes(self.mesh) else lever.sum() / area.sum()
        lever = lever - middle * area
        inertia = second.sum() - middle**2 * area.sum()
        out = np.zeros((self.basis.N, 4, 2))
        out[:, 0, 0] = area / area.sum()
        out[:, 2, 1] = lever / inertia
        return out.reshape(-1, 2)
