"""Where a mesh should be fine: from errors of its elements to the edge lengths of the next one.

Plain geometry: what the errors are errors of is not known here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.quadratic import TET_EDGES, unique_edges

#: Order in which an element's share of the error per volume falls with its size.  Smooth
#: solutions would give quadratic elements 4; most of the error sits at edges where the
#: solution is singular, and gives 1 to 2 while they are being resolved.
_ORDER = 1.5

#: One step makes elements at most this much smaller or larger: an estimate on a coarse mesh
#: is not to be trusted further.
_FINER, _COARSER = 0.3, 1.2

#: Growth of the edge length per distance (m/m); steeper, and the mesher's own quality
#: measure decides the size.
_GROWTH = 0.4

#: Lengths are rounded to steps of this ratio, so that the rounding of a solution they were
#: found from does not make another mesh.
_STEP = 1.02


@dataclass(frozen=True)
class Sizing:
    """Target edge lengths at points.

    Attributes
    ----------
    points : (n, 3) array
        Where (m).
    lengths : (n,) array
        Edge length (m); between the points it is interpolated.
    """

    points: Floats
    lengths: Floats


def sizing_for(
    mesh: Mesh, errors: Floats, wanted: float, *, shortest: float, most: float
) -> Sizing:
    """Return the edge lengths that bring the sum of the elements' errors down to `wanted`.

    With fewest elements each has the same error µ.  Since an element's share of the error
    falls with its volume and size, as h³⁺ᵠ, an element of error η becomes (η/µ)^(3/(3+q))
    elements of size h (µ/η)^(1/(3+q)); that their errors µ add up to `wanted` gives µ.

    Parameters
    ----------
    mesh : Mesh
        Tetrahedra.
    errors : (n_cells,) array
        Each element's share of the error, not negative.
    wanted : float
        Sum of the shares on the next mesh.
    shortest : float
        Shortest edge (m).
    most : float
        Number of elements that the next mesh shall not exceed by much: if `wanted` needs
        more, its error is larger.
    """
    tets = mesh.cells[:, :4]
    errors = np.maximum(errors, 1e-12 * errors.max())
    power = _ORDER + 3.0
    sum_of_roots = (errors ** (3.0 / power)).sum()
    each = max((wanted / sum_of_roots) ** (power / _ORDER), (sum_of_roots / most) ** (power / 3.0))
    factor = np.clip((each / errors) ** (1.0 / power), _FINER, _COARSER)
    ends = mesh.points[tets[:, TET_EDGES]]
    mean_edge = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).mean(axis=1)
    logs = np.repeat(np.log(factor * mean_edge), 4)
    used, corner = np.unique(tets, return_inverse=True)
    corner = corner.ravel()
    lengths = np.exp(np.bincount(corner, logs) / np.bincount(corner))
    points = mesh.points[used]
    edges, _ = unique_edges(corner.reshape(-1, 4))
    lengths = limited_growth(points, edges, np.maximum(lengths, shortest), _GROWTH)
    rounded = _STEP ** np.round(np.log(lengths) / np.log(_STEP))
    return Sizing(points, rounded)


def limited_growth(points: Floats, edges: Ints, lengths: Floats, growth: float) -> Floats:
    """Return lengths lowered until none differs along an edge by more than growth x distance.

    Parameters
    ----------
    points : (n, 3) array
        Coordinates (m).
    edges : (n_edges, 2) int array
        Pairs of points.
    lengths : (n,) array
        Target edge lengths (m).
    growth : float
        Largest change per distance (m/m).
    """
    lengths = lengths.copy()
    a, b = edges.T
    rise = growth * np.linalg.norm(points[a] - points[b], axis=1)
    while True:
        before = lengths.copy()
        np.minimum.at(lengths, a, before[b] + rise)
        np.minimum.at(lengths, b, before[a] + rise)
        if (lengths >= before * (1.0 - 1e-12)).all():
            return lengths


#: Points of the table that stands for the map between two stops: it is then its own exact
#: inverse, whatever the map.
_POINTS = 401


@dataclass(frozen=True)
class Stretching:
    """Squeezes z between two stops, less and less towards each of them.

    Attributes
    ----------
    low, high : float
        The stops (mm): below and above, and right at them, nothing is squeezed.
    most : float
        Largest length of an element over its width; 1 squeezes nothing.
    growth : float
        How much longer an element may be per distance from a stop (1/mm).
    """

    low: float
    high: float
    most: float
    growth: float

    def squeezed(self, points: Floats) -> Floats:
        """Return points (n, 3) in mm as the mesher gets to see them."""
        z, image = self._table()
        return _with_z(points, _mapped(points[:, 2], z, image))

    def restored(self, points: Floats) -> Floats:
        """Return squeezed points (n, 3) in mm put back."""
        z, image = self._table()
        return _with_z(points, _mapped(points[:, 2], image, z))

    def _table(self) -> tuple[Floats, Floats]:
        z = np.linspace(self.low, self.high, _POINTS)
        middle = 0.5 * (z[1:] + z[:-1])
        away = np.minimum(middle - self.low, self.high - middle)
        length = np.minimum(self.most, 1.0 + self.growth * away)
        steps = np.diff(z) / length
        return z, self.low + np.concatenate([[0.0], np.cumsum(steps)])


#: Leaves everything as it is.
UNSTRETCHED = Stretching(low=0.0, high=1.0, most=1.0, growth=0.0)


def _mapped(values: Floats, source: Floats, image: Floats) -> Floats:
    """Interpolate between the tables; beyond them, move along with their ends."""
    inside = np.interp(values, source, image)
    beyond = np.where(values > source[-1], values - source[-1], np.minimum(values - source[0], 0.0))
    return np.asarray(inside + beyond)


def _with_z(points: Floats, z: Floats) -> Floats:
    return np.column_stack([points[:, :2], z])
