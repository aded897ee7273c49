"""Structured, graded hexahedral mesh of the bimorph alone: the accuracy reference.

Layers, shim tab and electrodes are resolved exactly; elements shrink geometrically
towards the places where the solution is singular (the clamp, the ceramic's ends).
The generator with its rod is not boxes and is meshed by :mod:`geometry.tetmesh`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Bools, Floats, Ints
from geometry.fit import check_plain_layers
from geometry.mesh import Mesh
from geometry.parameters import Device

#: Element length at the free tip in piezo layer thicknesses: its singularity is weak.
_TIP = 0.3


#: Ratio of neighbouring intervals towards layer faces and side edges, where the
#: stiffness jumps meet a free surface.
_EDGE_RATIO = 2.5
#: Largest interval there relative to the smallest: without a limit, more intervals would
#: only crowd the edges and never refine the middle.
_EDGE_SPREAD = 4.0


@dataclass(frozen=True)
class HexMeshing:
    """How finely the bimorph is divided.

    Attributes
    ----------
    piezo_layers, shim_layers, across : int
        Elements through each piezo layer, through the shim, across the width.
    largest : float
        Longest element along z, in bimorph thicknesses.
    smallest : float
        Length of the element at the clamp, as a fraction of a piezo layer's thickness.
    growth : float
        Ratio of neighbouring element lengths along z.
    """

    piezo_layers: int
    shim_layers: int
    across: int
    largest: float
    smallest: float = 0.05
    growth: float = 2.0


#: A family of meshes for refinement studies, each about 1.3 times finer than the last
#: (9, 25, 43, 86 and 166 thousand unknowns for the paper's bimorph).
LEVELS = (
    HexMeshing(piezo_layers=2, shim_layers=1, across=4, largest=1.6),
    HexMeshing(piezo_layers=3, shim_layers=2, across=6, largest=1.2),
    HexMeshing(piezo_layers=4, shim_layers=2, across=7, largest=0.9),
    HexMeshing(piezo_layers=5, shim_layers=3, across=9, largest=0.7),
    HexMeshing(piezo_layers=6, shim_layers=4, across=11, largest=0.5),
)


def hexahedral(device: Device, meshing: HexMeshing) -> Mesh:
    """Mesh the bimorph, z = 0 at the lower end of the tab (of the ceramic without one)."""
    check_plain_layers(device)
    bimorph = device.bimorph
    half, hp = 0.5 * bimorph.shim_thickness, bimorph.piezo_thickness
    layer = _towards_both_ends(hp, meshing.piezo_layers)
    x = np.concatenate(
        [
            -half - hp + layer[:-1],
            -half + np.linspace(0.0, 2.0 * half, meshing.shim_layers + 1)[:-1],
            half + layer,
        ]
    )
    longest = meshing.largest * bimorph.thickness
    # a bimorph many thicknesses wide needs more intervals across than the family's own
    across = max(meshing.across, 2 + math.ceil(bimorph.width / (1.5 * longest)))
    y = -0.5 * bimorph.width + _towards_both_ends(bimorph.width, across)
    tab, length = bimorph.tab_length, bimorph.length
    first, last = meshing.smallest * hp, max(meshing.smallest, _TIP) * hp
    z = tab + _graded(length, first, last, meshing.growth, longest)
    if tab > 0.0:
        z = np.concatenate([_graded(tab, first, first, meshing.growth, longest)[:-1], z])
    return _boxes(x, y, z, half, tab)


def _towards_both_ends(length: float, count: int) -> Floats:
    """Divide [0, length] with intervals shrinking geometrically towards both ends."""
    distance = np.minimum(np.arange(count), np.arange(count)[::-1])
    steps = np.minimum(_EDGE_RATIO ** distance.astype(float), _EDGE_SPREAD)
    return np.concatenate([[0.0], np.cumsum(steps)]) * float(length / steps.sum())


def _graded(length: float, first: float, last: float, growth: float, longest: float) -> Floats:
    """Divide [0, length], elements growing from `first` below and `last` above."""
    lower, upper = [first], [last]
    while sum(lower) + sum(upper) < length:
        side = lower if lower[-1] <= upper[-1] else upper
        side.append(min(side[-1] * growth, longest))
    steps = np.array(lower + upper[::-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) * float(length / steps.sum())


def _boxes(x: Floats, y: Floats, z: Floats, half: float, tab: float) -> Mesh:
    """Fill the grid with boxes, leaving out what lies beside the tab."""
    nx, ny, nz = (v.size for v in (x, y, z))
    index = np.arange(nx * ny * nz).reshape(nx, ny, nz)
    i, j, k = (
        g.ravel() for g in np.meshgrid(*(np.arange(n - 1) for n in (nx, ny, nz)), indexing="ij")
    )
    x_mid, z_mid = 0.5 * (x[i] + x[i + 1]), 0.5 * (z[k] + z[k + 1])
    region = np.where(x_mid > half, 0, np.where(x_mid < -half, 1, 2))
    keep = (region == 2) | (z_mid > tab)
    i, j, k, region = i[keep], j[keep], k[keep], region[keep]
    corners = (
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    )
    cells = np.stack([index[i + a, j + b, k + c] for a, b, c in corners], axis=1)
    grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    used, cells = np.unique(cells, return_inverse=True)
    points = grid[used]
    cells = cells.reshape(-1, 8)
    return Mesh(
        points=points,
        cells=cells,
        kind="hexahedron",
        region_of_cell=region.astype(np.int64),
        regions=("piezo_top", "piezo_bottom", "shim"),
        faces=_named_faces(cells, points, region, half, float(x[-1]), float(z[-1])),
    )


def _named_faces(
    cells: Ints, points: Floats, region: Ints, half: float, outer: float, tip: float
) -> dict[str, Ints]:
    """Return the quadrilaterals of each named face."""
    low_x, high_x = cells[:, [0, 3, 7, 4]], cells[:, [1, 2, 6, 5]]
    low_z, high_z = cells[:, [0, 1, 2, 3]], cells[:, [4, 5, 6, 7]]

    def on_plane(quads: Ints, axis: int, value: float) -> Bools:
        return np.asarray(np.all(np.isclose(points[quads, axis], value, atol=1e-12), axis=1))

    top, bottom = region == 0, region == 1
    return {
        "base": low_z[on_plane(low_z, 2, 0.0)],
        "tip": high_z[on_plane(high_z, 2, tip)],
        "electrode_top_inner": low_x[top & on_plane(low_x, 0, half)],
        "electrode_top_outer": high_x[top & on_plane(high_x, 0, outer)],
        "electrode_bottom_inner": high_x[bottom & on_plane(high_x, 0, -half)],
        "electrode_bottom_outer": low_x[bottom & on_plane(low_x, 0, -outer)],
    }
