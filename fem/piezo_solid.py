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

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from fem.skfem_mesh import to_skfem
from geometry.arrays import Bools, Floats, Ints, Numbers, Sparse
from geometry.materials import (
    Piezoceramic,
    PiezoTensors,
    isotropic_stiffness,
    orthotropic_stiffness,
)
from geometry.mesh import Mesh
from geometry.parameters import Device

#: Voigt index of a pair of axes.
_VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
#: Port unknowns at the end of the reduced system.
BASE_W, BASE_PSI, ELECTRODE = -3, -2, -1


@dataclass(frozen=True)
class SolidSystem:
    """Assembled solid over y = [free displacements and potentials, w_base, ψ_base, U].

    Attributes
    ----------
    stiffness : (n, n) sparse
        Symmetric indefinite; complex when lossy.  Its last row is minus the charge.
    mass : (n, n) sparse
        Zero in the rows of potentials.
    tip : (n, 2) array
        Columns give tip displacement and tip rotation from y, and port forces to y.
    expand : (4 * n_nodes, n) sparse
        All of (u_x, u_y, u_z, φ) at the nodes from y, in metres and volts.
    nodes : (n_nodes, 3) array
        Where the nodes are (m).
    node_mass : (n_nodes,) array
        Lumped mass (kg), for weighing modes.
    potentials : int
        Number of free potential unknowns.
    volts_per_unit : float
        Size of the potential's unit (V); U is in volts all the same.
    """

    stiffness: Sparse
    mass: Sparse
    tip: Floats
    expand: Sparse
    nodes: Floats
    node_mass: Floats
    potentials: int
    volts_per_unit: float

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.stiffness.shape[0])


@dataclass(frozen=True)
class _Material:
    """Tensors of one region; e and eps None where there is no field."""

    c: Numbers
    density: float
    piezo: PiezoTensors | None = None


def assemble(
    device: Device, mesh: Mesh, *, lossy: bool, ceramic: Piezoceramic | None = None
) -> SolidSystem:
    """Assemble the solid model of `device` on `mesh`.

    Parameters
    ----------
    device : Device
        Materials and poling.
    mesh : Mesh
        Regions among piezo_top, piezo_bottom, shim, glue, rod; faces as named there.
    lossy : bool
        Take the ceramic's Q and tan δ into account (complex matrices).
    ceramic : Piezoceramic, optional
        Full material to use instead of the device's own, for studies of the tensor.
    """
    from skfem import Basis, ElementHexS2, ElementTetP2

    domain = to_skfem(mesh)
    element = ElementHexS2() if mesh.kind == "hexahedron" else ElementTetP2()
    # straight quadratic tetrahedra have linear gradients: order 2 is exact for stiffness
    order = 2 if mesh.kind == "tetra" else 4
    materials = _materials(device, mesh.regions, ceramic or device.piezo.ceramic(), lossy=lossy)
    whole = Basis(domain, element, intorder=4)
    n = whole.N
    dtype = complex if lossy else float
    stiffness = _Blocks(n, dtype)
    mass_scalar = sparse.csr_matrix((n, n))
    active = np.zeros(n, dtype=bool)
    for region, material in materials.items():
        cells = domain.subdomains[region]
        gradients = Basis(domain, element, intorder=order, elements=cells)
        values = Basis(domain, element, intorder=4, elements=cells)
        stiffness.add(_gram(gradients), material)
        mass_scalar = mass_scalar + material.density * _mass(values)
        if material.piezo is not None:
            active[np.unique(whole.element_dofs[:, cells])] = True
    unit = _volts_per_unit(materials)
    transform = _Constraint(whole, domain, active, unit)
    expand = transform.matrix()
    k = (expand.T @ stiffness.matrix() @ expand).tocsr()
    m = (
        expand.T @ sparse.block_diag([mass_scalar] * 3 + [sparse.csr_matrix((n, n))]) @ expand
    ).tocsr()
    tip = expand.T @ _tip_functionals(domain, element, n)
    return SolidSystem(
        stiffness=k,
        mass=m,
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


def _materials(
    device: Device, regions: tuple[str, ...], ceramic: Piezoceramic, *, lossy: bool
) -> dict[str, _Material]:
    tensors = ceramic.tensors(lossy=lossy)
    turned = PiezoTensors(tensors.c, device.bimorph.poling_sign * tensors.e, tensors.eps)
    piezo = _Material(tensors.c, ceramic.density, turned)
    shim, glue, rod = device.shim, device.glue, device.rod
    across = shim.transverse_modulus or 2.0 * (1.0 + shim.poisson_ratio) * shim.shear_modulus
    known = {
        "piezo_top": piezo,
        "piezo_bottom": piezo,
        "shim": _Material(
            orthotropic_stiffness(
                shim.youngs_modulus, across, shim.shear_modulus, shim.poisson_ratio
            ),
            shim.density,
        ),
        "glue": _Material(
            isotropic_stiffness(glue.youngs_modulus, glue.poisson_ratio), glue.density
        ),
        "rod": _Material(isotropic_stiffness(rod.youngs_modulus, rod.poisson_ratio), rod.density),
    }
    return {region: known[region] for region in regions}


def _volts_per_unit(materials: dict[str, _Material]) -> float:
    """Return the voltage whose field energy is that of a unit displacement's strain energy."""
    piezo = next(m.piezo for m in materials.values() if m.piezo is not None)
    return float(np.sqrt(np.abs(piezo.c[0, 0] / piezo.eps[0, 0])))


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

    def add(self, gram: dict[tuple[int, int], Sparse], material: _Material) -> None:
        """Add one region; entries of the tensors that vanish cost nothing."""
        for p in range(3):
            for q in range(p, 3):
                self._combine(p, q, gram, material.c[np.ix_(_VOIGT[p], _VOIGT[q])])
        if material.piezo is None:
            return
        for p in range(3):
            self._combine(p, 3, gram, material.piezo.e[:, _VOIGT[p]].T)
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
    """Rigid base section, equipotential electrodes, no potential outside the ceramic."""

    def __init__(self, whole: Any, domain: Any, active: Bools, unit: float) -> None:
        def dofs(*names: str) -> Ints:
            return np.unique(np.concatenate([whole.get_dofs(name).flatten() for name in names]))

        self._n, self._unit, self._x = whole.N, unit, whole.doflocs[0]
        self._base = dofs("base")
        self._outer = dofs("electrode_top_outer", "electrode_bottom_outer")
        inner = dofs("electrode_top_inner", "electrode_bottom_inner")
        free = np.ones(self._n, dtype=bool)
        free[self._base] = False
        self._free_u = np.flatnonzero(free)
        field = active.copy()
        field[self._outer] = field[inner] = False
        self._free_phi = np.flatnonzero(field)
        self.potentials = self._free_phi.size

    def matrix(self) -> Sparse:
        """Return (4 n, n_y): nodal (u, φ) from y, φ scaled by its unit."""
        n, u, phi, base = self._n, self._free_u, self._free_phi, self._base
        free = np.concatenate([u, n + u, 2 * n + u, 3 * n + phi])
        value = np.concatenate([np.ones(3 * u.size), np.full(phi.size, self._unit)])
        k = free.size
        rows = np.concatenate([free, base, 2 * n + base, 3 * n + self._outer])
        columns = np.concatenate(
            [
                np.arange(k),
                np.full(base.size, k),
                np.full(base.size, k + 1),
                np.full(self._outer.size, k + 2),
            ]
        )
        values = np.concatenate(
            [value, np.ones(base.size), self._x[base], np.ones(self._outer.size)]
        )
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
