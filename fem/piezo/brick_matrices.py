"""Stiffness and mass of bricks of high order from integrals along the axes.

A region's nine Gram matrices are products of integrals along the axes,

    G_ab = ∫ ∂_a N_i ∂_b N_j dV = X_ab ⊗ Y_ab ⊗ Z_ab ,

and all blocks over (u_x, u_y, u_z, φ) are one matrix product of their entries with the
tensors.  For one pair of functions along x at a time it fits the cache, and goes straight
to its place in compressed rows: memory touched for the first time is what costs most here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from tactgen.fem.elements.line_basis import LineMatrices, line_matrices
from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers, Sparse
from tactgen.geometry.bimorph.bricks import Bricks, Slab

#: The quarter is one of four.
_COPIES = 4.0
#: Of the nine pairs of axes, one in which nothing is differentiated along x.
_PLAIN = 4


def brick_matrices(
    bricks: Bricks, known: dict[str, Material], unit: float, tested: Bools | None = None
) -> tuple[Sparse, Sparse]:
    """Stiffness and mass of the whole body by the values on its quarter, held nowhere.

    Parameters
    ----------
    bricks : Bricks
        The quarter.
    known : dict of str to Material
        Material of each region.
    unit : float
        Size of the potential's unit (V).
    tested : (nx, ny, nz) mask, optional
        Products of functions whose rows are wanted; by default all that are there.

    Returns
    -------
    stiffness, mass : (4 n, 4 n) sparse
        Over (u_x, u_y, u_z, φ) of each product of functions, z fastest; columns sorted.  Those
        that no material has are there, with zeros; those that are left out have empty rows.
    """
    products = bricks.products()
    lines = (line_matrices(axis) for axis in bricks.axes)
    pairs = _Pairs(products, products if tested is None else tested, *lines)
    layers = [_Layer.of(bricks, slab, known[slab.region], unit) for slab in bricks.slabs]
    dtype = np.result_type(*(layer.weights.dtype for layer in layers))
    values = np.empty((4 * pairs.count, 4), dtype=dtype)
    columns = np.empty((4 * pairs.count, 4), dtype=np.int32)
    inertia = np.empty(3 * pairs.count)
    moved = np.empty(3 * pairs.count, dtype=np.int32)
    component = np.arange(4, dtype=np.int32)
    for across, alike in pairs.groups:
        here = [layer.of_pairs(across.at) for layer in layers]
        for pair in alike:
            start, count, within, column = pairs.places(pair, across)
            at = (4 * start + within)[:, None] + count[:, None] * component
            columns[at] = (4 * column[:, None] + component)[:, None, :]
            light = (3 * start + within)[:, None] + count[:, None] * component[:3]
            moved[light] = 4 * column[:, None] + component[:3]
            there = [layer for layer in here if layer.reaches(pair)]
            values[at] = sum(layer.blocks(pair) for layer in there)
            inertia[light] = sum(layer.inertia(pair)[:, None] for layer in there)
    n = 4 * pairs.row_counts.size
    counts = pairs.row_counts.ravel()
    stiff = _starts(counts[:, None] * np.array([4, 4, 4, 4]))
    heavy = _starts(counts[:, None] * np.array([1, 1, 1, 0]))
    return (
        sparse.csr_matrix((values.ravel(), columns.ravel(), stiff), shape=(n, n)),
        sparse.csr_matrix((inertia, moved, heavy), shape=(n, n)),
    )


def _starts(counts: Ints) -> Ints:
    """Where rows of these lengths start."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)


@dataclass(frozen=True)
class _Across:
    """The pairs of functions over y and z that go with a pair along x, by rows, columns ascending.

    `at` (m,) is where they are among all pairs along y times all along z, z fastest; `rows` and
    `columns` (m,) number the functions, `within` (m,) the places in a row, `counts` (ny nz,) the
    pairs of each row.
    """

    at: Ints
    rows: Ints
    columns: Ints
    within: Ints
    counts: Ints


@dataclass(frozen=True)
class _Pairs:
    """All pairs of functions that share a brick, as products of pairs along the axes.

    `there` (nx, ny, nz) says which products of functions there are, `tested` which have rows.
    """

    there: Bools
    tested: Bools
    x: LineMatrices
    y: LineMatrices
    z: LineMatrices

    @cached_property
    def groups(self) -> list[tuple[_Across, list[int]]]:
        """Pairs along x that go with the same pairs over y and z, and those."""
        nx = self.there.shape[0]
        flat, tested = self.there.reshape(nx, -1), self.tested.reshape(nx, -1)
        _, kinds = np.unique(np.hstack([flat, tested]), axis=0, return_inverse=True)
        kinds = kinds.ravel()
        rows, columns = (
            (getattr(self.y, of)[:, None] * self.there.shape[2] + getattr(self.z, of)).ravel()
            for of in ("rows", "columns")
        )
        order = np.lexsort((columns, rows))
        rows, columns = rows[order], columns[order]
        alike: dict[tuple[int, int], list[int]] = {}
        for pair, ends in enumerate(zip(self.x.rows, self.x.columns, strict=True)):
            alike.setdefault((int(kinds[ends[0]]), int(kinds[ends[1]])), []).append(pair)
        found = []
        for pairs in alike.values():
            i, j = self.x.rows[pairs[0]], self.x.columns[pairs[0]]
            kept = tested[i][rows] & flat[j][columns]
            counts = np.bincount(rows[kept], minlength=flat.shape[1])
            starts = np.cumsum(counts) - counts
            within = np.arange(counts.sum()) - np.repeat(starts, counts)
            found.append((_Across(order[kept], rows[kept], columns[kept], within, counts), pairs))
        return found

    @cached_property
    def _before(self) -> tuple[Ints, Ints]:
        """Partners of each function (nx, ny nz); those in earlier pairs along x (pairs, ny nz)."""
        counts = np.zeros((self.x.rows.size, self.there[0].size), dtype=np.int64)
        for across, pairs in self.groups:
            counts[pairs] = across.counts
        total = np.zeros((self.there.shape[0], counts.shape[1]), dtype=np.int64)
        before = np.empty_like(counts)
        for pair, i in enumerate(self.x.rows):
            before[pair] = total[i]
            total[i] += counts[pair]
        return total, before

    @property
    def row_counts(self) -> Ints:
        """Partners of each product of functions (nx, ny nz)."""
        return self._before[0]

    @cached_property
    def count(self) -> int:
        """Number of pairs."""
        return int(self.row_counts.sum())

    @cached_property
    def _row_starts(self) -> Ints:
        flat = self.row_counts.ravel()
        return (np.cumsum(flat) - flat).reshape(self.row_counts.shape)

    def places(self, pair: int, across: _Across) -> tuple[Ints, Ints, Ints, Ints]:
        """For one pair along x and all that go with it over y, z where they are.

        The start and length of the first function's row, the place in that row, and the other
        function; all counted in functions.
        """
        i, j, rows = self.x.rows[pair], self.x.columns[pair], across.rows
        within = self._before[1][pair][rows] + across.within
        other = j * self.there[0].size + across.columns
        return self._row_starts[i][rows], self.row_counts[i][rows], within, other


@dataclass(frozen=True)
class _Layer:
    """One slab: its integrals along x, and those over y and z with what they weigh.

    `gram` (m, 9) holds Y_ab Z_ab, `weights` (9, 16) what each G_ab gives to each block.
    """

    along_x: Floats
    gram: Floats
    weights: Numbers
    areas: Floats

    @classmethod
    def of(cls, bricks: Bricks, slab: Slab, material: Material, unit: float) -> _Layer:
        x, z = line_matrices(bricks.x, *slab.x), line_matrices(bricks.z, *slab.z)
        y = line_matrices(bricks.y)

        def product(a: int, b: int) -> Floats:
            along_y, along_z = ((int(a == k), int(b == k)) for k in (1, 2))
            return np.outer(y.integrals[along_y], z.integrals[along_z]).ravel()

        axes = [(a, b) for a in range(3) for b in range(3)]
        return cls(
            along_x=np.array([x.integrals[int(a == 0), int(b == 0)] for a, b in axes]),
            gram=np.column_stack([product(a, b) for a, b in axes]),
            weights=_COPIES * _weights(material, unit),
            areas=_COPIES * material.density * product(0, 0),
        )

    def of_pairs(self, at: Ints) -> _Layer:
        """What there is of some pairs over y and z."""
        return replace(self, gram=self.gram[at], areas=self.areas[at])

    def reaches(self, pair: int) -> bool:
        """Whether the slab has this pair of functions along x."""
        return bool(self.along_x[:, pair].any())

    def blocks(self, pair: int) -> Numbers:
        """4 x 4 blocks (m, 4, 4) of one pair along x with those over y and z."""
        scaled = self.along_x[:, [pair]] * self.weights
        # complex weights as twice as many real ones: the integrals are real
        product = self.gram @ scaled.view(float)
        return np.asarray(product.view(self.weights.dtype)).reshape(-1, 4, 4)

    def inertia(self, pair: int) -> Floats:
        """Mass (m,) of one pair along x with those over y and z."""
        return np.asarray(self.along_x[_PLAIN, pair] * self.areas)


def _weights(material: Material, unit: float) -> Numbers:
    """(9, 16): what each Gram matrix gives to each block over (u_x, u_y, u_z, φ)."""
    return material.flux_tensor(unit).transpose(1, 3, 0, 2).reshape(9, 16).copy()
