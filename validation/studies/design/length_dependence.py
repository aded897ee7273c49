"""How a designed length depends on each parameter that goes into it.

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

from tactgen.geometry.arrays import Floats
from tactgen.tmm.beam.parametric import Actuator, parameter_keys
from tactgen.tmm.beam.sensitivities import logarithmic_sensitivities
from tactgen.tmm.ports.finger import finger_spring_damper
from tactgen.validation.catalogue.bimorph import TIP_DISPLACEMENT
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.studies.design.aim import Aim
from tactgen.validation.studies.design.length_design import Design
from tactgen.validation.studies.design.length_map import actuator
from tactgen.validation.studies.design.length_scan import lowest_margin

#: How far on either side of a largest margin the slopes are taken (relative).
_BESIDE = 1e-3
_LENGTH = "bimorph.length"
_FINGER = "paper table 1 (one subject's finger, 2.5 g preload)"


@dataclass(frozen=True)
class Dependence:
    """One parameter: who vouches for it, and d ln l / d ln p for each length asked about."""

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


def decided_lengths(found: Design) -> tuple[tuple[float, float], ...]:
    """Return the lengths (m) whose dependence can be stated, each with its frequency (Hz).

    All at which the margin is just reached, and the one of largest margin if that was the
    aim; an end of the range of lengths depends on nothing.
    """
    peak = found.limit in ("peak", "compromise") and found.length not in found.aim.lengths
    return (*found.crossings, *([(found.length, found.frequency)] if peak else []))


def dependences(found: Design, origins: dict[str, str]) -> tuple[Dependence, ...]:
    """Return what :func:`decided_lengths` depend on, strongest first.

    All numbers that the transfer-matrix model reads and that are not 0, a factor on the
    finger's stiffness and one on its damping, and each stated point of the threshold.
    """
    device, aim = actuator(found.scene), found.aim
    columns = [_at_crossing(device, aim, *crossing) for crossing in found.crossings]
    if len(decided_lengths(found)) > len(columns):
        columns.append(_at_peak(device, aim, found.length))
    if not columns:
        return ()
    rows = [
        Dependence(key, text, source, tuple(column[key] for column in columns))
        for key, text, source in _listed(found, origins)
        if key in columns[0]
    ]
    # those of one size, as factors of one product are, stay as listed: their rounding is no order
    return tuple(sorted(rows, key=lambda row: -float(f"{row.largest:.9g}")))


def _at_crossing(device: Actuator, aim: Aim, length: float, frequency: float) -> dict[str, float]:
    """Return the slopes of a length at which the margin is just reached."""
    slopes = _margin_slopes(device, aim, length, frequency)
    by_length = slopes.pop(_LENGTH)
    return {key: -slope / by_length for key, slope in slopes.items()}


def _at_peak(device: Actuator, aim: Aim, length: float) -> dict[str, float]:
    """Return the slopes of the length of largest margin."""
    beside = length * np.array([1.0 - _BESIDE, 1.0 + _BESIDE])
    _, decisive = lowest_margin(device, aim, beside)
    below, above = (
        _margin_slopes(device, aim, float(l), float(f))
        for l, f in zip(beside, decisive, strict=True)
    )
    by_length = above.pop(_LENGTH) - below.pop(_LENGTH)
    return {key: -(slope - below[key]) / by_length for key, slope in above.items()}


def _margin_slopes(device: Actuator, aim: Aim, length: float, frequency: float) -> dict[str, float]:
    """Return d ln m / d ln p of every parameter, the length among them."""
    at = np.array([frequency])
    device = device.with_values({_LENGTH: length})
    slopes = _slopes(device, (_LENGTH, *_keys(device)), at)
    if device.load.kind == "finger":
        stiffness, damping = (float(v[0]) for v in finger_spring_damper(at))
        held = {"kind": "spring_damper", "stiffness": stiffness, "damping": damping}
        same = replace(device, load=device.load.model_copy(update=held))
        slopes |= _slopes(same, ("load.stiffness", "load.damping"), at)
    weights = aim.threshold.weights(frequency)
    return slopes | {_point(aim, i): -float(weight) for i, weight in enumerate(weights)}


def _keys(device: Actuator) -> tuple[str, ...]:
    """Return the parameters besides the length; a factor on 0 says nothing."""
    keys = parameter_keys(device)
    return tuple(k for k in keys if k != _LENGTH and device.value(k) != 0.0)


def _slopes(device: Actuator, keys: tuple[str, ...], at: Floats) -> dict[str, float]:
    """Return d ln|w_tip| / d ln p at one frequency."""
    found = logarithmic_sensitivities(device, TIP_DISPLACEMENT.port_readout, keys, at)
    return {key: float(value[0]) for key, value in found.items()}


def _point(aim: Aim, number: int) -> str:
    return f"threshold at {aim.threshold.points[number].frequency:g} Hz"


def _listed(found: Design, origins: dict[str, str]) -> Iterator[tuple[str, str, str]]:
    """Yield key, value and source of everything that the length may depend on."""
    finger = found.scene.load.kind == "finger"
    for row in parameter_rows(found.scene, origins):
        if not (finger and row.key.startswith("load.")):
            yield row.key, row.text, row.source
    if finger:
        yield "load.stiffness", "finger c(f)", _FINGER
        yield "load.damping", "finger d(f)", _FINGER
    for number, point in enumerate(found.aim.threshold.points):
        yield _point(found.aim, number), f"{1e6 * point.amplitude:g} µm", point.source
