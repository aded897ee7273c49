"""Calibration of the reluctance network on axisymmetric fields of random actuators.

Three quarters of the fields are fitted to, the last quarter gives the errors.  Each is one device
at one current and gap.  Lengths differ by nothing but scale, so the head's radius is one for all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.store.values import storable
from tactgen.tmm.chebyshev import Products, weighted_powers
from tactgen.tmm.reluctance import calibrated
from tactgen.tmm.reluctance.calibrated import GROUPS, VALUES, Fit, State, corrected, groups
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.evidence.fit_record import (
    covering,
    evidence,
    products_record,
    rounded,
    solve_normal,
)
from tactgen.validation.evidence.judgement import PROMISED
from tactgen.validation.evidence.random_devices import accepted, any_actuator
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.scene import Scene

#: Random devices of the shipped fit, their seed, and the share that is fitted to.
DEVICES, SEED, FITTED = 4000, 2, 0.75
#: How much wider the ranges are of which devices beyond the fit are drawn, and how many these are.
WIDER, BEYOND = 2.0, 400
#: Lines of the field's grid, of the usual: within 2e-3 of much finer ones.
_REFINEMENT = 0.85
#: Degree of a term, in which each group counts with its weight.
_TERMS = {
    "straight": (4.0, (0.8, np.inf, 1.2, 0.8, 1.5, 2.0, 1.5, 2.5, 2.5, 1.3, 1.5, 0.5, np.inf)),
    "saturating": (4.5, (1.0, 0.7, 1.3, 0.8, 2.0, 2.0, 2.0, 2.5, 2.0, 1.3, 1.5, 2.5, 2.5)),
}
_RIDGE, _STEPS = 1e-5, 8
#: Share of the devices with the fewest ampere turns, below which P is held, as of a linear steel:
#: there are too few to fit anything else.
_LINEAR = 0.2
#: Weights of force, flux linkage and co-energy.
_COUNTS = np.array([2.0, 1.0, 1.0])
_QUANTILE, _LEAST, _RIDGE_OF_ERRORS = 0.97, 5e-4, 1e-2


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


def fit(observed: Sequence[ObservedField], kind: str) -> tuple[Fit, dict[str, Any]]:
    """Fit to a part of the points, with errors from the rest, and what these show."""
    training = np.random.default_rng(SEED).random(len(observed)) < FITTED
    known, fresh = (points_of(list(compress(observed, own))) for own in (training, ~training))
    every, turns = np.concatenate([known.groups, fresh.groups]), GROUPS.index("ampere turns")
    low, high = every.min(axis=0), every.max(axis=0)
    low[turns] = np.quantile(every[:, turns], _LINEAR)
    degree, weights = _TERMS[kind]
    products = Products(low, high, weighted_powers(weights, degree))
    none = np.zeros((1 + 2 * len(GROUPS), len(VALUES)))
    found = Fit(products, _fit_energy(known, products), none)
    left, rows = left_over(fresh, found), products.quadratic(fresh.groups)
    found = replace(
        found, errors=covering(rows, np.maximum(left, _LEAST), _RIDGE_OF_ERRORS, _QUANTILE)
    )
    return found, evidence(VALUES, left, np.exp(rows @ found.errors), fresh.overrides)


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
        found = found + solve_normal(rows, (left * _COUNTS).ravel(), _RIDGE, found)
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


def calibrate(
    observed: Sequence[ObservedField],
    beyond: Sequence[ObservedField],
    announce: Callable[[str], None],
) -> dict[str, Any]:
    """Calibration as it is written to a file, from devices within its range and beyond it."""
    record: dict[str, Any] = {"devices": len(observed), "seed": SEED}
    for kind in _TERMS:
        announce(f"calibration: {kind} magnetisation curves")
        found, shown = fit(_of_kind(observed, kind), kind)
        record[kind] = products_record(found.products) | {
            "coefficients": rounded(found.coefficients), "errors": rounded(found.errors),
            "beyond": _widening(points_of(_of_kind(beyond, kind)), found), "evidence": shown,
        }  # fmt: skip
    return record


def _of_kind(observed: Sequence[ObservedField], kind: str) -> list[ObservedField]:
    devices = (load_scene("reluctance", list(one.overrides))[0].device for one in observed)
    straight = kind == "straight"
    return list(compress(observed, (calibrated.is_straight(d) == straight for d in devices)))


def _widening(of: Points, known: Fit) -> float:
    """Factor on all errors that covers the devices beyond the range."""
    stated = np.exp(known.products.quadratic(of.groups) @ known.errors)
    ratios = (left_over(of, known) / stated).max(axis=1)
    beyond = [bool(known.outside(at)) for at in of.groups]
    return float(f"{max(np.quantile(ratios[beyond], PROMISED), 1.0):.3g}")
