"""Points that several parts of a surface or a mesh have in common, made one."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats, Ints


def merge_points(points: Floats, within: float) -> tuple[Floats, Ints]:
    """Return the points that differ, and which of them each of the given ones is.

    Parameters
    ----------
    points : (n, 3) float
        In any unit of length.
    within : float
        Distance up to which points are the same, far below that of any others.
    """
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(within, output_type="ndarray")
    # the pairs are complete within each cluster, so the lowest index names the cluster
    lowest = np.arange(len(points))
    np.minimum.at(lowest, pairs.max(axis=1), pairs.min(axis=1))
    kept, index = np.unique(lowest, return_inverse=True)
    return points[kept], index
