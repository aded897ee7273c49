"""Products of an expansion's terms with shapes on the undivided bricks."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.expansion import POTENTIAL, Expansion
from tactgen.fem.elements.line_basis import LineMatrices, line_matrices
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.bricks import Axis, Bricks
from tactgen.geometry.bimorph.stretching import piece_breaks

#: The quarter is one of four.
_COPIES = 4.0


@dataclass(frozen=True)
class Shapes:
    """Some displacements (3, nx, ny, nz, k) and some potentials (nx, ny, nz, j) at the nodes."""

    moved: Floats
    charged: Floats

    @classmethod
    def none(cls, shape: tuple[int, int, int]) -> Shapes:
        """Return no shapes at all."""
        return cls(np.zeros((3, *shape, 0)), np.zeros((*shape, 0)))

    def of(self, component: int) -> Floats:
        """Return one of (u_x, u_y, u_z, φ)."""
        return self.charged if component == POTENTIAL else self.moved[component]

    def joined(self, other: Shapes) -> Shapes:
        """Return these and others behind them."""
        return Shapes(
            np.concatenate([self.moved, other.moved], axis=-1),
            np.concatenate([self.charged, other.charged], axis=-1),
        )


@dataclass(frozen=True)
class TermProducts:
    """leftᵀ (term) right for all terms of an expansion on its undivided bricks."""

    bricks: Bricks
    terms: Expansion

    def elastic(self, left: Shapes, right: Shapes) -> Floats:
        """Return (terms, k_left, k_right)."""
        return self._both_ways(self.terms.elastic, left, right)

    def dielectric(self, left: Shapes, right: Shapes) -> Floats:
        """Return (terms, j_left, j_right)."""
        return self._both_ways(self.terms.dielectric, left, right)

    def coupling(self, left: Shapes, right: Shapes) -> Floats:
        """Return (terms, j_left, k_right): potentials on the left, displacements on the right."""
        return np.array(
            [self._one(z, left.of(p), a, b, right.of(q)) for z, p, a, q, b in self.terms.coupling]
        ).reshape(len(self.terms.coupling), left.charged.shape[-1], right.moved.shape[-1])

    def inertial(self, left: Shapes, right: Shapes) -> Floats:
        """Return (terms, k_left, k_right)."""
        none = -1
        return np.array(
            [
                self._one(zone, left.of(c), none, none, right.of(c))
                for zone, c in self.terms.inertial
            ]
        )

    def _both_ways(self, terms: Ints, left: Shapes, right: Shapes) -> Floats:
        found = []
        for zone, p, a, q, b in terms:
            product = self._one(zone, left.of(p), a, b, right.of(q))
            if (p, a) != (q, b):
                product = product + self._one(zone, left.of(q), b, a, right.of(p))
            found.append(product)
        return np.array(found)

    def _one(self, zone: int, left: Floats, a: int, b: int, right: Floats) -> Floats:
        """Return ∫ ∂_a left ∂_b right over one zone (k_left, k_right)."""
        if not left.shape[-1] * right.shape[-1]:
            return np.zeros((left.shape[-1], right.shape[-1]))
        i, k = self.terms.places[zone]
        (at_x, x), (_, y), (at_z, z) = self._lines[0][i], self._lines[1][0], self._lines[2][k]
        along = [line[int(a == n), int(b == n)] for n, line in enumerate((x, y, z))]
        part = right[at_x, :, at_z]
        nx, ny, nz, count = part.shape
        out = along[0] @ part.reshape(nx, -1)
        out = np.matmul(along[1], out.reshape(nx, ny, nz * count))
        out = np.matmul(along[2], out.reshape(nx * ny, nz, count)).reshape(-1, count)
        chosen = left[at_x, :, at_z]
        return np.asarray(_COPIES * (chosen.reshape(-1, chosen.shape[-1]).T @ out))

    @cached_property
    def _lines(self) -> list[list[tuple[slice, Floats]]]:
        """Nodes and integrals (2, 2, n, n) of each piece of each axis."""
        return [
            [_line(axis, first, last) for first, last in itertools.pairwise(breaks)]
            for axis, breaks in zip(self.bricks.axes, piece_breaks(self.bricks), strict=True)
        ]


def _line(axis: Axis, first: int, last: int) -> tuple[slice, Floats]:
    matrices: LineMatrices = line_matrices(axis, first, last)
    n = axis.nodes.size
    full = np.zeros((2, 2, n, n))
    full[:, :, matrices.rows, matrices.columns] = matrices.integrals
    at = axis.nodes_of(first, last)
    return at, np.ascontiguousarray(full[:, :, at, at])
