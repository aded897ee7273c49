"""Fields of the solid on bricks: derivatives of its polynomials at their own nodes.

Within a brick they are exact; where bricks of one layer meet, the mean of both sides is taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats, Ints, Numbers
from tactgen.geometry.bimorph.bricks import Axis, Bricks, lobatto_points, mirrored_axis
from tactgen.geometry.meshing.mesh import Mesh

#: Every node, or those on bricks' edges across and all along z: what a picture needs.
Detail = Literal["nodes", "edges"]


@dataclass(frozen=True)
class Block:
    """A part of the whole grid with one material: nodes along x and z; along y all of them."""

    region: str
    x: slice
    z: slice


@dataclass(frozen=True)
class BrickSampler:
    """Points of the whole bimorph, layer by layer, and how fields come to them."""

    bricks: Bricks
    detail: Detail

    @cached_property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        """The axes of the whole: x and y mirrored."""
        x, y = (
            Axis(np.concatenate([-a.breaks[:0:-1], a.breaks]), a.degree)
            for a in (self.bricks.x, self.bricks.y)
        )
        return x, y, self.bricks.z

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The blocks of one material each."""
        found, middle = [], self.bricks.x.intervals
        along_x, _, along_z = self.axes
        for slab in self.bricks.slabs:
            low, high = slab.x
            sides = {"top": (middle + low, middle + high), "bottom": (middle - high, middle - low)}
            if low == 0:
                sides = {"": (middle - high, middle + high)}
            for side, part in sides.items():
                region = f"piezo_{side}" if slab.region == "piezo" else slab.region
                found.append(Block(region, along_x.nodes_of(*part), along_z.nodes_of(*slab.z)))
        return tuple(found)

    @cached_property
    def _grid(self) -> tuple[Ints, tuple[int, int, int]]:
        """Where the system's nodes are in the whole grid (flat), and the grid's shape."""
        _, from_x, _ = mirrored_axis(self.bricks.x.nodes)
        _, from_y, _ = mirrored_axis(self.bricks.y.nodes)
        used = self.bricks.used()[np.ix_(from_x, from_y)]
        nx, ny, nz = used.shape
        return np.flatnonzero(used), (nx, ny, nz)

    def _kept(self, block: Block) -> tuple[Ints, Ints, Ints]:
        """Return which nodes of a block are shown along each axis."""
        counts = (block.x.stop - block.x.start, self._grid[1][1], block.z.stop - block.z.start)
        steps = (
            (1, 1, 1) if self.detail == "nodes" else (self.axes[0].degree, self.axes[1].degree, 1)
        )
        x, y, z = (np.arange(0, n, step) for n, step in zip(counts, steps, strict=True))
        return x, y, z

    @cached_property
    def mesh(self) -> Mesh:
        """The points shown, in m, with eight-cornered cells between them."""
        points, cells, regions = [], [], []
        outer: dict[str, list[Ints]] = {"top": [], "bottom": []}
        names = tuple(dict.fromkeys(block.region for block in self.blocks))
        count = 0
        electrode = [float(self.bricks.z.breaks[k]) for k in self.bricks.electrode]
        for block in self.blocks:
            kept = self._kept(block)
            lines = [line[part] for line, part in zip(self._lines(block), kept, strict=True)]
            points.append(np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3))
            shape = tuple(line.size for line in lines)
            hexes, sides = _cells(shape)
            cells.append(count + hexes)
            regions.append(np.full(len(hexes), names.index(block.region)))
            for side, quads in zip(("bottom", "top"), sides, strict=True):
                if block.region == f"piezo_{side}":
                    z = points[-1][quads, 2]
                    under = ((z >= electrode[0] - 1e-12) & (z <= electrode[1] + 1e-12)).all(axis=1)
                    outer[side].append(count + quads[under])
            count += len(points[-1])
        return Mesh(
            points=np.concatenate(points),
            cells=np.concatenate(cells),
            kind="hexahedron",
            region_of_cell=np.concatenate(regions).astype(np.int64),
            regions=names,
            faces={f"electrode_{s}_outer": np.concatenate(q) for s, q in outer.items()},
        )

    def _lines(self, block: Block) -> tuple[Floats, Floats, Floats]:
        x, y, z = (axis.nodes for axis in self.axes)
        return x[block.x], y, z[block.z]

    @cached_property
    def _slopes(self) -> list[tuple[Floats, Floats, Floats]]:
        """Matrices (n, n) from values along each axis of a block to derivatives there."""
        found = []
        for block in self.blocks:
            x, y, z = self.axes
            found.append(
                (
                    _differentiation(x, block.x),
                    _differentiation(y, slice(0, y.nodes.size)),
                    _differentiation(z, block.z),
                )
            )
        return found

    def sample(self, values: Numbers) -> tuple[Numbers, Numbers]:
        """Return values (n, k) and gradients (n, k, 3) at the points from those at all nodes.

        Parameters
        ----------
        values : (n_nodes, k) array
            In the order of the system's nodes.
        """
        at, shape = self._grid
        grid = np.zeros((*shape, values.shape[1]), dtype=values.dtype)
        grid.reshape(-1, values.shape[1])[at] = values
        sampled, gradients = [], []
        for block, (d_x, d_y, d_z) in zip(self.blocks, self._slopes, strict=True):
            part = grid[block.x, :, block.z]
            x, y, z = self._kept(block)
            gradient = np.stack(
                [
                    np.einsum("ai,ijkc->ajkc", d_x[x], part[:, y][:, :, z]),
                    np.einsum("bj,ijkc->ibkc", d_y[y], part[x][:, :, z]),
                    np.einsum("ek,ijkc->ijec", d_z[z], part[x][:, y]),
                ],
                axis=-1,
            )
            shown = part[np.ix_(x, y, z)]
            sampled.append(shown.reshape(-1, shown.shape[-1]))
            gradients.append(gradient.reshape(-1, *gradient.shape[-2:]))
        return np.concatenate(sampled), np.concatenate(gradients)


def _differentiation(axis: Axis, part: slice) -> Floats:
    """Return the matrix (n, n) that differentiates piecewise polynomials at a part's nodes."""
    degree = axis.degree
    reference = _reference_slopes(degree)
    first = part.start // degree
    count = (part.stop - 1 - part.start) // degree
    matrix, shares = np.zeros((part.stop - part.start,) * 2), np.zeros(part.stop - part.start)
    for k in range(count):
        at = slice(k * degree, (k + 1) * degree + 1)
        width = float(axis.breaks[first + k + 1] - axis.breaks[first + k])
        matrix[at, at] += reference * (2.0 / width)
        shares[at] += 1.0
    return matrix / shares[:, None]


def _reference_slopes(degree: int) -> Floats:
    """Return derivatives (n, n) of the polynomials through Gauss–Lobatto points at these points."""
    points = lobatto_points(degree)
    powers = np.vander(points, increasing=True)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = powers[:, :-1] * np.arange(1, degree + 1)
    return np.asarray(slopes @ np.linalg.inv(powers))


def _cells(shape: tuple[int, ...]) -> tuple[Ints, tuple[Ints, Ints]]:
    """Return hexahedra of a block of points, z fastest, and quads at its ends along x."""
    number = np.arange(int(np.prod(shape))).reshape(shape)
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    nx, ny, nz = shape

    def corner(a: int, b: int, c: int) -> Ints:
        return number[a : nx - 1 + a, b : ny - 1 + b, c : nz - 1 + c].ravel()

    hexes = np.stack([corner(a, b, c) for c in (0, 1) for a, b in around], axis=1)

    def quads(at: int) -> Ints:
        face = number[at]
        return np.stack(
            [face[:-1, :-1], face[1:, :-1], face[1:, 1:], face[:-1, 1:]], axis=-1
        ).reshape(-1, 4)

    return hexes, (quads(0), quads(-1))
