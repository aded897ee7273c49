"""Fields of the solid on ten-node tetrahedra: gradients at the nodes, averaged layer by layer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from tactgen.geometry.arrays import Floats, Ints, Numbers
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.mirror import whole_mesh
from tactgen.geometry.meshing.quadratic import TET_EDGES

#: Barycentric coordinates of the ten nodes.
_NODES = np.vstack([np.eye(4), 0.5 * (np.eye(4)[TET_EDGES[:, 0]] + np.eye(4)[TET_EDGES[:, 1]])])


@dataclass(frozen=True)
class TetSampler:
    """Points of the whole, each region with its own, and how fields come to them.

    Attributes
    ----------
    solved : Mesh
        The mesh of the solution, ``tetra`` or ``tetra10``, whole or a quarter.
    nodes : (n_nodes, 3) array
        The system's nodes (m).
    """

    solved: Mesh
    nodes: Floats

    @cached_property
    def _quadratic(self) -> tuple[Floats, Ints, Ints]:
        """Points, cells (m, 10) with points of their region, and the node of every point."""
        whole = whole_mesh(self.solved)
        corners = whole.points[whole.cells]
        if whole.kind == "tetra":
            middles = 0.5 * (corners[:, TET_EDGES[:, 0]] + corners[:, TET_EDGES[:, 1]])
            corners = np.concatenate([corners, middles], axis=1)
        node = cKDTree(self.nodes).query(corners.reshape(-1, 3))[1]
        keys = np.repeat(whole.region_of_cell, corners.shape[1]) * len(self.nodes) + node
        different, cells = np.unique(keys, return_inverse=True)
        of_node = different % len(self.nodes)
        return self.nodes[of_node], cells.reshape(-1, corners.shape[1]), of_node

    @cached_property
    def mesh(self) -> Mesh:
        """The points in m and their ten-node cells."""
        points, cells, _ = self._quadratic
        whole = whole_mesh(self.solved)
        return Mesh(points, cells, "tetra10", whole.region_of_cell, whole.regions, {})

    def sample(self, values: Numbers) -> tuple[Numbers, Numbers]:
        """Return values (n, k) and gradients (n, k, 3) at the points; see BrickSampler.sample."""
        points, cells, of_node = self._quadratic
        shown = values[of_node]
        gradients = np.zeros((len(points), values.shape[1], 3), dtype=values.dtype)
        corners = points[cells]
        local = shown[cells]
        for k, slopes in enumerate(_shape_slopes()):
            jacobian = np.einsum("cni,nj->cij", corners, slopes)
            slope = np.einsum("cnv,nj->cvj", local, slopes) @ np.linalg.inv(jacobian)
            np.add.at(gradients, cells[:, k], slope)
        shares = np.bincount(cells.ravel(), minlength=len(points))
        return shown, gradients / shares[:, None, None]


def _shape_slopes() -> Floats:
    """Return (10, 10, 3): at each node, the slopes of the ten functions by ξ, η, ζ."""
    by = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    corners = (4.0 * _NODES - 1.0)[:, :, None] * by
    i, j = TET_EDGES.T
    middles = 4.0 * (_NODES[:, i, None] * by[j] + _NODES[:, j, None] * by[i])
    return np.concatenate([corners, middles], axis=1)
