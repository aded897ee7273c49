"""The numbers of a scene that a reader takes away: values, derivatives, samples.

By the transfer-matrix model, which gives all three in milliseconds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geometry.arrays import Floats
from tmm.beam.parametric import Actuator
from tmm.beam.port_quantities import READOUTS, evaluate, first_frequency, resonance_peak
from tmm.beam.sensitivities import derivatives, values
from validation.catalogue.quantities import QUANTITIES
from validation.engine.solve import Solution, solve
from validation.scene.scene import Scene

#: Frequencies at which loaded or free motion is a headline number (Hz), and one at which
#: it is shown as a warning: beside a minimum of the loaded 20 mm actuator.
FREQUENCIES, ILL_CONDITIONED = (10.0, 100.0, 250.0), 1000.0

#: Prismatic stretches of a tapered piece in derivatives and samples, whose relative size
#: they settle to a few percent; the numbers themselves take as many as everywhere else.
_SEGMENTS = 4
#: Rounds of the search for the peak.
_ROUNDS = 5

_SCALARS = (
    "static_tip_displacement",
    "short_circuit_frequencies",
    "open_circuit_frequencies",
    "coupling_factor",
    "capacitance_free",
)


@dataclass(frozen=True)
class Target:
    """A headline number: a quantity, by magnitude, at a frequency (Hz) if it has one."""

    quantity: str
    label: str
    unit: str
    frequency: float | None = None
    ill_conditioned: bool = False


def actuator(scene: Scene) -> Actuator:
    """Return what the transfer-matrix model reads of a scene."""
    return Actuator(scene.device, scene.support, scene.load, scene.beam, scene.drive)


def targets(scene: Scene) -> tuple[Target, ...]:
    """Return the headline numbers that this scene has."""
    held = not scene.ends.rigid_motions
    active = scene.piezo.d31 != 0.0
    labels = {
        "static_tip_displacement": "static tip displacement",
        "short_circuit_frequencies": "first frequency, short circuit",
        "open_circuit_frequencies": "first frequency, open circuit",
        "coupling_factor": "coupling factor",
        "capacitance_free": "free capacitance",
    }
    found = [
        Target(name, labels[name], QUANTITIES[name].unit)
        for name in _SCALARS
        if (held or name not in ("static_tip_displacement", "capacitance_free"))
        and (active or name not in ("static_tip_displacement", "coupling_factor"))
    ]
    if active:
        found += [
            Target("tip_displacement", f"tip displacement, {f:g} Hz", "m", f) for f in FREQUENCIES
        ]
    if active and scene.load.kind == "none":
        found += [
            Target("peak_frequency", "peak frequency", "Hz"),
            Target("peak_velocity", "peak tip velocity", "m/s"),
        ]
    if active and scene.load.kind == "finger":
        f = ILL_CONDITIONED
        found.append(Target("tip_displacement", f"tip displacement, {f:g} Hz", "m", f, True))
    return tuple(found)


class HeadlineNumbers:
    """Values, derivatives and numerical error bars of a scene's headline numbers.

    `actuator` is what derivatives and samples are taken of.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.actuator = replace(actuator(scene), segments=_SEGMENTS)

    @cached_property
    def short(self) -> float:
        """First short-circuit frequency (Hz)."""
        return float(values(self.actuator, "short_circuit_frequencies")[0])

    @cached_property
    def opened(self) -> float:
        """First open-circuit frequency (Hz)."""
        return float(values(self.actuator, "open_circuit_frequencies")[0])

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Frequency (Hz) and height (m/s) of the free tip's velocity peak."""
        return self._peak_of(actuator(self.scene))

    def _peak_of(self, of: Actuator) -> tuple[float, float]:
        at, size = resonance_peak(of, {}, np.array([self.short]), rounds=_ROUNDS)
        return float(at[0]), float(size[0])

    @cached_property
    def solution(self) -> Solution:
        """The same numbers as everywhere else, with their error bars."""
        at = [*FREQUENCIES, ILL_CONDITIONED, *([self.peak[0]] if self._free else [])]
        names = {t.quantity for t in targets(self.scene)} & set(QUANTITIES)
        changed = self.scene.model_copy(update={"frequency": tuple(at)})
        return solve(changed, ("tmm",), (*sorted(names), "tip_velocity"))

    @property
    def _free(self) -> bool:
        return self.scene.load.kind == "none" and self.scene.piezo.d31 != 0.0

    def value_and_bar(self, target: Target) -> tuple[float, float]:
        """Return the number and its numerical error bar, absolute."""
        if target.quantity == "peak_frequency":
            before, _ = resonance_peak(
                actuator(self.scene), {}, np.array([self.peak[0]]), rounds=_ROUNDS - 1
            )
            return self.peak[0], abs(float(before[0]) - self.peak[0])
        if target.quantity == "peak_velocity":
            found, i = self.solution.get("tip_velocity", "tmm"), -1
        else:
            found, i = self.solution.get(target.quantity, "tmm"), 0
            if target.frequency is not None:
                i = (*FREQUENCIES, ILL_CONDITIONED).index(target.frequency)
        value, bar = np.atleast_1d(found.value)[i], np.atleast_1d(found.uncertainty)[i]
        return float(np.abs(value)), float(bar)

    def value_and_slopes(
        self, target: Target, keys: tuple[str, ...]
    ) -> tuple[float, dict[str, float]]:
        """Return the number of `actuator` and its derivative by each key."""
        if target.quantity.startswith("peak"):
            return self._peak_and_slopes(target, keys)
        at = None if target.frequency is None else np.array([target.frequency])
        value = values(self.actuator, target.quantity, at)[0]
        slopes = derivatives(self.actuator, target.quantity, keys, at)
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
        velocity = values(self.actuator, "tip_velocity", at)
        relative = {
            key: (slope / velocity).real
            for key, slope in derivatives(self.actuator, "tip_velocity", keys, at).items()
        }
        if target.quantity == "peak_velocity":
            return height, {key: float(height * r[1]) for key, r in relative.items()}
        level = np.log(np.abs(velocity))
        curvature = (level[0] - 2.0 * level[1] + level[2]) / step
        return frequency, {
            key: float(-0.5 * (r[2] - r[0]) / curvature) for key, r in relative.items()
        }


class SampledNumbers:
    """The headline numbers at every sample; frequencies of modes are found once."""

    def __init__(self, device: Actuator, points: dict[str, Floats]) -> None:
        self._actuator, self._points = device, points
        self._size = next(iter(points.values())).size
        self._known: dict[str, Floats] = {}

    def of(self, target: Target, numbers: HeadlineNumbers) -> Floats:
        """Return the target's value at each sample."""
        if target.quantity in READOUTS:
            at = np.full(self._size, target.frequency or 0.0)
            return np.abs(evaluate(self._actuator, target.quantity, self._points, at))
        if target.quantity == "short_circuit_frequencies":
            return self._mode(numbers.short, open_circuit=False)
        if target.quantity == "open_circuit_frequencies":
            return self._mode(numbers.opened, open_circuit=True)
        short = self._mode(numbers.short, open_circuit=False)
        if target.quantity == "coupling_factor":
            return np.asarray(
                np.sqrt(1.0 - (short / self._mode(numbers.opened, open_circuit=True)) ** 2)
            )
        if "peak" not in self._known:
            self._known["peak"] = np.array(resonance_peak(self._actuator, self._points, short, 3))
        return np.asarray(self._known["peak"][int(target.quantity == "peak_velocity")])

    def _mode(self, start: float, *, open_circuit: bool) -> Floats:
        name = "open" if open_circuit else "short"
        if name not in self._known:
            self._known[name] = first_frequency(
                self._actuator, self._points, np.full(self._size, start), open_circuit=open_circuit
            )
        return self._known[name]
