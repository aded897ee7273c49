"""What a fit rests on, and reasons to doubt it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.validation.scene.idle_keys import idle
from tactgen.validation.scene.keys import value_of
from tactgen.validation.scene.parameter_list import ParameterRow, parameter_rows
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.identification.curve_fit import Misfit, Scan
from tactgen.validation.studies.identification.curve_model import (
    CurveModel,
    curve_model,
    sensitivities,
)
from tactgen.validation.studies.identification.identifiability import (
    RANK,
    Statistics,
    neighbours_alike,
    unlikely_scatter,
)
from tactgen.validation.studies.identification.measured_curve import MeasuredCurve

#: Share of the curve left unexplained above which the model is called wrong.
_UNEXPLAINED = 0.2
#: Residuals below this fraction of the curve are rounding, and are not judged.
ROUNDING = 1e-8


@dataclass(frozen=True)
class Assumption:
    """A parameter that was not fitted and that nobody vouches for.

    `slopes` holds d ln(fitted) / d ln(assumed) for each fitted parameter, nan at a bound.
    """

    row: ParameterRow
    slopes: tuple[float, ...]


def assumed_slopes(
    scene: Scene,
    origins: Mapping[str, str],
    misfit: Misfit,
    now: Complex,
    jacobian: Floats,
    free: list[int],
    model: CurveModel,
) -> tuple[Assumption, ...]:
    """Return how the estimates follow assumed parameters: −J⁺ ∂r/∂ln q at the optimum.

    This is implicit differentiation of the normal equations with the residuals' second
    derivatives left out, as in the covariance.  What the data do not tell apart shares a
    change alike.
    """
    rows = [
        row
        for row in parameter_rows(scene, dict(origins))
        if row.assumed
        and row.key not in model.keys
        and _is_number(value_of(scene, row.key))
        and not idle(scene, row.key)
    ]
    keys = [row.key for row in rows]
    values = np.array([value_of(scene, key) for key in keys], dtype=float)
    varied = curve_model(scene, model.quantity, model.frequencies, keys)
    shifts = misfit.jacobian(now, sensitivities(varied, values))
    slopes = np.full((len(model.keys), len(keys)), np.nan)
    slopes[free] = -np.linalg.lstsq(jacobian, shifts, rcond=RANK)[0]
    found = [
        Assumption(row, tuple(map(float, slope)))
        for row, slope, shift in zip(rows, slopes.T, shifts.T, strict=True)
        if shift.any()
    ]
    return tuple(sorted(found, key=lambda a: -np.nanmax(np.abs([*a.slopes, 0.0]))))


def _is_number(value: object) -> bool:
    return isinstance(value, float) and value != 0.0


def doubts(misfit: Misfit, stats: Statistics, now: Complex, residuals: Floats) -> list[str]:
    """Return reasons to doubt that the model describes the data."""
    curve = misfit.curve
    data, fitted = np.abs(curve.values), np.abs(now)
    distance = curve.values - now if curve.has_phase else data - fitted
    unexplained = float(np.sqrt(np.sum(np.abs(distance) ** 2) / np.sum(data**2)))
    found = []
    if unexplained > _UNEXPLAINED:
        ratio = float(np.median(data / fitted))
        found.append(
            f"the fitted curve leaves {100 * unexplained:.0f} % of the {curve.kind} unexplained "
            f"(measured over fitted magnitude, median {ratio:.3g}); check the units, that "
            "drive.voltage is the amplitude of the measurement, and the scene's dimensions"
        )
    alike = neighbours_alike(residuals, 2 if curve.has_phase else 1)
    if alike is not None and unexplained > ROUNDING:
        found.append(
            f"neighbouring residuals are alike (correlation {alike:+.2f}), so the model is off by "
            "more than noise and the true intervals are wider than those stated"
        )
    if misfit.noise == "stated" and unlikely_scatter(stats):
        found.append(
            f"the residuals are {stats.level:.3g} times the stated uncertainty (chi2 per degree "
            f"of freedom {stats.level**2:.3g} where 1 is expected); the intervals take the "
            "uncertainty as stated, so correct it or multiply them by that number"
        )
    return found


def phase_hint(curve: MeasuredCurve, found: Scan) -> list[str]:
    """Return a hint if another sign convention of the data would fit far better."""
    if not curve.has_phase:
        return []
    data = curve.values[found.points]

    def cost(values: Numbers) -> float:
        return float(np.min(np.sum(np.abs(np.log(found.curves / values)) ** 2, axis=1)))

    hints = {
        "the opposite sign (turn the phase by 180°)": -data,
        "the opposite sign of the phase (the time factor here is exp(+j omega t))": data.conj(),
        "both signs opposite (of the values and of the phase)": -data.conj(),
    }
    name, other = min(((n, cost(v)) for n, v in hints.items()), key=lambda entry: entry[1])
    if other < 0.25 * cost(data):
        return [f"the data would fit far better with {name}; check how the phase was recorded"]
    return []
