"""Bricks of high order: the layered bimorph as a quarter of boxes on one tensor grid.

Bimorph, wiring and poling are symmetric about the planes x = 0 and y = 0, so a quarter
(x ≥ 0, y ≥ 0) stands for the whole; of layers that are listed one by one half of it (y ≥ 0) does,
x = 0 in the middle of their thickness.  Each axis is divided into intervals; a brick is a
product of three of them and carries polynomials of a degree of its own per axis, whose
nodes are the Gauss–Lobatto points.

Polynomials of an axis are those of its nodes (Lagrange), or in a hierarchy: hats at the break
points, and bubbles of degree 2, 3, … within each interval.  Of a hierarchy the products of high
degree along several axes can be left out, which add many unknowns and little accuracy (B. Szabó
and I. Babuška, Finite Element Analysis, Wiley 1991, the trunk space).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import chain, pairwise
from typing import Literal

import numpy as np
from numpy.polynomial import legendre

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.bimorph.segments import bimorph_stack, cuts_along, side_edges
from tactgen.geometry.device.checks import check_bonded, check_constant_section
from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.meshing.mesh import Mesh

#: Which part of the lowest section is held: all layers, or the shim alone.
Held = Literal["layers", "shim"]

#: Sums of shares are equal within this.
_ROUNDING = 1e-9


@cache
def lobatto_points(degree: int) -> Floats:
    """Degree + 1 Gauss–Lobatto points in [−1, 1]: both ends and the zeros of P'."""
    polynomial = np.zeros(degree + 1)
    polynomial[degree] = 1.0
    inner = np.sort(legendre.legroots(legendre.legder(polynomial)).real)
    return np.concatenate([[-1.0], inner, [1.0]])


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis: ascending break points (m) and the degree of the polynomials between them.

    Functions are numbered upwards, those of an interval between those of its ends; in a
    hierarchy those of an interval by their degree.
    """

    breaks: Floats
    degree: int
    hierarchic: bool = False

    @property
    def intervals(self) -> int:
        """Number of intervals."""
        return int(self.breaks.size - 1)

    @cached_property
    def nodes(self) -> Floats:
        """Nodes (m), ascending; every `degree`-th is a break point."""
        share = 0.5 * (lobatto_points(self.degree)[1:] + 1.0)
        inner = self.breaks[:-1, None] + np.diff(self.breaks)[:, None] * share
        inner[:, -1] = self.breaks[1:]
        return np.concatenate([self.breaks[:1], inner.ravel()])

    @cached_property
    def bubbles(self) -> Ints:
        """Degree of each function (n,) that is zero at all break points; 0 of the others."""
        place = np.arange(self.nodes.size) % self.degree
        return np.where(place == 0, 0, place + 1)

    @property
    def one(self) -> Floats:
        """The function 1 in those of the axis (n,)."""
        return np.asarray((self.bubbles == 0) | (not self.hierarchic), dtype=float)

    @property
    def position(self) -> Floats:
        """The position along the axis (m) in its functions (n,)."""
        return self.one * self.nodes

    def nodes_of(self, first: int, last: int) -> slice:
        """Where the nodes of the intervals first … last − 1 are."""
        return slice(first * self.degree, last * self.degree + 1)


@dataclass(frozen=True)
class Slab:
    """Bricks of one material: intervals along each axis."""

    region: str
    x: tuple[int, int]
    y: tuple[int, int]
    z: tuple[int, int]
    ceramic: bool = False  #: Whether it is piezoelectric
    faces: tuple[int, ...] = (-1, 1)  #: Faces of a ceramic (along x) that are equipotential
    hot: int = 0  #: Face of a ceramic (along x) at the drive voltage, 0 if none is
    uniform: bool = False  #: Whether the potential is linear from face to face of a ceramic


@dataclass(frozen=True)
class Bricks:
    """A quarter of a layered bimorph on a tensor grid, or half of it."""

    #: From the planes of symmetry (x, y) and from the held end (z)
    x: Axis
    y: Axis
    z: Axis
    #: What is where; the rest of the grid is empty.  Regions are ``piezo``, ``shim`` and ``glue``
    slabs: tuple[Slab, ...]
    #: (int, int) Break points along z between which faces at the voltage carry electrodes.  Others
    #: are metallised all over
    electrode: tuple[int, int]
    held: Held = "layers"  #: Part of the lowest section that is the base
    #: Of hierarchic axes: products of functions are there whose degrees, each as a share of its
    #: axis' degree, add up to no more.  1 is the trunk space, 3 has all products
    richness: float = 3.0
    mirrored_x: bool = True  #: Whether x = 0 is a plane of symmetry, and x ≥ 0 all there is

    @property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        """The three axes."""
        return self.x, self.y, self.z

    @property
    def copies(self) -> float:
        """How many of it make the whole."""
        return 4.0 if self.mirrored_x else 2.0

    def continued_x(self, nodes: Floats) -> tuple[Floats, Ints, Bools]:
        """Positions along x of the whole, as :func:`mirrored_axis` gives them."""
        if self.mirrored_x:
            return mirrored_axis(nodes)
        return nodes, np.arange(nodes.size), np.zeros(nodes.size, dtype=bool)

    @property
    def ceramics(self) -> tuple[Slab, ...]:
        """Piezoelectric slabs."""
        return tuple(slab for slab in self.slabs if slab.ceramic)

    @property
    def degree(self) -> tuple[int, int, int]:
        """Degree of the polynomials along each axis."""
        return self.x.degree, self.y.degree, self.z.degree

    @property
    def shape(self) -> tuple[int, int, int]:
        """Nodes along each axis."""
        return self.x.nodes.size, self.y.nodes.size, self.z.nodes.size

    @property
    def regions(self) -> tuple[str, ...]:
        """Names of the materials, each once."""
        return tuple(dict.fromkeys(slab.region for slab in self.slabs))

    def nodes_of(self, *regions: str) -> Bools:
        """Mask (nx, ny, nz) of the nodes that belong to any of the regions."""
        mask = np.zeros(self.shape, dtype=bool)
        for slab in self.slabs:
            if slab.region in regions:
                mask[self.nodes_in(slab)] = True
        return mask

    def nodes_in(self, slab: Slab) -> tuple[slice, slice, slice]:
        """Where the nodes of a slab are along each axis."""
        spans = zip(self.axes, (slab.x, slab.y, slab.z), strict=True)
        x, y, z = (axis.nodes_of(*span) for axis, span in spans)
        return x, y, z

    def products(self) -> Bools:
        """Mask (nx, ny, nz) of the products of functions that are there."""
        shares = [
            a.bubbles / a.degree if a.hierarchic else np.zeros(a.nodes.size) for a in self.axes
        ]
        total = shares[0][:, None, None] + shares[1][:, None] + shares[2]
        return np.asarray(total <= self.richness + _ROUNDING)

    def one(self) -> Floats:
        """Function 1 in the products of functions (nx, ny, nz)."""
        return self.x.one[:, None, None] * self.y.one[:, None] * self.z.one

    def base(self) -> Bools:
        """Mask (nx, ny, nz) of the nodes of the base section."""
        parts = ("shim",) if self.held == "shim" else self.regions
        mask = self.nodes_of(*parts)
        mask[:, :, 1:] = False
        return mask

    def electrodes(self) -> tuple[Bools, Bools]:
        """Masks (nx, ny, nz) of the nodes of the electrodes at the voltage and at 0 V."""
        hot, cold = np.zeros(self.shape, dtype=bool), np.zeros(self.shape, dtype=bool)
        for slab in self.ceramics:
            _, y, z = self.nodes_in(slab)
            for sign in slab.faces:
                at = slab.x[sign > 0] * self.x.degree
                if sign == slab.hot:
                    hot[at, y, self.z.nodes_of(*self.driven(slab))] = True
                else:
                    cold[at, y, z] = True
        return hot, cold

    def driven(self, slab: Slab) -> tuple[int, int]:
        """Break points along z between which a ceramic's face at the voltage has its electrode."""
        return max(slab.z[0], self.electrode[0]), min(slab.z[1], self.electrode[1])

    def used(self) -> Bools:
        """Mask (nx, ny, nz) of the nodes that any material has."""
        return self.nodes_of(*self.regions)

    def corner_mesh(self) -> Mesh:
        """Whole bimorph with one eight-cornered cell per brick."""
        return _mirrored(self, tuple(axis.breaks for axis in self.axes), (1, 1, 1))

    def node_mesh(self) -> Mesh:
        """Whole bimorph with every node a point: bricks cut at their nodes."""
        degrees = tuple(axis.degree for axis in self.axes)
        return _mirrored(self, tuple(axis.nodes for axis in self.axes), degrees)


def mirrored_axis(nodes: Floats) -> tuple[Floats, Ints, Bools]:
    """Axis continued to the other side of 0: three arrays (2 n − 1,), ascending.

    Positions, the node of the half that each is or mirrors, and whether it lies on the other side.
    """
    n = nodes.size
    source = np.abs(np.arange(-(n - 1), n))
    reflected = np.arange(2 * n - 1) < n - 1
    return np.where(reflected, -nodes[source], nodes[source]), source, reflected


def _mirrored(bricks: Bricks, half: tuple[Floats, ...], cuts: tuple[int, ...]) -> Mesh:
    """Fill the grid mirrored in x and y with eight-cornered cells.

    `cuts` is the number of cells per interval along each axis.
    """
    x, y, z = bricks.continued_x(half[0])[0], mirrored_axis(half[1])[0], half[2]
    nx, ny, nz = x.size, y.size, z.size
    middle = nx // 2 if bricks.mirrored_x else 0
    owner = np.full((nx - 1, ny - 1, nz - 1), -1)
    names = _whole_regions(bricks)
    for slab in bricks.slabs:
        low, high = (i * cuts[0] for i in slab.x)
        along = slice(slab.z[0] * cuts[2], slab.z[1] * cuts[2])
        first, last = (i * cuts[1] for i in slab.y)
        of_half = np.abs(np.arange(ny - 1) - (ny - 2) / 2)  # cells from the plane y = 0 on
        across = (of_half > first) & (of_half < last)
        sides = [(slice(middle + low, middle + high), "top")]
        if bricks.mirrored_x:
            sides.append((slice(middle - high, middle - low), "bottom"))
        for side, name in sides:
            region = f"piezo_{name}" if slab.region == "piezo" else slab.region
            owner[side, across, along] = names.index(region)
    i, k, j = np.nonzero(owner.swapaxes(1, 2) >= 0)
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    corners = [(*ab, c) for c in (0, 1) for ab in around]
    cells = np.stack([((i + a) * ny + j + b) * nz + k + c for a, b, c in corners], axis=1)
    used, cells = np.unique(cells, return_inverse=True)
    grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    cells, owners = cells.reshape(-1, 8), owner[i, j, k]
    points = grid[used]
    return Mesh(
        points=points,
        cells=cells,
        kind="hexahedron",
        region_of_cell=owners.astype(np.int64),
        regions=names,
        faces=_named_faces(bricks, cells, points, owners, names),
    )


def _whole_regions(bricks: Bricks) -> tuple[str, ...]:
    if not bricks.mirrored_x:
        return bricks.regions
    rest = tuple(region for region in bricks.regions if region != "piezo")
    return ("piezo_top", "piezo_bottom", *rest)


def _named_faces(
    bricks: Bricks, cells: Ints, points: Floats, region: Ints, names: tuple[str, ...]
) -> dict[str, Ints]:
    """Quadrilaterals of each named face."""
    low_x, high_x = cells[:, [0, 3, 7, 4]], cells[:, [1, 2, 6, 5]]
    low_z, high_z = cells[:, [0, 1, 2, 3]], cells[:, [4, 5, 6, 7]]
    start, end = (bricks.z.breaks[k] for k in bricks.electrode)
    tolerance = 1e-9 * float(np.abs(bricks.x.breaks).max())

    def on_plane(quads: Ints, axis: int, value: float) -> Bools:
        return np.asarray((np.abs(points[quads, axis] - value) < tolerance).all(axis=1))

    def electroded(quads: Ints) -> Bools:
        z = points[quads, 2]
        return np.asarray(((z > start - tolerance) & (z < end + tolerance)).all(axis=1))

    held = np.ones(region.size, dtype=bool)
    if bricks.held == "shim":
        held = region == names.index("shim")
    found = {
        "base": low_z[held & on_plane(low_z, 2, 0.0)],
        "tip": high_z[on_plane(high_z, 2, float(bricks.z.breaks[-1]))],
    }
    for name, owner, x, sign, hot in _metallised(bricks):
        quads = high_x if sign > 0 else low_x
        of = (region == names.index(owner)) & on_plane(quads, 0, x)
        found[name] = quads[of & electroded(quads) if hot else of]
    return found


def _metallised(bricks: Bricks) -> Iterator[tuple[str, str, float, int, bool]]:
    """Name, region, position along x, direction and whether at the voltage of each metal face."""
    for slab in bricks.ceramics:
        for sign in slab.faces:
            x, hot = float(bricks.x.breaks[slab.x[sign > 0]]), sign == slab.hot
            if bricks.mirrored_x:
                face = "outer" if hot else "inner"
                yield f"electrode_top_{face}", "piezo_top", x, sign, hot
                yield f"electrode_bottom_{face}", "piezo_bottom", -x, -sign, hot
            else:
                face = "upper" if sign > 0 else "lower"
                yield f"electrode_{slab.region}_{face}", slab.region, x, sign, hot


#: Ratio of neighbouring intervals towards a side edge.
_GROWTH = 4.0
#: What is left in the middle is one interval if it is no more than so many of the next: none is
#: then much narrower than its neighbour.
_LAST = 1.5
#: Longest brick across the width, in thicknesses of the bimorph, or this share of half the
#: width if that is more: in a thin plate what is far from the edges varies with the width.
_WIDEST = 3.0
_WIDEST_SHARE = 0.5
#: Share of half the width that counts as a layer's thickness if that is more.
_SIDE_SHARE = 0.5
#: Half a shim up to this many piezo layers thick is one interval: polynomials across it
#: have more to give than the layers' have.
_THIN_CORE = 0.6
#: Share of the thickness that a layer counts with if it is thinner.
_LEAST_GRAIN = 0.1


@dataclass(frozen=True)
class BrickMeshing:
    """Mesh settings of the bimorph's bricks."""

    degree: tuple[int, int, int]  #: (int, int, int) Degree of the polynomials along x, y and z
    #: Intervals of a piezo layer from its inner to its outer face, as shares of it
    layer: tuple[float, ...] = (1.0,)
    #: Intervals of half the shim where that is no thin part of the whole; otherwise it is one
    core: int = 1
    #: Interval at the side edge, as a share of the thinnest layer, or of a quarter of the width if
    #: that is less (0: no grading)
    side: float = 0.0
    #: Length of the bricks at the held end and at the ceramic's lower end, as a share of the
    #: thinnest layer
    smallest: float = 0.2
    tip: float = 0.2  #: The same at the upper end, where the singularity is weak
    longest: float = 6.0  #: Longest brick along z, in thicknesses of the bimorph
    #: (float, float) Fewest and most pieces of the length that the longest brick may be all the
    #: same: modes of a stout bimorph, and what is far from the ends of a slender one, vary with it
    pieces: tuple[float, float] = (6.0, 10.0)
    growth: float = 6.0  #: Ratio of neighbouring lengths along z
    #: Polynomials in a hierarchy, of which these products are there
    #: (:class:`geometry.bimorph.bricks.Bricks`); without it those of nodes, all products
    richness: float | None = None


#: A family of divisions for refinement studies; from one to the next errors fall by two to
#: four (about 2, 3, 8, 14 and 27 thousand unknowns for a plain bimorph).  What is coarse in
#: one must be finer in the next (degree or length, each axis, edges and ends), or their
#: difference would not tell what is missing.
LEVELS = (
    BrickMeshing(
        (2, 2, 3), side=0.4, smallest=0.4, tip=1.0, longest=8.0, pieces=(4.0, 10.0), richness=2.0
    ),
    BrickMeshing((4, 4, 4), side=0.65, smallest=0.2, tip=1.0, pieces=(4.0, 10.0), richness=1.25),
    BrickMeshing(
        (4, 4, 5), (0.35, 0.65), 2, 0.25, 0.07, tip=0.5, pieces=(4.0, 10.0), richness=1.25
    ),
    BrickMeshing((4, 4, 5), (0.15, 0.85), 3, 0.15, 0.03, longest=5.0, pieces=(5.0, 10.0),
                 richness=1.5),
    BrickMeshing((4, 4, 5), (0.15, 0.7, 0.15), 4, 0.1, 0.015, tip=0.1, longest=5.0, growth=5.0,
                 richness=1.5),
)  # fmt: skip


def bimorph_bricks(device: Device, meshing: BrickMeshing, held: Held = "layers") -> Bricks:
    """Divide a quarter of the bimorph, z = 0 at the lower end of the tab (or of the ceramic).

    Of listed layers it is half of it.

    Raises InputError if the cross-section changes along the ceramic, or glue lets the layers slide.
    """
    check_constant_section(device)
    check_bonded(device)
    z, ceramic, electrode = _along(device, meshing)
    y, listed = _across(device.bimorph, meshing), bool(device.bimorph.layers)
    wide, ends = (0, y.size - 1), (*ceramic, z.size - 1)
    x, slabs = _listed(device, meshing, y, z) if listed else _sandwich(device, meshing, wide, ends)
    ax, ay, az = (
        Axis(breaks, degree, hierarchic=meshing.richness is not None)
        for breaks, degree in zip((x, y, z), meshing.degree, strict=True)
    )
    bricks = Bricks(ax, ay, az, slabs=slabs, electrode=electrode, held=held, mirrored_x=not listed)
    return bricks if meshing.richness is None else replace(bricks, richness=meshing.richness)


def _piezo_shares(bimorph: Bimorph, meshing: BrickMeshing) -> tuple[float, ...]:
    """Intervals of a ceramic from its inner to its outer face, as shares of it."""
    ends_inside = bimorph.bare_below > 0.0 or bimorph.bare_above > 0.0
    # the field is singular at the end of an electrode, on the outer face
    return tuple(sorted(meshing.layer, reverse=True)) if ends_inside else meshing.layer


def _sandwich(
    device: Device, meshing: BrickMeshing, wide: tuple[int, int], ends: tuple[int, int, int]
) -> tuple[Floats, tuple[Slab, ...]]:
    """Break points along x from the middle, and slabs, of half of piezo, shim and piezo."""
    bimorph = device.bimorph
    half, glue = 0.5 * bimorph.shim_thickness, bimorph.glue_thickness
    piezo = bimorph.piezo_thickness
    core = meshing.core if half > _THIN_CORE * piezo else 1
    steps = [half / core] * core + ([glue] if glue > 0.0 else [])
    steps += [s * piezo for s in _piezo_shares(bimorph, meshing)]
    x = np.concatenate([[0.0], np.cumsum(steps)])
    x[-1] = half + glue + piezo
    first, (low, high, n) = core + (glue > 0.0), ends
    slabs = [Slab("shim", (0, core), wide, (0, n))]
    if glue > 0.0:
        slabs.append(Slab("glue", (core, first), wide, (low, high)))
    outer = Slab("piezo", (first, x.size - 1), wide, (low, high), ceramic=True, hot=1)
    return x, (*slabs, outer)


def _listed(
    device: Device, meshing: BrickMeshing, y: Floats, z: Floats
) -> tuple[Floats, tuple[Slab, ...]]:
    """Break points along x, 0 in the middle, and slabs of the layers that the bimorph lists."""
    own = device.bimorph
    x, slabs = [-0.5 * own.thickness], []
    for number, (layer, ends) in enumerate(zip(bimorph_stack(device), own.spans, strict=True)):
        is_ceramic, thickness = layer.poling != 0.0, float(layer.thickness)
        shares: tuple[float, ...] = (1.0,)
        if is_ceramic:
            shares = _piezo_shares(device.bimorph, meshing)
            shares = shares if layer.low + layer.high > 0.0 else shares[::-1]
        elif thickness > 2.0 * _THIN_CORE * _grain(device.bimorph):
            shares = (1.0 / meshing.core,) * meshing.core
        first = len(x) - 1
        x += [float(layer.low + thickness * share) for share in np.cumsum(shares)]
        x[-1] = float(layer.high)
        slabs.append(
            Slab(
                layer.region,
                (first, len(x) - 1),
                (0, _nearest(y, 0.5 * own.widths[number])),
                (_nearest(z, ends[0]), _nearest(z, ends[1])),
                ceramic=is_ceramic,
                faces=own.layers.faces(number),
                hot=int(layer.hot),
                uniform=layer.uniform,
            )
        )
    return np.array(x), tuple(slabs)


def _grain(bimorph: Bimorph) -> float:
    """Length (m) on which the solution varies at edges and ends.

    That is the thinnest layer; of a foil a tenth of the whole, of which ever flatter bricks
    would only cost digits.
    """
    thin = min(bimorph.piezo_thickness, bimorph.shim_thickness)
    if bimorph.layers:
        thin = min(layer.thickness for layer in bimorph.layers)
    return float(max(thin, _LEAST_GRAIN * bimorph.thickness))


def _across(bimorph: Bimorph, meshing: BrickMeshing) -> Floats:
    """Divide the half width, intervals growing from each layer's side edge to both sides."""
    edges = side_edges(0.5 * width for width in bimorph.widths or [bimorph.width])
    first = meshing.side * min(_grain(bimorph), _SIDE_SHARE * edges[1])
    y: Floats = np.zeros(1)
    part: Floats
    for low, high in pairwise(edges):
        length, widest = high - low, max(_WIDEST * bimorph.thickness, _WIDEST_SHARE * high)
        if meshing.side == 0.0:
            part = np.linspace(0.0, length, int(np.ceil(length / widest)) + 1)
        elif low == 0.0:
            part = _from_the_middle(length, first, widest)
        else:
            part = _graded(length, first, first, _GROWTH, widest)
        y = np.concatenate([y, low + part[1:-1], [high]])
    return y


def _from_the_middle(length: float, first: float, widest: float) -> Floats:
    """Divide [0, length], intervals growing from `first` at its upper end."""
    steps = [first]
    while (rest := length - sum(steps)) > _LAST * (step := min(_GROWTH * steps[-1], widest)):
        steps.append(step)
    steps.append(rest)
    return np.concatenate([[0.0], np.cumsum(steps[::-1])[:-1], [length]])


def _along(
    device: Device, meshing: BrickMeshing
) -> tuple[Floats, tuple[int, int], tuple[int, int]]:
    """Divide the length; also return where the ceramic is, and the electrodes at the voltage."""
    bimorph = device.bimorph
    thin = _grain(bimorph)
    length = bimorph.height
    at_most, at_least = (length / pieces for pieces in meshing.pieces)
    longest = min(max(meshing.longest * bimorph.thickness, at_least), at_most)
    first, last = meshing.smallest * thin, max(meshing.smallest, meshing.tip) * thin
    ceramic = (bimorph.tab_length, bimorph.tab_length + bimorph.length)
    electrode = (ceramic[0] + bimorph.bare_below, ceramic[1] - bimorph.bare_above)
    cuts = cuts_along([*ceramic, *electrode, *chain(*bimorph.spans)], length)
    z = np.zeros(1)
    for low, high in pairwise(cuts):
        upper = last if high == length else first
        part = _graded(high - low, first, upper, meshing.growth, longest)
        z = np.concatenate([z, low + part[1:]])
    z[-1] = length
    (lower, upper), (bottom, top) = (
        [_nearest(z, end) for end in ends] for ends in (ceramic, electrode)
    )
    return z, (lower, upper), (bottom, top)


def _nearest(breaks: Floats, place: float) -> int:
    return int(np.abs(breaks - place).argmin())


def _graded(length: float, first: float, last: float, growth: float, longest: float) -> Floats:
    """Divide [0, length], intervals growing from `first` below and `last` above."""
    lower, upper = [first], [last]
    while sum(lower) + sum(upper) < length:
        side = lower if lower[-1] <= upper[-1] else upper
        side.append(min(side[-1] * growth, longest))
    steps = np.array(lower + upper[::-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) * float(length / steps.sum())
