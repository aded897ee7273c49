"""Uncertainty of the headline numbers from the parameters' ranges.

The numerical error of a quantity says how well an equation was solved; this says how
well the quantity is known.  By the transfer-matrix model, which gives values, derivatives and
samples in milliseconds: first order from differences, u² = Σ (∂q/∂p)² w²/12 for uniform
ranges of width w, and Sobol's indices with the 95 % interval from samples (Saltelli's scheme,
SALib).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.geometry.device.laminate import OWN
from tactgen.geometry.device.materials import Spread
from tactgen.geometry.device.profile import Profile
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.parametric import Actuator, has_kink, parameter_keys
from tactgen.tmm.beam.port_quantities import (
    circuit_power,
    evaluate,
    first_frequency,
    resonance_peak,
)
from tactgen.tmm.beam.transfer_matrix import is_tapered, sections
from tactgen.tmm.ports.excitation_and_circuit import excitation_of
from tactgen.tmm.ports.readout import Electrodes, ModalReadout, Readout
from tactgen.validation.catalogue.quantities import (
    CIRCUIT_POWER,
    QUANTITIES,
    TIP_DISPLACEMENT,
    TIP_VELOCITY,
    QuantityRow,
)
from tactgen.validation.engine.derivatives import PLACES, extrapolated
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.conditions import beyond_voltage
from tactgen.validation.scene.keys import declaration, number_keys, read_as
from tactgen.validation.scene.parameter_list import ranges, show
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import value_of, with_materials_as_keys
from tactgen.validation.scene.warnings import idle
from tactgen.validation.studies.length_map import actuator

#: Frequencies at which loaded or free motion is a headline number (Hz), and one at which
#: it is shown as a warning: next to a minimum of the loaded 20 mm actuator.
FREQUENCIES, ILL_CONDITIONED = (10.0, 100.0, 250.0), 1000.0
#: Prismatic stretches of a tapered piece in derivatives and samples, whose relative size
#: they settle to a few percent; the numbers themselves take as many as everywhere else.
_SEGMENTS = 4
#: Relative distance of the differences.
_CLOSE = 2e-4
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
    def contributors(self) -> list[tuple[str, float, float]]:
        """Parameters with total index and its confidence, largest first."""
        return sorted(((k, s, c) for k, (s, c) in self.total.items()), key=lambda e: -e[1])


def targets(scene: Scene) -> tuple[Target, ...]:
    """Headline numbers that this scene has; no response if not the voltage alone drives it."""
    on_support, driven = not scene.ends.rigid_motions, not beyond_voltage(scene)
    active = scene.piezo.d31 != 0.0
    rows = [
        row
        for row in QUANTITIES.values()
        if row.varied
        and (active or not row.is_transduced)
        and (driven or not (isinstance(row.read, Readout) and row.read.under is None))
        and (on_support or not (row.static and row.held_by_support))
    ]
    numbers = [Target(row.name, row.label, row.unit) for row in rows if not row.by_frequency]
    numbers += [_response(row, f) for row in rows if row.by_frequency for f in FREQUENCIES]
    if active and (row := _peaking(scene)):
        numbers += [
            Target(row.name, "peak frequency", "Hz", peak="frequency"),
            Target(row.name, f"peak {row.label}", row.unit, peak="height"),
        ]
    if active and driven and scene.load.kind == "finger":
        numbers.append(replace(_response(TIP_DISPLACEMENT, ILL_CONDITIONED), ill_conditioned=True))
    return tuple(numbers)


def _peaking(scene: Scene) -> QuantityRow | None:
    """Response whose peak at the first resonance is a number: of a free tip, of a harvester."""
    if scene.load.kind == "none" and not beyond_voltage(scene):
        return TIP_VELOCITY
    excitation = excitation_of(scene.circuit, scene.drive)
    taken = scene.circuit.kind == "load" and scene.circuit.resistance > 0.0
    if taken and excitation.is_mechanical and scene.load.kind in ("none", "mass"):
        return CIRCUIT_POWER
    return None


def _peak(
    device: Actuator, name: str, points: Mapping[str, Floats], modes: Sequence[Floats], rounds: int
) -> tuple[Floats, Floats]:
    """Frequency (n,) in Hz and height (n,) of a response's resonance.

    `modes` are first frequencies (n,) in short and in open circuit, between which a circuit's lies.
    """
    if name == CIRCUIT_POWER.name:
        between = np.sqrt(modes[0] * modes[1])
        return resonance_peak(partial(circuit_power, device), points, between, rounds)
    read = QUANTITIES[name].port_readout
    return resonance_peak(partial(evaluate, device, read), points, modes[0], rounds)


def _response(row: QuantityRow, frequency: float) -> Target:
    return Target(row.name, f"{row.label}, {frequency:g} Hz", row.unit, frequency)


class SampledNumbers:
    """Headline numbers of a scene at samples (n,) of its keys; tapers have few segments."""

    def __init__(self, scene: Scene, points: dict[str, Floats]) -> None:
        self.actuator = replace(actuator(scene), segments=_SEGMENTS)
        self._points = points
        self._size = next(iter(points.values())).size
        self._modes: dict[Electrodes, Floats] = {}
        self._peaks: dict[str, tuple[Floats, Floats]] = {}

    def of(self, target: Target) -> Floats:
        """Target's value (n,) at each sample."""
        if target.peak:
            return self._peak_of(target.name)[int(target.peak == "height")]
        read = target.read
        if isinstance(read, Readout):
            at = np.full(self._size, target.frequency or 0.0)
            return np.abs(evaluate(self.actuator, read, self._points, at))
        first = [self._mode(circuit) for circuit in read.circuits]
        return np.asarray(read.combine(*first)) if read.combine else first[0]

    def _peak_of(self, name: str) -> tuple[Floats, Floats]:
        """Frequency (n,) in Hz and height (n,) of a response's resonance."""
        if name not in self._peaks:
            modes = self._mode("short"), self._mode("open")
            self._peaks[name] = _peak(self.actuator, name, self._points, modes, 5)
        return self._peaks[name]

    def _mode(self, circuit: Electrodes) -> Floats:
        if circuit not in self._modes:
            start = np.full(self._size, _first(self.actuator, circuit))
            self._modes[circuit] = first_frequency(
                self.actuator, self._points, start, open_circuit=circuit == "open"
            )
        return self._modes[circuit]


def _first(device: Actuator, circuit: Electrodes) -> float:
    """First natural frequency (Hz)."""
    pieces = sections(
        device.device, device.support, device.beam, lossy=False, segments=device.segments
    )
    return float(bending_frequencies(pieces, device.ends, 1, open_circuit=circuit == "open")[0])


def values_and_errors(
    scene: Scene, numbers: Sequence[Target]
) -> Iterator[tuple[Target, float, float]]:
    """Yield each headline number as everywhere else, with its absolute numerical error."""
    device, peaks = actuator(scene), []
    if peaking := next((target.name for target in numbers if target.peak), ""):
        modes = [np.array([_first(device, circuit)]) for circuit in ("short", "open")]
        peaks = [float(_peak(device, peaking, {}, modes, rounds)[0][0]) for rounds in (4, 5)]
    at = (*FREQUENCIES, ILL_CONDITIONED, *peaks[1:])
    names = sorted({target.name for target in numbers})
    at_them = scene.model_copy(update={"frequency": at})
    solution = solve(at_them, ("tmm",), names, modelling=False)
    for target in numbers:
        if target.peak == "frequency":
            yield target, peaks[1], abs(peaks[1] - peaks[0])
            continue
        q, i = solution.get(target.name, "tmm"), -1 if target.peak else 0
        if target.frequency is not None:
            i = at.index(target.frequency)
        yield target, float(np.abs(np.atleast_1d(q.value)[i])), float(np.atleast_1d(q.error)[i])


def uncertain_parameters(scene: Scene) -> dict[str, Spread]:
    """Ranges of the transfer-matrix model's parameters that have one, in the scene's order.

    Springs that stand for a contact are no parameters of the scene.
    """
    scene = with_materials_as_keys(scene)
    known = ranges(scene)
    found = {key: known[key] for key in parameter_keys(actuator(scene)) if key in known}
    return {k: of for k, of in found.items() if of.high > of.low and not idle(scene, k)}


def range_text(key: str, spread: Spread) -> str:
    """Range of a key as people read it."""
    info = declaration(key)
    low, (high, _, unit) = show(spread.low, info), show(spread.high, info).partition(" ")
    return f"{low.partition(' ')[0]} to {high} {unit}".rstrip()


def left_out(scene: Scene) -> str:
    """Sentence on numbers that are known to vary and are not sampled, "" if none."""
    scene = with_materials_as_keys(scene)
    device = actuator(scene)
    known = parameter_keys(device)
    layers = [f"bimorph.{name}" for name in scene.bimorph.layers.smooth_sizes]

    def reason(key: str) -> str:
        value = value_of(scene, key)
        if not value or key in known:
            return ""
        if isinstance(value, Profile):
            return "points of a profile"
        unread = "not read by the transfer-matrix model" if key in scene.tolerances else ""
        if not isinstance(value, float) or idle(scene, key):
            return unread
        if scene.support.kind == "contact" and key.startswith(("contact.", "guide.")):
            return "springs of a contact"
        if read_as(key) != key and key not in layers:
            return "layers poled along"
        if has_kink(device, key):
            return "a piece of the row of beams appears or vanishes there"
        return unread

    keys: dict[str, list[str]] = {}
    for key in number_keys(scene):
        keys.setdefault(reason(key), []).append(key)
    keys.pop("", None)
    listed = [f"{', '.join(those)} ({why})" for why, those in keys.items()]
    if names := sorted({layer.material for layer in scene.bimorph.layers} - set(OWN)):
        listed.append(
            f"constants of {', '.join(names)} (of a second material of its kind in bimorph.layers)"
        )
    return f"left out of the parameters: {'; '.join(listed)}" if listed else ""


def parameter_uncertainty(
    scene: Scene, evaluations: int | None = None, announce: Callable[[str], None] = lambda _: None
) -> list[Uncertainty]:
    """Every headline number with its uncertainty.

    `evaluations` is how often the model may be solved; the largest power of two of base samples
    that this allows is taken.
    """
    from SALib.analyze import sobol
    from SALib.sample import sobol as saltelli

    scene = with_materials_as_keys(scene)
    parameters = uncertain_parameters(scene)
    keys = tuple(parameters)
    bounds = np.array([spread[:2] for spread in parameters.values()])
    problem = {"num_vars": len(keys), "names": list(keys), "bounds": bounds.tolist()}
    base = base_samples(len(keys), evaluations or affordable(scene))
    points = saltelli.sample(problem, base, calc_second_order=False, seed=_SEED)
    usual = np.array([value_of(scene, key) for key in keys])
    places = np.array([0.0, *PLACES])
    close = usual * (1.0 + _CLOSE * np.kron(np.eye(len(keys)), places[:, None]))
    sampled, beside = (
        SampledNumbers(scene, dict(zip(keys, part.T, strict=True))) for part in (points, close)
    )
    # Saltelli's rows come in groups of A, the mixtures, B; A and B are independent samples
    independent = np.isin(np.arange(len(points)) % (len(keys) + 2), (0, len(keys) + 1))
    rows = []
    for target, value, error in values_and_errors(scene, targets(scene)):
        announce(f"parameter uncertainty: {target.label}")
        near = beside.of(target).reshape(len(keys), places.size)
        # what is taken over from the samples' model is relative
        y = sampled.of(target) * (value / near[0, 0])
        indices = sobol.analyze(problem, y, calc_second_order=False, num_resamples=100, seed=_SEED)
        relative, _ = extrapolated(near.T / near[0, 0], np.zeros(len(keys)), _CLOSE)
        slope = value * relative / usual
        reach = np.abs(bounds - usual[:, None]).max(axis=1)
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
                slopes=dict(zip(keys, slope.tolist(), strict=True)),
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
