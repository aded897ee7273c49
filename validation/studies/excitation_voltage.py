"""Excitation voltage at the detection threshold, beside the paper's Fig 17.

V(f) = threshold(f) / |w(f) per volt|, by the transfer-matrix model, for both wirings and
for the loaded and the free tip.  The paper states neither the wiring nor the finger's
impedance at the 50 g of that experiment, so agreement is not expected; the point is to see
by how much, and what would have to be different.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.tmm.beam.port_quantities import evaluate
from tactgen.tmm.ports.excitation import UNIT_VOLTAGE
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD, STATED_VOLTAGES, StatedVoltage
from tactgen.validation.catalogue.quantities import TIP_DISPLACEMENT
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.length_map import (
    actuator,
    band_points,
    local_minima,
    with_surroundings,
)

#: Wiring, and whether the tip is loaded.
Wiring = Literal["parallel", "series"]
Case = tuple[Wiring, Literal["loaded", "free"]]
WIRINGS: tuple[Wiring, ...] = ("parallel", "series")
CASES: tuple[Case, ...] = tuple((wiring, load) for wiring in WIRINGS for load in ("loaded", "free"))
#: Frequency (Hz) at which a threshold is derived from the stated voltage.
_IMPLIED_AT = 100.0


@dataclass(frozen=True)
class Stated:
    """Stated voltage and the model's range (V) for each case."""

    paper: StatedVoltage
    model: dict[Case, tuple[float, float]]

    def ratio(self, case: Case) -> float | None:
        """Model over paper; None where the text states a range."""
        low, high = self.paper.voltages
        return self.model[case][0] / low if low == high else None


@dataclass(frozen=True)
class PerVolt:
    """Tip displacement per volt (m/V) where the text states threshold and voltage."""

    frequency: float  #: Hz
    paper: tuple[float, float]  #: (float, float) Threshold over highest and lowest stated voltage
    model: dict[Case, float]  #: By the transfer-matrix model
    #: Factor on the load's impedance that would give the paper's value (the middle of its range);
    #: None if no factor does, since the free tip already moves less
    load_factor: dict[str, float | None]

    @property
    def middle(self) -> float:
        """Geometric middle of the paper's range."""
        return math.sqrt(self.paper[0] * self.paper[1])


@dataclass(frozen=True)
class VoltageStudy:
    """Voltages at the detection threshold: over frequency, and where the text states them.

    `implied` is the threshold (m) at the frequency `implied_at` (Hz) that follows from the
    stated voltage there and the paper's own displacement per volt, interpolated.
    """

    frequencies: Floats
    voltages: dict[Case, Floats]
    stated: tuple[Stated, ...]
    moved: tuple[PerVolt, ...]
    implied_at: float
    implied: float


def voltage_study(scene: Scene) -> VoltageStudy:
    """Voltages at the threshold of a scene's actuator.

    Loaded is the scene's load, or the finger if the scene has none.
    """
    # the stated frequencies, and close by every extreme of a voltage
    stated_at = [f for s in STATED_VOLTAGES for f in s.frequencies]
    grid = np.unique([*band_points(DISPLAY_THRESHOLD.range), *stated_at])
    extremes = [_extremes(scene, case, grid, sign) for case in CASES for sign in (1.0, -1.0)]
    grid = with_surroundings(grid, np.concatenate(extremes))
    per_volt = {case: _per_volt(scene, case, grid) for case in CASES}
    threshold = DISPLAY_THRESHOLD.at(grid)
    voltages: dict[Case, Floats] = {
        case: np.asarray(threshold / np.abs(w)) for case, w in per_volt.items()
    }
    stated = []
    for paper in STATED_VOLTAGES:
        inside = (grid >= paper.frequencies[0]) & (grid <= paper.frequencies[1])
        ends = {c: (float(v[inside].min()), float(v[inside].max())) for c, v in voltages.items()}
        stated.append(Stated(paper, ends))
    moved = tuple(
        _stated_per_volt(point.frequency, point.amplitude, grid, per_volt)
        for point in DISPLAY_THRESHOLD.points
    )
    (here,) = (s for s in STATED_VOLTAGES if s.frequencies == (_IMPLIED_AT, _IMPLIED_AT))
    f, middle = np.log([(m.frequency, m.middle) for m in moved]).T
    implied = here.voltages[0] * math.exp(float(np.interp(math.log(_IMPLIED_AT), f, middle)))
    return VoltageStudy(grid, voltages, tuple(stated), moved, _IMPLIED_AT, implied)


def loaded(scene: Scene) -> Scene:
    """Scene with its own load, or under the finger if it has none."""
    return scene if scene.load.kind != "none" else _with_load(scene, "finger")


def _with_load(scene: Scene, kind: str) -> Scene:
    return scene.model_copy(update={"load": scene.load.model_copy(update={"kind": kind})})


def _extremes(scene: Scene, case: Case, grid: Floats, sign: float) -> Floats:
    """Where (Hz) the voltage has its minima (sign 1) or maxima (−1)."""

    def voltage(_: Ints, f: Floats) -> Floats:
        moved = np.abs(_per_volt(scene, case, f.ravel())).reshape(f.shape)
        return np.asarray(sign * DISPLAY_THRESHOLD.at(f) / moved)

    return local_minima(grid, voltage(np.zeros(1, int), grid)[None], voltage)[1]


def _per_volt(scene: Scene, case: Case, frequencies: Floats) -> Complex:
    """Tip displacement per volt (n,) in m/V."""
    wiring, load = case
    changed = loaded(scene) if load == "loaded" else _with_load(scene, "none")
    bimorph = scene.bimorph.model_copy(update={"wiring": wiring})
    read = replace(TIP_DISPLACEMENT.port_readout, under=UNIT_VOLTAGE)
    return evaluate(
        actuator(changed.model_copy(update={"bimorph": bimorph})), read, {}, frequencies
    )


def _stated_per_volt(
    frequency: float, threshold: float, grid: Floats, per_volt: dict[Case, Complex]
) -> PerVolt:
    """Displacement per volt at a frequency (Hz) of which the text states the threshold (m)."""
    # the narrowest statement that covers this frequency
    here = min(
        (s for s in STATED_VOLTAGES if s.frequencies[0] <= frequency <= s.frequencies[1]),
        key=lambda s: s.frequencies[1] - s.frequencies[0],
    )
    low, high = here.voltages
    at = int(np.flatnonzero(grid == frequency)[0])
    model = {case: complex(w[at]) for case, w in per_volt.items()}
    paper = threshold / high, threshold / low
    factors: dict[str, float | None] = {
        wiring: _load_factor(
            model[wiring, "free"], model[wiring, "loaded"], math.sqrt(paper[0] * paper[1])
        )
        for wiring in WIRINGS
    }
    return PerVolt(frequency, paper, {case: abs(w) for case, w in model.items()}, factors)


def _load_factor(free: complex, loaded: complex, target: float) -> float | None:
    """Factor k > 0 on the load's impedance with which |w| equals the target.

    With the tip's own dynamic stiffness D and the load's Z, w(k) = w_free / (1 + k Z/D) and
    Z/D = w_free / w_loaded − 1, hence |1 + k Z/D| = |w_free| / target, a quadratic.
    """
    z = free / loaded - 1.0
    excess = (abs(free) / target) ** 2 - 1.0
    if excess <= 0.0 or z == 0.0:
        return None
    half = z.real / abs(z) ** 2
    return -half + math.sqrt(half**2 + excess / abs(z) ** 2)
