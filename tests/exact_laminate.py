"""Exact three-dimensional solution of a piezoelectric laminate in cylindrical bending.

Layers stacked along x, endless in y (no strain), simply supported at z = 0 and z = L where also
φ = 0.  With p = n π / L

    u_x = W(x) sin pz,  u_z = U(x) cos pz,  φ = Φ(x) sin pz,
    σ_xx = S sin pz,    τ_xz = T cos pz,    D_x = D sin pz

turn the equations of motion and Gauss's law of each layer into y' = A y for the state
y = [U, W, Φ, T, S, D], which is continuous from layer to layer; a layer of thickness h is
exp(A h).  This is Pagano's solution (J. Compos. Mater. 3, 1969, 398) with the electric field as
Heyliger and Brooks (Int. J. Solids Struct. 32, 1995, 2945) add it.  Computed with 40 digits; owes
nothing to :mod:`fem`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import numpy as np

_DIGITS = 40
_XX, _ZZ, _XZ = 0, 2, 4
_U, _W, _PHI, _T, _S, _D = range(6)


@dataclass(frozen=True)
class Layer:
    """One layer: thickness (m), density (kg/m³) and tensors in Voigt order xx yy zz yz xz xy.

    `c` (6, 6) in Pa, `e` (3, 6) in C/m² with engineering strains, `eps` (3, 3) in F/m.
    """

    thickness: float
    density: float
    c: Any
    e: Any
    eps: Any


@dataclass(frozen=True)
class Laminate:
    """Layers from low to high x, and the half wave length L (m) along z."""

    layers: tuple[Layer, ...]
    length: float

    def transfer(self, omega: Any) -> Any:
        """6 x 6 matrix from the lowest to the highest face at angular frequency ω."""
        with mp.workdps(_DIGITS):
            whole = mp.eye(6)
            for layer in self.layers:
                system = _system(layer, mp.pi / mp.mpf(self.length), mp.mpf(omega))
                whole = mp.expm(system * mp.mpf(layer.thickness), method="taylor") * whole
            return whole


def _system(layer: Layer, p: Any, omega: Any) -> Any:
    """A of y' = A y, from the constitutive law T = c S − eᵀ E, D = e S + ε E."""
    c, e, eps = (np.asarray(v) for v in (layer.c, layer.e, layer.eps))
    inertia = mp.mpf(layer.density) * omega**2
    c_xx, c_xz, c_zz, c_s = (mp.mpf(float(c[i, j])) for i, j in ((0, 0), (0, 2), (2, 2), (4, 4)))
    e_xx, e_xz = mp.mpf(float(e[0, _XX])), mp.mpf(float(e[0, _ZZ]))
    e_s = mp.mpf(float(e[2, _XZ]))
    k_x, k_z = mp.mpf(float(eps[0, 0])), mp.mpf(float(eps[2, 2]))
    # [S, D] = [[c_xx, e_xx], [e_xx, −k_x]] [W', Φ'] − p [c_xz, e_xz] U
    normal = mp.inverse(mp.matrix([[c_xx, e_xx], [e_xx, -k_x]]))
    a = mp.zeros(6)
    a[_U, _T], a[_U, _PHI], a[_U, _W] = 1 / c_s, -e_s * p / c_s, -p
    for row, line in ((_W, 0), (_PHI, 1)):
        a[row, _S], a[row, _D] = normal[line, 0], normal[line, 1]
        a[row, _U] = p * (normal[line, 0] * c_xz + normal[line, 1] * e_xz)
    # σ_zz = c_xz W' − c_zz p U + e_xz Φ';  T' = −p σ_zz − ρω² U
    for column in (_U, _S, _D):
        a[_T, column] = -p * (c_xz * a[_W, column] + e_xz * a[_PHI, column])
    a[_T, _U] += p**2 * c_zz - inertia
    a[_S, _T], a[_S, _W] = p, -inertia
    # D_z = e_s (U' + p W) − k_z p Φ;  D' = p D_z
    for column in (_T, _PHI, _W):
        a[_D, column] = p * e_s * a[_U, column]
    a[_D, _W] += p**2 * e_s
    a[_D, _PHI] -= p**2 * k_z
    return a


def static_state(
    laminate: Laminate, *, pressure: tuple[float, float], faces: tuple[float | None, float | None]
) -> tuple[Any, Any]:
    """Y at the lowest and the highest face, at rest.

    Parameters
    ----------
    pressure : (float, float)
        σ_xx (Pa) at the lowest and the highest face.
    faces : (float or None, float or None)
        Potentials (V) there; None is a face without charge (D = 0).
    """
    with mp.workdps(_DIGITS):
        t = laminate.transfer(0)
        rows = [(_T, 0), (_S, pressure[1]), _electric(faces[1])]
        start = mp.zeros(6, 1)
        start[_S] = mp.mpf(pressure[0])
        at, value = _electric(faces[0])
        start[at] = value
        free = [_U, _W, _D if at == _PHI else _PHI]
        system, right = mp.zeros(3), mp.zeros(3, 1)
        given = t * start
        for i, (row, wanted) in enumerate(rows):
            right[i] = mp.mpf(wanted) - given[row]
            for j, column in enumerate(free):
                system[i, j] = t[row, column]
        found = mp.lu_solve(system, right)
        for j, column in enumerate(free):
            start[column] = found[j]
        return start, t * start


def _electric(potential: float | None) -> tuple[int, Any]:
    return (_D, mp.mpf(0)) if potential is None else (_PHI, mp.mpf(potential))


def natural_frequency(
    laminate: Laminate, guess: float, *, grounded: Sequence[bool] = (True, True)
) -> float:
    """Natural frequency (Hz) nearest `guess` with free faces.

    A face is grounded (φ = 0) or without charge (D = 0).
    """
    below = [_U, _W, _D if grounded[0] else _PHI]
    above = [_T, _S, _PHI if grounded[1] else _D]

    def defect(frequency: Any) -> Any:
        t = laminate.transfer(2 * mp.pi * frequency)
        block = mp.matrix([[t[i, j] for j in below] for i in above])
        return mp.det(block)

    with mp.workdps(_DIGITS):
        scale = defect(mp.mpf(guess))
        root = mp.findroot(lambda f: defect(f) / scale, (guess, 1.001 * guess), tol=1e-24)
        return float(root)
