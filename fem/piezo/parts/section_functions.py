"""What displacement and potential may look like at a section far from all ends.

Whatever happens at the ends of a uniform stretch, its middle sees little of but a few shapes of
deformation: those of Saint-Venant's solutions, and others that decay the more slowly the longer
their waves.  The shapes are the left singular vectors of the map from the values at both ends
to those in the middle, the best there are for a given number (Babuška and Lipton, Multiscale
Model. Simul. 9, 2011), found from random ends (Buhr and Smetana, SIAM J. Sci. Comput. 40, 2018).
To these static shapes comes what the inertia of sections that move rigidly adds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from tactgen.fem.piezo.bricks import (
    elimination_order,
    loss_matrix,
    quarter_matrices,
    quarter_unknowns,
)
from tactgen.fem.piezo.symmetry import Motion
from tactgen.fem.piezo.system import Material, volts_per_unit
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.store.values import storable

#: Random ends that are tried: the shapes that they find are fewer by far.
_TRIED = 60
#: Degree of the polynomials in x and in y that random ends are made of.
_DEGREE = 6


@storable
@dataclass(frozen=True)
class SectionFunctions:
    """Shapes at a section, orthonormal over its nodes.

    Attributes
    ----------
    values : (4 m, s) array
        (u_x, u_y, u_z, φ) at the m nodes of the section's grid, y fastest: first shapes of
        displacement, then shapes of potential.  The very first is the same along all of a body
        that moves along an axis, or twists.
    moving : int
        How many are shapes of displacement.
    """

    values: Floats
    moving: int


def section_functions(
    middle: Bricks,
    known: dict[str, Material],
    losses: dict[str, Material],
    motion: Motion,
    share: float,
) -> SectionFunctions:
    """Return the shapes that the middle of a stretch sees of its ends, a voltage, inertia, losses.

    Parameters
    ----------
    middle : Bricks
        The stretch; its middle is a break point along z.
    known, losses : dict of str to Material
        Lossless materials, and the imaginary parts of those with losses.
    motion : str
        Class of motion.
    share : float
        Least singular value of a shape that counts, relative to the largest of displacement.
    """
    unit = volts_per_unit(known)
    stiffness, mass = quarter_matrices(middle, known, unit)
    unknowns = quarter_unknowns(middle, motion, unit, has_base=False)
    free = unknowns.free.reshape(*middle.shape, 4)
    ends = np.zeros_like(free)
    ends[:, :, [0, -1]] = free[:, :, [0, -1]]
    given = ends.ravel()
    inner = free.ravel() & ~given
    at = np.flatnonzero(inner)
    place = elimination_order(middle)
    order = np.argsort(4 * place[at // 4] + at % 4)
    values = np.zeros((free.size, _TRIED + 1))
    values[given, :_TRIED] = _random_ends(middle)[given]
    values[:, _TRIED] = unknowns.ports[:, 2]
    factor = factorise(stiffness[at][:, at], order=order)
    values[at] -= factor.solve((stiffness @ values)[at])
    rigid = _rigid(middle, motion)
    more = [(mass @ _moved(middle, rigid))[at]]
    if motion == "bending_x":
        more.append((loss_matrix(middle, losses, unit) @ values)[at])
    inertia, *lossy = (factor.solve(loads) for loads in more)
    shown = [np.hstack([values[at], *lossy]), np.hstack([values[at][:, _TRIED:], inertia])]
    seen, own = (_at_middle(fields, at, free) for fields in shown)
    potential = np.arange(seen.shape[0]) % 4 == 3
    # potential is in units that give it the size of a displacement: one measure for both
    least = share * float(np.linalg.norm(seen[~potential], 2))
    u, phi = (
        _strongest(seen, own, rows, first, share, least)
        for rows, first in ((~potential, rigid), (potential, rigid[:, :0]))
    )
    return SectionFunctions(np.hstack([u, phi]), u.shape[1])


def _at_middle(fields: Floats, at: Ints, free: Bools) -> Floats:
    """Return what the middle section (4 m, k) sees of fields (n, k) at some unknowns."""
    values = np.zeros((free.size, fields.shape[1]))
    values[at] = fields
    shaped = values.reshape(*free.shape, -1)
    return shaped[:, :, free.shape[2] // 2].reshape(-1, fields.shape[1])


def _random_ends(middle: Bricks) -> Floats:
    """Return random polynomials at both ends (4 n, tried), zero elsewhere.

    Noise from node to node would ask for bricks as short along z as the finest across.
    """
    x, y = (
        legendre.legvander(axis.nodes / axis.nodes[-1], _DEGREE) for axis in (middle.x, middle.y)
    )
    amplitudes = np.random.default_rng(0).standard_normal((_DEGREE + 1, _DEGREE + 1, 2, 4, _TRIED))
    values = np.zeros((*middle.shape, 4, _TRIED))
    values[:, :, [0, -1]] = np.einsum("xi,yj,ijeck->xyeck", x, y, amplitudes, optimize=True)
    return values.reshape(-1, _TRIED)


def _moved(middle: Bricks, rigid: Floats) -> Floats:
    """Return the section's rigid motions (4 n, 2 k), the same all along z and growing with it."""
    nx, ny, nz = middle.shape
    z = middle.z.nodes / middle.z.nodes[-1] - 0.5
    along = np.stack([np.ones(nz), z])
    moved = np.einsum("xyck,jz->xyzcjk", rigid.reshape(nx, ny, 4, -1), along)
    return np.asarray(moved.reshape(4 * nx * ny * nz, -1))


def _rigid(middle: Bricks, motion: Motion) -> Floats:
    """Return the rigid motions (4 m, k) of the section that a class of motion has."""
    x, y = np.meshgrid(middle.x.nodes, middle.y.nodes, indexing="ij")
    still, one = np.zeros_like(x), np.ones_like(x)
    fields = {
        "bending_x": [(one, still, still), (still, still, x)],
        "bending_y": [(still, one, still), (still, still, y)],
        "torsion": [(-y, x, still)],
        "axial": [(still, still, one)],
    }[motion]
    columns = np.array([np.stack([*field, still], axis=-1).ravel() for field in fields]).T
    return np.asarray(np.linalg.qr(columns)[0])


def _strongest(
    seen: Floats, own: Floats, rows: Bools, rigid: Floats, share: float, least: float
) -> Floats:
    """Return the shapes above `least` in some rows of what is seen.

    Rigid motions come first: they must be there to rounding, or the joint would resist them.
    Last comes what is new in `own`, what a voltage and inertia show, each by its own measure.
    """
    here, single = (np.where(rows[:, None], fields, 0.0) for fields in (seen, own))
    here, single = (fields - rigid @ (rigid.T @ fields) for fields in (here, single))
    shapes, sizes, _ = np.linalg.svd(here, full_matrices=False)
    # exactly: what has no displacement has no mass, and counts as a potential
    shapes = np.where(rows[:, None], shapes, 0.0)
    shapes = np.hstack([rigid, shapes[:, sizes > least]])
    for field in single.T:
        left = field - shapes @ (shapes.T @ field)
        if np.linalg.norm(left) > share * np.linalg.norm(field):
            left -= shapes @ (shapes.T @ left)
            shapes = np.column_stack([shapes, left / np.linalg.norm(left)])
    return shapes
