"""The numbers of a scene that a reader takes away: values, derivatives, samples.

By the transfer-matrix model, which gives all three in milliseconds.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.beam.parametric import Actuator
from tactgen.tmm.beam.port_quantities import evaluate, first_frequency, resonance_peak
from tactgen.tmm.beam.sensitivities import derivatives, values
from tactgen.tmm.ports.readout import Circuit, ModalReadout, Readout
from tactgen.validation.catalogue.bimorph import TIP_DISPLACEMENT, TIP_VELOCITY
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import QuantityRow
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.scene.scene import Scene

#: Frequencies at which loaded or free motion is a headline number (Hz), and one at which
#: it is shown as a warning: beside a minimum of the loaded 20 mm actuator.
FREQUENCIES, ILL_CONDITIONED = (10.0, 100.0, 250.0), 1000.0

#: Prismatic stretches of a tapered piece in derivatives and samples, whose relative size
#: they settle to a few percent; the numbers themselves take as many as everywhere else.
_SEGMENTS = 4
#: Rounds of the search for the peak.
_ROUNDS = 5

#: The resonance whose peak is a headline number: that of a free tip.
_RESONANCE = TIP_VELOCITY


@dataclass(frozen=True)
class Target:
    """A headline number: a quantity, by magnitude, at a frequency (Hz) if it has one.

    `peak` is set for a number about the quantity's resonance instead.
    """

    quantity: QuantityRow
    label: str
    unit: str
    frequency: float | None = None
    ill_conditioned: bool = False
    peak: Literal["", "frequency", "height"] = ""

    def __reduce__(self) -> tuple[Any, ...]:
        """Travel between processes with the quantity's name: its row holds functions."""
        others = [getattr(self, field.name) for field in fields(self)[1:]]
        return _target, (self.quantity.name, *others)

    @property
    def read(self) -> Readout | ModalReadout:
        """How the quantity is read."""
        assert isinstance(self.quantity.read, Readout | ModalReadout)
        return self.quantity.read


def _target(quantity: str, *others: Any) -> Target:
    return Target(QUANTITIES[quantity], *others)


def actuator(scene: Scene) -> Actuator:
    """Return what the transfer-matrix model reads of a scene."""
    return Actuator(scene.device, scene.held, scene.load, scene.beam, scene.drive)


def targets(scene: Scene) -> tuple[Target, ...]:
    """Return the headline numbers that this scene has."""
    held = not scene.ends.rigid_motions
    active = scene.piezo.d31 != 0.0
    rows = [
        row
        for row in QUANTITIES.values()
        if row.varied
        and (active or not row.is_transduced)
        and (held or not (row.static and row.held_by_support))
    ]
    found = [Target(row, row.label, row.unit) for row in rows if not row.by_frequency]
    found += [_response(row, f) for row in rows if row.by_frequency for f in FREQUENCIES]
    if active and scene.load.kind == "none":
        found += [
            Target(_RESONANCE, "peak frequency", "Hz", peak="frequency"),
            Target(_RESONANCE, "peak tip velocity", _RESONANCE.unit, peak="height"),
        ]
    if active and scene.load.kind == "finger":
        found.append(replace(_response(TIP_DISPLACEMENT, ILL_CONDITIONED), ill_conditioned=True))
    return tuple(found)


def _response(row: QuantityRow, frequency: float) -> Target:
    return Target(row, f"{row.label}, {frequency:g} Hz", row.unit, frequency)


class HeadlineNumbers:
    """Values, derivatives and numerical error bars of a scene's headline numbers.

    `actuator` is what derivatives and samples are taken of.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.actuator = replace(actuator(scene), segments=_SEGMENTS)
        self._first: dict[Circuit, float] = {}

    def first(self, circuit: Circuit) -> float:
        """Return the first natural frequency (Hz)."""
        if circuit not in self._first:
            self._first[circuit] = float(values(self.actuator, ModalReadout((circuit,)))[0])
        return self._first[circuit]

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Frequency (Hz) and height (m/s) of the free tip's velocity peak."""
        return self._peak_of(actuator(self.scene))

    def _peak_of(self, of: Actuator) -> tuple[float, float]:
        return _peak(of, self.first("short"), _ROUNDS)

    @cached_property
    def solution(self) -> Solution:
        """The same numbers as everywhere else, with their error bars."""
        at = [*FREQUENCIES, ILL_CONDITIONED, *([self.peak[0]] if self._free else [])]
        names = {t.quantity.name for t in targets(self.scene)}
        changed = self.scene.model_copy(update={"frequency": tuple(at)})
        return solve(changed, ("tmm",), sorted(names))

    @property
    def _free(self) -> bool:
        return self.scene.load.kind == "none" and self.scene.piezo.d31 != 0.0

    def value_and_bar(self, target: Target) -> tuple[float, float]:
        """Return the number and its numerical error bar, absolute."""
        if target.peak == "frequency":
            before, _ = _peak(actuator(self.scene), self.peak[0], _ROUNDS - 1)
            return self.peak[0], abs(before - self.peak[0])
        found, i = self.solution.get(target.quantity.name, "tmm"), 0
        if target.peak:
            i = -1
        elif target.frequency is not None:
            i = (*FREQUENCIES, ILL_CONDITIONED).index(target.frequency)
        value, bar = np.atleast_1d(found.value)[i], np.atleast_1d(found.error)[i]
        return float(np.abs(value)), float(bar)

    def value_and_slopes(
        self, target: Target, keys: tuple[str, ...]
    ) -> tuple[float, dict[str, float]]:
        """Return the number of `actuator` and its derivative by each key."""
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
        """Return height or frequency f of the peak of L = ln|v| and its derivatives.

        At the peak ∂L/∂f = 0, so the height changes by ∂L/∂p at fixed f, and f by
        −(∂²L/∂f∂p)/(∂²L/∂f²); central differences over 1e-4 of f, good to some 1e-4.
        """
        frequency, height = self._peak_of(self.actuator)
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
    read = _RESONANCE.port_readout
    at, size = resonance_peak(of, read, {}, np.array([start]), rounds=rounds)
    return float(at[0]), float(size[0])


class SampledNumbers:
    """The headline numbers at every sample; frequencies of modes are found once.

    Parameters
    ----------
    numbers : HeadlineNumbers
        Whose actuator is sampled.
    points : dict of str to (n,) array
        Values by scene key.
    """

    def __init__(self, numbers: HeadlineNumbers, points: dict[str, Floats]) -> None:
        self._numbers, self._points = numbers, points
        self._size = next(iter(points.values())).size
        self._modes: dict[Circuit, Floats] = {}

    def of(self, target: Target) -> Floats:
        """Return the target's value (n,) at each sample."""
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
        read = _RESONANCE.port_readout
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
