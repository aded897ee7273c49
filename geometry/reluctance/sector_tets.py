"""A sector of the normal actuator, turned: the structured mesh of its magnetic field in 3D.

The grid of the half section, swept.  Without the slot for the shim's tab every sector is
a mirror image of the next, so its half planes are walls that the flux does not cross.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.tessellation import merge_points
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import TET_EDGES, Mesh, find_rows, tet_volumes, unique_edges
from tactgen.geometry.meshing.structured_tets import reflected, swept_tetrahedra
from tactgen.geometry.reluctance.section_grid import (
    Grid,
    actuator_regions,
    air_radius,
    graded_grid,
    graded_lines,
)
from tactgen.geometry.reluctance.tets import PARTS, REGIONS

#: Lines closer than this (m) are one: cells between them would be slivers.
_APART = 1e-9


@dataclass(frozen=True)
class Sector:
    """Mesh settings of the actuator's sector."""

    #: Fineness of the half section, see :func:`geometry.reluctance.section_grid.graded_grid`
    refinement: float = 1.4
    copies: int = 16  #: Sectors in a turn
    layers: int = 1  #: Layers of cells from one half plane to the other


def sector_mesh(device: Device, gap: float, sector: Sector) -> Mesh:
    """Mesh of a sector, with `REGIONS`; z = 0 is the sleeve's top face.

    Raises InputError if the parts do not fit at this gap.
    """
    parts = actuator_regions(device, gap)
    graded = graded_grid(parts, refinement=sector.refinement)
    grid = replace(graded, z=without_slivers(graded.z))
    angles = np.linspace(0.0, 2.0 * np.pi / sector.copies, sector.layers + 1)
    return swept_tetrahedra(grid.r, grid.z, angles, cell_labels(grid, gap), REGIONS)


def without_slivers(lines: Floats) -> Floats:
    """Lines of which those that are nearly one are one."""
    apart = np.append(True, np.diff(lines) > _APART)
    return np.asarray(lines[apart])


def cell_labels(grid: Grid, gap: float) -> Ints:
    """Index into `REGIONS` of each cell of the half section."""
    r = 0.5 * (grid.r[1:] + grid.r[:-1])[:, None]
    z = 0.5 * (grid.z[1:] + grid.z[:-1])[None, :]
    labels = np.full(grid.labels.shape, REGIONS.index("far"))
    labels[:-1, 1:-1] = REGIONS.index("air")
    sleeve = next(part for part in grid.regions if part.name == "sleeve")
    # a cell more than the sleeve has, and the gap
    mantle = grid.r[np.searchsorted(grid.r, sleeve.radii[1] + _APART)]
    below = grid.z[np.searchsorted(grid.z, sleeve.heights[0] - _APART) - 1]
    labels[(r < mantle) & (z > below) & (z < gap)] = REGIONS.index("near")
    coil = next(part for part in grid.regions if part.turns)
    # T0 is not zero there: no place for a weight
    within = (z > coil.heights[0]) & (z < coil.heights[1])
    labels[(r < coil.radii[1]) & within] = REGIONS.index("coil")
    for index, part in enumerate(grid.regions):
        name = "coil" if part.turns else "rod" if part.moves else "sleeve"
        labels[grid.labels == index] = REGIONS.index(name)
    return labels


#: Eighths of a square.
COPIES = 8
#: Power by which the layers lie denser towards the middle of a wall, where the next unit is near.
_DENSER = 1.5


@dataclass(frozen=True)
class Cell:
    """Division of a cell into tetrahedra."""

    #: Fineness of the half section, see :func:`geometry.reluctance.section_grid.graded_grid`
    refinement: float = 0.7
    layers: int = 4  #: Layers of cells over the 45 degrees, thinner where the neighbour is near


def cell_mesh(device: Device, gap: float, pitch: float, cell: Cell) -> Mesh:
    """Eighth of the cell, with `REGIONS`; its square wall is the face ``mantle``.

    Raises InputError if the parts do not fit at this gap (m), or not into the pitch (m).
    """
    parts = actuator_regions(device, gap)
    outer = max(part.radii[1] for part in parts)
    wall = 0.5 * pitch
    if wall <= outer:
        raise InputError(
            f"display.pitch = {1e3 * pitch:g} mm is no more than an actuator's diameter of "
            f"{2e3 * outer:g} mm; set display.pitch to more than that"
        )
    graded = graded_grid(parts, max(air_radius(parts), 2.0 * pitch), refinement=cell.refinement)
    inner = graded.r[graded.r <= outer * (1.0 + 1e-9)]
    size = min(float(np.diff(inner)[-1]), 0.5 * (wall - outer)) / cell.refinement
    beyond = graded_lines(np.array([outer, wall]), np.array([size, np.inf]), 1.0 / cell.refinement)
    r = np.concatenate([inner[:-1], beyond])
    grid = Grid(r, without_slivers(graded.z), parts)
    labels = cell_labels(grid, gap)
    # the wall is no end of the air: stress passes along it
    labels[-1, 1:-1] = np.where(
        labels[-1, 1:-1] == REGIONS.index("far"), REGIONS.index("air"), labels[-1, 1:-1]
    )
    shares = np.linspace(0.0, 1.0, cell.layers + 1) ** _DENSER
    mesh = swept_tetrahedra(grid.r, grid.z, 0.25 * np.pi * shares, labels, REGIONS)
    return replace(mesh, points=_squared(mesh.points, outer, wall))


def _squared(points: Floats, outer: float, wall: float) -> Floats:
    """Points whose circles beyond `outer` go over into the square's side x = `wall`."""
    x, radius = points[:, 0], np.hypot(points[:, 0], points[:, 1])
    beyond = radius > outer
    moved = points.copy()
    share = (radius[beyond] - outer) / (wall - outer)
    # at the wall r goes over into wall / cos(angle)
    longer = 1.0 + share * wall * (1.0 / x[beyond] - 1.0 / radius[beyond])
    moved[beyond, :2] *= longer[:, None]
    return moved


#: Units of which the eighth has a part, their places in pitches, how many of each the nine have.
UNITS = ("middle", "beside", "diagonal")
PLACES = {"middle": (0.0, 0.0), "beside": (1.0, 0.0), "diagonal": (1.0, 1.0)}
COUNTS = {"middle": 1, "beside": 4, "diagonal": 4}
#: Eighths of a unit that the mesh has, by the octants (from the x-axis on) that they lie in.
_OCTANTS = {"middle": (0,), "beside": (0, 1, 2, 3), "diagonal": (0, 5, 6, 7)}
#: Eighths whose square wall is the outermost one, x = 1.5 pitches.
_OUTERMOST = (("beside", 0), ("diagonal", 0), ("diagonal", 7))
#: Distance (m) up to which points of neighbouring cells are the same.
_SAME_POINT = 1e-12
#: Distance of the outermost walls from the middle, and size of the first cells beyond, in pitches.
_WALL, _FIRST = 1.5, 0.25


def part_of(unit: str, part: str) -> str:
    """Region of a unit's ``rod``, ``coil`` or ``sleeve``."""
    return f"{part}_{unit}"


def nine_mesh(device: Device, gap: float, pitch: float, cell: Cell) -> Mesh:
    """Eighth of nine units: `REGIONS`, parts by unit as :func:`part_of` names them.

    Raises InputError if the parts do not fit at this gap (m), or not into the pitch (m).
    """
    own = cell_mesh(device, gap, pitch, cell)
    shared = tuple(name for name in REGIONS if name not in PARTS)
    regions = (*shared, *(part_of(unit, part) for unit in UNITS for part in PARTS))
    points: list[Floats] = []
    cells, labels, walls = [], [], []
    for unit in UNITS:
        names = [name if name in shared else part_of(unit, name) for name in own.regions]
        label = np.array([regions.index(name) for name in names])[own.region_of_cell]
        for octant in _OCTANTS[unit]:
            turn, start = _turn(octant), len(points) * len(own.points)
            placed = own.points.copy()
            placed[:, :2] = own.points[:, :2] @ turn.T + pitch * np.array(PLACES[unit])
            odd = np.linalg.det(turn) < 0.0
            points.append(placed)
            cells.append(start + (reflected(own.cells) if odd else own.cells))
            labels.append(label)
            if (unit, octant) in _OUTERMOST:
                walls.append(start + own.faces["mantle"])
    merged, index = merge_points(np.concatenate(points), _SAME_POINT)
    inner = index[np.concatenate(cells)]
    ends = np.array([_WALL * pitch, max(air_radius(actuator_regions(device, gap)), 2.0 * pitch)])
    outer_points, outer = _drawn_out(merged, inner, index[np.concatenate(walls)], ends, cell)
    far = np.full(len(outer), regions.index("far"))
    return Mesh(
        points=outer_points,
        cells=np.concatenate([inner, outer]),
        kind="tetra10",
        region_of_cell=np.concatenate([*labels, far]),
        regions=regions,
        faces={},
    )


def _turn(octant: int) -> Floats:
    """Map (2, 2) of the first octant of a unit onto another: a turn, mirrored if odd."""
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    mirror = np.array([[0.0, 1.0], [1.0, 0.0]]) if octant % 2 else np.eye(2)
    return np.asarray(np.linalg.matrix_power(quarter, octant // 2) @ mirror)


def _drawn_out(
    points: Floats, cells: Ints, wall: Ints, ends: Floats, cell: Cell
) -> tuple[Floats, Ints]:
    """All points, and the cells between the wall's triangles (n, 3) and the end of the air.

    `ends` are the distances (m) of both from the middle.
    A node is drawn out along its ray from the axis, onto layers of corners with one of mid-edge
    nodes halfway between two.  The cells of a prism go up from corners of lower number to those of
    higher, so that neighbours cut their common side alike.
    """
    sizes = np.array([_FIRST / _WALL * ends[0], np.inf])
    steps = graded_lines(ends, sizes / cell.refinement, 1.0 / cell.refinement) / ends[0]
    layers = 2 * steps.size - 1
    scales = np.interp(np.arange(layers), 2 * np.arange(steps.size), steps)
    a, b, c = np.sort(wall, axis=1).T
    paths = ((a, b, c, c), (a, b, b, c), (a, a, b, c))
    drawn = np.concatenate(
        [_drawn(np.stack(path, axis=1), ups, cells, layers) for ups, path in enumerate(paths)]
    )
    used, numbered = np.unique(drawn, return_inverse=True)
    node, layer = used // layers, used % layers
    # what lies in the wall is there already
    number = np.where(layer == 0, node, len(points) + np.cumsum(layer > 0) - 1)
    new = points[node[layer > 0]] * np.stack(
        [scales[layer[layer > 0]]] * 2 + [np.ones(np.count_nonzero(layer))], axis=1
    )
    every, tets = np.concatenate([points, new]), number[numbered.reshape(drawn.shape)]
    inverted = tet_volumes(every[tets[:, :4]]) < 0.0
    tets[inverted] = reflected(tets[inverted])
    return every, tets


def _drawn(path: Ints, ups: int, cells: Ints, layers: int) -> Ints:
    """Ten nodes of the cells along a path (n, 4) of corners, one copy for each prism above.

    A node is `layers` times the wall's node, plus its layer; the last `ups` + 1 corners are in
    the upper layer.
    """
    place = np.concatenate([np.zeros(3 - ups, dtype=int), np.full(1 + ups, 2)])
    i, j = TET_EDGES.T
    nodes = np.hstack([path, _middles(path[:, i], path[:, j], cells)])
    place = np.concatenate([place, (place[i] + place[j]) // 2])
    prisms = 2 * np.arange((layers - 1) // 2)
    return np.asarray((nodes * layers + place + prisms[:, None, None]).reshape(-1, 10))


def _middles(first: Ints, second: Ints, cells: Ints) -> Ints:
    """Mid-edge nodes between corners of ten-node cells; of a corner and itself, it."""
    edges, edges_of_cell = unique_edges(cells)
    middles = np.empty(len(edges), dtype=cells.dtype)
    middles[edges_of_cell] = cells[:, 4:]
    wanted = np.stack([first, second], axis=-1).reshape(-1, 2)
    found = middles[find_rows(wanted, edges)].reshape(first.shape)
    return np.asarray(np.where(first == second, first, found))
