"""The length of the lateral actuator that keeps its tip above the detection threshold.

The paper (section 4, Fig 9) wants the deflection "as close to the threshold as possible or above
it" over the band, from "an actuator that is as compact as possible".  With the lowest ratio of
deflection to detection threshold over the band,

    m(l) = min_f |w(f, l)| / threshold(f),

the aims are the shortest l with m(l) >= margin, and the l of largest m.  By the transfer-matrix
model, for any support, load and segmented beam that it can hold.

m is neither smooth nor monotone: the frequency that decides changes, and dips of |w| pass through
the band.  A longer actuator repeats the picture of a shorter one at a lower frequency: its minima
move as a power of the length (about length^-1.57 on the paper's support, length^-2 clamped).
So m is scanned in steps of a share of the length, extremes that only just keep or miss the margin
between two steps are added, and every crossing and the highest peak are refined.

Sensitivities: with m(l, p) the lowest margin over the band, at a length where the margin is just
reached ln m(l, p) = const, and the implicit function theorem gives

    d ln l / d ln p = −S_p / S_l,    S_x = ∂ ln m / ∂ ln x.

At the length of largest margin S_l changes sign, smoothly or, where the deciding frequency
jumps, with a step; from either side of it (±)

    d ln l / d ln p = −(S_p⁺ − S_p⁻) / (S_l⁺ − S_l⁻).

The S are those of |w| / threshold at the frequency that decides: at a minimum over frequency
its own shift is of second order.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.parametric import Actuator, parameter_keys
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.span import wavenumbers
from tactgen.tmm.ports.finger_and_pad import finger_spring_damper
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD, ThresholdCurve
from tactgen.validation.catalogue.quantities import STATIC_TIP_DISPLACEMENT
from tactgen.validation.engine.solve import solve
from tactgen.validation.engine.warnings import modelling_warnings
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import with_values
from tactgen.validation.studies.length_map import (
    actuator,
    band_points,
    check_lengths,
    check_moves,
    local_minima,
    tip_amplitude,
    tip_slopes,
)

AimKind = Literal["shortest", "margin"]
#: What decides the length: the margin is just reached, the margin is largest, an end of the
#: range, or no length reaches the margin and the largest one is given instead.
Limit = Literal["threshold", "peak", "end", "compromise"]

#: The paper's lengths (m), 20 mm (red) to 40 mm (blue line of Fig 9), and frequencies (Hz).
PAPER_LENGTHS, PAPER_BAND = (20e-3, 40e-3), (10.0, 1000.0)
#: Lengths of a table and a plot: from 20 to 40 mm in steps of 2.5 mm.
CURVES = 9
#: Largest step of the scan, as a share of the length: the paper's two gaps, 18.40 to 22.64 mm
#: and 68.19 to 74.53 mm, are 14 and 6 steps wide.
_STEP = 0.015
#: Half waves along the actuator at the band's end up to which its minima are separate: with
#: n of them the next minimum is 1/n further in ln l and 2/n in ln f, then 8 steps of length
#: and 6 of frequency away.
_HALF_WAVES = 8
#: Relative accuracies: of crossings, of peaks, which rounding flattens, and of an extreme of m
#: before the crossings beside it are refined.
_ACCURACY, _PEAK_ACCURACY, _LOCATED = 1e-9, 1e-7, 1e-4


def stated_band(threshold: ThresholdCurve) -> tuple[float, float]:
    """Paper's band as far as a threshold is stated; all of it if nowhere (Hz)."""
    low, high = max(PAPER_BAND[0], threshold.range[0]), min(PAPER_BAND[1], threshold.range[1])
    return (low, high) if low < high else threshold.range


@dataclass(frozen=True)
class Aim:
    """Aim of the length design."""

    #: The shortest length that keeps the margin, or the length of the largest margin
    kind: AimKind = "shortest"
    margin: float = 1.0  #: Deflection over detection threshold to keep
    #: (float, float) Frequencies over which it is to be kept (Hz)
    band: tuple[float, float] = PAPER_BAND
    #: (float, float) Shortest and longest ceramic length (m)
    lengths: tuple[float, float] = PAPER_LENGTHS
    threshold: ThresholdCurve = DISPLAY_THRESHOLD  #: The detection threshold

    def __post_init__(self) -> None:
        """Refuse an aim that means nothing (InputError, naming the option)."""
        (low, high), (short, long) = self.band, self.lengths
        if not (math.isfinite(self.margin) and self.margin > 0.0):
            raise InputError(
                f"margin = {self.margin:g} is not a factor above 0; write for example --margin 1.5"
            )
        if not low < high:
            raise InputError(
                f"band = {low:g} to {high:g} Hz does not rise; write for example --band 10:1000"
            )
        if self.threshold.outside(np.array(self.band)).any():
            first, last = self.threshold.range
            raise InputError(
                f"band = {low:g} to {high:g} Hz reaches beyond the detection threshold, which is "
                f"stated from {first:g} to {last:g} Hz; write for example --band "
                f"{first:g}:{last:g}"
            )
        if not 0.0 < short < long:
            raise InputError(
                f"lengths = {1e3 * short:g} mm to {1e3 * long:g} mm must rise and start above "
                "0 mm; write for example --lengths 20mm:40mm"
            )


def lowest_margin(device: Actuator, aim: Aim, lengths: Floats) -> tuple[Floats, Floats]:
    """M (n,) and the frequency (n,) in Hz that decides it, for lengths (n,) in m."""
    lengths = np.asarray(lengths, dtype=float)
    f = band_points(aim.band)

    def ratio(which: Ints, frequencies: Floats) -> Floats:
        w = tip_amplitude(device, lengths[which][:, None], frequencies)
        return np.asarray(w / aim.threshold.at(frequencies))

    on_grid = ratio(np.arange(lengths.size), f)
    at = np.argmin(on_grid, axis=1)
    lowest, where = on_grid[np.arange(lengths.size), at], f[at]
    for row, frequency, value in zip(*local_minima(f, on_grid, ratio), strict=True):
        if value < lowest[row]:
            lowest[row], where[row] = value, frequency
    return lowest, where


def _scan(device: Actuator, aim: Aim, own: float) -> tuple[Floats, Floats]:
    """Lengths (n,) in m over the aim's range, `own` among them if inside, and their m (n,)."""
    check_range(device, aim)
    low, high = aim.lengths
    steps = math.ceil(math.log(high / low) / math.log1p(_STEP))
    inner = np.geomspace(low, high, steps + 1)[1:-1]
    lengths = np.unique([low, *inner, high, min(max(own, low), high)])
    margins, _ = lowest_margin(device, aim, lengths)
    check_moves(margins)
    added = np.array(_hidden(device, aim, lengths, margins))
    if added.size:
        at = np.searchsorted(lengths, added)
        lengths = np.insert(lengths, at, added)
        margins = np.insert(margins, at, lowest_margin(device, aim, added)[0])
    return lengths, margins


def _hidden(device: Actuator, aim: Aim, lengths: Floats, margins: Floats) -> list[float]:
    """Where m has a minimum between lengths that keep the margin, or a maximum between others."""
    extremes = []
    for i in range(1, lengths.size - 1):
        sign = 1.0 if margins[i] >= aim.margin else -1.0
        before, here, after = sign * margins[i - 1 : i + 2]
        same_side = sign * (margins[i - 1 : i + 2] - aim.margin) >= 0.0
        if here < before and here <= after and same_side.all():
            extreme = _extreme(device, aim, (lengths[i - 1], lengths[i + 1]), sign, _LOCATED)
            if sign * math.exp(_excess(device, aim, extreme)) * aim.margin < here:
                extremes.append(extreme)
    return extremes


def _extreme(
    device: Actuator, aim: Aim, around: tuple[float, float], sign: float, accuracy: float
) -> float:
    """Length (m) of the least `sign` · m between two lengths, to a share of them."""
    from scipy.optimize import minimize_scalar

    return float(
        minimize_scalar(
            lambda l: sign * _excess(device, aim, l),
            bounds=around,
            method="bounded",
            options={"xatol": accuracy * around[1]},
        ).x
    )


def _excess(device: Actuator, aim: Aim, length: float) -> float:
    """ln(m / margin) of one length; the smallest number stands for no motion at all."""
    margin = float(lowest_margin(device, aim, np.array([length]))[0][0])
    return math.log(max(margin, sys.float_info.min)) - math.log(aim.margin)


def check_range(device: Actuator, aim: Aim) -> None:
    """Refuse lengths that cannot be had, are no beam, or have too many minima to separate."""
    check_lengths(device, np.array(aim.lengths))
    mm = 1e3
    (low, high), top = aim.lengths, aim.band[1]
    thickness = device.device.bimorph.thickness
    if low < thickness:
        raise InputError(
            f"lengths from {mm * low:g} mm are shorter than the actuator is thick, no beam; start "
            f"at {mm * thickness:g} mm or more"
        )
    omega = np.array([2.0 * np.pi * top])
    wavenumber = max(
        float(np.max(wavenumbers(section(p, device.device, device.beam, lossy=False), 1.0, omega)))
        for p in beam_pieces(device.device, device.support)
        if p.section == "bimorph"
    )
    half_waves = wavenumber * high / np.pi
    if half_waves > _HALF_WAVES:
        raise InputError(
            f"lengths to {mm * high:g} mm hold up to {half_waves:.3g} half waves at {top:g} Hz, "
            f"and beyond {_HALF_WAVES} their minima are not told apart; stop at "
            f"{mm * _HALF_WAVES * np.pi / wavenumber:.4g} mm or take a narrower --band"
        )


class Interval(NamedTuple):
    """Lengths (m) that keep the margin, and the frequency (Hz) that decides at each end.

    A frequency is None where the range of lengths ends, not the margin.
    """

    shortest: float
    longest: float
    at_shortest: float | None
    at_longest: float | None


@dataclass(frozen=True)
class Design:
    """A length for an aim."""

    scene: Scene
    aim: Aim
    #: The length (m), its m(l), and the frequency that decides it (Hz)
    length: float
    margin: float
    frequency: float
    limit: Limit  #: What decides the length
    intervals: tuple[Interval, ...]  #: All lengths that keep the margin asked for
    #: (n,) The scan of m(l)
    lengths: Floats
    margins: Floats
    #: (float, float) m and the deciding frequency of the scene's own length
    present: tuple[float, float]
    warnings: tuple[str, ...]  #: Reasons to doubt the model there

    @property
    def crossings(self) -> tuple[tuple[float, float], ...]:
        """Lengths (m) at which the margin is just reached, each with its frequency (Hz)."""
        ends = [
            end
            for i in self.intervals
            for end in ((i.shortest, i.at_shortest), (i.longest, i.at_longest))
        ]
        return tuple((length, at) for length, at in ends if at is not None)

    @property
    def decided(self) -> tuple[tuple[float, float], ...]:
        """Lengths (m) that depend on parameters, each with its frequency (Hz).

        All at which the margin is just reached, and the one of largest margin if that was the
        aim; an end of the range of lengths depends on nothing.
        """
        peak = self.limit in ("peak", "compromise") and self.length not in self.aim.lengths
        return (*self.crossings, *([(self.length, self.frequency)] if peak else []))


def design(scene: Scene, aim: Aim) -> Design:
    """Length for an aim.

    Raises InputError if the tip does not move, or the range holds lengths that are not to be had or
    that no beam model describes.
    """
    device, own = actuator(scene), scene.bimorph.length
    grid, margins = _scan(device, aim, own)
    intervals = _feasible(device, aim, grid, margins)
    limit: Limit
    if aim.kind == "shortest" and intervals:
        length = intervals[0].shortest
        limit = "end" if intervals[0].at_shortest is None else "threshold"
    else:
        best = int(np.argmax(margins))
        around = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, grid.size - 1)])
        length = largest_margin(device, aim, around)
        limit = "compromise" if not intervals else "end" if length in aim.lengths else "peak"
    reached, at = lowest_margin(device, aim, np.array([length, own]))
    return Design(
        scene=scene,
        aim=aim,
        length=length,
        margin=float(reached[0]),
        frequency=float(at[0]),
        limit=limit,
        intervals=intervals,
        lengths=grid,
        margins=margins,
        present=(float(reached[1]), float(at[1])),
        warnings=_doubts(scene, length),
    )


def _doubts(scene: Scene, length: float) -> tuple[str, ...]:
    """Warning of a large modelling error at a length (m)."""
    asked = with_values(scene, {_LENGTH: length})
    found = solve(asked, ("tmm",), (STATIC_TIP_DISPLACEMENT.name,))
    return tuple(modelling_warnings(found.quantities))


def largest_margin(device: Actuator, aim: Aim, around: tuple[float, float]) -> float:
    """Length (m) of largest m between two lengths that enclose one peak."""
    inner = _extreme(device, aim, around, -1.0, _PEAK_ACCURACY)
    # the bounded search never tries the ends themselves
    return max(*around, inner, key=lambda l: _excess(device, aim, l))


def _feasible(device: Actuator, aim: Aim, grid: Floats, margins: Floats) -> tuple[Interval, ...]:
    from scipy.optimize import brentq

    enough = margins >= aim.margin
    ends = [
        float(
            brentq(
                lambda l: _excess(device, aim, l),
                grid[left],
                grid[left + 1],
                xtol=_ACCURACY * grid[left],
            )
        )
        for left in np.flatnonzero(enough[1:] != enough[:-1])
    ]
    decisive = lowest_margin(device, aim, np.array(ends))[1] if ends else np.zeros(0)
    marks: list[tuple[float, float | None]] = list(zip(ends, decisive.tolist(), strict=True))
    if enough[0]:
        marks.insert(0, (float(grid[0]), None))
    if enough[-1]:
        marks.append((float(grid[-1]), None))
    return tuple(
        Interval(low, high, f_low, f_high)
        for (low, f_low), (high, f_high) in zip(marks[::2], marks[1::2], strict=True)
    )


#: How far on either side of a largest margin the slopes are taken (relative).
_ASIDE = 1e-3
_LENGTH = "bimorph.length"
_FINGER = "paper table 1 (one subject's finger, 2.5 g preload)"


@dataclass(frozen=True)
class Dependence:
    """One parameter: its source, and d ln l / d ln p for each decided length."""

    key: str
    text: str
    source: str
    slopes: tuple[float, ...]

    @property
    def largest(self) -> float:
        """Size of the largest slope."""
        return max(abs(slope) for slope in self.slopes)


def dependences(result: Design, origins: dict[str, str]) -> tuple[Dependence, ...]:
    """Sensitivities of the decided lengths, strongest first.

    All numbers that the transfer-matrix model reads and that are not 0, a factor on the
    finger's stiffness and one on its damping, and each stated point of the threshold.
    """
    device, aim = actuator(result.scene), result.aim
    columns = []
    for length, frequency in result.crossings:
        slopes = _margin_slopes(device, aim, length, frequency)
        columns.append({key: -slope / slopes[_LENGTH] for key, slope in slopes.items()})
    if len(result.decided) > len(columns):
        columns.append(_at_peak(device, aim, result.length))
    if not columns:
        return ()
    rows = [
        Dependence(key, text, source, tuple(column[key] for column in columns))
        for key, text, source in _listed(result, origins)
        if key in columns[0] and key != _LENGTH
    ]
    # those of one size, as factors of one product are, stay as listed: their rounding is no order
    return tuple(sorted(rows, key=lambda row: -float(f"{row.largest:.9g}")))


def _at_peak(device: Actuator, aim: Aim, length: float) -> dict[str, float]:
    """Slopes of the length of largest margin."""
    aside = length * np.array([1.0 - _ASIDE, 1.0 + _ASIDE])
    _, decisive = lowest_margin(device, aim, aside)
    below, above = (
        _margin_slopes(device, aim, float(l), float(f))
        for l, f in zip(aside, decisive, strict=True)
    )
    by_length = above[_LENGTH] - below[_LENGTH]
    return {key: -(slope - below[key]) / by_length for key, slope in above.items()}


def _margin_slopes(device: Actuator, aim: Aim, length: float, frequency: float) -> dict[str, float]:
    """D ln m / d ln p of every parameter, the length among them; a factor on 0 says nothing."""
    device = device.with_values({_LENGTH: length})
    slopes = tip_slopes(device, parameter_keys(device), frequency)
    if device.load.kind == "finger":
        stiffness, damping = (float(v[0]) for v in finger_spring_damper(np.array([frequency])))
        springs = {"kind": "spring_damper", "stiffness": stiffness, "damping": damping}
        same = replace(device, load=device.load.model_copy(update=springs))
        slopes |= tip_slopes(same, ("load.stiffness", "load.damping"), frequency)
    weights = aim.threshold.weights(frequency)
    return slopes | {_point(aim, i): -float(weight) for i, weight in enumerate(weights)}


def _point(aim: Aim, number: int) -> str:
    return f"threshold at {aim.threshold.points[number].frequency:g} Hz"


def _listed(result: Design, origins: dict[str, str]) -> Iterator[tuple[str, str, str]]:
    """Key, value and source of everything that the length may depend on."""
    finger = result.scene.load.kind == "finger"
    for row in parameter_rows(result.scene, origins):
        if not (finger and row.key.startswith("load.")):
            yield row.key, row.text, row.source
    if finger:
        yield "load.stiffness", "finger c(f)", _FINGER
        yield "load.damping", "finger d(f)", _FINGER
    for number, point in enumerate(result.aim.threshold.points):
        yield _point(result.aim, number), f"{1e6 * point.amplitude:g} µm", point.source
