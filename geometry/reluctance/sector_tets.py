"""A sector of the normal actuator, turned: the structured mesh of its magnetic field in 3D.

The grid of the half section, swept.  Without the slot for the shim's tab every sector is
a mirror image of the next, so its half planes are walls that the flux does not cross.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.swept_tets import swept_tetrahedra
from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS, Grid, Region, graded_grid
from tactgen.geometry.reluctance.section_regions import actuator_regions
from tactgen.geometry.reluctance.tets import REGIONS

#: Lines closer than this (m) are one: cells between them would be slivers.
_APART = 1e-9


@dataclass(frozen=True)
class Sector:
    """How the actuator is cut and divided.

    Attributes
    ----------
    refinement : float
        Fineness of the half section, see :func:`geometry.reluctance.section_grid.graded_grid`.
    copies : int
        Sectors in a turn.
    layers : int
        Layers of cells from one half plane to the other.
    """

    refinement: float = 1.4
    copies: int = 16
    layers: int = 1


def sector_mesh(device: Device, gap: float, sector: Sector) -> Mesh:
    """Return the mesh of a sector, with `REGIONS`; z = 0 is the sleeve's top face.

    Raises
    ------
    InputError
        If the parts do not fit at this gap.
    """
    parts = actuator_regions(device, gap)
    graded = graded_grid(parts, OUTER_RADIUS, refinement=sector.refinement)
    grid = replace(graded, z=without_slivers(graded.z))
    angles = np.linspace(0.0, 2.0 * np.pi / sector.copies, sector.layers + 1)
    return swept_tetrahedra(grid.r, grid.z, angles, cell_labels(grid, gap), REGIONS)


def region_name(part: Region) -> str:
    """Return the region of `REGIONS` that a part of the half section belongs to."""
    if part.turns:
        return "coil"
    return "rod" if part.moves else "sleeve"


def without_slivers(lines: Floats) -> Floats:
    """Return lines of which those that are nearly one are one."""
    apart = np.append(True, np.diff(lines) > _APART)
    return np.asarray(lines[apart])


def cell_labels(grid: Grid, gap: float) -> Ints:
    """Return the index into `REGIONS` of each cell of the half section."""
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
        labels[grid.labels == index] = REGIONS.index(region_name(part))
    return labels
