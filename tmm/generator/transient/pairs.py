"""The steps of a run in pairs: the coarser pass by which the order of its error is observed."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints

#: Steps between two breaks: a time inside the piece, the start, each step's end and length (s).
#: Equal lengths are equal to the last digit, so that they share their matrices.
Piece = tuple[float, float, list[tuple[float, float]]]


def paired(pieces: list[Piece]) -> tuple[list[Piece], Bools]:
    """Return the same pieces with neighbours of equal length as one step.

    Also which of the times at which the given steps start or end are kept, (k,).
    """
    found, kept = [], []
    for inside, start, ends in pieces:
        longer: list[tuple[float, float]] = []
        kept.append(True)
        at = 0
        while at < len(ends):
            whole = at + 1 < len(ends) and ends[at][1] == ends[at + 1][1]
            end, h = ends[at + whole]
            longer.append((end, 2.0 * h if whole else h))
            kept += [False, True] if whole else [True]
            at += 1 + whole
        found.append((inside, start, longer))
    return found, np.array(kept)


def spread(values: Floats, ends: Bools) -> Floats:
    """Return values at some of the times, those of `ends` (k,), at all: that of the next end."""
    after: Ints = np.cumsum(ends) - ends
    return np.asarray(values[after])
