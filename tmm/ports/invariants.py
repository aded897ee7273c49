"""What no passive, reciprocal multiport may break, whatever it is made of."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.ports.multiport import Multiport, balanced


def symmetric_form(port: Multiport) -> Complex:
    """Return S (n, k, k), D with each row times its pair's sign: symmetric if reciprocal."""
    signs = np.array([p.pair.sign for p in port.ports])
    return np.asarray(port.stiffness * signs[:, None])


def passivity_margin(port: Multiport) -> Floats:
    """Return the smallest eigenvalue (n,) of the dissipation form, scaled to the largest.

    The mean power taken in is ½ Ω Im(xᴴ S x); a passive model has Im S positive semidefinite,
    so the margin is ≥ 0 up to rounding.
    """
    s = balanced(symmetric_form(port))
    eigenvalues = np.linalg.eigvalsh(0.5 * (s.imag + s.imag.transpose(0, 2, 1)))
    return np.asarray(eigenvalues[:, 0] / np.maximum(np.abs(eigenvalues).max(axis=1), 1e-300))


def reciprocity_error(port: Multiport) -> Floats:
    """Return max |S − Sᵀ| (n,), each entry relative to its two diagonal neighbours."""
    s = symmetric_form(port)
    size = np.sqrt(np.abs(np.einsum("nii->ni", s)))
    scale = np.maximum(size[:, :, None] * size[:, None, :], np.abs(s))
    scale = np.where(scale > 0.0, scale, 1.0)  # where nothing couples
    return np.asarray((np.abs(s - s.transpose(0, 2, 1)) / scale).max(axis=(1, 2)))
