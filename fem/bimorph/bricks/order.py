"""In which order the unknowns of bricks are best eliminated.

A bimorph is a chain along z, so nested dissection needs no search: halve the chain at a
plane between bricks, halve the halves, and eliminate each plane after what it separates.
Within one interval of the chain what is inside a brick goes first, then faces, then edges.
A general ordering finds no less fill, and takes longer than the factorisation itself.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Ints
from tactgen.geometry.bimorph.bricks import Bricks


def elimination_order(bricks: Bricks) -> Ints:
    """Return the place (n,) of each of the grid's nodes, z fastest, in the order of elimination."""
    shape = bricks.shape
    x, y, z = np.unravel_index(np.arange(int(np.prod(shape))), shape)
    along_x, along_y, along_z = bricks.degree
    on_plane, count = z % along_z == 0, bricks.z.intervals
    # both end planes separate nothing: they go with the interval that they end
    ends = on_plane & ((z == 0) | (z == shape[2] - 1))
    interval = np.minimum(z // along_z, count - 1)
    intervals, planes = _dissected(count)
    group = np.where(on_plane & ~ends, planes[interval], intervals[interval])
    shared = (x % along_x == 0).astype(int) + (y % along_y == 0) + 3 * ends
    brick = (x // along_x) * bricks.y.intervals + y // along_y
    order = np.lexsort((brick, shared, group))
    place = np.empty(order.size, dtype=np.int64)
    place[order] = np.arange(order.size)
    return place


def _dissected(count: int) -> tuple[Ints, Ints]:
    """Return when each of `count` intervals, and the plane below each, is eliminated."""
    intervals, planes = np.zeros((2, count), dtype=np.int64)
    step = 0
    # stretches still to be eliminated, the last first; an empty one stands for its plane
    left = [(0, count)]
    while left:
        low, high = left.pop()
        if high - low > 1:
            middle = (low + high) // 2
            left += [(middle, middle), (middle, high), (low, middle)]
            continue
        (planes if low == high else intervals)[low] = step
        step += 1
    return intervals, planes
