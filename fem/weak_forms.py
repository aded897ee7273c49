"""The weak forms of both actuators in scikit-fem's terms, and one assembler for all of them.

Every matrix of these models is ∫ B(v)ᵀ C B(u) dV with a generalised strain B, the mathematics, and
a tensor C, the material:

    matrix           B                              C
    piezo stiffness  (S(u), grad φ)                 [[c, eᵀ], [e, −ε]]
    mass             u                              ρ
    Poisson          grad φ                         µ or ε
    curl–curl        curl A                         dH/dB
    half section     (−r ∂u/∂z, 2u + r ∂u/∂r)       2π r dH/dB     (u = A_φ / r)

`notebooks/chain_bimorph.py` and `notebooks/chain_reluctance.py` solve a device each with nothing
else; the rooms `piezo` and `magnetics` assemble the same matrices faster, which
`tests/fem/test_weak_forms.py` holds to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats, Numbers, Sparse

#: Volts per unit of the potential: fields, strains and their products are then of like size.
GIGAVOLT = 1e9


def assemble(basis: Any, operator: Callable[..., Floats], tensor: Numbers) -> Sparse:
    """Matrix ∫ B(v)ᵀ C B(u) dV of a scikit-fem basis, B taken once of each local function.

    Parameters
    ----------
    basis : skfem.Basis
        Functions and quadrature, on all cells or on those of one material.
    operator : callable
        B (s, cells, points) of the fields of one function.
    tensor : (s, s) or (s, s, cells, points) array
        C, symmetric.
    """
    strains = np.stack([operator(*function) for function in basis.basis])
    points = tensor.reshape(*tensor.shape, *(1, 1)[: 4 - tensor.ndim])
    stresses = np.einsum("stcq,jtcq->jscq", points, strains * basis.dx, optimize=True)
    by_cell = (basis.dx.shape[0], strains.shape[0], -1)
    left, right = (x.transpose(2, 0, 1, 3).reshape(by_cell) for x in (strains, stresses))
    local = left @ right.swapaxes(1, 2)
    dofs = basis.element_dofs.T
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    entries = (local.ravel(), (rows.ravel(), columns.ravel()))
    return sparse.coo_matrix(entries, shape=(basis.N, basis.N)).tocsr()


def strain(u: Any) -> Floats:
    """S(u) (6, cells, points) in Voigt's order xx yy zz yz xz xy, shears doubled."""
    s = u.grad
    shears = (s[1, 2] + s[2, 1], s[0, 2] + s[2, 0], s[0, 1] + s[1, 0])
    return np.stack([s[0, 0], s[1, 1], s[2, 2], *shears])


def piezo_strain(u: Any, potential: Any) -> Floats:
    """B = (S, grad φ) (9, cells, points)."""
    return np.concatenate([strain(u), potential.grad])


def piezo_tensor(material: Material) -> Numbers:
    """C = [[c, eᵀ], [e, −ε]] (9, 9) with the potential in gigavolts."""
    if material.piezo is None:
        return np.pad(material.c, (0, 3))
    e, eps = GIGAVOLT * material.piezo.e, GIGAVOLT**2 * material.piezo.eps
    return np.block([[material.c, e.T], [e, -eps]])


def section_flux(radius: Floats) -> Callable[[Any], Floats]:
    """B_r and B_z (2, cells, points) of u = A_φ / r at points of this radius (m)."""
    return lambda u: np.stack([-radius * u.grad[1], 2.0 * u + radius * u.grad[0]])
