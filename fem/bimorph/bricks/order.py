"""In which order the unknowns of bricks are best eliminated.

A bimorph is a chain along z, so no search is needed: both ends are eaten towards the middle, and
each plane between bricks goes after what it separates, when it has one neighbour left, not two as
in a nested dissection of the chain.  Within one interval of the chain what lies on no line of the
cross-section goes first, then the lines column by column, across the shorter way.  A general
ordering finds no less fill, and takes longer than the factorisation itself.
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
    count = bricks.z.intervals
    # both end planes separate nothing: they go with the interval that they end
    separates = (z % along_z == 0) & (z > 0) & (z < shape[2] - 1)
    interval = np.minimum(z // along_z, count - 1)
    intervals, planes = _turns(count)
    turn = np.where(separates, planes[interval], intervals[interval])
    upper = 2 * interval >= count
    # of a cross-section's lines and what lies between two, one after the other
    column, row = _lines(y, along_y), _lines(x, along_x)
    brick = (x // along_x) * bricks.y.intervals + y // along_y
    inside = (x % along_x > 0) & (y % along_y > 0)
    order = np.lexsort((brick, row * ~inside, column * ~inside, ~inside, upper, turn))
    place = np.empty(order.size, dtype=np.int64)
    place[order] = np.arange(order.size)
    return place


def _turns(count: int) -> tuple[Ints, Ints]:
    """Return when each of `count` intervals, and the plane below each, is eliminated."""
    number = np.arange(count)
    intervals = 2 * np.minimum(number, count - 1 - number)
    planes = np.zeros(count, dtype=np.int64)
    planes[1:] = np.maximum(intervals[1:], intervals[:-1]) + 1
    return intervals, planes


def _lines(number: Ints, degree: int) -> Ints:
    """Return even numbers of a section's lines, and odd ones of what lies between two."""
    return 2 * (number // degree) + (number % degree > 0)
