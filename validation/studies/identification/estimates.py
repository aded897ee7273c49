"""What a fit of parameters to a measured curve found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.identification.fit_parameters import FitParameter
from tactgen.validation.studies.identification.fit_quality import Assumption
from tactgen.validation.studies.identification.measured_curve import MeasuredCurve


@dataclass(frozen=True)
class FittedParameter:
    """One fitted parameter, SI units.

    Attributes
    ----------
    parameter : FitParameter
        What was fitted, from where, within which bounds.
    value : float
        At the optimum.
    interval : (float, float)
        95 % confidence interval.
    opened : tuple of str
        ``low``, ``high``: ends of the interval that are only bounds of the search.
    edge : str
        ``low`` or ``high`` if the value itself is at that bound.
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


@dataclass(frozen=True)
class Identification:
    """A fit and what it tells.

    Attributes
    ----------
    scene, start : Scene
        With the fitted values, and with those that the fit started from.
    curve : MeasuredCurve
        The data that counted.
    estimates : tuple of FittedParameter
        In the order asked for.
    correlation : (p, p) array
        Between ln of the estimates; nan for those at a bound.
    singular_values : (p',) array
        Of the scaled Jacobian over those not at a bound, descending.
    noise : str
        ``relative``, ``constant`` or ``stated``: how residuals were counted.
    level : float
        Estimated noise: a fraction, an amount in the curve's SI unit, or √(χ²/freedom).
    freedom : int
        Residuals less free parameters.
    fitted : (n,) complex array
        The fitted curve at the data's frequencies.
    band : (n,) complex array
        Half width of the fitted curve's 95 % band: of ln|curve| and, imaginary, of its phase.
    assumptions : tuple of Assumption
        What the estimates rest on, strongest first.
    findings : tuple of str
        What the curve does not determine, in words.
    warnings : tuple of str
        Reasons to doubt the fit.
    """

    scene: Scene
    start: Scene
    curve: MeasuredCurve
    estimates: tuple[FittedParameter, ...]
    correlation: Floats
    singular_values: Floats
    noise: str
    level: float
    freedom: int
    fitted: Complex
    band: Complex
    assumptions: tuple[Assumption, ...]
    findings: tuple[str, ...]
    warnings: tuple[str, ...]

    def get(self, name: str) -> FittedParameter:
        """Return the estimate of a symbol or scene key."""
        return next(e for e in self.estimates if name in (e.parameter.key, e.parameter.symbol))

    @property
    def residuals(self) -> Complex:
        """ln(data / fitted), shape (n,): the misfit's fraction and, imaginary, its phase."""
        fitted = self.fitted if self.curve.has_phase else np.abs(self.fitted)
        return np.asarray(np.log(self.curve.values / fitted + 0j))
