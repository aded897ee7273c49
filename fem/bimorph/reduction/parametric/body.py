"""What does not depend on a basis: rigid motions, tip means and means of sections, by pieces."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.expansion import Coefficients, Expansion
from tactgen.fem.bimorph.reduction.parametric.products import Shapes
from tactgen.fem.elements.line_basis import line_weights
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Axis, Bricks
from tactgen.geometry.bimorph.stretching import piece_breaks

#: Components (u_x, u_y, u_z) whose means over sections tell each class of motion, and whether
#: weighed by the place along y.
MEANS: dict[Motion, tuple[tuple[int, int], ...]] = {
    "bending_x": ((0, 0), (2, 0)),
    "bending_y": ((1, 0), (2, 1)),
    "torsion": ((1, 0), (0, 1)),
    "axial": ((2, 0),),
}


def rigid_shapes(bricks: Bricks) -> Shapes:
    """Return u_x = 1, then u_z and u_x that rise from 0 to 1 over each piece along x and z.

    Translation and rotation of any member of the family are sums of these.
    """
    across, _, along = piece_breaks(bricks)
    of_x, of_z = _ramps(bricks.x, across), _ramps(bricks.z, along)
    shapes = Shapes.none(bricks.shape)
    moved = np.zeros((3, *bricks.shape, 1 + len(of_x) + len(of_z)))
    moved[0, ..., 0] = 1.0
    for i, ramp in enumerate(of_x):
        moved[2, ..., 1 + i] = ramp[:, None, None]
    for k, ramp in enumerate(of_z):
        moved[0, ..., 1 + len(of_x) + k] = ramp
    return Shapes(moved, shapes.charged)


def rigid_motions(c: Coefficients) -> Floats:
    """Return (n, shapes, 2): base motion and rotation u_z = x ψ, u_x = −z ψ as rigid shapes."""
    x, z, g = c.pieces.x, c.pieces.z, c.scale
    n, count = g.shape[0], 1 + x.shape[1] + z.shape[1]
    out = np.zeros((n, count, 2))
    out[:, 0, 0] = g[:, 0]
    out[:, 1 : 1 + x.shape[1], 1] = g[:, [2]] * x
    out[:, 1 + x.shape[1] :, 1] = -g[:, [0]] * z
    return out


def tip_shapes(bricks: Bricks) -> Shapes:
    """Return the loads of the tip by pieces along x: mean of u_x, of u_z, and of u_z over a ramp.

    As values at the nodes, whose product with nodal displacements is the mean.
    """
    across, _, _ = piece_breaks(bricks)
    along_y = line_weights(bricks.y)[0]
    along_y = along_y / along_y.sum()
    moved = np.zeros((3, *bricks.shape, 3 * (len(across) - 1)))
    for i, (plain, ramped) in enumerate(_means(bricks.x, across)):
        moved[0, :, :, -1, 3 * i] = np.outer(plain, along_y)
        moved[2, :, :, -1, 3 * i + 1] = np.outer(plain, along_y)
        moved[2, :, :, -1, 3 * i + 2] = np.outer(ramped, along_y)
    return Shapes(moved, Shapes.none(bricks.shape).charged)


def tip_weights(c: Coefficients) -> Floats:
    """Return (n, functionals, 2): mean displacement and mean rotation of the tip by pieces."""
    x, g = c.pieces.x, c.scale
    half = x.sum(axis=1)
    lower = np.cumsum(x, axis=1) - x
    out = np.zeros((g.shape[0], 3 * x.shape[1], 2))
    out[:, 0::3, 0] = x / (half * g[:, 0])[:, None]
    levered = x / (g[:, 2] * half**3 / 3.0)[:, None]
    out[:, 1::3, 1] = levered * lower
    out[:, 2::3, 1] = levered * x
    return out


def section_means(bricks: Bricks, motion: Motion, moved: Floats) -> Floats:
    """Return means of sections at the nodes along z, (means, pieces, 2, nz, k).

    Of what :data:`MEANS` names, over each piece along x, plain and over a ramp, and over y.
    """
    across, _, _ = piece_breaks(bricks)
    plain, levered = line_weights(bricks.y)
    half = bricks.y.nodes[-1]
    along_y = (plain / half, levered / half**2)
    return np.array(
        [
            [
                [
                    np.einsum("x,y,xyzk->zk", weights, along_y[order], moved[component])
                    for weights in pair
                ]
                for pair in _means(bricks.x, across)
            ]
            for component, order in MEANS[motion]
        ]
    )


@dataclass(frozen=True)
class Sections:
    """Where the sections are, and what share of a mode's energy their rigid motions hold.

    Attributes
    ----------
    motion : str
        Class of motion.
    weights : (pieces along z, nz) array
        Share of each piece's length that belongs to each node along z.
    """

    motion: Motion
    weights: Floats

    def share(self, terms: Expansion, c: Coefficients, means: Floats) -> Floats:
        """Return the share (n, modes) of the kinetic energy of modes of unit mass.

        Parameters
        ----------
        means : (n, means, pieces, 2, nz, modes) array
            See :func:`section_means`, of û.
        """
        x, z, half = c.pieces.x, c.pieces.z, c.pieces.y[:, 0]
        mass = np.zeros((*x.shape, self.weights.shape[1]))
        for zone, (i, k) in enumerate(terms.places):
            volume = 4.0 * x[:, i] * half * z[:, k]
            mass[:, i] += (c.density[:, zone] * volume)[:, None] * self.weights[k]
        components = [component for component, _ in MEANS[self.motion]]
        own = means / c.scale[:, components][:, :, None, None, None, None]
        lower = np.cumsum(x, axis=1) - x
        whole = mass.sum(axis=1)
        about_y = np.einsum("npz,np->nz", mass, lower**2 + lower * x + x**2 / 3.0)
        about_x = whole * half[:, None] ** 2 / 3.0

        def plain(values: Floats) -> Floats:
            return np.asarray(np.einsum("npz,npzm->nzm", mass, values[:, :, 0]))

        def over_x(values: Floats) -> Floats:
            levered = lower[:, :, None, None] * values[:, :, 0]
            levered = levered + x[:, :, None, None] * values[:, :, 1]
            return np.asarray(np.einsum("npz,npzm->nzm", mass, levered))

        def over_y(values: Floats) -> Floats:
            return half[:, None, None] * plain(values)

        def energy(moment: Floats, size: Floats) -> Floats:
            return np.asarray((moment**2 / size[:, :, None]).sum(axis=1))

        first = own[:, 0]
        if self.motion == "bending_x":
            return energy(plain(first), whole) + energy(over_x(own[:, 1]), about_y)
        if self.motion == "bending_y":
            return energy(plain(first), whole) + energy(over_y(own[:, 1]), about_x)
        if self.motion == "torsion":
            return energy(over_x(first) - over_y(own[:, 1]), about_y + about_x)
        return energy(plain(first), whole)


def sections(bricks: Bricks, motion: Motion) -> Sections:
    """Return the sections of a division."""
    _, _, along = piece_breaks(bricks)
    weights = [
        line_weights(bricks.z, first, last)[0] / (bricks.z.breaks[last] - bricks.z.breaks[first])
        for first, last in itertools.pairwise(along)
    ]
    return Sections(motion, np.array(weights))


def _ramps(axis: Axis, breaks: list[int]) -> list[Floats]:
    at = axis.breaks[breaks]
    return [
        np.clip((axis.nodes - low) / (high - low), 0.0, 1.0) for low, high in itertools.pairwise(at)
    ]


def _means(axis: Axis, breaks: list[int]) -> list[tuple[Floats, Floats]]:
    """Return what gives the mean over each piece of an axis, and that over a ramp from 0 to 1."""
    found = []
    for first, last in itertools.pairwise(breaks):
        low, high = axis.breaks[first], axis.breaks[last]
        plain, levered = line_weights(axis, first, last)
        found.append((plain / (high - low), (levered - low * plain) / (high - low) ** 2))
    return found
