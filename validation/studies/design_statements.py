"""Sensitivities of a designed length, and the design in sentences.

With m(l, p) the lowest margin over the band, at a length where the margin is just reached
ln m(l, p) = const, and the implicit function theorem gives

    d ln l / d ln p = −S_p / S_l,    S_x = ∂ ln m / ∂ ln x.

At the length of largest margin S_l changes sign, smoothly or, where the deciding frequency
jumps, with a step; from either side of it (±)

    d ln l / d ln p = −(S_p⁺ − S_p⁻) / (S_l⁺ − S_l⁻).

The S are those of |w| / threshold at the frequency that decides: at a minimum over frequency
its own shift is of second order.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tactgen.tmm.beam.parametric import Actuator, parameter_keys
from tactgen.tmm.ports.loads import finger_spring_damper
from tactgen.validation.scene.conditions import conditions
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.studies.design import Aim, Design, lowest_margin
from tactgen.validation.studies.length_map import actuator, tip_slopes

#: How far on either side of a largest margin the slopes are taken (relative).
_ASIDE = 1e-3
_LENGTH = "bimorph.length"
_FINGER = "paper table 1 (one subject's finger, 2.5 g preload)"
#: Parameters with smaller slopes are named without their number: 10 % of one then moves the
#: length by less than 0.005 %.
NEGLIGIBLE = 5e-4
#: Most frequencies of a threshold that are named one by one.
_LISTED = 5


@dataclass(frozen=True)
class Dependence:
    """One parameter: its source, and d ln l / d ln p for each decided length."""

    key: str
    text: str
    source: str
    slopes: tuple[float, ...]

    @property
    def assumed(self) -> bool:
        """Whether nobody but this project vouches for the parameter."""
        return self.source.startswith("assumed")

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


def sentences(result: Design) -> tuple[str, ...]:
    """Design in sentences: drive, length, margin, present length, limits."""
    return conditions(result.scene), *statements(result), caveat(result)


def statements(result: Design) -> tuple[str, str, str]:
    """Sentences on the resulting length, the intervals and the present length."""

    def end(length: float, at: float | None) -> str:
        limit = "end of the range" if at is None else f"critical frequency {at:.4g} Hz"
        return f"{_mm(length)} ({limit})"

    ranges = "; ".join(
        f"{end(i.shortest, i.at_shortest)} to {end(i.longest, i.at_longest)}"
        for i in result.intervals
    )
    margin, at = result.present
    own, (low, high) = result.scene.bimorph.length, result.aim.lengths
    outside = "" if low <= own <= high else " outside that range,"
    present = f"a minimum |w| / threshold of {margin:.4g}, at {at:.4g} Hz"
    return (
        _outcome(result),
        f"Lengths that meet the margin: {ranges}." if ranges else "No length meets the margin.",
        f"The scene's own length, {_mm(own)},{outside} has {present}.",
    )


def _outcome(result: Design) -> str:
    aim = result.aim
    band = f"{aim.band[0]:g} to {aim.band[1]:g} Hz"
    within = f"of {_mm(aim.lengths[0])} to {_mm(aim.lengths[1])}"
    wanted = f"|w| / threshold ≥ {aim.margin:g} over {band}"
    reached = f"the minimum of |w| / threshold is {result.margin:.4g}, at {result.frequency:.4g} Hz"
    if result.limit == "compromise":
        return f"No length {within} meets {wanted}. The closest is {_mm(result.length)}: {reached}."
    if aim.kind == "margin":
        end = (
            " (an end of the range; the margin may grow beyond it)" if result.limit == "end" else ""
        )
        best = f"{_mm(result.length)}{end}"
        return f"The length with the largest margin {within} over {band} is {best}: {reached}."
    if result.limit == "end":
        return (
            f"The shortest length allowed, {_mm(result.length)}, already meets {wanted}: "
            f"{reached}. The range limits the length, not the threshold."
        )
    return (
        f"The shortest length {within} that meets {wanted} is {_mm(result.length)}. "
        f"The critical frequency is {result.frequency:.4g} Hz."
    )


def caveat(result: Design) -> str:
    """Where the threshold is known."""
    points = [p.frequency for p in result.aim.threshold.points]
    if len(points) > _LISTED:
        listed = f"{len(points)} frequencies from {points[0]:g} to {points[-1]:g} Hz"
    else:
        listed = ", ".join(f"{f:g}" for f in points[:-1]) + f" and {points[-1]:g} Hz"
    between = "" if result.frequency in points else f", as at {result.frequency:.4g} Hz"
    return (
        f"The detection threshold is stated at {listed}; it is interpolated linearly in log-log "
        f"between them{between}."
    )


def _mm(length: float) -> str:
    return f"{1e3 * length:.5g} mm"
