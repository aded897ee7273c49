"""Support identification (the paper's Fig 8): a scene's parameters from a measured curve.

The paper determined its support "empirically".  Here the same is a least-squares fit of
the transfer-matrix model with a statement of what the curve can and cannot tell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.plan import check_on_contact
from tactgen.validation.engine.warnings import load_warnings
from tactgen.validation.scene.idle_keys import idle
from tactgen.validation.scene.keys import with_values
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.identification.curve_fit import Misfit, Scan, descend, scan
from tactgen.validation.studies.identification.curve_model import (
    CurveModel,
    curve_model,
    sensitivities,
)
from tactgen.validation.studies.identification.estimates import FittedParameter, Identification
from tactgen.validation.studies.identification.fit_parameters import (
    DEFAULT_FIT,
    FitParameter,
    fit_parameter,
)
from tactgen.validation.studies.identification.fit_quality import (
    ROUNDING,
    assumed_slopes,
    doubts,
    phase_hint,
)
from tactgen.validation.studies.identification.identifiability import (
    INSEPARABLE,
    VAGUE,
    Statistics,
    inseparable,
    statistics,
    vague,
)
from tactgen.validation.studies.identification.measured_curve import MeasuredCurve
from tactgen.validation.studies.identification.profile_likelihood import profile_interval

#: Kinds of noise that may be asked for where no uncertainty is stated.
NOISE = ("relative", "constant")
#: Constant noise must make the data this much likelier (in ln) to be preferred to relative.
_CLEARLY = 2.0
_OPPOSITE = {"low": "high", "high": "low"}
#: Fewest points of a curve, and fewest per parameter.
_LEAST_POINTS, _PER_PARAMETER = 5, 2


def identify(
    scene: Scene,
    data: MeasuredCurve,
    fit: Sequence[str] = DEFAULT_FIT,
    noise: str | None = None,
    origins: Mapping[str, str] | None = None,
) -> Identification:
    """Fit parameters of a scene to a measured curve with the transfer-matrix model.

    Parameters
    ----------
    scene : Scene
        What was measured; `drive.voltage` is the (peak) amplitude that the data belong to.
    data : MeasuredCurve
        From :func:`validation.studies.identification.measured_data.read_measured`.
    fit : sequence of str
        ``NAME[=START][:LOW..HIGH]`` each, see
        :func:`validation.studies.identification.fit_parameters.fit_parameter`.
    noise : str, optional
        ``relative`` or ``constant``; by default the one under which the data are likelier.
        Not used where the data state their uncertainty.
    origins : mapping, optional
        Where the scene's values come from, as :func:`validation.scene.scene.load_scene` returns it.

    Raises
    ------
    InputError
        If a parameter or the data cannot be used, in one sentence.
    """
    curve = data.at(data.used)
    quantity = curve.quantity.name
    check_on_contact(scene, (quantity,))
    parameters = _parameters(scene.model_copy(update={"quantities": (quantity,)}), fit)
    _check_points(curve, parameters)
    at_data = scene.model_copy(update={"frequency": tuple(map(float, curve.frequencies))})
    warnings = list(load_warnings(at_data, (quantity,)))
    start = with_values(scene, {p.key: p.start for p in parameters})
    model = curve_model(start, quantity, curve.frequencies, [p.key for p in parameters])
    _check_effect(model, parameters, curve)
    found = scan(model, parameters)
    misfit, values, edges = _best(model, curve, parameters, found, noise)
    now, sensitivity = model(values), sensitivities(model, values)
    residuals = misfit.residuals(now)
    free = [i for i, edge in enumerate(edges) if not edge]
    everything = misfit.jacobian(now, sensitivity)
    jacobian, stated = everything[:, free], misfit.noise == "stated"
    stats = statistics(jacobian, residuals, stated=stated)
    fitted_scene = with_values(start, dict(zip(model.keys, map(float, values), strict=True)))
    warnings += doubts(misfit, stats, now, residuals) + phase_hint(curve, found)
    warnings += _inadmissible(fitted_scene)
    estimates = _estimates(model, misfit, parameters, (values, edges), stats)
    return Identification(
        scene=fitted_scene,
        start=start,
        curve=curve,
        estimates=estimates,
        correlation=_scattered(stats.correlation, free, len(parameters)),
        singular_values=stats.singular_values,
        noise=misfit.noise,
        level=stats.level * misfit.unit_of_noise,
        freedom=stats.freedom,
        fitted=now,
        band=_band(sensitivity[:, free], stats),
        assumptions=assumed_slopes(fitted_scene, origins or {}, misfit, now, jacobian, free, model),
        # two that only their product fixes may both have drifted to their bounds
        findings=_findings(estimates, statistics(everything, residuals, stated=stated)),
        warnings=tuple(warnings),
    )


def _parameters(scene: Scene, fit: Sequence[str]) -> list[FitParameter]:
    parameters = [fit_parameter(scene, text) for text in fit]
    keys = [p.key for p in parameters]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"--fit names {key} twice; keep one of them")
    if not parameters:
        raise InputError("nothing is to be fitted; name a parameter, for example --fit c_s")
    for key in keys:
        if idle(scene, key):
            raise InputError(f"--fit: {idle(scene, key)}")
    return parameters


def _check_points(curve: MeasuredCurve, parameters: Sequence[FitParameter]) -> None:
    least = max(_LEAST_POINTS, _PER_PARAMETER * len(parameters))
    if curve.frequencies.size < least:
        raise InputError(
            f"{curve.source} holds {curve.frequencies.size} points that count, too few to fit "
            f"{len(parameters)} parameters; give at least {least}, or fit fewer parameters"
        )


def _check_effect(
    model: CurveModel, parameters: Sequence[FitParameter], curve: MeasuredCurve
) -> None:
    start = np.array([p.start for p in parameters])
    now = model(start)
    if not (np.isfinite(now).all() and np.abs(now).min() > 0.0):
        raise InputError(
            f'scene "{model.scene.name}" gives no {curve.kind} to compare with '
            f"{curve.source}; check drive.voltage and the values that the scene sets"
        )
    for parameter, column in zip(parameters, sensitivities(model, start).T, strict=True):
        if not column.any():
            raise InputError(
                f"--fit {parameter.key}: it has no effect on the {curve.kind} of the "
                "transfer-matrix model; fit another parameter, or measure another curve"
            )


def _best(
    model: CurveModel,
    curve: MeasuredCurve,
    parameters: Sequence[FitParameter],
    found: Scan,
    noise: str | None,
) -> tuple[Misfit, Floats, list[str]]:
    """Fit under each kind of noise that is possible and keep the likeliest."""
    kinds = ("stated",) if curve.error is not None else (noise,) if noise else NOISE
    fits = []
    for kind in kinds:
        misfit = Misfit(curve, kind)
        values, edges = descend(model, misfit, parameters, found)
        residuals = misfit.residuals(model(values))
        if np.sqrt(np.mean(residuals**2)) < ROUNDING:
            return misfit, values, edges  # exact: there is no noise to tell kinds apart by
        handicap = _CLEARLY if kind == "constant" else 0.0
        fits.append((misfit.surprise(residuals) + handicap, misfit, values, edges))
    return min(fits, key=lambda entry: entry[0])[1:]


def _estimates(
    model: CurveModel,
    misfit: Misfit,
    parameters: Sequence[FitParameter],
    best: tuple[Floats, list[str]],
    stats: Statistics,
) -> tuple[FittedParameter, ...]:
    """Return the estimates with linear intervals if all are narrow, else with profiled ones."""
    values, edges = best
    deviation = np.full(values.size, np.nan)
    deviation[[not edge for edge in edges]] = stats.deviation
    reach = np.exp(np.minimum(stats.quantile * deviation, 300.0))
    stated = misfit.noise == "stated"
    narrow = not any(edges) and bool((reach < np.sqrt(VAGUE)).all())
    estimates = []
    for i, (parameter, edge) in enumerate(zip(parameters, edges, strict=True)):
        value = float(values[i])
        opened: tuple[str, ...] = ()
        if narrow:
            low, high = value / reach[i], value * reach[i]
        else:
            low, high, opened = profile_interval(
                model,
                misfit,
                parameters,
                values,
                i,
                variance=1.0 if stated else stats.level**2,
                quantile=stats.quantile,
                deviation=float(deviation[i]),
            )
        if value < 0.0:  # the fit's bounds go by magnitude
            low, high, opened = high, low, tuple(_OPPOSITE[end] for end in opened)
            edge = _OPPOSITE.get(edge, "")
        estimates.append(FittedParameter(parameter, value, (float(low), float(high)), opened, edge))
    return tuple(estimates)


def _findings(estimates: Sequence[FittedParameter], stats: Statistics) -> tuple[str, ...]:
    """Say what the curve does not determine; the statistics are those of all parameters."""
    found = inseparable(
        [e.parameter.symbol for e in estimates], stats, np.array([e.half_width for e in estimates])
    )
    # the diagonal is 1, so a second correlation near 1 is with another parameter
    tied = (np.abs(stats.correlation) > INSEPARABLE).sum(axis=1) > 1
    for e, drifts in zip(estimates, tied, strict=True):
        low, high = (e.parameter.unit.show(float(f"{end:.3g}")) for end in e.interval)
        span = float(np.exp(min(2.0 * e.half_width, 300.0)))
        if not e.edge or span > VAGUE:
            found.append(vague(e.parameter.symbol, (low, high), e.opened, span))
        if e.edge and not drifts:
            at = e.parameter.unit.show(e.value)
            found.append(
                f"{e.parameter.symbol} ended at its {'lower' if e.edge == 'low' else 'upper'} "
                f"bound {at}, where the data push it; widen the bounds, or do not fit it"
            )
    return tuple(sentence for sentence in found if sentence)


def _inadmissible(scene: Scene) -> list[str]:
    """Return why the fitted ceramic cannot exist, if it cannot."""
    try:
        scene.piezo.ceramic().check_admissible()
    except InputError as error:
        return [f"the fitted values are not possible: {error}"]
    return []


def _scattered(correlation: Floats, free: list[int], count: int) -> Floats:
    full = np.full((count, count), np.nan)
    full[np.ix_(free, free)] = correlation
    return full


def _band(sensitivity: Complex, stats: Statistics) -> Complex:
    def half_width(s: Floats) -> Floats:
        variance = np.einsum("ni,ij,nj->n", s, stats.covariance, s)
        return np.asarray(stats.quantile * np.sqrt(np.maximum(variance, 0.0)))

    return np.asarray(half_width(sensitivity.real) + 1j * half_width(sensitivity.imag))
