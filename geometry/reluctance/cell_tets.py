"""One cell of an endless square array of normal actuators: an eighth of it, in tetrahedra.

The swept sector of 45 degrees, whose lines beyond the sleeve are stretched from circles into the
cell's square wall, half a pitch from the axis.  By symmetry the flux crosses neither half plane;
what the wall stands for depends on the neighbours' currents.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.swept_tets import swept_tetrahedra
from tactgen.geometry.reluctance.section_grid import (
    OUTER_RADIUS,
    Grid,
    graded_grid,
    graded_lines,
)
from tactgen.geometry.reluctance.section_regions import actuator_regions
from tactgen.geometry.reluctance.sector_tets import cell_labels, without_slivers
from tactgen.geometry.reluctance.tets import REGIONS

#: Eighths of a square.
COPIES = 8
#: Power by which the layers lie denser towards the middle of a wall, where the next unit is near.
_DENSER = 1.5


@dataclass(frozen=True)
class Cell:
    """How a cell is divided.

    Attributes
    ----------
    refinement : float
        Fineness of the half section, see :func:`geometry.reluctance.section_grid.graded_grid`.
    layers : int
        Layers of cells over the 45 degrees, thinner where the neighbour is near.
    """

    refinement: float = 0.7
    layers: int = 4


def cell_mesh(device: Device, gap: float, pitch: float, cell: Cell) -> Mesh:
    """Return an eighth of the cell, with `REGIONS`; its square wall is the face ``mantle``.

    Raises
    ------
    InputError
        If the parts do not fit at this gap (m), or not into the pitch (m).
    """
    parts = actuator_regions(device, gap)
    outer = max(part.radii[1] for part in parts)
    wall = 0.5 * pitch
    if wall <= outer:
        raise InputError(
            f"display.pitch = {1e3 * pitch:g} mm is no more than an actuator's diameter of "
            f"{2e3 * outer:g} mm; set display.pitch to more than that"
        )
    graded = graded_grid(parts, max(OUTER_RADIUS, 2.0 * pitch), refinement=cell.refinement)
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
    """Return points whose circles beyond `outer` go over into the square's side x = `wall`."""
    x, radius = points[:, 0], np.hypot(points[:, 0], points[:, 1])
    beyond = radius > outer
    moved = points.copy()
    share = (radius[beyond] - outer) / (wall - outer)
    # at the wall r goes over into wall / cos(angle)
    longer = 1.0 + share * wall * (1.0 / x[beyond] - 1.0 / radius[beyond])
    moved[beyond, :2] *= longer[:, None]
    return moved
