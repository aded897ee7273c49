"""The piezoelectric solid: displacement and potential on a 3D mesh, seen at five ports.

Strong form: div T = ρ ü, div D = 0 with T = c S − eᵀ E, D = e S + ε E, E = −grad φ.
Weak form, for all (v, ψ):

    ∫ S(v)ᵀ c S(u) + S(v)ᵀ eᵀ grad φ − Ω² ρ v·u dV   = port forces
    ∫ grad ψ · e S(u) − grad ψ · ε grad φ dV          = −charge

Electrodes are equipotential: both outer faces at U, both shim faces at 0.  The base
face moves as a rigid section (w, ψ; no motion along y or z); tip displacement and
rotation are the means over the tip face that are work-conjugate to a uniform and a
linear traction.  The potential is carried in units that give it the size of a
displacement, so that all entries of the system are alike.

Assembly uses one idea: with scalar shape functions N_i, all blocks are combinations of
the nine Gram matrices G_ab = ∫ ∂_a N_i ∂_b N_j per region.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from fem.bimorph.bordered import Bordered
from fem.bimorph.bricks.assembly import assemble_bricks
from fem.bimorph.system import VOIGT, Material, SolidSystem, materials, volts_per_unit
from fem.elements.skfem_mesh import to_skfem
from geometry.arrays import Bools, Floats, Ints, Numbers, Sparse
from geometry.bimorph.bricks import Bricks
from geometry.device.materials import Piezoceramic
from geometry.device.parameters import Device
from geometry.meshing.mesh import Mesh


def assemble(
    device: Device,
    mesh: Mesh | Bricks,
    *,
    lossy: bool,
    ceramic: Piezoceramic | None = None,
    uniform_field: bool = False,
) -> SolidSystem:
    """Assemble the solid model of `device` on `mesh`, all that its ports can move.

    Bricks are the business of :mod:`fem.bimorph.bricks.assembly`; other cells are scikit-fem's:
    quadratic tetrahedra of ten nodes, and hexahedra of twenty.

    Parameters
    ----------
    device : Device
        Materials and poling.
    mesh : Mesh or Bricks
        Regions among piezo_top, piezo_bottom, shim, glue, rod; faces as named there.
    lossy : bool
        Take the ceramic's Q and tan δ into account (complex matrices).
    ceramic : Piezoceramic, optional
        Full material to use instead of the device's own, for studies of the tensor.
    uniform_field : bool
        Let the potential be linear through each layer, as beam theories have it.
    """
    if isinstance(mesh, Bricks):
        return assemble_bricks(
            device, mesh, lossy=lossy, ceramic=ceramic, uniform_field=uniform_field
        )
    from skfem import Basis, ElementHexS2, ElementTetP2

    domain = to_skfem(mesh)
    element = ElementHexS2() if mesh.kind == "hexahedron" else ElementTetP2()
    # straight quadratic tetrahedra have linear gradients: order 2 is exact for stiffness
    order = 2 if mesh.kind == "tetra" else 4
    known = materials(device, mesh.regions, ceramic or device.piezo.ceramic(), lossy=lossy)
    whole = Basis(domain, element, intorder=4)
    n = whole.N
    dtype = complex if lossy else float
    stiffness = _Blocks(n, dtype)
    mass_scalar = sparse.csr_matrix((n, n))
    active = np.zeros(n, dtype=bool)
    for region, material in known.items():
        cells = domain.subdomains[region]
        gradients = Basis(domain, element, intorder=order, elements=cells)
        values = Basis(domain, element, intorder=4, elements=cells)
        stiffness.add(_gram(gradients), material)
        mass_scalar = mass_scalar + material.density * _mass(values)
        if material.piezo is not None:
            active[np.unique(whole.element_dofs[:, cells])] = True
    unit = volts_per_unit(known)
    transform = _Constraint(whole, active, unit, device if uniform_field else None)
    expand = transform.matrix()
    k = expand.T @ stiffness.matrix() @ expand
    m = expand.T @ sparse.block_diag([mass_scalar] * 3 + [sparse.csr_matrix((n, n))]) @ expand
    tip = expand.T @ _tip_functionals(domain, element, n)
    return SolidSystem(
        stiffness=Bordered.cut(k),
        mass=Bordered.cut(m),
        tip=np.asarray(tip),
        expand=expand,
        nodes=whole.doflocs.T,
        node_mass=_lumped(mass_scalar),
        potentials=transform.potentials,
        volts_per_unit=unit,
    )


def _lumped(mass: Sparse) -> Floats:
    """Return nodal masses in proportion to the diagonal (row sums are negative at corners)."""
    diagonal = np.asarray(mass.diagonal())
    return np.asarray(diagonal * (mass.sum() / diagonal.sum()))


def _gram(basis: Any) -> dict[tuple[int, int], Sparse]:
    """Return G_ab = ∫ ∂_a N_i ∂_b N_j for a ≤ b; the rest are transposes."""
    from skfem import BilinearForm

    def form(a: int, b: int) -> Sparse:
        # first argument is the column (trial) function
        return BilinearForm(lambda u, v, _: v.grad[a] * u.grad[b]).assemble(basis)

    return {(a, b): form(a, b) for a in range(3) for b in range(a, 3)}


def _mass(basis: Any) -> Sparse:
    from skfem import BilinearForm

    return BilinearForm(lambda u, v, _: u * v).assemble(basis)


class _Blocks:
    """The 4 x 4 block matrix over (u_x, u_y, u_z, φ), filled region by region."""

    def __init__(self, n: int, dtype: type) -> None:
        self._blocks = [
            [sparse.csr_matrix((n, n), dtype=dtype) for _ in range(4)] for _ in range(4)
        ]

    def add(self, gram: dict[tuple[int, int], Sparse], material: Material) -> None:
        """Add one region; entries of the tensors that vanish cost nothing."""
        for p in range(3):
            for q in range(p, 3):
                self._combine(p, q, gram, material.c[np.ix_(VOIGT[p], VOIGT[q])])
        if material.piezo is None:
            return
        for p in range(3):
            self._combine(p, 3, gram, material.piezo.e[:, VOIGT[p]].T)
        self._combine(3, 3, gram, -material.piezo.eps)

    def _combine(
        self, p: int, q: int, gram: dict[tuple[int, int], Sparse], weights: Numbers
    ) -> None:
        for a in range(3):
            for b in range(3):
                if weights[a, b] != 0.0:
                    g = gram[a, b] if a <= b else gram[b, a].T
                    self._blocks[p][q] = self._blocks[p][q] + weights[a, b] * g

    def matrix(self) -> Sparse:
        """Return the full symmetric matrix."""
        rows = [
            [self._blocks[p][q] if p <= q else self._blocks[q][p].T for q in range(4)]
            for p in range(4)
        ]
        return sparse.bmat(rows, format="csr")


class _Constraint:
    """Rigid base section, equipotential electrodes, no potential outside the ceramic.

    With `uniform` the potential is prescribed everywhere: linear through that device's layers.
    """

    def __init__(self, whole: Any, active: Bools, unit: float, uniform: Device | None) -> None:
        def dofs(*names: str) -> Ints:
            return np.unique(np.concatenate([whole.get_dofs(name).flatten() for name in names]))

        self._n, self._unit, self._x = whole.N, unit, whole.doflocs[0]
        self._base = dofs("base")
        outer = dofs("electrode_top_outer", "electrode_bottom_outer")
        inner = dofs("electrode_top_inner", "electrode_bottom_inner")
        self._driven, self._potential = outer, np.ones(outer.size)
        free = np.ones(self._n, dtype=bool)
        free[self._base] = False
        self._free_u = np.flatnonzero(free)
        field = active.copy()
        field[outer] = field[inner] = False
        if uniform is not None:
            self._driven = np.flatnonzero(active)
            bimorph = uniform.bimorph
            depth = np.abs(self._x[self._driven]) - 0.5 * bimorph.shim_thickness
            self._potential = depth / bimorph.piezo_thickness
            field[:] = False
        self._free_phi = np.flatnonzero(field)
        self.potentials = self._free_phi.size

    def matrix(self) -> Sparse:
        """Return (4 n, n_y): nodal (u, φ) from y, φ scaled by its unit."""
        n, u, phi, base = self._n, self._free_u, self._free_phi, self._base
        free = np.concatenate([u, n + u, 2 * n + u, 3 * n + phi])
        value = np.concatenate([np.ones(3 * u.size), np.full(phi.size, self._unit)])
        k = free.size
        rows = np.concatenate([free, base, 2 * n + base, 3 * n + self._driven])
        columns = np.concatenate(
            [
                np.arange(k),
                np.full(base.size, k),
                np.full(base.size, k + 1),
                np.full(self._driven.size, k + 2),
            ]
        )
        values = np.concatenate([value, np.ones(base.size), self._x[base], self._potential])
        return sparse.csr_matrix((values, (rows, columns)), shape=(4 * n, k + 3))


def _tip_functionals(domain: Any, element: Any, n: int) -> Floats:
    """Return (4 n, 2): mean u_x over the tip face, and mean rotation from u_z = x ψ."""
    from skfem import FacetBasis, LinearForm

    basis = FacetBasis(domain, element, facets=domain.boundaries["tip"], intorder=5)
    area = LinearForm(lambda v, _: v).assemble(basis)
    lever = LinearForm(lambda v, w: w.x[0] * v).assemble(basis)
    inertia = LinearForm(lambda v, w: w.x[0] ** 2 * v).assemble(basis).sum()
    out = np.zeros((4 * n, 2))
    out[:n, 0] = area / area.sum()
    out[2 * n : 3 * n, 1] = lever / inertia
    return out
