"""Least squares over the logarithms of parameters: the transfer-matrix model to one curve.

A resonance curve has many local minima, since two peaks that do not overlap look alike to
a least-squares step.  So a coarse grid over the support's stiffness and damping comes
first, and its best nodes are where the descents begin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints, Numbers
from tactgen.validation.studies.identification.curve_model import CurveModel, sensitivities
from tactgen.validation.studies.identification.fit_parameters import FitParameter
from tactgen.validation.studies.identification.measured_curve import MeasuredCurve

#: Grid of the scan: ratio between neighbouring nodes, and points of the curve it looks at.
_RATIOS = {"support.rotational_stiffness": 2.0, "support.rotational_damping": 10.0}
_OTHER_RATIO = 2.0
_MOST_NODES = 60
_SCAN_POINTS = 64
#: Nodes of the grid from which descents begin, besides the start that the user gives.
_DESCENTS = 2
#: A value within this distance (in ln p) of a bound, and pushed towards it, is at the bound.
_AT_BOUND = 1e-2


@dataclass(frozen=True)
class Misfit:
    """How the distance between curve and data is counted.

    Attributes
    ----------
    curve : MeasuredCurve
        Points that count only.
    noise : str
        ``relative``: every point is uncertain by the same fraction; the residual is
        ln(model/data), real part and (with a phase) imaginary part.  ``constant``: by the
        same amount; the residual is the difference.  ``stated``: by its own uncertainty.
        For the first two the variance goes as 1/weight, the weights' mean taken as 1.
    """

    curve: MeasuredCurve
    noise: str

    @property
    def scale(self) -> Floats:
        """Factor (n,) that turns residuals into ones of equal variance."""
        if self.noise == "stated":
            assert self.curve.error is not None
            return np.asarray(1.0 / self.curve.error)
        weight = np.sqrt(self.curve.relative_weight)
        return weight if self.noise == "relative" else np.asarray(weight / self.unit_of_noise)

    @property
    def unit_of_noise(self) -> float:
        """What a residual of 1 means: a fraction, an amount (SI), or one standard deviation."""
        if self.noise == "constant":
            return float(np.median(np.abs(self.curve.values)))
        return 1.0

    def residuals(self, model: Complex) -> Floats:
        """Return the residuals (n,) of a magnitude, (2n,) of a complex curve."""
        data = self.curve.values
        if self.noise == "relative":
            distance = np.log(model / data) if self.curve.has_phase else np.log(abs(model) / data)
        else:
            distance = model - data if self.curve.has_phase else np.abs(model) - data
        return self._split(distance * self.scale)

    def jacobian(self, model: Complex, sensitivity: Complex) -> Floats:
        """Return the residuals' derivatives by ln p from those of ln(curve), (n, p) complex."""
        if self.noise == "relative":
            change: Numbers = sensitivity
        elif self.curve.has_phase:
            change = model[:, None] * sensitivity
        else:
            change = np.abs(model)[:, None] * sensitivity.real
        return self._split(change * self.scale[:, None])

    def _split(self, values: Numbers) -> Floats:
        if self.curve.has_phase:
            return np.concatenate([values.real, values.imag])
        return np.asarray(values.real)

    def surprise(self, residuals: Floats) -> float:
        """Return −ln(likelihood) up to a constant, the noise level estimated.

        Comparable between ``relative`` and ``constant``: densities are those of the data.
        """
        size = np.abs(self.curve.values)
        unit = size if self.noise == "relative" else np.full(size.shape, self.unit_of_noise)
        parts = 2 if self.curve.has_phase else 1
        mean_square = max(float(np.mean(residuals**2)), np.finfo(float).tiny)
        return float(0.5 * residuals.size * np.log(mean_square) + parts * np.log(unit).sum())


@dataclass(frozen=True)
class Scan:
    """Modelled curves on a grid of parameter values.

    Attributes
    ----------
    points : (m,) int array
        Positions of the curve's points that were looked at.
    nodes : (k, p) array
        Values of all fitted parameters at each node, SI.
    curves : (k, m) complex array
        The curve at each node.
    """

    points: Ints
    nodes: Floats
    curves: Complex


def scan(model: CurveModel, parameters: Sequence[FitParameter]) -> Scan:
    """Evaluate the curve on a grid over two parameters, the others at their starts.

    Support stiffness and damping come first, since they place and shape the peak.
    """
    first = sorted(range(len(parameters)), key=lambda i: parameters[i].key not in _RATIOS)[:2]
    axes = [_axis(parameters[i]) for i in first]
    grid = np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")], axis=1)
    nodes = np.tile([p.start for p in parameters], (len(grid) + 1, 1))
    nodes[1:, first] = grid  # the first node is the start itself
    coarse, points = model.thinned(_SCAN_POINTS)
    return Scan(points, nodes, np.stack([coarse(node) for node in nodes]))


def _axis(parameter: FitParameter) -> Floats:
    span = np.log(parameter.high / parameter.low)
    count = 1 + int(np.ceil(span / np.log(_RATIOS.get(parameter.key, _OTHER_RATIO))))
    return np.geomspace(parameter.low, parameter.high, min(max(count, 3), _MOST_NODES))


def descend(
    model: CurveModel, misfit: Misfit, parameters: Sequence[FitParameter], found: Scan
) -> tuple[Floats, list[str]]:
    """Return the best values (p,) and for each ``""``, ``"low"`` or ``"high"`` if at a bound."""
    thin = replace(misfit, curve=misfit.curve.at(found.points))
    costs = np.array([np.sum(thin.residuals(c) ** 2) for c in found.curves])
    free = list(range(len(parameters)))
    tries = [
        least_squares(model, misfit, parameters, found.nodes[start], free, most=20, tolerance=1e-3)
        for start in _starts(costs, found.nodes)
    ]
    best = min(tries, key=lambda entry: entry[0])[1]
    edges = [""] * len(parameters)
    while free:
        _, best = least_squares(model, misfit, parameters, best, free, most=300)
        stuck = _at_bounds(model, misfit, parameters, best, free)
        for i, edge in stuck.items():
            edges[i] = edge
            best[i] = getattr(parameters[i], edge)
        free = [i for i in free if i not in stuck]
        if not stuck:
            break
    return best, edges


def _starts(costs: Floats, nodes: Floats) -> list[int]:
    """Return the start itself and the best nodes of the grid, far enough from each other."""
    picked: list[int] = []
    logs = np.log(np.abs(nodes))
    for i in np.argsort(costs):
        if np.isfinite(costs[i]) and all(
            np.abs(logs[i] - logs[j]).max() > np.log(2.0) for j in picked
        ):
            picked.append(int(i))
        if len(picked) == _DESCENTS:
            break
    return [0, *(i for i in picked if i)]


def least_squares(
    model: CurveModel,
    misfit: Misfit,
    parameters: Sequence[FitParameter],
    start: Floats,
    free: list[int],
    most: int,
    tolerance: float = 1e-13,
) -> tuple[float, Floats]:
    """Return the cost and the values after a descent over the free ones' logarithms.

    It ends after `most` steps, or when the cost changes by no more than the tolerance.
    """
    from scipy import optimize

    sign = np.sign(start)

    def values(logs: Floats) -> Floats:
        full = start.copy()
        full[free] = sign[free] * np.exp(logs)
        return full

    def jacobian(logs: Floats) -> Floats:
        now = values(logs)
        return misfit.jacobian(model(now), sensitivities(model, now)[:, free])

    low, high = (
        np.array([np.log(abs(getattr(parameters[i], edge))) for i in free])
        for edge in ("low", "high")
    )
    inside = 1e-6 * (high - low)
    found = optimize.least_squares(
        lambda logs: misfit.residuals(model(values(logs))),
        np.clip(np.log(np.abs(start[free])), low + inside, high - inside),
        jac=jacobian,
        bounds=(low, high),
        x_scale="jac",
        ftol=tolerance,
        xtol=1e-11,
        gtol=1e-14,
        max_nfev=most,
    )
    return float(found.cost), values(found.x)


def _at_bounds(
    model: CurveModel,
    misfit: Misfit,
    parameters: Sequence[FitParameter],
    values: Floats,
    free: list[int],
) -> dict[int, str]:
    """Return which free values lie at a bound that the data push them against."""
    now = model(values)
    slope = misfit.jacobian(now, sensitivities(model, values)).T @ misfit.residuals(now)
    stuck = {}
    for i in free:
        for edge, outward in (("low", 1.0), ("high", -1.0)):
            distance = abs(np.log(values[i] / getattr(parameters[i], edge)))
            if distance < _AT_BOUND and outward * slope[i] > 0.0:
                stuck[i] = edge
    return stuck
