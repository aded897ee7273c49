"""Least squares of the transfer-matrix model to one curve, over logarithms of parameters.

A resonance curve has many local minima, since two peaks that do not overlap look alike to
a least-squares step.  So a coarse grid over the support's stiffness and damping comes
first, and its best nodes are where the descents begin.

Statistics are linear over ln p at the optimum: with J the residuals' derivatives and s² their
variance, cov(ln p) = s² (JᵀJ)⁻¹.  A parameter that the curve hardly determines bends the sum of
squares far from a parabola, or leaves it flat up to a bound; its interval is then that of the
profile likelihood (Bates and Watts, Nonlinear Regression Analysis and Its Applications, 1988,
chapter 6).  lmfit's `conf_interval` stops short of open ends and fails on exact data, so the
profile is our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints, Numbers
from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.ports.multiport import Multiport, wired
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.catalogue.quantities import QUANTITIES, AnswerReadout
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.model import Refined
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import with_values
from tactgen.validation.studies.measured_data import MeasuredCurve

#: Probability that an interval is made for.
CONFIDENCE = 0.95
#: Singular values below this fraction of the largest are rounding of the derivatives.
RANK = 1e-9
#: What the bimorph is made of.  All else acts through its ports' terminations.
_DIVIDED = ("bimorph.", "piezo.", "shim.", "glue.", "beam.", "rod.")
#: Step in ln p for sensitivities: truncation and rounding are then both below 1e-6.
_STEP = 1e-4
#: Grid of the scan: ratio between neighbouring nodes, most nodes of an axis, points of the curve.
_RATIOS = {"support.rotational_stiffness": 2.0, "support.rotational_damping": 10.0}
_OTHER_RATIO, _MOST_NODES, _SCAN_POINTS = 2.0, 60, 64
#: The same of one parameter alone, and the nodes looked at between two of these before a descent
#: begins: a length moves a sharp peak by its width over a thousandth of itself.
_ALONE_RATIO, _MOST_ALONE, _BETWEEN = 1.02, 600, 41
#: Nodes of the grid from which descents begin, besides the start that the user gives.
_DESCENTS = 2
#: A value within this distance (in ln p) of a bound, and pushed towards it, is at the bound.
_AT_BOUND = 1e-2
#: Ends of a profile: share of their distance from the optimum (in ln p), and of a refit's sum of
#: squares; an interval's end adds some 4/n to that.
_END_TOLERANCE, _COST_TOLERANCE = 1e-2, 1e-6
#: First step of a profile where the linear one is no guide (in ln p).
_LEAST_STEP, _LARGEST_STEP = 1e-3, 1.0


@dataclass(frozen=True)
class CurveModel:
    """A curve of the transfer-matrix model as a function of some scene keys.

    It goes past the machinery of stages and errors that a single answer goes through.  A curve
    of the machine is that model on its rod, coil and contact in small motions.
    """

    scene: Scene
    quantity: str
    frequencies: Floats
    keys: Sequence[str]

    def scene_at(self, values: Floats) -> Scene:
        """Scene with values (p,) in SI units."""
        return with_values(self.scene, dict(zip(self.keys, map(float, values), strict=True)))

    def __call__(self, values: Floats) -> Complex:
        """Curve (n,) for values (p,) in SI units."""
        scene = self.scene_at(values)
        divided = any(key.startswith(_DIVIDED) for key in self.keys)
        port = self._port(scene) if divided else self._same_port
        row = QUANTITIES[self.quantity]
        if isinstance(row.read, AnswerReadout):
            return _of_machine(scene, port, row.read)
        mounted = attach(wired(port, scene.bimorph.wiring), scene.ends)
        return row.port_readout.read(mounted, scene.drive.voltage)

    def _port(self, scene: Scene) -> Multiport:
        return multiport(scene.device, scene.support, scene.beam, self.frequencies)

    @cached_property
    def _same_port(self) -> Multiport:
        """D(Ω) where none of the keys changes it."""
        return self._port(self.scene)

    def sensitivities(self, values: Floats) -> Complex:
        """∂ ln(curve) / ∂ ln(parameter), shape (n, p), by central differences."""
        columns = []
        for i in range(values.size):
            up, down = values.copy(), values.copy()
            up[i] *= np.exp(_STEP)
            down[i] *= np.exp(-_STEP)
            above, below = self(up), self(down)
            # of the ratio's logarithm, and 0 to the last bit where there is no effect
            columns.append((above - below) / (above + below) / _STEP)
        return np.stack(columns, axis=1)


def _of_machine(scene: Scene, port: Multiport, read: AnswerReadout) -> Complex:
    from tactgen.validation.models.small_signal import RodWithError, SmallSignal, rod_of

    rod = RodWithError(rod_of(scene, map_of(scene)))
    value: Complex = read.of(SmallSignal(scene, Refined(port, (), ""), rod)).value
    return value


@dataclass(frozen=True)
class Misfit:
    """Misfit between curve and data."""

    curve: MeasuredCurve  #: Points that count only
    #: ``relative``: every point is uncertain by the same fraction; the residual is ln(model/data),
    #: real part and (with a phase) imaginary part.  ``constant``: by the same amount; the residual
    #: is the difference.  ``stated``: by its own uncertainty. For the first two the variance goes
    #: as 1/weight, the weights' mean taken as 1.
    noise: str

    @property
    def scale(self) -> Floats:
        """Factor (n,) that turns residuals into ones of equal variance."""
        if self.noise == "stated":
            assert self.curve.error is not None
            return np.asarray(1.0 / self.curve.error)
        weight = self.curve.weight / self.curve.weight.mean()
        return np.asarray(np.sqrt(weight) / self.unit_of_noise)

    @property
    def unit_of_noise(self) -> float:
        """Meaning of a residual of 1: a fraction, an amount (SI), or a deviation."""
        return float(np.median(np.abs(self.curve.values))) if self.noise == "constant" else 1.0

    def residuals(self, model: Complex) -> Floats:
        """Residuals (n,) of a magnitude, (2n,) of a complex curve."""
        data = self.curve.values
        shape: Numbers = model if self.curve.has_phase else np.abs(model)
        distance = np.log(shape / data) if self.noise == "relative" else shape - data
        return self._split(distance * self.scale)

    def jacobian(self, model: Complex, sensitivity: Complex) -> Floats:
        """Residuals' derivatives by ln p from those of ln(curve), (n, p) complex."""
        change: Numbers = sensitivity
        if self.noise != "relative":
            phase = self.curve.has_phase
            change = model[:, None] * change if phase else np.abs(model)[:, None] * change.real
        return self._split(change * self.scale[:, None])

    def _split(self, values: Numbers) -> Floats:
        if self.curve.has_phase:
            return np.concatenate([values.real, values.imag])
        return np.asarray(values.real)

    def surprise(self, residuals: Floats) -> float:
        """−ln(likelihood) up to a constant, the noise level estimated.

        Comparable between ``relative`` and ``constant``: densities are those of the data.
        """
        size = np.abs(self.curve.values)
        unit = size if self.noise == "relative" else np.full(size.shape, self.unit_of_noise)
        parts = 2 if self.curve.has_phase else 1
        mean_square = max(float(np.mean(residuals**2)), np.finfo(float).tiny)
        return float(0.5 * residuals.size * np.log(mean_square) + parts * np.log(unit).sum())


class Scan(NamedTuple):
    """Modelled curves on a grid: positions (m,) of points, nodes (k, p) in SI, curves (k, m)."""

    points: Ints
    nodes: Floats
    curves: Complex


def scan(model: CurveModel, start: Floats, low: Floats, high: Floats) -> Scan:
    """Evaluate the curve on a grid over two parameters, the others at their starts (p,).

    Support stiffness and damping come first, since they place and shape the peak.
    """
    first = sorted(range(start.size), key=lambda i: model.keys[i] not in _RATIOS)[:2]
    axes = []
    for i in first:
        ratio, most = _RATIOS.get(model.keys[i], _OTHER_RATIO), _MOST_NODES
        if start.size == 1:
            ratio, most = _ALONE_RATIO, _MOST_ALONE
        count = 1 + int(np.ceil(np.log(high[i] / low[i]) / np.log(ratio)))
        axes.append(np.geomspace(low[i], high[i], min(max(count, 3), most)))
    grid = np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")], axis=1)
    nodes = np.tile(start, (len(grid) + 1, 1))
    nodes[1:, first] = grid  # the first node is the start itself
    f = model.frequencies
    points = np.unique(np.linspace(0, f.size - 1, min(f.size, _SCAN_POINTS)).round().astype(int))
    coarse = replace(model, frequencies=f[points])
    return Scan(points, nodes, np.stack([coarse(node) for node in nodes]))


def starts(costs: Floats, nodes: Floats) -> list[int]:
    """Start itself and the best nodes of the grid, far enough from each other."""
    picked: list[int] = []
    logs = np.log(np.abs(nodes))
    for i in np.argsort(costs):
        apart = all(np.abs(logs[i] - logs[j]).max() > np.log(2.0) for j in picked)
        if np.isfinite(costs[i]) and apart:
            picked.append(int(i))
        if len(picked) == _DESCENTS:
            break
    return [0, *(i for i in picked if i)]


@dataclass(frozen=True)
class Fit:
    """A model against a measured curve; bounds (p,) are signed, with ``|low| < |high|``."""

    model: CurveModel
    misfit: Misfit
    low: Floats
    high: Floats

    def residuals(self, values: Floats) -> Floats:
        """Residuals (n,) or (2n,)."""
        return self.misfit.residuals(self.model(values))

    def jacobian(self, values: Floats) -> Floats:
        """Residuals' derivatives by ln p."""
        return self.misfit.jacobian(self.model(values), self.model.sensitivities(values))

    def descend(
        self, start: Floats, free: list[int], most: int, tolerance: float = 1e-13
    ) -> tuple[float, Floats]:
        """Sum of squares and values (p,) after a descent over the free ones' logarithms.

        It ends after `most` steps, or when the sum changes by no more than the tolerance.
        """
        from scipy import optimize

        def values(logs: Floats) -> Floats:
            full = start.copy()
            full[free] = np.sign(start[free]) * np.exp(logs)
            return full

        low, high = np.log(np.abs(self.low[free])), np.log(np.abs(self.high[free]))
        inside = 1e-6 * (high - low)
        end = optimize.least_squares(
            lambda logs: self.residuals(values(logs)),
            np.clip(np.log(np.abs(start[free])), low + inside, high - inside),
            jac=lambda logs: self.jacobian(values(logs))[:, free],
            bounds=(low, high),
            x_scale="jac",
            ftol=tolerance,
            xtol=1e-11,
            gtol=1e-14,
            max_nfev=most,
        )
        return 2.0 * float(end.cost), values(end.x)

    def best(self, scanned: Scan) -> tuple[Floats, list[str]]:
        """Best values (p,) and which bound each is at, if any."""
        thin = replace(self.misfit, curve=self.misfit.curve.at(scanned.points))
        costs = np.array([np.sum(thin.residuals(c) ** 2) for c in scanned.curves])
        free = list(range(self.low.size))
        tries = [
            self.descend(self._nearby(scanned.nodes[start]), free, most=20, tolerance=1e-3)
            for start in starts(costs, scanned.nodes)
        ]
        values = min(tries, key=lambda entry: entry[0])[1]
        edges = [""] * self.low.size
        while free:
            _, values = self.descend(values, free, most=300)
            stuck = self.at_bounds(values, free)
            for i, edge in stuck.items():
                edges[i], values[i] = edge, (self.low if edge == "low" else self.high)[i]
            free = [i for i in free if i not in stuck]
            if not stuck:
                break
        return values, edges

    def _nearby(self, start: Floats) -> Floats:
        """Start of a descent: of one parameter the best value between neighbouring nodes."""
        if start.size > 1:
            return start
        near = start * np.geomspace(1.0 / _ALONE_RATIO, _ALONE_RATIO, _BETWEEN)
        near = near[(np.abs(near) >= np.abs(self.low)) & (np.abs(near) <= np.abs(self.high))]
        costs = np.array([np.sum(self.residuals(np.array([value])) ** 2) for value in near])
        if not np.isfinite(costs).any():
            return start
        return near[[int(np.nanargmin(costs))]]

    def at_bounds(self, values: Floats, free: list[int]) -> dict[int, str]:
        """Free values at a bound that the data push them against."""
        slope = self.jacobian(values).T @ self.residuals(values)
        return {
            i: edge
            for i in free
            for edge, bound, outward in (("low", self.low, 1.0), ("high", self.high, -1.0))
            if abs(np.log(values[i] / bound[i])) < _AT_BOUND and outward * slope[i] > 0.0
        }

    def profile(
        self, best: Floats, index: int, rise: float, guess: float
    ) -> tuple[float, float, tuple[str, ...]]:
        """Ends of a parameter's interval, and which of them are only its bounds.

        An end is where the sum of squares, the other parameters refitted, has risen by `rise`
        from that of the `best` values (p,); `guess` is its distance in ln p, maybe nan.
        """
        step = float(np.clip(guess, _LEAST_STEP, _LARGEST_STEP)) if np.isfinite(guess) else 1.0
        ends, opened = [], []
        for edge, bound, direction in (("low", self.low, -1.0), ("high", self.high, 1.0)):
            room = abs(float(np.log(best[index] / bound[index])))
            distance = None  # at the bound there is no room
            if room > 0.0:
                distance = self._crossing(best, index, direction, rise, min(step, room), room)
            if distance is None:
                opened.append(edge)
                ends.append(float(bound[index]))
            else:
                ends.append(float(best[index] * np.exp(direction * distance)))
        return ends[0], ends[1], tuple(opened)

    def _crossing(
        self, best: Floats, index: int, direction: float, rise: float, outer: float, room: float
    ) -> float | None:
        """Distance (ln p) at which the sum of squares has risen, None if nowhere."""
        from scipy.optimize import brentq

        others = [i for i in range(best.size) if i != index]
        least = float(np.sum(self.residuals(best) ** 2))
        latest = best.copy()  # each refit begins where the last one ended
        # at the optimum and at one place twice no refit: it could end lower and hide a crossing
        excess = {0.0: -rise}

        def above(distance: float) -> float:
            nonlocal latest
            if distance not in excess:
                at = latest.copy()
                at[index] = best[index] * np.exp(direction * distance)
                if others:
                    cost, latest = self.descend(at, others, most=30, tolerance=_COST_TOLERANCE)
                else:
                    cost = float(np.sum(self.residuals(at) ** 2))
                excess[distance] = cost - (least + rise)
            return excess[distance]

        inner = 0.0
        while above(outer) < 0.0:
            if outer >= room:
                return None
            inner, outer = outer, min(2.0 * outer, room)
        return float(brentq(above, inner, outer, xtol=_END_TOLERANCE * outer))


@dataclass(frozen=True)
class Statistics:
    """Linear statistics of the free parameters, over ln p."""

    root: Floats  #: (p, p) rootᵀ root is the covariance of ln p
    #: Half width of an interval in standard deviations (Student's t, or the normal distribution
    #: where the noise is stated)
    quantile: float
    #: (p,) Of J/s, descending: 1/σ of the best and worst determined combinations of ln p
    singular_values: Floats
    level: float  #: Root mean square of the residuals, degrees of freedom accounted for
    freedom: int  #: Residuals less parameters

    @property
    def deviation(self) -> Floats:
        """Standard deviation (p,) of ln p."""
        return np.asarray(np.linalg.norm(self.root, axis=0))

    @property
    def correlation(self) -> Floats:
        """Correlations (p, p)."""
        normed = self.root / self.deviation
        return np.asarray(normed.T @ normed)

    def half_width(self, slopes: Floats) -> Floats:
        """Half width (n,) of intervals, from slopes (n, p) over ln p."""
        return np.asarray(self.quantile * np.linalg.norm(slopes @ self.root.T, axis=1))


def statistics(jacobian: Floats, residuals: Floats, *, stated: bool) -> Statistics:
    """Statistics of a fit from its Jacobian (n, p) over ln p and residuals (n,).

    `stated`: the residuals are in units of a stated standard deviation; otherwise their variance
    is estimated from them.
    """
    from scipy.special import ndtri, stdtrit

    freedom = residuals.size - jacobian.shape[1]  # all parameters may be at bounds
    level = float(np.sqrt(np.sum(residuals**2) / freedom))
    # an exact curve would have a variance of 0 and no correlations
    deviation = 1.0 if stated else max(level, np.finfo(float).eps)
    _, values, right = np.linalg.svd(jacobian / deviation, full_matrices=False)
    floored = np.maximum(values, RANK * values.max(initial=0.0))
    tail = 0.5 * (1.0 + CONFIDENCE)
    quantile = float(ndtri(tail) if stated else stdtrit(freedom, tail))
    return Statistics(right / floored[:, None], quantile, values, level, freedom)
