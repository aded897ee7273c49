"""The error bar of the finest of three answers, each by half the step of the one before.

The error goes as hᵖ, so with a ratio r = 2⁻ᵖ of the distance of the last two answers to that of the
first two it is r / (1 − r) times the former (Richardson; as in P. J. Roache's grid convergence
index).  What uses it here is of order two where all is smooth, r = 1/4.  A ratio below 1/4 is
chance, so then 1/4 of the larger distance stands for the smaller; above 2/3 nothing converges and
twice the smaller distance stands.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats

#: Least and largest ratio of the distances that is believed.
_LEAST, _MOST = 0.25, 2.0 / 3.0


def error_bar(larger: Floats, smaller: Floats, safety: float) -> Floats:
    """Return the error bar (k,) of the finest answers.

    Parameters
    ----------
    larger, smaller : (k,) float
        Distance of the first answers from the second, of the second from the last; 0 or more.
    safety : float
        Factor on the error; the grid convergence index takes 1.25 where the order is observed.
    """
    within = np.clip(smaller, _LEAST * larger, _MOST * larger)
    whole = np.where(larger > 0.0, larger, 1.0)
    ratio = np.where(larger > 0.0, within / whole, _MOST)
    return np.asarray(safety * np.maximum(smaller, _LEAST * larger) * ratio / (1.0 - ratio))
