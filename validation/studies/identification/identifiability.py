"""What a fit tells about its parameters: intervals, correlations, what cannot be told apart.

Linear statistics over ln p at the optimum: with J the residuals' derivatives and s² their
variance, cov(ln p) = s² (JᵀJ)⁻¹.  Intervals over ln p are positive and asymmetric in p.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats

#: Probability that an interval is made for.
CONFIDENCE = 0.95
#: Beyond this correlation two parameters cannot be told apart by the data.
INSEPARABLE = 0.99
#: A parameter whose interval spans more than this factor is not determined by the data.
VAGUE = 2.0
#: Intervals narrower than this (of ln p) are those of an exact curve.
_EXACT = 1e-9
#: Singular values below this fraction of the largest are rounding of the derivatives.
RANK = 1e-9


@dataclass(frozen=True)
class Statistics:
    """Linear statistics of the free parameters, over ln p.

    Attributes
    ----------
    root : (p, p) array
        rootᵀ root is the covariance of ln p.
    quantile : float
        Half width of an interval in standard deviations (Student's t, or the normal
        distribution where the noise is stated).
    singular_values : (p,) array
        Of J/s, descending: 1/σ of the best and worst determined combinations of ln p.
    level : float
        Root mean square of the residuals, degrees of freedom accounted for.
    freedom : int
        Residuals less parameters.
    """

    root: Floats
    quantile: float
    singular_values: Floats
    level: float
    freedom: int

    @property
    def covariance(self) -> Floats:
        """Covariance (p, p) of ln p."""
        return np.asarray(self.root.T @ self.root)

    @property
    def deviation(self) -> Floats:
        """Standard deviation (p,) of ln p."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def correlation(self) -> Floats:
        """Correlations (p, p)."""
        deviation = self.deviation
        return np.asarray(self.covariance / np.outer(deviation, deviation))


def statistics(jacobian: Floats, residuals: Floats, *, stated: bool) -> Statistics:
    """Return the statistics of a fit.

    Parameters
    ----------
    jacobian : (n, p) array
        Residuals by ln p.
    residuals : (n,) array
        At the optimum.
    stated : bool
        Whether the residuals are in units of a stated standard deviation; otherwise
        their variance is estimated from them.
    """
    from scipy.special import ndtri, stdtrit

    freedom = residuals.size - jacobian.shape[1]  # all parameters may be at bounds
    level = float(np.sqrt(np.sum(residuals**2) / freedom))
    # an exact curve would have a variance of 0 and no correlations
    deviation = 1.0 if stated else max(level, np.finfo(float).eps)
    _, values, right = np.linalg.svd(jacobian / deviation, full_matrices=False)
    kept = np.maximum(values, RANK * values.max(initial=0.0))
    tail = 0.5 * (1.0 + CONFIDENCE)
    quantile = float(ndtri(tail) if stated else stdtrit(freedom, tail))
    return Statistics(right / kept[:, None], quantile, values, level, freedom)


def inseparable(names: Sequence[str], found: Statistics, known: Floats) -> list[str]:
    """Say which parameters the data do not tell apart, and what they determine instead.

    `known` (p,) is the half width of each one's interval of ln p.
    """
    sentences = [
        _inseparable(names, found, known, j, i)
        for i in range(len(names))
        for j in range(i)
        if abs(found.correlation[i, j]) > INSEPARABLE
    ]
    return [sentence for sentence in sentences if sentence]


def vague(name: str, ends: tuple[str, str], opened: Sequence[str], span: float) -> str:
    """Say that the data do not determine a parameter, or nothing if they do.

    `ends` are those of its interval as text, `opened` which of them are only bounds of
    the search, `span` their ratio.
    """
    low, high = ends
    if len(opened) == 2:
        told = f"the curve tells nothing about {name} between its bounds {low} and {high}"
    elif opened:
        limit = f"below {high}" if opened[0] == "low" else f"above {low}"
        told = f"{name} is not determined by this curve, which says only that it is {limit}"
    elif span > VAGUE:
        told = (
            f"{name} is practically not determined by this curve: its {100 * CONFIDENCE:g} % "
            f"interval spans a factor of {_factor(span)}"
        )
    else:
        return ""
    return f"{told}; hold it at a known value, or measure at frequencies where it acts"


def _inseparable(names: Sequence[str], found: Statistics, known: Floats, i: int, j: int) -> str:
    """Name the product of powers of two parameters that the data fix, and how well.

    Nothing is said if they fix none: then neither parameter is determined.
    """
    powers = np.linalg.svd(found.root[:, [i, j]])[2][1]  # the direction of least variance
    if abs(powers[1]) > 5.0 * abs(powers[0]):
        i, j, powers = j, i, powers[::-1]
    powers = powers / powers[0]
    fixed = float(found.quantile * np.linalg.norm(found.root[:, [i, j]] @ powers))
    if fixed > np.log(VAGUE):
        return ""
    told = f"(correlation {found.correlation[i, j]:+.4f})"
    if abs(powers[1]) < 0.1:
        return (
            f"{names[i]} rests on {names[j]} {told}: for a known {names[j]} the curve fixes "
            f"{names[i]} {_spread(fixed)}, else only {_spread(known[i])}"
        )
    exponent = f"{abs(powers[1]):.3g}"
    second = names[j] if exponent == "1" else f"{names[j]}^{exponent}"
    combination = f"{names[i]} {'/' if powers[1] < 0.0 else '*'} {second}"
    if max(known[i], known[j]) < _EXACT:
        return (
            f"{names[i]} and {names[j]} are told apart only because this curve has no noise "
            f"{told}: with noise it fixes {combination}"
        )
    return (
        f"{names[i]} and {names[j]} cannot be told apart {told}: the curve fixes {combination} "
        f"{_spread(fixed)}, but {names[i]} alone only {_spread(known[i])} and {names[j]} "
        f"{_spread(known[j])}"
    )


def _spread(half_width: float) -> str:
    """Return how well something is known, from the half width of the interval of its ln."""
    if half_width < _EXACT:
        return "to rounding"
    if half_width < 0.2:
        return f"to ±{100.0 * half_width:.2g} %"
    return f"within a factor of {_factor(np.exp(min(half_width, 300.0)))}"


def _factor(value: float) -> str:
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}" if value < 1000.0 else "over 1000"


def neighbours_alike(residuals: Floats, parts: int) -> float | None:
    """Return the correlation of neighbouring residuals if noise alone would hardly give it.

    `parts` equal pieces (real, imaginary) follow each other.  Independent residuals have
    a correlation of 0 ± 1/√n; four times that is taken as proof.
    """
    pieces = residuals.reshape(parts, -1)
    square = float(np.sum(pieces**2))
    if square == 0.0:
        return None
    alike = float(np.sum(pieces[:, 1:] * pieces[:, :-1])) / square
    return alike if alike > 4.0 / np.sqrt(residuals.size) else None


def unlikely_scatter(found: Statistics) -> bool:
    """Whether residuals in units of a stated uncertainty have a χ² beyond 99.9 % of chances."""
    from scipy.special import chdtr

    probability = float(chdtr(found.freedom, found.freedom * found.level**2))
    return not 5e-4 < probability < 1.0 - 5e-4
