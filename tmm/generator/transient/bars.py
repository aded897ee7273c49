"""Error bars of a run in time, by the observed order of three passes over the same steps.

The passes take the chosen steps in pairs, as they are, and in halves.  The error of the last goes
as hᵖ, so with a ratio r = 2⁻ᵖ of its distance from the second to the second's from the first it
is r / (1 − r) times the former (Richardson; as in P. J. Roache's grid convergence index).  The rule
is of order two where the motion is smooth, r = 1/4, and about one at impacts.  A ratio below 1/4 is
chance, so then 1/4 of the larger distance stands for the smaller; above 2/3 nothing converges and
twice the smaller distance stands.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints

#: Least and largest ratio of the distances that is believed.
_LEAST, _MOST = 0.25, 2.0 / 3.0
#: Safety factor.  The grid convergence index takes 1.25 where the order is observed; with that 8 of
#: 200 outputs of random runs with contact lay outside, all but two of them by less than a fifth.
_SAFETY = 1.5

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


def error_bar(larger: Floats, smaller: Floats) -> Floats:
    """Return the error bar (k,) of the finest of three passes, up to each time.

    Parameters
    ----------
    larger, smaller : (k,) float
        Largest distance until then of the first pass from the second, of the second from the last.
    """
    within = np.clip(smaller, _LEAST * larger, _MOST * larger)
    whole = np.where(larger > 0.0, larger, 1.0)
    ratio = np.where(larger > 0.0, within / whole, _MOST)
    return np.asarray(_SAFETY * np.maximum(smaller, _LEAST * larger) * ratio / (1.0 - ratio))


def spread(values: Floats, ends: Bools) -> Floats:
    """Return values at some of the times, those of `ends` (k,), at all: that of the next end."""
    after: Ints = np.cumsum(ends) - ends
    return np.asarray(values[after])
