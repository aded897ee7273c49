"""A matrix function of frequency that is asked thousands of times: exact, then from polynomials.

Orbits ask for a few dozen frequencies at a time, close to the last ones, and most of what such a
small question costs does not depend on how many they are.  So after a while the range is divided
into intervals on each of which every entry is a polynomial through its Chebyshev points, halved
until it meets the function between them to rounding.  Where that needs intervals too short, at the
poles of a lossless system or at a kink, the function itself is asked.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats
from tactgen.geometry.errors import InputError

#: From frequencies (n,) to entries (n, e).
Function: TypeAlias = Callable[[Floats], Complex]

#: Degree, and the places between the Chebyshev points at which a polynomial is held against the
#: function, in units of half an interval.
_DEGREE = 20
_CHECKED = np.cos(np.pi * (np.array([0.5, 5.5, 10.5, 14.5, 19.5])) / _DEGREE)
#: Error of an entry over its largest value on the interval: what the function's rounding leaves.
_TOLERANCE = 1e-12
#: Shortest interval over the frequency at its upper end, and that over the table's.
_SHORTEST = 1e-4
#: Intervals in work at once, beyond which what is left is not smooth: rounding above the tolerance
#: would have all of it divided down to the shortest.
_MOST = 2000
#: Frequencies that are asked of the function itself before a table is worth its making, and how
#: many are read at once.
_FIRST, _AT_ONCE = 3000, 1000
#: The table reaches beyond what is asked by this factor.
_BEYOND = 1.3

_ALL = slice(None)
_NODES = np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
_WEIGHTS = np.where(np.arange(_DEGREE + 1) % 2, -1.0, 1.0)
_WEIGHTS[[0, -1]] *= 0.5


class Tabulated:
    """The function, from its table where that has been made.

    Called with frequencies (n,) in Hz, 0 or above, returns entries (n, e), or some of them.
    """

    def __init__(self, function: Function) -> None:
        self._function = function
        self._asked = 0
        self._ends = np.zeros(1)  # of the intervals, ascending
        self._values = np.zeros((0, _DEGREE + 1, 0), dtype=complex)
        self._smooth: Bools = np.zeros(0, dtype=bool)

    def __call__(self, frequencies: Floats, entries: slice = _ALL) -> Complex:
        """Return the entries."""
        if self._asked < _FIRST:
            self._asked += frequencies.size
            return self._function(frequencies)[:, entries]
        top = float(frequencies.max(initial=0.0))
        if top > self._ends[-1]:
            try:
                self._extend(_BEYOND * top)
            except InputError:  # it ends between here and there, or even before
                return self._function(frequencies)[:, entries]
        parts = range(0, frequencies.size, _AT_ONCE)
        found = [self._read(frequencies[i : i + _AT_ONCE], entries) for i in parts]
        return found[0] if len(found) == 1 else np.concatenate(found)

    def _read(self, frequencies: Floats, entries: slice) -> Complex:
        at = np.maximum(np.searchsorted(self._ends, frequencies) - 1, 0)
        low, high = self._ends[at], self._ends[at + 1]
        values = self._values[..., entries]
        found = _interpolated(values[at], (2.0 * frequencies - low - high) / (high - low))
        rough = ~self._smooth[at]
        if rough.any():
            found[rough] = self._function(frequencies[rough])[:, entries]
        return found

    def _extend(self, top: float) -> None:
        """Divide what lies between the table's end and a frequency."""
        pending = np.array([[self._ends[-1], top]])
        done: list[tuple[float, Complex, bool]] = []
        while pending.size:
            low, high = pending[:, :1], pending[:, 1:]
            places = np.concatenate([_NODES, _CHECKED])
            asked = 0.5 * (low + high) + 0.5 * (high - low) * places
            # the ends exactly, so that rounding leads to no frequency below 0
            asked[:, 0], asked[:, _DEGREE] = pending[:, 1], pending[:, 0]
            values = self._function(asked.ravel()).reshape(*asked.shape, -1)
            nodes, known = values[:, : _DEGREE + 1], values[:, _DEGREE + 1 :]
            size = np.abs(nodes).max(axis=1, keepdims=True)
            each = np.repeat(nodes, _CHECKED.size, axis=0)
            met = _interpolated(each, np.tile(_CHECKED, len(nodes))).reshape(known.shape)
            smooth = (np.abs(met - known) <= _TOLERANCE * size).all(axis=(1, 2))
            short = high - low < _SHORTEST * np.maximum(high, _SHORTEST * top)
            ended = smooth | short[:, 0] | (len(pending) > _MOST)
            done += [
                (float(pending[i, 1]), nodes[i], bool(smooth[i])) for i in np.flatnonzero(ended)
            ]
            left = pending[~ended]
            middle = left.mean(axis=1)
            pending = np.concatenate(
                [np.stack([left[:, 0], middle], 1), np.stack([middle, left[:, 1]], 1)]
            )
        done.sort(key=lambda interval: interval[0])
        made = np.stack([values for _, values, _ in done])
        self._values = np.concatenate([self._values, made]) if self._smooth.size else made
        self._ends = np.append(self._ends, [end for end, _, _ in done])
        self._smooth = np.append(self._smooth, [smooth for _, _, smooth in done])


def _interpolated(values: Complex, places: Floats) -> Complex:
    """Return polynomials (n, e) through values (n, degree + 1, e) at places (n,) from −1 to 1.

    By the barycentric formula (Berrut and Trefethen, SIAM Review 46 (2004) 501).
    """
    apart = places[:, None] - _NODES
    hit = apart == 0.0
    factor = _WEIGHTS / np.where(hit, 1.0, apart)
    on_node = hit.any(axis=1)
    factor[on_node] = hit[on_node]
    found = np.matmul(factor[:, None, :], values)[:, 0]
    return np.asarray(found / factor.sum(axis=1)[:, None])
