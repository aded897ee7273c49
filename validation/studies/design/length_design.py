"""The length of the lateral actuator for a stated aim (paper section 4), and what it rests on.

The paper wants the deflection "as close to the threshold as possible or above it" over the
band, from "an actuator that is as compact as possible".  With the lowest ratio of deflection
to detection threshold over the band,

    m(l) = min_f |w(f, l)| / threshold(f),

the aims are the shortest l with m(l) >= margin, and the l of largest m.  m is neither smooth
nor monotone: the frequency that decides changes, and dips of |w| pass through the band.  So
it is scanned (:mod:`validation.studies.design.length_scan`), and every crossing and the highest
peak are then refined.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.beam.parametric import Actuator
from tactgen.validation.engine.drive_warnings import SLENDER
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.design.aim import Aim
from tactgen.validation.studies.design.length_map import actuator
from tactgen.validation.studies.design.length_scan import lowest_margin, scan

#: What decides the length: the margin is just reached, the margin is largest, an end of the
#: range, or no length reaches the margin and the largest one is given instead.
Limit = Literal["threshold", "peak", "end", "compromise"]

#: Relative accuracy to which crossings are refined, and peaks, which rounding flattens.
_ACCURACY, _PEAK_ACCURACY = 1e-9, 1e-7


@dataclass(frozen=True)
class Interval:
    """Lengths (m) that keep the margin, and the frequency (Hz) that decides at each end.

    A frequency is None where the range of lengths ends, not the margin.
    """

    shortest: float
    longest: float
    at_shortest: float | None
    at_longest: float | None


@dataclass(frozen=True)
class Design:
    """A length for an aim.

    Attributes
    ----------
    length, margin, frequency : float
        The length (m), its m(l), and the frequency that decides it (Hz).
    limit : {"threshold", "peak", "end", "compromise"}
        What decides the length.
    intervals : tuple of Interval
        All lengths that keep the margin asked for.
    lengths, margins : (n,) arrays
        The scan of m(l).
    present : (float, float)
        m and the deciding frequency of the scene's own length.
    warnings : tuple of str
        Reasons to doubt the model there.
    """

    scene: Scene
    aim: Aim
    length: float
    margin: float
    frequency: float
    limit: Limit
    intervals: tuple[Interval, ...]
    lengths: Floats
    margins: Floats
    present: tuple[float, float]
    warnings: tuple[str, ...]

    @property
    def crossings(self) -> tuple[tuple[float, float], ...]:
        """Lengths (m) at which the margin is just reached, each with its frequency (Hz)."""
        ends = [
            end
            for i in self.intervals
            for end in ((i.shortest, i.at_shortest), (i.longest, i.at_longest))
        ]
        return tuple((length, at) for length, at in ends if at is not None)


def design(scene: Scene, aim: Aim) -> Design:
    """Find the length for an aim.

    Raises
    ------
    InputError
        If the tip does not move, or if the lengths cannot be had; see
        :func:`validation.studies.design.length_scan.scan`.
    """
    device = actuator(scene)
    grid, margins = scan(device, aim, scene.bimorph.length)
    intervals = _feasible(device, aim, grid, margins)
    limit: Limit
    if aim.kind == "shortest" and intervals:
        length = intervals[0].shortest
        limit = "end" if intervals[0].at_shortest is None else "threshold"
    else:
        best = int(np.argmax(margins))
        around = grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)]
        length = largest_margin(device, aim, around)
        limit = "end" if length in aim.lengths else "peak"
        if not intervals:
            limit = "compromise"
    reached, frequency = lowest_margin(device, aim, np.array([length]))
    own, own_at = lowest_margin(device, aim, np.array([scene.bimorph.length]))
    return Design(
        scene=scene,
        aim=aim,
        length=length,
        margin=float(reached[0]),
        frequency=float(frequency[0]),
        limit=limit,
        intervals=intervals,
        lengths=grid,
        margins=margins,
        present=(float(own[0]), float(own_at[0])),
        warnings=_doubts(scene, length),
    )


def largest_margin(device: Actuator, aim: Aim, around: tuple[float, float]) -> float:
    """Return the length (m) of largest m between two lengths that enclose one peak."""
    from scipy.optimize import minimize_scalar

    low, high = around
    found = minimize_scalar(
        lambda l: -_excess(device, aim, l),
        bounds=around,
        method="bounded",
        options={"xatol": _PEAK_ACCURACY * high},
    )
    # the bounded search never tries the ends themselves
    return float(max(low, high, found.x, key=lambda l: _excess(device, aim, l)))


def _feasible(device: Actuator, aim: Aim, grid: Floats, margins: Floats) -> tuple[Interval, ...]:
    from scipy.optimize import brentq

    def crossing(left: int) -> float:
        return float(
            brentq(
                lambda l: _excess(device, aim, l),
                grid[left],
                grid[left + 1],
                xtol=_ACCURACY * grid[left],
            )
        )

    enough = margins >= aim.margin
    edges = np.flatnonzero(enough[1:] != enough[:-1])
    ends = [crossing(int(left)) for left in edges]
    decisive = lowest_margin(device, aim, np.array(ends))[1] if ends else np.zeros(0)
    marks: list[tuple[float, float | None]] = [
        (l, float(f)) for l, f in zip(ends, decisive, strict=True)
    ]
    if enough[0]:
        marks.insert(0, (float(grid[0]), None))
    if enough[-1]:
        marks.append((float(grid[-1]), None))
    return tuple(
        Interval(low, high, f_low, f_high)
        for (low, f_low), (high, f_high) in zip(marks[::2], marks[1::2], strict=True)
    )


def _excess(device: Actuator, aim: Aim, length: float) -> float:
    """Return ln(m / margin) of one length; the smallest number stands for no motion at all."""
    margin = float(lowest_margin(device, aim, np.array([length]))[0][0])
    return math.log(max(margin, sys.float_info.min)) - math.log(aim.margin)


def _doubts(scene: Scene, length: float) -> tuple[str, ...]:
    slenderness = length / scene.bimorph.thickness
    if slenderness >= SLENDER:
        return ()
    doubt = (
        f"at {1e3 * length:.4g} mm the actuator is {slenderness:.2g} times as long as thick, too "
        "stubby for a beam model to be trusted; compare with --set models=solid"
    )
    return (doubt,)
