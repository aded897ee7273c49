"""Identification of a scene's parameters from a measured curve.

The paper determined its support "empirically" (Fig 8).  Here the same is a least-squares fit of
the transfer-matrix model with a statement of what the curve determines.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.device.checks import check_bimorph
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import share
from tactgen.geometry.units import NUMBER, Unit, quoted
from tactgen.tmm.beam.parametric import check_length_free
from tactgen.validation.engine.solve import check_on_contact
from tactgen.validation.engine.warnings import load_warnings
from tactgen.validation.scene.files import one_line
from tactgen.validation.scene.keys import check_key, declaration
from tactgen.validation.scene.parameter_list import ParameterRow, parameter_rows
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.tolerances import unit_of
from tactgen.validation.scene.variation import SYMBOLS, value_of, with_values
from tactgen.validation.scene.warnings import idle
from tactgen.validation.studies.curve_fit import (
    CONFIDENCE,
    RANK,
    CurveModel,
    Fit,
    Misfit,
    Scan,
    Statistics,
    scan,
    statistics,
)
from tactgen.validation.studies.measured_data import MeasuredCurve

#: Beyond this correlation the data do not separate two parameters.
_INSEPARABLE = 0.99
#: A parameter whose interval spans more than this factor is not determined by the data.
VAGUE = 2.0
#: Bounds where none are given: this factor below and above the start.
_REACH = 100.0
_REMEDY = "write for example --fit c_s=0.2N*m/rad:0.05..2N*m/rad or --fit c_s"
_LEADING_NUMBER = re.compile(NUMBER, re.IGNORECASE | re.ASCII)


@dataclass(frozen=True)
class FitParameter:
    """One number of a scene that is fitted, SI units.

    `start`, `low` and `high` have one sign and none is 0, for the fit runs over the
    logarithm of the magnitude; ``|low| < |high|``.
    """

    key: str
    unit: Unit
    start: float
    low: float
    high: float

    @property
    def symbol(self) -> str:
        """The paper's symbol, or the key."""
        return next((s for s, key in SYMBOLS.items() if key == self.key), self.key)


@dataclass(frozen=True)
class FittedParameter:
    """One fitted parameter, SI units.

    `interval` is the 95 % confidence interval; `opened` names the ends of it (``low``, ``high``)
    that are only bounds of the search, `edge` the bound that the value itself is at.
    """

    parameter: FitParameter
    value: float
    interval: tuple[float, float]
    opened: tuple[str, ...]
    edge: str

    @property
    def half_width(self) -> float:
        """Half width of the interval of ln(value)."""
        return abs(float(np.log(self.interval[1] / self.interval[0]))) / 2.0


def fit_parameter(scene: Scene, text: str) -> FitParameter:
    """Read ``NAME[=START][:LOW..HIGH]``; NAME is a scene key or a symbol of the paper.

    The start is the scene's value unless given, the bounds a factor 100 either side of it.  A LOW
    without a unit has that of HIGH.

    Raises InputError if the name, a value or its unit cannot be used.
    """
    head, colon, bounds = text.partition(":")
    name, equals, start_text = (part.strip() for part in head.partition("="))
    low_text, dots, high_text = (part.strip() for part in bounds.partition(".."))
    if not name or (equals and not start_text) or (colon and not (low_text and high_text and dots)):
        raise InputError(
            f"--fit {quoted(text)} is not of the form NAME[=START][:LOW..HIGH]; {_REMEDY}"
        )
    key = SYMBOLS.get(name, name)
    unit = _unit_of_parameter(scene, key)
    if key == "bimorph.length":
        check_length_free(scene.bimorph)
    start = _read(key, start_text, unit) if equals else float(value_of(scene, key))
    if start == 0.0:
        raise InputError(
            f"{key} = {unit.show(0.0)} cannot be where a fit starts; give a value that is not 0, "
            f'for example --fit "{name}={unit.example}"'
        )
    if colon:
        if _LEADING_NUMBER.fullmatch(low_text):
            low_text += _LEADING_NUMBER.sub("", high_text, count=1)
        low, high = sorted((_read(key, end, unit) for end in (low_text, high_text)), key=abs)
    else:
        least, most = unit.limits or (0.0, math.inf)
        low, high = (
            math.copysign(min(max(abs(end), least), most), start)
            for end in (start / _REACH, start * _REACH)
        )
        if key.endswith((".start", ".end")):  # of a listed layer
            high = min(high, scene.bimorph.length)
    if low * start <= 0.0 or not abs(low) <= abs(start) <= abs(high) or abs(low) == abs(high):
        raise InputError(
            f"--fit {quoted(text)} starts {key} at {unit.show(start)}, outside its bounds "
            f"{unit.show(low)} to {unit.show(high)}; give LOW and HIGH of one sign, not 0, with "
            "the start between them"
        )
    return FitParameter(key, unit, start, low, high)


def _read(key: str, text: str, unit: Unit) -> float:
    """SI value as the scene would read it."""
    try:
        value = unit.parse(text)
        unit.check(value)
    except ValueError as error:
        raise InputError(one_line(f"--fit: {key} = {quoted(text)} {error}")) from None
    return value


def _unit_of_parameter(scene: Scene, key: str) -> Unit:
    check_key(key, SYMBOLS)
    unit = unit_of(declaration(key))
    if unit is None or value_of(scene, key) is None:
        raise InputError(
            f"--fit {key} is not a number that can be fitted; use for example {', '.join(SYMBOLS)}"
        )
    return unit


def findings(estimates: Sequence[FittedParameter], stats: Statistics) -> tuple[str, ...]:
    """Sentences on undetermined parameters, from the statistics of all."""
    sentences, tied = [], set()
    for i, j in combinations(range(len(estimates)), 2):
        if abs(stats.correlation[i, j]) > _INSEPARABLE:
            sentences.append(_inseparable(estimates, stats, i, j))
            tied |= {i, j}
    for i, e in enumerate(estimates):
        if _span(2.0 * e.half_width) > VAGUE or (e.opened and not e.edge):
            sentences.append(_undetermined(e))
        if e.edge and i not in tied:
            sentences.append(
                f"{e.parameter.symbol} ended at its {'lower' if e.edge == 'low' else 'upper'} "
                f"bound {e.parameter.unit.show(e.value)}, where the data push it; widen the "
                "bounds, or do not fit it"
            )
    return tuple(filter(None, sentences))


def _undetermined(e: FittedParameter) -> str:
    """Sentence on an undetermined parameter."""
    name, span = e.parameter.symbol, _span(2.0 * e.half_width)
    low, high = (e.parameter.unit.show(float(f"{end:.3g}")) for end in e.interval)
    known = {
        (): f"its {100 * CONFIDENCE:g} % interval spans a factor of {span:.2g}",
        ("low",): f"it says only that it is below {high}",
        ("high",): f"it says only that it is above {low}",
    }.get(e.opened, f"it says nothing between the bounds {low} and {high}")
    return (
        f"{name} is not determined by this curve: {known}; hold it at a known value, or measure at "
        "frequencies where it acts"
    )


def _inseparable(estimates: Sequence[FittedParameter], stats: Statistics, i: int, j: int) -> str:
    """Product of powers of two parameters that the data fix, and how well.

    Nothing if they fix none: then neither parameter is determined.
    """
    powers = np.linalg.svd(stats.root[:, [i, j]])[2][1]  # the direction of least variance
    if abs(powers[1]) > 5.0 * abs(powers[0]):
        i, j, powers = j, i, powers[::-1]
    powers = powers / powers[0]
    fixed = float(stats.quantile * np.linalg.norm(stats.root[:, [i, j]] @ powers))
    if fixed > np.log(VAGUE):
        return ""
    a, b = sorted((i, j))
    names = [e.parameter.symbol for e in estimates]
    exponent = f"{abs(powers[1]):.3g}"
    product = f"{names[i]} {'/' if powers[1] < 0.0 else '*'} {names[j]}"
    return (
        f"{names[a]} and {names[b]} cannot be told apart (correlation "
        f"{stats.correlation[i, j]:+.4f}): the curve fixes {product}"
        f"{'' if exponent == '1' else f'^{exponent}'} {_spread(fixed)}, but {names[a]} alone only "
        f"{_spread(estimates[a].half_width)} and {names[b]} {_spread(estimates[b].half_width)}"
    )


def _spread(half_width: float) -> str:
    """Relative interval, from the half width of the interval of its ln."""
    if half_width < 0.2:
        return f"to ±{share(half_width)}"
    return f"within a factor of {_span(half_width):.2g}"


def _span(logarithm: float) -> float:
    return float(np.exp(min(logarithm, 300.0)))


#: What a velocity curve over the first resonance determines.
DEFAULT_FIT = ("c_s", "d_s")
#: Kinds of noise where no uncertainty is stated.
NOISE = ("relative", "constant")
#: Constant noise must make the data this much likelier (in ln) to be preferred to relative.
_CLEARLY = 2.0
#: Fewest points of a curve, and fewest per parameter.
_LEAST_POINTS, _PER_PARAMETER = 5, 2
#: Share of the curve left unexplained above which the model is called wrong, and below which
#: residuals are rounding.
_UNEXPLAINED, _ROUNDING = 0.2, 1e-8
_TINY = np.finfo(float).tiny
#: Share of the sum of squares that is left where another reading of the data fits far better.
_FAR_BETTER = 0.25
_VOLTAGE = "drive.voltage"
#: Factor within which a voltage is looked for: that of units stated wrongly, and more.
_ANY = 1e6
_OPPOSITE = {"low": "high", "high": "low"}


@dataclass(frozen=True)
class Assumption:
    """A parameter that was not fitted and that nobody vouches for.

    `slopes` holds d ln(fitted) / d ln(assumed) for each fitted parameter, nan at a bound.
    """

    row: ParameterRow
    slopes: tuple[float, ...]


@dataclass(frozen=True)
class Identification:
    """Fit with its result."""

    #: With the fitted values, and with those that the fit started from
    scene: Scene
    start: Scene
    curve: MeasuredCurve  #: The data that counted
    estimates: tuple[FittedParameter, ...]  #: In the order of the request
    correlation: Floats  #: (p, p) Between ln of the estimates; nan for those at a bound
    singular_values: Floats  #: (p',) Of the scaled Jacobian over those not at a bound, descending
    noise: str  #: ``relative``, ``constant`` or ``stated``: how residuals were counted
    level: float  #: Estimated noise: a fraction, an amount in the curve's SI unit, or √(χ²/freedom)
    freedom: int  #: Residuals less free parameters
    fitted: Complex  #: (n,) complex The fitted curve at the data's frequencies
    #: (n,) complex Half width of the fitted curve's 95 % band: of ln|curve| and, imaginary, of its
    #: phase
    band: Complex
    assumptions: tuple[Assumption, ...]  #: What the estimates rest on, strongest first
    findings: tuple[str, ...]  #: What the curve does not determine, in words
    warnings: tuple[str, ...]  #: Reasons to doubt the fit

    def get(self, name: str) -> FittedParameter:
        """Estimate of a symbol or scene key."""
        return next(e for e in self.estimates if name in (e.parameter.key, e.parameter.symbol))

    @property
    def residuals(self) -> Complex:
        """ln(data / fitted), shape (n,): the misfit's fraction and, imaginary, its phase."""
        fitted = self.fitted if self.curve.has_phase else np.abs(self.fitted)
        return np.asarray(np.log(self.curve.values / fitted + 0j))


def identify(
    scene: Scene,
    data: MeasuredCurve,
    fit: Sequence[str] = DEFAULT_FIT,
    noise: str | None = None,
    origins: Mapping[str, str] | None = None,
) -> Identification:
    """Fit parameters of a scene to a measured curve with the transfer-matrix model.

    The scene's `drive.voltage` is the (peak) amplitude that the data belong to; `fit` is read by
    :func:`fit_parameter`.  `noise` is ``relative`` or ``constant``, by default the one under which
    the data are likelier; not used where they state their uncertainty.  Without `origins`, as
    :func:`validation.scene.load.load_scene` returns them, no assumptions are looked for.

    Raises InputError if a parameter or the data cannot be used, in one sentence.
    """
    curve = data.at(data.weight > 0.0)
    quantity = curve.quantity.name
    check_on_contact(scene, (quantity,))
    parameters = _parameters(scene.model_copy(update={"quantities": (quantity,)}), fit)
    least = max(_LEAST_POINTS, _PER_PARAMETER * len(parameters))
    if curve.frequencies.size < least:
        raise InputError(
            f"{curve.source} holds {curve.frequencies.size} points that count, too few to fit "
            f"{len(parameters)} parameters; give at least {least}, or fit fewer parameters"
        )
    at_data = scene.model_copy(update={"frequency": tuple(map(float, curve.frequencies))})
    warnings = list(load_warnings(at_data, (quantity,)))
    start = with_values(scene, {p.key: p.start for p in parameters})
    check_bimorph(start.device, start.support)
    model = CurveModel(start, quantity, curve.frequencies, [p.key for p in parameters])
    _check_effect(model, parameters, curve)
    scanned, best, values, edges = _best(model, curve, parameters, noise)
    misfit, now, sensitivity = best.misfit, model(values), model.sensitivities(values)
    residuals = misfit.residuals(now)
    free = [i for i, edge in enumerate(edges) if not edge]
    jacobian, stated = misfit.jacobian(now, sensitivity), misfit.noise == "stated"
    stats = statistics(jacobian[:, free], residuals, stated=stated)
    fitted_scene = model.scene_at(values)
    warnings += _doubts(misfit, stats, now, residuals) + _phase_hint(curve, scanned)
    warnings += _voltage_hint(best, scanned, float(np.sum(residuals**2)))
    estimates = _estimates(best, parameters, values, edges, stats)
    correlation = np.full((len(parameters), len(parameters)), np.nan)
    correlation[np.ix_(free, free)] = stats.correlation
    band = (stats.half_width(part[:, free]) for part in (sensitivity.real, sensitivity.imag))
    return Identification(
        scene=fitted_scene,
        start=start,
        curve=curve,
        estimates=estimates,
        correlation=correlation,
        singular_values=stats.singular_values,
        noise=misfit.noise,
        level=stats.level * misfit.unit_of_noise,
        freedom=stats.freedom,
        fitted=now,
        band=np.asarray(next(band) + 1j * next(band)),
        assumptions=_assumptions(fitted_scene, origins, best, now, jacobian[:, free], free),
        # two that only their product fixes may both have drifted to their bounds
        findings=findings(estimates, statistics(jacobian, residuals, stated=stated)),
        warnings=tuple(warnings),
    )


def _parameters(scene: Scene, fit: Sequence[str]) -> list[FitParameter]:
    parameters = [fit_parameter(scene, text) for text in fit]
    keys = [p.key for p in parameters]
    if not parameters:
        raise InputError("nothing is to be fitted; name a parameter, for example --fit c_s")
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"--fit names {key} twice; keep one of them")
        if idle(scene, key):
            raise InputError(
                f"--fit: {idle(scene, key)}, or name another parameter, such as --fit "
                "piezo.quality_factor"
            )
    return parameters


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
    for parameter, column in zip(parameters, model.sensitivities(start).T, strict=True):
        if not column.any():
            raise InputError(
                f"--fit {parameter.key}: it has no effect on the {curve.kind} of the "
                "transfer-matrix model; fit another parameter, or measure another curve"
            )


def _best(
    model: CurveModel, curve: MeasuredCurve, parameters: Sequence[FitParameter], noise: str | None
) -> tuple[Scan, Fit, Floats, list[str]]:
    """Fit under each kind of noise that is possible; the likeliest."""
    start, low, high = np.array([(p.start, p.low, p.high) for p in parameters]).T
    scanned = scan(model, start, low, high)
    kinds = ("stated",) if curve.error is not None else (noise,) if noise else NOISE
    fits = []
    for kind in kinds:
        fit = Fit(model, Misfit(curve, kind), low, high)
        values, edges = fit.best(scanned)
        residuals = fit.residuals(values)
        if np.sqrt(np.mean(residuals**2)) < _ROUNDING:  # exact: no noise to tell kinds apart by
            return scanned, fit, values, edges
        handicap = _CLEARLY if kind == "constant" else 0.0
        fits.append((fit.misfit.surprise(residuals) + handicap, fit, values, edges))
    return scanned, *min(fits, key=lambda entry: entry[0])[1:]


def _estimates(
    fit: Fit,
    parameters: Sequence[FitParameter],
    values: Floats,
    edges: Sequence[str],
    stats: Statistics,
) -> tuple[FittedParameter, ...]:
    """Estimates with linear intervals if all are narrow, else with profiled ones."""
    deviation = np.full(values.size, np.nan)
    deviation[[not edge for edge in edges]] = stats.deviation
    linear = stats.quantile * deviation
    narrow = not any(edges) and bool((linear < 0.5 * np.log(VAGUE)).all())
    rise = stats.quantile**2 * (1.0 if fit.misfit.noise == "stated" else stats.level**2)
    estimates = []
    for i, (parameter, edge) in enumerate(zip(parameters, edges, strict=True)):
        value = float(values[i])
        opened: tuple[str, ...] = ()
        if narrow:
            low, high = value / np.exp(linear[i]), value * np.exp(linear[i])
        else:
            low, high, opened = fit.profile(values, i, rise, float(linear[i]))
        if value < 0.0:  # the fit's bounds go by magnitude
            low, high, opened = high, low, tuple(_OPPOSITE[end] for end in opened)
            edge = _OPPOSITE.get(edge, "")
        estimates.append(FittedParameter(parameter, value, (float(low), float(high)), opened, edge))
    return tuple(estimates)


def _assumptions(
    scene: Scene,
    origins: Mapping[str, str] | None,
    fit: Fit,
    now: Complex,
    jacobian: Floats,
    free: list[int],
) -> tuple[Assumption, ...]:
    """Sensitivity of the estimates to assumed parameters: −J⁺ ∂r/∂ln q at the optimum.

    This is implicit differentiation of the normal equations with the residuals' second
    derivatives left out, as in the covariance.  What the data do not separate shares a change
    alike.
    """
    if origins is None:
        return ()
    model = fit.model
    rows = [
        row
        for row in parameter_rows(scene, dict(origins))
        if row.assumed
        and row.key not in model.keys
        and isinstance(value := value_of(scene, row.key), float)
        and value != 0.0
        and not idle(scene, row.key)
    ]
    keys = [row.key for row in rows]
    values = np.array([value_of(scene, key) for key in keys], dtype=float)
    varied = replace(model, scene=scene, keys=keys)
    shifts = fit.misfit.jacobian(now, varied.sensitivities(values))
    slopes = np.full((len(model.keys), len(keys)), np.nan)
    slopes[free] = -np.linalg.lstsq(jacobian, shifts, rcond=RANK)[0]
    acting = [
        Assumption(row, tuple(map(float, slope)))
        for row, slope, shift in zip(rows, slopes.T, shifts.T, strict=True)
        if shift.any()
    ]
    return tuple(sorted(acting, key=lambda a: -np.nanmax(np.abs([*a.slopes, 0.0]))))


def _doubts(misfit: Misfit, stats: Statistics, now: Complex, residuals: Floats) -> list[str]:
    """Reasons to doubt that the model describes the data."""
    from scipy.special import chdtr

    curve = misfit.curve
    data, fitted = np.abs(curve.values), np.abs(now)
    distance = curve.values - now if curve.has_phase else data - fitted
    unexplained = float(np.sqrt(np.sum(np.abs(distance) ** 2) / np.sum(data**2)))
    doubts = []
    if unexplained > _UNEXPLAINED:
        doubts.append(
            f"the fitted curve leaves {100 * unexplained:.0f} % of the {curve.kind} unexplained "
            f"(measured over fitted magnitude, median {float(np.median(data / fitted)):.3g}); "
            "check the units, that drive.voltage is the amplitude of the measurement, and the "
            "scene's dimensions"
        )
    # of independent residuals 0 ± 1/√n; real parts, then imaginary ones
    pieces = residuals.reshape(2 if curve.has_phase else 1, -1)
    alike = float(np.sum(pieces[:, 1:] * pieces[:, :-1])) / max(np.sum(pieces**2), _TINY)
    if alike > 4.0 / np.sqrt(residuals.size) and unexplained > _ROUNDING:
        doubts.append(
            f"neighbouring residuals are alike (correlation {alike:+.2f}), so the model is off by "
            "more than noise and the true intervals are wider than those stated"
        )
    chance = float(chdtr(stats.freedom, stats.freedom * stats.level**2))
    if misfit.noise == "stated" and not 5e-4 < chance < 1.0 - 5e-4:
        doubts.append(
            f"the residuals are {stats.level:.3g} times the stated uncertainty (chi2 per degree "
            f"of freedom {stats.level**2:.3g} where 1 is expected); the intervals take the "
            "uncertainty as stated, so correct it or multiply them by that number"
        )
    return doubts


def _phase_hint(curve: MeasuredCurve, scanned: Scan) -> list[str]:
    """Hint at another sign convention of the data that would fit far better."""
    if not curve.has_phase:
        return []
    data = curve.values[scanned.points]

    def cost(values: Numbers) -> float:
        return float(np.min(np.sum(np.abs(np.log(scanned.curves / values)) ** 2, axis=1)))

    hints = {
        "the opposite sign (turn the phase by 180°)": cost(-data),
        "the opposite sign of the phase (the time factor here is exp(+j omega t))": cost(
            data.conj()
        ),
        "both signs opposite (of the values and of the phase)": cost(-data.conj()),
    }
    name = min(hints, key=lambda name: hints[name])
    if hints[name] >= _FAR_BETTER * cost(data):
        return []
    return [f"the data would fit far better with {name}; check how the phase was recorded"]


def _voltage_hint(fit: Fit, scanned: Scan, left: float) -> list[str]:
    """Hint at another drive voltage, a constant factor, with which the data would fit far better.

    `left` is the sum of squares that the fit leaves.  The voltage is fitted beside the parameters,
    from the node of the grid at which measured over computed varies least.
    """
    model, curve, stated = fit.model, fit.misfit.curve, fit.model.scene.drive.voltage
    if _VOLTAGE in model.keys or left < curve.frequencies.size * _ROUNDING**2:
        return []
    ratios = np.log(np.abs(curve.values[scanned.points] / scanned.curves))
    node = int(np.argmin(np.var(ratios, axis=1)))
    first = np.append(scanned.nodes[node], stated * np.exp(np.mean(ratios[node])))
    wider = Fit(
        replace(model, keys=(*model.keys, _VOLTAGE)), fit.misfit,
        np.append(fit.low, stated / _ANY), np.append(fit.high, stated * _ANY),
    )  # fmt: skip
    if not wider.model.sensitivities(first)[:, -1].any():  # an admittance
        return []
    cost, values = wider.descend(first, list(range(first.size)), most=100)
    if cost >= _FAR_BETTER * left:
        return []
    hint = (
        f"measured over computed is {values[-1] / stated:.4g} at every frequency, if {_VOLTAGE} is "
        f"fitted too: the root mean square misfit is then {np.sqrt(cost / left):.2g} times this "
        f"one; set {_VOLTAGE} = {values[-1]:.4g} V (the peak value), or check the gain and the "
        "unit of the measurement"
    )
    return [hint]
