"""Uncertainty of the headline numbers from the parameters' ranges.

The numerical error of a quantity says how well an equation was solved; this says how
well the quantity is known.  By the transfer-matrix model, which gives values, derivatives and
samples in milliseconds: first order from exact derivatives, u² = Σ (∂q/∂p)² w²/12 for uniform
ranges of width w, and Sobol's indices with the 95 % interval from samples (Saltelli's scheme,
SALib).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.tmm.beam.parametric import Actuator, parameter_keys
from tactgen.tmm.beam.port_quantities import evaluate, first_frequency, resonance_peak
from tactgen.tmm.beam.sensitivities import derivatives, values
from tactgen.tmm.beam.transfer_matrix import is_tapered
from tactgen.tmm.ports.readout import Circuit, ModalReadout, Readout
from tactgen.validation.catalogue.quantities import (
    QUANTITIES,
    TIP_DISPLACEMENT,
    TIP_VELOCITY,
    QuantityRow,
)
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.scene.inputs import idle
from tactgen.validation.scene.parameter_list import ranges, show
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import value_of
from tactgen.validation.studies.length_map import actuator

#: Frequencies at which loaded or free motion is a headline number (Hz), and one at which
#: it is shown as a warning: next to a minimum of the loaded 20 mm actuator.
FREQUENCIES, ILL_CONDITIONED = (10.0, 100.0, 250.0), 1000.0
#: Prismatic stretches of a tapered piece in derivatives and samples, whose relative size
#: they settle to a few percent; the numbers themselves take as many as everywhere else.
_SEGMENTS = 4
#: Rounds of the search for the peak.
_ROUNDS = 5
#: Evaluations that one study may take; Saltelli's scheme takes (parameters + 2) times a
#: power of two.  Segmented beams get fewer, since each piece costs.
_EVALUATIONS = 6000
_SEED = 1


@dataclass(frozen=True)
class Target:
    """A headline number: a quantity, by magnitude, at a frequency (Hz) if it has one.

    `peak` is set for a number about the quantity's resonance instead.
    """

    name: str
    label: str
    unit: str
    frequency: float | None = None
    ill_conditioned: bool = False
    peak: Literal["", "frequency", "height"] = ""

    @property
    def quantity(self) -> QuantityRow:
        """The quantity's row."""
        return QUANTITIES[self.name]

    @property
    def read(self) -> Readout | ModalReadout:
        """Readout of the quantity."""
        read = self.quantity.read
        assert isinstance(read, Readout | ModalReadout)
        return read


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
    """Uncertainty of one headline number (SI)."""

    target: Target
    #: The number and its numerical error
    value: float
    numerical: float
    standard: float  #: Standard deviation to first order
    worst: float  #: Change to first order when every parameter sits at its worse end
    sampled: float  #: Standard deviation of the samples
    #: Ends of the interval that holds 95 % of the samples
    low: float
    high: float
    slopes: dict[str, float]  #: Derivative by parameter
    #: Sobol's first-order and total index by parameter, with half the 95 % confidence interval of
    #: the estimate
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


def targets(scene: Scene) -> tuple[Target, ...]:
    """Headline numbers that this scene has."""
    on_support, active = not scene.ends.rigid_motions, scene.piezo.d31 != 0.0
    rows = [
        row
        for row in QUANTITIES.values()
        if row.varied
        and (active or not row.is_transduced)
        and (on_support or not (row.static and row.held_by_support))
    ]
    numbers = [Target(row.name, row.label, row.unit) for row in rows if not row.by_frequency]
    numbers += [_response(row, f) for row in rows if row.by_frequency for f in FREQUENCIES]
    if active and scene.load.kind == "none":
        name, unit = TIP_VELOCITY.name, TIP_VELOCITY.unit
        numbers += [
            Target(name, "peak frequency", "Hz", peak="frequency"),
            Target(name, "peak tip velocity", unit, peak="height"),
        ]
    if active and scene.load.kind == "finger":
        numbers.append(replace(_response(TIP_DISPLACEMENT, ILL_CONDITIONED), ill_conditioned=True))
    return tuple(numbers)


def _response(row: QuantityRow, frequency: float) -> Target:
    return Target(row.name, f"{row.label}, {frequency:g} Hz", row.unit, frequency)


class HeadlineNumbers:
    """Values, derivatives and samples of a scene's headline numbers.

    Derivatives and samples are of `actuator`, whose tapers have few segments.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.actuator = replace(actuator(scene), segments=_SEGMENTS)
        self._first: dict[Circuit, float] = {}

    def first(self, circuit: Circuit) -> float:
        """First natural frequency (Hz)."""
        if circuit not in self._first:
            self._first[circuit] = float(values(self.actuator, ModalReadout((circuit,)))[0])
        return self._first[circuit]

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Frequency (Hz) and height (m/s) of the free tip's velocity peak."""
        return _peak(actuator(self.scene), self.first("short"), _ROUNDS)

    @cached_property
    def solution(self) -> Solution:
        """The same numbers as everywhere else, with their errors."""
        names = {t.name for t in targets(self.scene)}
        peaks = [self.peak[0]] if any(t.peak for t in targets(self.scene)) else []
        at = (*FREQUENCIES, ILL_CONDITIONED, *peaks)
        return solve(self.scene.model_copy(update={"frequency": at}), ("tmm",), sorted(names))

    def value_and_error(self, target: Target) -> tuple[float, float]:
        """Number and its numerical error, absolute."""
        if target.peak == "frequency":
            before, _ = _peak(actuator(self.scene), self.peak[0], _ROUNDS - 1)
            return self.peak[0], abs(before - self.peak[0])
        q, i = self.solution.get(target.name, "tmm"), -1 if target.peak else 0
        if target.frequency is not None:
            i = (*FREQUENCIES, ILL_CONDITIONED).index(target.frequency)
        return float(np.abs(np.atleast_1d(q.value)[i])), float(np.atleast_1d(q.error)[i])

    def value_and_slopes(
        self, target: Target, keys: tuple[str, ...]
    ) -> tuple[float, dict[str, float]]:
        """Number of `actuator` and its derivative by each key."""
        if target.peak:
            return self._peak_and_slopes(target, keys)
        at = None if target.frequency is None else np.array([target.frequency])
        value = values(self.actuator, target.read, at)[0]
        slopes = derivatives(self.actuator, target.read, keys, at)
        return float(abs(value)), {
            key: float((np.conj(value) * slope[0]).real / abs(value))
            for key, slope in slopes.items()
        }

    def _peak_and_slopes(
        self, target: Target, keys: tuple[str, ...]
    ) -> tuple[float, dict[str, float]]:
        """Height or frequency f of the peak of L = ln|v| and its derivatives.

        At the peak ∂L/∂f = 0, so the height changes by ∂L/∂p at fixed f, and f by
        −(∂²L/∂f∂p)/(∂²L/∂f²); central differences over 1e-4 of f, good to some 1e-4.
        """
        frequency, height = _peak(self.actuator, self.first("short"), _ROUNDS)
        step = 1e-4 * frequency
        at = frequency + step * np.array([-1.0, 0.0, 1.0])
        velocity = values(self.actuator, target.read, at)
        relative = {
            key: (slope / velocity).real
            for key, slope in derivatives(self.actuator, target.read, keys, at).items()
        }
        if target.peak == "height":
            return height, {key: float(height * r[1]) for key, r in relative.items()}
        level = np.log(np.abs(velocity))
        curvature = (level[0] - 2.0 * level[1] + level[2]) / step
        return frequency, {
            key: float(-0.5 * (r[2] - r[0]) / curvature) for key, r in relative.items()
        }


def _peak(of: Actuator, start: float, rounds: int) -> tuple[float, float]:
    at, size = resonance_peak(of, TIP_VELOCITY.port_readout, {}, np.array([start]), rounds=rounds)
    return float(at[0]), float(size[0])


class SampledNumbers:
    """The headline numbers at samples (n,) of scene keys; frequencies of modes once."""

    def __init__(self, numbers: HeadlineNumbers, points: dict[str, Floats]) -> None:
        self._numbers, self._points = numbers, points
        self._size = next(iter(points.values())).size
        self._modes: dict[Circuit, Floats] = {}

    def of(self, target: Target) -> Floats:
        """Target's value (n,) at each sample."""
        if target.peak:
            return self._peaks[int(target.peak == "height")]
        read = target.read
        if isinstance(read, Readout):
            at = np.full(self._size, target.frequency or 0.0)
            return np.abs(evaluate(self._numbers.actuator, read, self._points, at))
        first = [self._mode(circuit) for circuit in read.circuits]
        return np.asarray(read.combine(*first)) if read.combine else first[0]

    @cached_property
    def _peaks(self) -> tuple[Floats, Floats]:
        """Frequency (n,) in Hz and height (n,) of the free tip's resonance."""
        read = TIP_VELOCITY.port_readout
        return resonance_peak(
            self._numbers.actuator, read, self._points, self._mode("short"), rounds=3
        )

    def _mode(self, circuit: Circuit) -> Floats:
        if circuit not in self._modes:
            start = np.full(self._size, self._numbers.first(circuit))
            self._modes[circuit] = first_frequency(
                self._numbers.actuator, self._points, start, open_circuit=circuit == "open"
            )
        return self._modes[circuit]


def uncertain_parameters(scene: Scene) -> tuple[UncertainParameter, ...]:
    """Parameters of the transfer-matrix model that have a range, in the scene's order.

    Springs that stand for a contact are no parameters of the scene.
    """
    rows, known = [], ranges(scene)
    for key in parameter_keys(actuator(scene)):
        spread = known.get(key)
        if idle(scene, key) or spread is None or not spread.high > spread.low:
            continue
        group, _, name = key.partition(".")
        info = type(getattr(scene, group)).model_fields[name]
        value: float = value_of(scene, key)
        low, (high, _, unit) = show(spread.low, info), show(spread.high, info).partition(" ")
        text_range = f"{low.partition(' ')[0]} to {high} {unit}".rstrip()
        rows.append(
            UncertainParameter(
                key, value, spread.low, spread.high, spread.reason, spread.whose,
                show(value, info), text_range,
            )
        )  # fmt: skip
    return tuple(rows)


def parameter_uncertainty(
    scene: Scene, evaluations: int | None = None, announce: Callable[[str], None] = lambda _: None
) -> list[Uncertainty]:
    """Every headline number with its uncertainty.

    Parameters
    ----------
    evaluations : int, optional
        How often the model may be solved; the largest power of two of base samples that
        this allows is taken.
    """
    from SALib.analyze import sobol
    from SALib.sample import sobol as saltelli

    parameters = uncertain_parameters(scene)
    keys = tuple(p.key for p in parameters)
    bounds = np.array([(p.low, p.high) for p in parameters])
    numbers = HeadlineNumbers(scene)
    problem = {"num_vars": len(keys), "names": list(keys), "bounds": bounds.tolist()}
    base = base_samples(len(keys), evaluations or affordable(scene))
    points = saltelli.sample(problem, base, calc_second_order=False, seed=_SEED)
    sampled = SampledNumbers(numbers, dict(zip(keys, points.T, strict=True)))
    # Saltelli's rows come in groups of A, the mixtures, B; A and B are independent samples
    independent = np.isin(np.arange(len(points)) % (len(keys) + 2), (0, len(keys) + 1))
    rows = []
    for target in targets(scene):
        announce(f"parameter uncertainty: {target.label}")
        value, error = numbers.value_and_error(target)
        usual, slopes = numbers.value_and_slopes(target, keys)
        # what is taken over from the derivatives' and samples' model is relative
        slopes = {key: slope * value / usual for key, slope in slopes.items()}
        y = sampled.of(target) * (value / usual)
        indices = sobol.analyze(problem, y, calc_second_order=False, num_resamples=100, seed=_SEED)
        slope = np.array([slopes[key] for key in keys])
        reach = np.abs(bounds - np.array([[p.value] for p in parameters])).max(axis=1)
        low, high = np.percentile(y[independent], [2.5, 97.5])
        rows.append(
            Uncertainty(
                target=target,
                value=value,
                numerical=error,
                standard=float(np.sqrt(((slope * np.ptp(bounds, axis=1)) ** 2).sum() / 12.0)),
                worst=float((np.abs(slope) * reach).sum()),
                sampled=float(y[independent].std()),
                low=float(low),
                high=float(high),
                slopes=slopes,
                first=_by_key(keys, indices, "S1"),
                total=_by_key(keys, indices, "ST"),
            )
        )
    return rows


def affordable(scene: Scene) -> int:
    """Affordable number of evaluations; segmented beams cost more."""
    if is_tapered(scene.device, scene.support):
        return _EVALUATIONS // 8
    single = len(beam_pieces(scene.device, scene.support)) == 1
    return _EVALUATIONS if single else _EVALUATIONS // 2


def base_samples(parameters: int, evaluations: int) -> int:
    """Largest power of two of base samples within so many evaluations."""
    return int(2 ** max(1, math.floor(math.log2(evaluations / (parameters + 2)))))


def _by_key(
    keys: tuple[str, ...], indices: Mapping[str, Any], name: str
) -> dict[str, tuple[float, float]]:
    columns = zip(keys, indices[name].tolist(), indices[f"{name}_conf"].tolist(), strict=True)
    return {key: (index, half_width) for key, index, half_width in columns}
