"""How far the headline numbers move within the stated ranges of the parameters.

The numerical error bar of a quantity says how well an equation was solved; this says how
well the quantity is known.  By the transfer-matrix model: first order from exact
derivatives, u² = Σ (∂q/∂p)² w²/12 for uniform ranges of width w, and Sobol's indices with
the 95 % interval from samples (Saltelli's scheme, SALib).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.bimorph.pieces import beam_pieces
from tactgen.tmm.beam.parametric import parameter_keys
from tactgen.tmm.beam.transfer_matrix import is_tapered
from tactgen.validation.engine.inputs import idle
from tactgen.validation.scene.parameter_list import show
from tactgen.validation.scene.ranges import ranges
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.uncertainty.headline_numbers import (
    HeadlineNumbers,
    SampledNumbers,
    Target,
    actuator,
    targets,
)

#: Evaluations that one study may take; Saltelli's scheme takes (parameters + 2) times a
#: power of two.  Rows of several pieces get fewer, since each piece costs.
_EVALUATIONS = 6000
_SEED = 1


@dataclass(frozen=True)
class UncertainParameter:
    """A parameter that may lie anywhere in a range, every place alike."""

    key: str
    value: float
    low: float
    high: float
    reason: str
    whose: str
    text: str
    text_range: str


@dataclass(frozen=True)
class Uncertainty:
    """What the ranges of the parameters do to one headline number (SI).

    Attributes
    ----------
    value, numerical : float
        The number and its numerical error bar.
    standard : float
        Standard deviation to first order.
    worst : float
        Change to first order when every parameter sits at its worse end.
    sampled : float
        Standard deviation of the samples.
    low, high : float
        Ends of the interval that holds 95 % of the samples.
    slopes : dict of str to float
        Derivative by parameter.
    first, total : dict of str to (float, float)
        Sobol's first-order and total index by parameter, with half the 95 % confidence
        interval of the estimate.
    """

    target: Target
    value: float
    numerical: float
    standard: float
    worst: float
    sampled: float
    low: float
    high: float
    slopes: dict[str, float]
    first: dict[str, tuple[float, float]]
    total: dict[str, tuple[float, float]]

    @property
    def nonlinearity(self) -> float:
        """By how much (relative) the standard deviation of the samples exceeds first order."""
        return self.sampled / self.standard - 1.0

    @property
    def contributors(self) -> list[tuple[str, float, float]]:
        """Parameters with total index and its confidence, largest first."""
        return sorted(((k, s, c) for k, (s, c) in self.total.items()), key=lambda e: -e[1])


def uncertain_parameters(scene: Scene) -> tuple[UncertainParameter, ...]:
    """Return the parameters of the transfer-matrix model that have a range, in the scene's order.

    Ranges as :func:`validation.scene.ranges.ranges`.
    """
    found, known = [], ranges(scene)
    for key in parameter_keys(actuator(scene)):
        group_name, name = key.split(".")
        group = getattr(scene, group_name)
        spread = known.get(key)
        # springs that stand for a contact are no parameters of the scene
        if idle(scene, key):
            continue
        if spread is not None and spread.high > spread.low:
            info = type(group).model_fields[name]
            low, high = show(spread.low, info), show(spread.high, info)
            text = show(getattr(group, name), info)
            number, _, unit = high.partition(" ")
            text_range = f"{low.partition(' ')[0]} to {number} {unit}".rstrip()
            found.append(
                UncertainParameter(
                    key, getattr(group, name), spread.low, spread.high, spread.reason,
                    spread.whose, text, text_range,
                )
            )  # fmt: skip
    return tuple(found)


def parameter_uncertainty(
    scene: Scene,
    evaluations: int | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> list[Uncertainty]:
    """Return every headline number with what the parameters' ranges do to it.

    Parameters
    ----------
    evaluations : int, optional
        How often the model may be solved; the largest power of two of base samples that
        this allows is taken.
    """
    from SALib.analyze import sobol
    from SALib.sample import sobol as saltelli

    parameters = uncertain_parameters(scene)
    numbers = HeadlineNumbers(scene)
    problem = {
        "num_vars": len(parameters),
        "names": [p.key for p in parameters],
        "bounds": [[p.low, p.high] for p in parameters],
    }
    base = base_samples(len(parameters), evaluations or affordable(scene))
    points = saltelli.sample(problem, base, calc_second_order=False, seed=_SEED)
    sampled = SampledNumbers(numbers, {p.key: points[:, i] for i, p in enumerate(parameters)})
    # Saltelli's rows come in groups of A, the mixtures, B; A and B are independent samples
    independent = np.isin(np.arange(len(points)) % (len(parameters) + 2), (0, len(parameters) + 1))
    found = []
    for target in targets(scene):
        announce(f"parameter uncertainty: {target.label}")
        value, bar = numbers.value_and_bar(target)
        usual, slopes = numbers.value_and_slopes(target, tuple(p.key for p in parameters))
        # what is taken over from the derivatives' and samples' model is relative
        slopes = {key: slope * value / usual for key, slope in slopes.items()}
        y = sampled.of(target) * (value / usual)
        indices = sobol.analyze(problem, y, calc_second_order=False, num_resamples=100, seed=_SEED)
        changes = np.array([slopes[p.key] * (p.high - p.low) for p in parameters])
        extremes = [
            max(abs(slopes[p.key] * (end - p.value)) for end in (p.low, p.high)) for p in parameters
        ]
        low, high = np.percentile(y[independent], [2.5, 97.5])
        found.append(
            Uncertainty(
                target=target,
                value=value,
                numerical=bar,
                standard=float(np.sqrt((changes**2).sum() / 12.0)),
                worst=float(sum(extremes)),
                sampled=float(y[independent].std()),
                low=float(low),
                high=float(high),
                slopes=slopes,
                first=_by_key(problem, indices, "S1"),
                total=_by_key(problem, indices, "ST"),
            )
        )
    return found


def affordable(scene: Scene) -> int:
    """Return how often a report may solve the model: rows of several pieces cost more."""
    if is_tapered(scene.device, scene.support):
        return _EVALUATIONS // 8
    single = len(beam_pieces(scene.device, scene.support)) == 1
    return _EVALUATIONS if single else _EVALUATIONS // 2


def base_samples(parameters: int, evaluations: int) -> int:
    """Return the largest power of two of base samples within so many evaluations."""
    return int(2 ** max(1, math.floor(math.log2(evaluations / (parameters + 2)))))


def _by_key(
    problem: Mapping[str, Any], indices: Mapping[str, Any], name: str
) -> dict[str, tuple[float, float]]:
    columns = zip(problem["names"], indices[name], indices[f"{name}_conf"], strict=True)
    return {key: (float(index), float(bar)) for key, index, bar in columns}
