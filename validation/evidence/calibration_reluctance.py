"""Calibration of the reluctance network on axisymmetric fields of random actuators.

Three quarters of the fields are fitted to, the last quarter gives the errors.  Each is one device
at one current and gap.  Lengths differ by nothing but scale, so the head's radius is one for all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.store.values import storable
from tactgen.tmm.chebyshev import Products, weighted_powers
from tactgen.tmm.reluctance import calibrated
from tactgen.tmm.reluctance.calibrated import GROUPS, VALUES, Fit, State, corrected, groups
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.evidence.coverage import PROMISED, cached_by_code
from tactgen.validation.evidence.fit_record import evidence, products_record, rounded
from tactgen.validation.evidence.random_devices import accepted, any_actuator
from tactgen.validation.scene.scene import Scene, load_scene

#: Random devices of the shipped fit, their seed, and the share that is fitted to.
DEVICES, SEED, FITTED = 4000, 2, 0.75
#: How much wider the ranges are of which devices beyond the fit are drawn, and how many these are.
WIDER, BEYOND = 2.0, 400
#: Lines of the field's grid, of the usual: within 2e-3 of much finer ones.
_REFINEMENT = 0.85
#: Degree of a term, in which each group counts with its weight.
_DEGREE = {"straight": 4.0, "saturating": 4.5}
_WEIGHTS = {
    "straight": (0.8, np.inf, 1.2, 0.8, 1.5, 2.0, 1.5, 2.5, 2.5, 1.3, 1.5, 0.5, np.inf),
    "saturating": (1.0, 0.7, 1.3, 0.8, 2.0, 2.0, 2.0, 2.5, 2.0, 1.3, 1.5, 2.5, 2.5),
}
_RIDGE, _STEPS = 1e-5, 8
#: Share of the devices with the fewest ampere turns, below which P is held, as of a linear steel:
#: there are too few to fit anything else.
_LINEAR = 0.2
#: Weights of force, flux linkage and co-energy.
_COUNTS = np.array([2.0, 1.0, 1.0])
_QUANTILE, _LEAST = 0.97, 5e-4


@storable
@dataclass(frozen=True)
class ObservedField:
    """Field of one random actuator at its current and gap."""

    overrides: tuple[str, ...]  #: Of the scene ``reluctance``
    field: Floats  #: (4,) By the field, in the order of ``VALUES``
    network: Floats  #: (4,) By the network


def observe(seed: int, number: int, wider: float = 1.0) -> ObservedField:
    """Solve the field of a random actuator."""
    from tactgen.fem.magnetics.axisymmetric import solve_point

    rng = np.random.default_rng([seed, number])

    def attempt() -> ObservedField:
        overrides = any_actuator(rng, wider)
        device = load_scene("reluctance", overrides)[0].device
        network = network_samples(device, np.array([device.coil.current]), np.array([device.gap]))
        field = solve_point(device, refinement=_REFINEMENT)
        return ObservedField(
            tuple(overrides),
            np.array([getattr(field, name) for name in VALUES]),
            np.array([getattr(network, name)[0, 0] for name in VALUES]),
        )

    return accepted(attempt)


def observe_once(seed: int, number: int, wider: float = 1.0) -> ObservedField:
    """Field of a random actuator, cached."""
    name, work = ("reluctance", seed, number, wider), partial(observe, seed, number, wider)
    one: ObservedField = cached_by_code("calibration", name, __name__, work)
    return one


@dataclass(frozen=True)
class Points:
    """ObservedField points as arrays over n of them."""

    scenes: tuple[Scene, ...]
    overrides: tuple[tuple[str, ...], ...]
    groups: Floats  #: (n, g)
    gap: Floats  #: (n,) In m
    current: Floats  #: (n,) In A
    network: Floats  #: (n, 4)
    field: Floats  #: (n, 4)

    def part(self, which: Ints | Bools) -> Points:
        """Some of them."""
        numbers = np.arange(len(self.scenes))[which]
        arrays = (self.groups, self.gap, self.current, self.network, self.field)
        scenes = tuple(self.scenes[i] for i in numbers)
        overrides = tuple(self.overrides[i] for i in numbers)
        return Points(scenes, overrides, *(one[numbers] for one in arrays))


def points_of(observed: Sequence[ObservedField]) -> Points:
    """ObservedField points with their groups."""
    scenes = tuple(load_scene("reluctance", list(one.overrides))[0] for one in observed)
    gap = np.array([scene.gap for scene in scenes])
    current = np.array([scene.coil.current for scene in scenes])
    at = [
        groups(scene.device, np.array([i]), np.array([g]))[0]
        for scene, i, g in zip(scenes, current, gap, strict=True)
    ]
    network, field = (np.array([getattr(o, n) for o in observed]) for n in ("network", "field"))
    overrides = tuple(one.overrides for one in observed)
    return Points(scenes, overrides, np.array(at), gap, current, network, field)


def fit(of: Points, kind: str) -> tuple[Fit, dict[str, Any]]:
    """Fit to a part of the points, with errors from the rest, and what these show."""
    training = np.random.default_rng(SEED).random(len(of.scenes)) < FITTED
    known, fresh = of.part(training), of.part(~training)
    low, high = of.groups.min(axis=0), of.groups.max(axis=0)
    turns = GROUPS.index("ampere turns")
    low[turns] = np.quantile(of.groups[:, turns], _LINEAR)
    products = Products(low, high, weighted_powers(_WEIGHTS[kind], _DEGREE[kind]))
    none = np.zeros((1 + 2 * len(GROUPS), len(VALUES)))
    found = Fit(products, _fit_energy(known, products), none)
    left = left_over(fresh, found)
    found = replace(found, errors=_fit_errors(products.quadratic(fresh.groups), left))
    stated = np.exp(products.quadratic(fresh.groups) @ found.errors)
    return found, evidence(VALUES, left, stated, fresh.overrides)


def _fit_energy(of: Points, products: Products) -> Floats:
    """Coefficients (t,) of P, by Gauss-Newton steps on force, flux linkage and co-energy."""
    force, linkage, energy, _ = of.network.T
    terms = products(of.groups)
    by_gap = products.slope(of.groups, 0) * (energy / of.gap)[:, None]
    by_current = products.slope(of.groups, 1) * (energy / of.current)[:, None]
    size = _sizes(of)[:, :3]
    found = np.zeros(terms.shape[1])
    for _ in range(_STEPS):
        factor = np.exp(terms @ found)
        parts = np.stack([force - by_gap @ found, linkage + by_current @ found, energy], axis=1)
        left = (of.field[:, :3] - factor[:, None] * parts) / size
        own = np.stack([-by_gap, by_current, np.zeros_like(terms)], axis=1)
        slopes = parts[:, :, None] * terms[:, None, :] + own
        slopes *= factor[:, None, None] / size[:, :, None]
        rows = (slopes * _COUNTS[:, None]).reshape(-1, found.size)
        normal = rows.T @ rows
        ridge = _RIDGE * np.trace(normal) / len(normal)
        normal[np.diag_indices_from(normal)] += ridge
        right = rows.T @ (left * _COUNTS).ravel() - ridge * found
        found = found + np.linalg.solve(normal, right)
    return found


def _sizes(of: Points) -> Floats:
    """Sizes (n, 4) that errors are shares of."""
    return calibrated.sizes(State(*of.field.T), of.current, of.gap).T


def left_over(of: Points, known: Fit) -> Floats:
    """Errors (n, 4) of :data:`VALUES` as shares of their sizes."""
    found = []
    for scene, i, g, network in zip(of.scenes, of.current, of.gap, of.network, strict=True):
        state = State(*(np.array([v]) for v in network))
        found.append(corrected(scene.device, np.array([i]), np.array([g]), state, known)[0])
    return np.asarray(np.abs(np.array(found)[:, :, 0] - of.field) / _sizes(of))


def _fit_errors(rows: Floats, left: Floats) -> Floats:
    """Coefficients (1 + 2 g, 4) of the logarithms of the errors (n, 4), such that they cover."""
    error = np.maximum(left, _LEAST)
    normal = rows.T @ rows + 1e-2 * len(rows) * np.diag([0.0] + [1.0] * (rows.shape[1] - 1))
    found = np.linalg.solve(normal, rows.T @ np.log(error))
    found[0] += np.log(np.quantile(error / np.exp(rows @ found), _QUANTILE, axis=0))
    return np.asarray(found)


def calibrate(
    observed: Sequence[ObservedField],
    beyond: Sequence[ObservedField],
    announce: Callable[[str], None],
) -> dict[str, Any]:
    """Calibration as it is written to a file, from devices within its range and beyond it."""
    record: dict[str, Any] = {"devices": len(observed), "seed": SEED}
    inside, outside = points_of(observed), points_of(beyond)
    for kind in ("straight", "saturating"):
        announce(f"calibration: {kind} magnetisation curves")
        found, shown = fit(_of_kind(inside, kind), kind)
        widened = _widening(_of_kind(outside, kind), found)
        record[kind] = {**_plain(found), "beyond": widened, "evidence": shown}
    return record


def _of_kind(of: Points, kind: str) -> Points:
    straight = np.array([calibrated.is_straight(scene.device) for scene in of.scenes])
    return of.part(straight if kind == "straight" else ~straight)


def _widening(of: Points, known: Fit) -> float:
    """Factor on all errors that covers the devices beyond the range."""
    beyond = of.part(np.array([bool(known.outside(at)) for at in of.groups]))
    stated = np.exp(known.products.quadratic(beyond.groups) @ known.errors)
    ratios = (left_over(beyond, known) / stated).max(axis=1)
    return float(f"{max(np.quantile(ratios, PROMISED), 1.0):.3g}")


def _plain(found: Fit) -> dict[str, Any]:
    return products_record(found.products) | {
        "coefficients": [rounded(v) for v in found.coefficients],
        "errors": [[rounded(v) for v in row] for row in found.errors],
    }
