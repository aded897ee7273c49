"""What displacement and potential may look like at a section far from all ends.

Whatever happens at the ends of a uniform stretch, its middle sees little of but a few shapes of
deformation: those of Saint-Venant's solutions, and others that decay the more slowly the longer
their waves.  The shapes are the left singular vectors of the map from the values at both ends
to those in the middle, the best there are for a given number (Babuška and Lipton, Multiscale
Model. Simul. 9, 2011), found from random ends (Buhr and Smetana, SIAM J. Sci. Comput. 40, 2018).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from tactgen.fem.bimorph.bricks.assembly import quarter_matrices, quarter_unknowns
from tactgen.fem.bimorph.bricks.order import elimination_order
from tactgen.fem.bimorph.motions import Motion
from tactgen.fem.bimorph.symmetry import Unknowns
from tactgen.fem.bimorph.system import Material
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Bools, Floats
from tactgen.geometry.bimorph.bricks import Bricks

#: Random ends that are tried: the shapes that they find are fewer by far.
_TRIED = 60
#: Degree of the polynomials in x and in y that random ends are made of.
_DEGREE = 6


@dataclass(frozen=True)
class SectionFunctions:
    """Shapes at a section, orthonormal over its nodes.

    Attributes
    ----------
    values : (4 m, s) array
        (u_x, u_y, u_z, φ) at the m nodes of the section's grid, y fastest: first shapes of
        displacement, then shapes of potential.
    moving : int
        How many are shapes of displacement.
    by_voltage : (s,) array
        Amplitudes of the shapes of potential that a voltage of one unit makes far from all ends.
    """

    values: Floats
    moving: int
    by_voltage: Floats


def section_functions(
    middle: Bricks, known: dict[str, Material], unit: float, motion: Motion, share: float
) -> SectionFunctions:
    """Return the shapes that the middle of a stretch sees of its ends and of a voltage.

    Parameters
    ----------
    middle : Bricks
        The stretch; its middle is a break point along z.
    known : dict of str to Material
        Lossless materials.
    unit : float
        Size of the potential's unit (V).
    motion : str
        Class of motion.
    share : float
        Least singular value of a shape that counts, relative to the largest of displacement.
    """
    stiffness, _ = quarter_matrices(middle, known, unit)
    unknowns = quarter_unknowns(middle, motion, unit, has_base=False)
    free = unknowns.free.reshape(*middle.shape, 4)
    ends = np.zeros_like(free)
    ends[:, :, [0, -1]] = free[:, :, [0, -1]]
    given = np.flatnonzero(ends)
    inner = (free & ~ends).reshape(-1, 4)
    right = _random_ends(middle)[given]
    at = np.flatnonzero(inner)
    by_voltage = Unknowns(inner, unknowns.ports).bordered(stiffness)
    loads = np.column_stack([stiffness[at][:, given] @ right, by_voltage.border[:, 2]])
    place = elimination_order(middle)
    order = np.argsort(4 * place[at // 4] + at % 4)
    values = np.zeros((free.size, _TRIED + 1))
    values[at] = -factorise(by_voltage.inner, order=order).solve(loads)
    seen = values.reshape(*free.shape, -1)[:, :, middle.shape[2] // 2].reshape(-1, _TRIED + 1)
    potential = np.arange(seen.shape[0]) % 4 == 3
    rigid = _rigid(middle, motion)
    # potential is in units that give it the size of a displacement: one measure for both
    least = share * float(np.linalg.norm(seen[~potential, :-1], 2))
    u, phi = (
        _strongest(seen, rows, own, share, least)
        for rows, own in ((~potential, rigid), (potential, rigid[:, :0]))
    )
    shapes = np.hstack([u, phi])
    return SectionFunctions(shapes, u.shape[1], shapes.T @ np.where(potential, seen[:, -1], 0.0))


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


def _strongest(seen: Floats, rows: Bools, rigid: Floats, share: float, least: float) -> Floats:
    """Return the shapes above `least` in some rows of what random ends and a voltage show.

    Rigid motions come first: they must be there to rounding, or the joint would resist them.
    """
    here = np.where(rows[:, None], seen, 0.0)
    here = here - rigid @ (rigid.T @ here)
    by_ends, by_voltage = here[:, :-1], here[:, -1]
    shapes, sizes, _ = np.linalg.svd(by_ends, full_matrices=False)
    # exactly: what has no displacement has no mass, and counts as a potential
    shapes = np.where(rows[:, None], shapes, 0.0)
    shapes = np.hstack([rigid, shapes[:, sizes > least]])
    left = by_voltage - shapes @ (shapes.T @ by_voltage)
    if np.linalg.norm(left) > share * np.linalg.norm(by_voltage):
        left -= shapes @ (shapes.T @ left)
        shapes = np.column_stack([shapes, left / np.linalg.norm(left)])
    return shapes
