"""The half plane of an axisymmetric device as a grid of graded lines, which can move with a part.

Rectangular regions in (r, z), lines through all their edges, cells that shrink towards
the corners of iron and grow outwards.  Where parts move or change their size, the lines on
their edges follow and the cells between are stretched; cells, labels and numbering stay.  No
field, no elements.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.device.checks import check_gap
from tactgen.geometry.device.magnetisation import MagnetisationCurve
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.errors import InputError

#: Cells at an iron line: this part of the distance to the nearest facing edge.
CORNER = 0.2
#: Cells at a winding's edge: this part of the winding's own width or height.
WINDING = 0.5
#: Increase of the cell size per length away from a line; 1 about doubles it from cell to cell.
GROWTH = 1.0
#: Cells at the lowest and highest edge: at most this part of the way to the outer wall.
_TO_WALL = 0.1
#: Samples from an edge to the middle between two, by which cells are counted, and the first as a
#: power of ten of the distance: far below any cell.
_SAMPLES, _FIRST = 300, -8.0
#: Part of a cell that is left out rather than made one more: it saves lines at no visible loss.
_SPARED = 0.3
#: A fitted grid is good until a cell is this much wider or higher than where it was graded.
_STRETCH = 2.5
#: Edges (m) that are this close are the same; where two that were apart meet, so much is left
#: between their lines.
_APART = 1e-10

#: Air around a device: this part of its largest radius (60 mm for the paper's diameter of 2.3 mm),
#: at least this part of the distance of its farthest end.  Costs a few lines.
_RADII, _REACH = 60e-3 / 1.15e-3, 3.0


@dataclass(frozen=True)
class Region:
    """A ring of rectangular section, of one material."""

    name: str  #: What results call it
    radii: tuple[float, float]  #: Inner and outer radius (m)
    heights: tuple[float, float]  #: Lower and upper end (m)
    #: Its material; None is vacuum's permeability (air, copper)
    curve: MagnetisationCurve | None = None
    turns: float = 0.0  #: Turns of a winding that fills the section evenly; 0 where there is none
    moves: bool = False  #: Whether it moves along z with the other moving regions

    @property
    def section(self) -> float:
        """Area of the half section (m²)."""
        return (self.radii[1] - self.radii[0]) * (self.heights[1] - self.heights[0])

    def displaced(self, displacement: float) -> Region:
        """Region after the moving ones went up by `displacement` (m)."""
        if not self.moves:
            return self
        low, high = self.heights
        return replace(self, heights=(low + displacement, high + displacement))


@dataclass(frozen=True)
class Grid:
    """A tensor-product grid with its regions, of which every edge lies on a line."""

    r: Floats  #: (nr + 1,) Lines (m), increasing from 0
    z: Floats  #: (nz + 1,) Lines (m), increasing
    regions: tuple[Region, ...]  #: Where two overlap, the later one holds

    @cached_property
    def labels(self) -> Ints:
        """Index of the region of each cell, (nr, nz); −1 in the air outside all of them."""
        r, z = 0.5 * (self.r[1:] + self.r[:-1]), 0.5 * (self.z[1:] + self.z[:-1])
        labels = np.full((r.size, z.size), -1)
        for index, region in enumerate(self.regions):
            labels[np.ix_(_within(r, region.radii), _within(z, region.heights))] = index
        return labels

    @property
    def iron_velocity(self) -> Floats:
        """Motion of z lines with the iron edges, (nz + 1,), linear between."""
        places = {float(self.z[0]): 0.0, float(self.z[-1]): 0.0}
        for region in self.regions:
            if region.curve is not None:
                places |= dict.fromkeys(region.heights, float(region.moves))
        marks = sorted(places)
        return np.interp(self.z, marks, [places[mark] for mark in marks])

    def fitted(self, regions: tuple[Region, ...]) -> Grid | None:
        """Grid fitted to regions of other sizes and heights.

        Each line goes with the edge that lies on it.  None where a line would have to follow
        two edges, an edge would pass another, or a cell would become too wide or too high.
        """
        if [part.name for part in regions] != [part.name for part in self.regions]:
            return None
        pairs = list(zip(self.regions, regions, strict=True))
        r = _followed(self.r, [e for a, b in pairs for e in zip(a.radii, b.radii, strict=True)])
        z = _followed(self.z, [e for a, b in pairs for e in zip(a.heights, b.heights, strict=True)])
        return None if r is None or z is None else Grid(r, z, regions)


def _followed(lines: Floats, edges: list[tuple[float, float]]) -> Floats | None:
    """Lines that go with edges from where they were to where they are; ends stay."""
    ends = ((float(lines[0]), float(lines[0])), (float(lines[-1]), float(lines[-1])))
    places: dict[float, float] = {}
    for old, new in sorted((*edges, *ends)):
        if abs(places.setdefault(old, new) - new) > _APART:
            return None
    marks, goals = np.array(list(places)), np.array(list(places.values()))
    if np.diff(goals).min() < -_APART:
        return None
    for n in np.flatnonzero(np.diff(goals) < _APART) + 1:
        goals[n] = goals[n - 1] + _APART
    found = np.interp(lines, marks, goals)
    good = bool((np.diff(found) <= _STRETCH * np.diff(lines)).all())
    return np.asarray(found) if good and (np.diff(found) > 0.0).all() else None


def air_radius(regions: tuple[Region, ...]) -> float:
    """Radius and half height (m) of the air around z = 0, in proportion to the device."""
    widest = max(region.radii[1] for region in regions)
    reach = max(abs(z) for region in regions for z in region.heights)
    return max(_RADII * widest, _REACH * reach)


def graded_grid(
    regions: tuple[Region, ...], outer_radius: float | None = None, *, refinement: float = 1.0
) -> Grid:
    """Grid over 0 ≤ r ≤ R, −R ≤ z ≤ R, graded towards every edge of iron, air elsewhere.

    R (m) is the radius and half height of the air around z = 0, by default :func:`air_radius`.
    `refinement` divides the cell sizes at the edges and their growth; 2 gives about twice as many
    lines in each direction.

    Raises ValueError if an edge of a moving region is level with one of a fixed region: a line can
    follow only one of them.
    """
    outer_radius = outer_radius or air_radius(regions)
    r_marks = np.unique([0.0, outer_radius, *(x for region in regions for x in region.radii)])
    r_sizes = _edge_sizes(r_marks, [(i.radii, i.heights, i) for i in regions]) / refinement
    still = {x for region in regions if not region.moves for x in region.heights}
    carried = {x for region in regions if region.moves for x in region.heights}
    if still & carried:
        raise ValueError(f"a moving and a fixed edge are level at z = {min(still & carried)} m")
    z_marks = np.array(sorted(still | carried | {-outer_radius, outer_radius}))
    z_sizes = _edge_sizes(z_marks, [(i.heights, i.radii, i) for i in regions]) / refinement
    # two cells of air at least beyond the iron, however far its last edge is from the others
    ends = _TO_WALL * np.diff(z_marks)[[0, -1]]
    z_sizes[[1, -2]] = np.minimum(z_sizes[[1, -2]], ends)
    growth = GROWTH / refinement
    return Grid(
        graded_lines(r_marks, r_sizes, growth), graded_lines(z_marks, z_sizes, growth), regions
    )


def graded_lines(marks: Floats, sizes: Floats, growth: float) -> Floats:
    """Lines through all marks, spaced by h(x) = min over marks of size + growth·distance.

    Each interval between the increasing `marks` (n,) in m gets whole cells that share ∫ dx/h
    evenly. `sizes` (n,) are the cell sizes wanted at the marks (m), infinite where there is no
    need; `growth` is the greatest increase of the size per length.
    """
    # fine samples towards both ends of an interval, where 1/h is steep
    ramp = np.concatenate([[0.0], np.logspace(_FIRST, np.log10(0.5), _SAMPLES)])
    samples = np.unique(np.concatenate([ramp, 1.0 - ramp]))
    lines = [marks[:1]]
    for start, end in pairwise(marks):
        x = start + (end - start) * samples
        middle = 0.5 * (x[1:] + x[:-1])
        size = np.min(sizes + growth * np.abs(middle[:, None] - marks), axis=1)
        cells = np.concatenate([[0.0], np.cumsum(np.diff(x) / size)])
        count = max(1, int(np.ceil(cells[-1] - _SPARED)))
        inner = np.interp(np.arange(1, count) * cells[-1] / count, cells, x)
        lines.append(np.append(inner, end))
    return np.concatenate(lines)


_Span = tuple[float, float]


def _edge_sizes(marks: Floats, edges: list[tuple[_Span, _Span, Region]]) -> Floats:
    """Cell size wanted at each mark; infinite where nothing asks for one.

    `edges` are the regions' extents along this direction and across it.  Iron asks for a
    part of the distance to the nearest iron edge that it faces, that is, whose extent
    across overlaps; a winding, at whose edges the field has no singularity, for a larger
    part of its own extent.
    """
    sizes = np.full(marks.size, np.inf)
    iron = [(x, across) for along, across, region in edges if region.curve for x in along]
    wanted = [
        (x, WINDING * (along[1] - along[0]))
        for along, _, region in edges
        if region.turns
        for x in along
    ]
    for x, (low, high) in iron:
        facing = [
            abs(other - x)
            for other, (bottom, top) in iron
            if other != x and min(high, top) > max(low, bottom)
        ]
        wanted.append((x, CORNER * min(facing)))
    for x, size in wanted:
        at = int(np.searchsorted(marks, x))
        sizes[at] = min(sizes[at], size)
    return sizes


def _within(x: Floats, span: _Span) -> Bools:
    return np.asarray((x > span[0]) & (x < span[1]))


#: Rounding of coordinates (m), so that edges meant to be level are so.
_DIGITS = 12
#: A moving edge level with a fixed one is lifted by this (m), since a line follows one part.
_REGIONS_APART = 1e-10


def actuator_regions(device: Device, gap: float) -> tuple[Region, ...]:
    """Parts of the normal actuator at a gap; z = 0 is the sleeve's top face.

    Raises InputError if parts overlap at this gap, or a moving one meets a fixed one, or the gap is
    not open.
    """
    rod, coil, sleeve = device.rod, device.coil, device.sleeve
    if not gap > 0.0:
        raise InputError(f"gap = {gap * 1e3:g} mm is not open; use a gap above 0 mm")
    check_gap(device, gap)
    steel = magnetisation_curve(device.steel)
    head = (NOMINAL_GAP, NOMINAL_GAP + rod.head_thickness)
    flange = -rod.flange_position
    moving = (
        Region("rod", (0.0, rod.radius), (-rod.length, head[1]), steel),
        Region("flange", (0.0, rod.flange_radius), (flange - rod.flange_thickness, flange), steel),
        Region("head", (0.0, rod.head_radius), head, steel),
        Region(
            "coil",
            (coil.inner_radius, coil.outer_radius),
            (-coil.position - coil.length, -coil.position),
            turns=coil.turns,
        ),
    )
    fixed = [
        Region("sleeve", (sleeve.inner_radius, sleeve.outer_radius), (-sleeve.length, 0.0), steel)
    ]
    if sleeve.collar_radius < sleeve.inner_radius:  # else there is none
        collar = (sleeve.collar_radius, sleeve.outer_radius), (-sleeve.collar_thickness, 0.0)
        fixed.append(Region("collar", *collar, steel))
    carried = [_rounded(replace(part, moves=True).displaced(gap - NOMINAL_GAP)) for part in moving]
    still = [_rounded(part) for part in fixed]
    _refuse_overlap(carried, still, gap)
    level = {z for part in still for z in part.heights}
    if any(z in level for part in carried for z in part.heights):
        carried = [part.displaced(_REGIONS_APART) for part in carried]
    return (*carried, *still)


def _rounded(part: Region) -> Region:
    (inner, outer), (low, high) = part.radii, part.heights
    return replace(
        part,
        radii=(round(inner, _DIGITS), round(outer, _DIGITS)),
        heights=(round(low, _DIGITS), round(high, _DIGITS)),
    )


def _refuse_overlap(carried: list[Region], still: list[Region], gap: float) -> None:
    """Refuse parts that touch although one moves, and a winding inside the iron it moves with."""
    for one in carried:
        for other in still:
            across, along = _shared(one, other)
            # a common edge is no contact of faces
            if min(across, along) >= 0.0 and max(across, along) > 0.0:
                raise InputError(
                    f"gap = {gap * 1e3:g} mm drives the {one.name} into the {other.name} by "
                    f"{min(across, along) * 1e3:.3g} mm; use a smaller gap or other radii"
                )
        if one.turns:
            for other in carried:
                if other is not one and min(_shared(one, other)) > 0.0:
                    raise InputError(
                        f"the {one.name} runs into the {other.name} by "
                        f"{min(_shared(one, other)) * 1e3:.3g} mm; make it shorter or move it"
                    )


def _shared(one: Region, other: Region) -> tuple[float, float]:
    """Lengths (m) shared across and along the axis; negative is a distance."""
    return (
        min(one.radii[1], other.radii[1]) - max(one.radii[0], other.radii[0]),
        min(one.heights[1], other.heights[1]) - max(one.heights[0], other.heights[0]),
    )
