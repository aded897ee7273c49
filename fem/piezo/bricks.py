"""The piezoelectric solid on bricks of high order: a part, one class of motion at a time.

Weak form and unknowns are those of :mod:`fem.piezo.solid`, the matrices those of
:mod:`fem.piezo.bricks`.
What the quarter or half stands for says :mod:`fem.piezo.symmetry`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from tactgen.fem.elements.line_basis import line_matrices, line_weights, nodal_values, values_at
from tactgen.fem.piezo.modal_model import Motion
from tactgen.fem.piezo.symmetry import OTHERS, SIGNS, Expansion, Unknowns, mirror_signs
from tactgen.fem.piezo.system import Material, SolidSystem, materials, volts_per_unit
from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers, Sparse
from tactgen.geometry.bimorph.bricks import Bricks, Slab, mirrored_axis
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.device.parameters import Device

#: Of the nine pairs of axes, one in which nothing is differentiated along x.
_PLAIN = 4


def brick_matrices(
    bricks: Bricks, known: dict[str, Material], unit: float, tested: Bools | None = None
) -> tuple[Sparse, Sparse]:
    """Stiffness and mass of the whole body by the values on its quarter, held nowhere.

    `known` is the material of each region, `unit` the size of the potential's unit (V), `tested`
    (nx, ny, nz) tells the products of functions whose rows are wanted; by default all that are
    there.

    Both are sparse (4 n, 4 n) over (u_x, u_y, u_z, φ) of each product of functions, z fastest;
    columns sorted.  Those that no material has are there, with zeros; those that are left out have
    empty rows.
    """
    there = bricks.products()
    pairs, pattern, place = _pattern(bricks, there, there if tested is None else tested)
    layers = [_Layer.of(bricks, slab, known[slab.region], unit) for slab in bricks.slabs]
    dtype = np.result_type(*(layer.weights.dtype for layer in layers))
    blocks, inertia = np.empty((place.size, 4, 4), dtype=dtype), np.empty(place.size)
    first = 0
    for pair, across in enumerate(pairs):
        at = place[first : first + across.size]
        first += across.size
        reaching = [layer for layer in layers if layer.reaches(pair)]
        blocks[at] = sum(layer.blocks(pair, across) for layer in reaching)
        inertia[at] = sum(layer.inertia(pair, across) for layer in reaching)
    n = 4 * there.size
    where = pattern.indices, pattern.indptr
    stiffness = sparse.bsr_matrix((blocks, *where), shape=(n, n)).tocsr()
    moving = sparse.csr_matrix(np.diag([1.0, 1.0, 1.0, 0.0]))
    mass = sparse.kron(sparse.csr_matrix((inertia, *where), shape=pattern.shape), moving, "csr")
    return stiffness, mass


def _pattern(bricks: Bricks, there: Bools, tested: Bools) -> tuple[list[Ints], Sparse, Ints]:
    """Pairs of functions that share a brick, as products of pairs along the axes.

    For each pair along x those over y and z, among all along y times all along z, z fastest; the
    sparsity pattern of all; and the place there of each.  `there` (nx, ny, nz) says which products
    of functions there are, `tested` which have rows.
    """
    x, y, z = (line_matrices(axis) for axis in bricks.axes)
    there, tested = (mask.reshape(bricks.shape[0], -1) for mask in (there, tested))
    size = there.shape[1]
    rows, columns = (
        (of_y[:, None] * bricks.shape[2] + of_z).ravel()
        for of_y, of_z in ((y.rows, z.rows), (y.columns, z.columns))
    )
    ends = list(zip(x.rows, x.columns, strict=True))
    pairs: list[Ints] = [np.flatnonzero(tested[i][rows] & there[j][columns]) for i, j in ends]
    first = np.concatenate([i * size + rows[at] for (i, _), at in zip(ends, pairs, strict=True)])
    other = np.concatenate([j * size + columns[at] for (_, j), at in zip(ends, pairs, strict=True)])
    number = np.arange(first.size)
    shape = (there.size, there.size)
    pattern = sparse.coo_matrix((number, (first, other)), shape=shape).tocsr()
    place = np.empty_like(number)
    place[pattern.data] = number
    return pairs, pattern, place


@dataclass(frozen=True)
class _Layer:
    """Integrals of one slab along x, and over y and z with their weights.

    `gram` (m, 9) holds Y_ab Z_ab, `weights` (9, 16) what each G_ab gives to each block.
    """

    along_x: Floats
    gram: Floats
    weights: Numbers
    areas: Floats

    @classmethod
    def of(cls, bricks: Bricks, slab: Slab, material: Material, unit: float) -> _Layer:
        spans = zip(bricks.axes, (slab.x, slab.y, slab.z), strict=True)
        x, y, z = (line_matrices(axis, *span) for axis, span in spans)

        def product(a: int, b: int) -> Floats:
            along_y, along_z = ((int(a == k), int(b == k)) for k in (1, 2))
            return np.outer(y.integrals[along_y], z.integrals[along_z]).ravel()

        axes = [(a, b) for a in range(3) for b in range(3)]
        return cls(
            along_x=np.array([x.integrals[int(a == 0), int(b == 0)] for a, b in axes]),
            gram=np.column_stack([product(a, b) for a, b in axes]),
            weights=bricks.copies * material.flux_tensor(unit).transpose(1, 3, 0, 2).reshape(9, 16),
            areas=bricks.copies * material.density * product(0, 0),
        )

    def reaches(self, pair: int) -> bool:
        """Whether the slab has this pair of functions along x."""
        return bool(self.along_x[:, pair].any())

    def blocks(self, pair: int, across: Ints) -> Numbers:
        """4 x 4 blocks (m, 4, 4) of one pair along x with some (m,) over y and z."""
        scaled = self.along_x[:, [pair]] * self.weights
        # complex weights as twice as many real ones: the integrals are real
        product = self.gram[across] @ scaled.view(float)
        return np.asarray(product.view(self.weights.dtype)).reshape(-1, 4, 4)

    def inertia(self, pair: int, across: Ints) -> Floats:
        """Mass (m,) of one pair along x with some over y and z."""
        return np.asarray(self.along_x[_PLAIN, pair] * self.areas[across])


def elimination_order(bricks: Bricks) -> Ints:
    """Place (n,) of each of the grid's nodes, z fastest, in the order of elimination."""
    shape = bricks.shape
    x, y, z = np.unravel_index(np.arange(int(np.prod(shape))), shape)
    along_x, along_y, along_z = bricks.degree
    count = bricks.z.intervals
    # both end planes separate nothing: they go with the interval that they end
    separates = (z % along_z == 0) & (z > 0) & (z < shape[2] - 1)
    interval = np.minimum(z // along_z, count - 1)
    intervals, planes = _turns(count)
    turn = np.where(separates, planes[interval], intervals[interval])
    upper = 2 * interval >= count
    # of a cross-section's lines and what lies between two, one after the other
    column, row = _lines(y, along_y), _lines(x, along_x)
    brick = (x // along_x) * bricks.y.intervals + y // along_y
    inside = (x % along_x > 0) & (y % along_y > 0)
    order = np.lexsort((brick, row * ~inside, column * ~inside, ~inside, upper, turn))
    place = np.empty(order.size, dtype=np.int64)
    place[order] = np.arange(order.size)
    return place


def _turns(count: int) -> tuple[Ints, Ints]:
    """When each of `count` intervals, and the plane below each, is eliminated."""
    number = np.arange(count)
    intervals = 2 * np.minimum(number, count - 1 - number)
    planes = np.zeros(count, dtype=np.int64)
    planes[1:] = np.maximum(intervals[1:], intervals[:-1]) + 1
    return intervals, planes


def _lines(number: Ints, degree: int) -> Ints:
    """Even numbers of a section's lines, odd ones of the gaps between."""
    return 2 * (number // degree) + (number % degree > 0)


def assemble_bricks(
    device: Device,
    bricks: Bricks,
    *,
    lossy: bool,
    ceramic: Piezoceramic | None = None,
    motion: Motion = "bending_x",
    uniform_field: bool = False,
) -> SolidSystem:
    """Assemble one class of motion of the solid model of `device` on `bricks`.

    Only "bending_x" takes part in what the ports do.  A uniform field is that of a potential which
    is linear through each layer, as beam theories have it.  The rest is as of
    :func:`fem.piezo.solid.assemble`.
    """
    known = materials(device, bricks.regions, ceramic or device.piezo.ceramic(), lossy=lossy)
    unit = volts_per_unit(known)
    matrices = brick_matrices(bricks, known, unit)
    if uniform_field:
        bricks = replace(bricks, slabs=tuple(replace(s, uniform=s.ceramic) for s in bricks.slabs))
    quarter = _Quarter(bricks, known, unit, *matrices, device.measurement.below_tip)
    return quarter.system(motion)


@dataclass(frozen=True)
class _Quarter:
    """Unsupported quarter, common to all classes of motion."""

    bricks: Bricks
    known: dict[str, Material]
    unit: float
    stiffness: Sparse
    mass: Sparse
    below_tip: float  #: Of the place of measurement (m)

    @cached_property
    def nodal_mass(self) -> Floats:
        """The mass at the nodes (n,)."""
        return nodal_mass(self.bricks, self.known)

    @cached_property
    def seen(self) -> Floats:
        """The functionals of tip and place of measurement (4 n, t)."""
        return seen_functionals(self.bricks, self.below_tip)

    @cached_property
    def place(self) -> Ints:
        """The place of each node (n,) in the order of elimination."""
        return elimination_order(self.bricks)

    def system(self, motion: Motion) -> SolidSystem:
        """System of one class of motion, of the whole body."""
        bricks, unit, mass, place = self.bricks, self.unit, self.mass, self.place
        unknowns = quarter_unknowns(bricks, motion, unit)
        nodes, expand, node_mass = whole_nodes(bricks, unknowns, motion, unit, self.nodal_mass)
        seen = unknowns.seen(self.seen)
        return SolidSystem(
            stiffness=unknowns.bordered(self.stiffness),
            mass=unknowns.bordered(mass),
            tip=seen[:, :2],
            measured=seen[:, 2:] if self.below_tip else None,
            expand=expand,
            nodes=nodes,
            node_mass=node_mass,
            volts_per_unit=unit,
            motion=motion,
            related=self.system,
            others=OTHERS[2 if bricks.mirrored_x else 1],
            elimination=np.argsort(4 * place[unknowns.index // 4] + unknowns.index % 4),
            translation=unknowns.translation(bricks.one().ravel()),
        )


def quarter_unknowns(bricks: Bricks, motion: Motion, unit: float) -> Unknowns:
    """Free and prescribed unknowns of one class of motion.

    Over (u_x, u_y, u_z, φ) node by node, z fastest; `unit` is that of the potential (V).
    """
    x, y = bricks.x.nodes, bricks.y.nodes
    base, piezo = bricks.base(), bricks.nodes_of(*(slab.region for slab in bricks.ceramics))
    outer, inner = bricks.electrodes()
    prescribed = bricks.nodes_of(*(slab.region for slab in bricks.ceramics if slab.uniform))
    field = piezo & ~outer & ~inner & ~prescribed
    used = bricks.used() & ~base
    free = np.stack([used, used, used, field], axis=-1) & bricks.products()[..., None]
    at_x, at_y = SIGNS[motion]
    if bricks.mirrored_x:
        free[x == 0.0, :, :, :] &= np.array(at_x) > 0
    free[:, y == 0.0, :, :] &= np.array(at_y) > 0
    ports = np.zeros((*free.shape, 3))
    if motion == "bending_x":
        ports[base, 0, 0] = 1.0
        ports[..., 2, 1][base] = np.broadcast_to(x[:, None, None], base.shape)[base]
        ports[..., 3, 2] = _prescribed_potential(bricks, outer) / unit
    if motion == "bending_y":
        ports[base, 1, 0] = 1.0
        ports[..., 2, 1][base] = np.broadcast_to(y[:, None], base.shape)[base]
    if ports.any():
        ports *= bricks.one()[..., None, None]
    return Unknowns(free.reshape(-1, 4), ports.reshape(-1, 3))


def _prescribed_potential(bricks: Bricks, outer: Bools) -> Floats:
    """Potential per volt (nx, ny, nz): on electrodes, and under them where it is to be linear."""
    found = outer.astype(float)
    for slab in bricks.ceramics:
        if slab.uniform and slab.hot:
            along_x, along_y, _ = bricks.nodes_in(slab)
            x = bricks.x.nodes[along_x]
            share = (x - x[0]) / (x[-1] - x[0])
            share = share if slab.hot > 0 else 1.0 - share
            at = along_x, along_y, bricks.z.nodes_of(*bricks.driven(slab))
            found[at] = share[:, None, None]
    return found


def seen_functionals(bricks: Bricks, below_tip: float) -> Floats:
    """(4 n, t): mean u_x over the tip face, and mean rotation from u_z = x ψ.

    Then the mean u_x over the section so far below the tip (m), if any.
    """
    top = float(bricks.z.breaks[-1])
    one, x = (np.multiply.outer(of, bricks.y.one) for of in (bricks.x.one, bricks.x.position))
    plain, levered = _section(bricks, top)
    if not bricks.mirrored_x:  # about the middle of the face, which need not be at x = 0
        levered = levered - (plain * x).sum() / (plain * one).sum() * plain
    out = np.zeros((*bricks.shape, 4, 3 if below_tip else 2))
    out[:, :, -1, 0, 0] = plain / (plain * one).sum()
    out[:, :, -1, 2, 1] = levered / (levered * x).sum()
    if below_tip:
        plain, _ = _section(bricks, top - below_tip)
        along = values_at(bricks.z, top - below_tip)
        out[..., 0, 2] = np.multiply.outer(plain / (plain * one).sum(), along)
    return out.reshape(-1, out.shape[-1])


def _section(bricks: Bricks, z: float) -> Floats:
    """∫ N_i N_j and ∫ x N_i N_j (2, nx, ny) over the section at a height z (m)."""
    found = np.zeros((2, *bricks.shape[:2]))
    for slab in bricks.slabs:
        low, high = bricks.z.breaks[list(slab.z)]
        if low < z <= high:
            across, _ = line_weights(bricks.y, *slab.y)
            found += np.multiply.outer(line_weights(bricks.x, *slab.x), across)
    return found


def whole_nodes(
    bricks: Bricks, unknowns: Unknowns, motion: Motion, unit: float, nodal: Floats
) -> tuple[Floats, Expansion, Floats]:
    """Nodes, expansion and nodal masses of the whole body, mirrored from the quarter.

    The nodes are the points of :meth:`geometry.bimorph.bricks.Bricks.node_mesh`, in its order.
    """
    x, from_x, turned_x = bricks.continued_x(bricks.x.nodes)
    y, from_y, turned_y = mirrored_axis(bricks.y.nodes)
    z = bricks.z.nodes
    used = bricks.used()[np.ix_(from_x, from_y)]
    source = np.arange(unknowns.free.shape[0]).reshape(bricks.shape)[np.ix_(from_x, from_y)][used]
    turned = np.stack(np.broadcast_arrays(turned_x[:, None, None], turned_y[:, None]), axis=-1)
    turned = np.broadcast_to(turned, (*used.shape, 2))[used]
    sign = mirror_signs(motion, turned) * np.array([1.0, 1.0, 1.0, unit])
    nodes = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1)[used]
    copies = np.bincount(source, minlength=unknowns.free.shape[0])
    lines = None
    if any(axis.hierarchic for axis in bricks.axes):
        at_x, at_y, at_z = (nodal_values(axis) for axis in bricks.axes)
        lines = at_x, at_y, at_z
    return nodes, Expansion(unknowns, source, sign, lines), nodal[source] / copies[source]


def nodal_mass(bricks: Bricks, known: dict[str, Material]) -> Floats:
    """Mass of the quarter's body at its nodes (n,), all four quarters counted.

    In proportion to the diagonal of the mass over values at nodes: row sums may be negative.
    """
    plain = [replace(axis, hierarchic=False) for axis in bricks.axes]
    found, total = np.zeros(bricks.shape), 0.0
    for slab in bricks.slabs:
        spans = (slab.x, slab.y, slab.z)
        lines = [line_matrices(axis, *span) for axis, span in zip(plain, spans, strict=True)]
        along = [line.integrals[0, 0][line.rows == line.columns] for line in lines]
        sizes = [axis.breaks[b] - axis.breaks[a] for axis, (a, b) in zip(plain, spans, strict=True)]
        density = bricks.copies * known[slab.region].density
        found += density * np.multiply.outer(np.outer(along[0], along[1]), along[2])
        total += density * float(np.prod(sizes))
    return np.asarray(found * (total / found.sum())).ravel()
