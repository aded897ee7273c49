"""How a bimorph can move: classes of motion, and which of them a mode is of."""

from __future__ import annotations

from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats

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
    """Rigid motions of sections, each squared twice its kinetic energy over ω².

    Nodes are gathered in slices along z; in each the displacement is fitted by translations
    along x, y and z, by rotations in x and y and by twist.

    Parameters
    ----------
    nodes : (n, 3) array
        Where the nodes are (m).
    mass : (n,) array
        Of the nodes (kg).
    displacement : (n, 3, k) array
        Of k motions.

    Returns
    -------
    (6, slices, k) array
        Linear in the displacement.
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
    """Class that holds most of the energy `total`, and its share.

    Parameters
    ----------
    motions : (6, slices) array
        See :func:`section_motions`.
    """
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
