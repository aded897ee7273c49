"""How far the units' first natural frequencies lie apart, and the screws that bring them together.

Each unit is drawn from the scatter and answered by its own model on its own contact.  A grub screw
compresses the return spring by its pitch in a turn; it can be turned either way as far as it stays
within the ground plate.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.display.layout import drawn_units, unit_names
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.model import Modes, Refined
from tactgen.validation.engine.results import Estimate
from tactgen.validation.scene.scene import Scene

#: First frequency of a scene with its error bar (Hz), by some model.
FirstFrequency = Callable[[Scene], Estimate]
#: How the bars come about.
_METHOD = "of each unit's first natural frequency, by the model's own bars"
#: Least preload that a screw leaves, as a share of the nominal one: with none the head is loose.
_LOOSE = 0.02
#: Relative distance from the target at which a search ends, and most of its steps.
_CLOSE, _MOST = 1e-6, 12
#: Slope of log f over log preload with which a search starts: f² goes with the contact's
#: stiffness, that with the preload, less what the beam bends itself.
_EXPONENT = 0.4


@dataclass(frozen=True)
class Spread:
    """The units as drawn, and after their screws were turned."""

    units: tuple[str, ...]  #: Names, row by row
    frequencies: tuple[Estimate, ...]  #: Of each unit as drawn (Hz)
    turns: tuple[float, ...]  #: Of each screw, positive tightens
    turns_bar: float  #: What the bars of the frequencies leave open in turns
    tuned: tuple[Estimate, ...]  #: After turning (Hz)
    #: Of the nominal unit with its screw as far out and in as it goes (Hz)
    lowest: Estimate
    highest: Estimate
    method: str  #: How the bars come about

    def as_drawn(self) -> Estimate:
        """Frequencies of all units as drawn."""
        return self._listed(
            [f.value for f in self.frequencies], [f.error for f in self.frequencies]
        )

    def screws(self) -> Estimate:
        """Turns of all screws."""
        return self._listed(list(self.turns), [self.turns_bar] * len(self.turns))

    def apart(self) -> Estimate:
        """How far the highest frequency is from the lowest, as drawn."""
        return _range(self.frequencies)

    def left_apart(self) -> Estimate:
        """Same after turning."""
        return _range(self.tuned)

    def reach(self) -> Estimate:
        """What a screw can do to the nominal unit's frequency, from end to end."""
        return Estimate(
            self.highest.value - self.lowest.value, self.highest.error + self.lowest.error
        )

    def _listed(self, values: list[float], bars: list[float]) -> Estimate:
        return Estimate(np.array(values), np.array(bars), classes=self.units)


def _range(found: tuple[Estimate, ...]) -> Estimate:
    high, low = (pick(found, key=lambda f: f.value) for pick in (max, min))
    return Estimate(high.value - low.value, high.error + low.error)


def screw_travel(display: Display) -> float:
    """How far a grub screw goes either way within the ground plate (m)."""
    return float(display.plate_thickness - display.screw_length)


def first_frequency(modes: Refined[Modes]) -> Estimate:
    """First frequency of modes with the bar that they are judged by."""
    value = float(modes.fine.frequencies[0])
    rounding = np.atleast_1d(np.asarray(modes.rounding))[0]
    bar = abs(value) * (1e-13 + float(rounding))
    for coarser, factor in modes.coarser:
        bar += factor * abs(value - float(coarser.frequencies[0]))
    return Estimate(value, bar)


def spread(scene: Scene, of: FirstFrequency) -> Spread:
    """What the scatter does to the units of a scene, and what the screws undo of it.

    Raises InputError if a screw would leave no preload at all.
    """
    device, display = scene.device, scene.display
    rate, step = device.spring.stiffness, display.screw_pitch
    travel = rate * screw_travel(display)
    if not rate > 0.0:
        raise InputError(
            "spring.stiffness = 0 N/m lets no screw change the preload; give the spring a stiffness"
        )
    drawn = drawn_units(device, display, scene.scatter)
    scenes = [with_device(scene, unit) for unit in drawn]
    found = tuple(of(unit) for unit in scenes)
    target = float(np.median([f.value for f in found]))
    set_to = [
        _tuned(unit, of, alone, target, travel) for unit, alone in zip(scenes, found, strict=True)
    ]
    tuned = tuple(after for _, after in set_to)
    turns = tuple(
        (force - unit.spring.preload) / (rate * step)
        for unit, (force, _) in zip(scenes, set_to, strict=True)
    )
    lowest, highest = (
        of(_pressed(scene, force)) for force in _limits(scene.spring.preload, travel)
    )
    widest = max(f.error / f.value for f in found)
    bar = (2.0 * widest + _CLOSE) / _EXPONENT * device.spring.preload / (rate * step)
    return Spread(
        unit_names(display), found, turns, bar, tuned, lowest, highest,
        _METHOD,
    )  # fmt: skip


def with_device(scene: Scene, device: Device) -> Scene:
    """Scene with another device."""
    return scene.model_copy(update={name: getattr(device, name) for name in Device.model_fields})


def _pressed(scene: Scene, preload: float) -> Scene:
    spring = scene.spring.model_copy(update={"preload": preload})
    return scene.model_copy(update={"spring": spring})


def _limits(preload: float, travel: float) -> tuple[float, float]:
    return max(preload - travel, _LOOSE * preload), preload + travel


def _tuned(
    scene: Scene, of: FirstFrequency, drawn: Estimate, target: float, travel: float
) -> tuple[float, Estimate]:
    """Preload (N) that brings a unit to a frequency, or as near as its screw goes.

    With what it then vibrates at.  Secants of log f over log preload, which is nearly straight.
    """
    if abs(drawn.value / target - 1.0) < _CLOSE:
        return scene.spring.preload, drawn
    low, high = np.log(_limits(scene.spring.preload, travel))
    before = float(np.log(scene.spring.preload)), float(np.log(drawn.value / target))
    here, found = before[0] - before[1] / _EXPONENT, drawn
    for _ in range(_MOST):
        here = float(np.clip(here, low, high))
        found = of(_pressed(scene, float(np.exp(here))))
        short = float(np.log(found.value / target))
        stuck = (here == low and short > 0.0) or (here == high and short < 0.0)
        if abs(short) < _CLOSE or stuck or here == before[0]:
            break
        slope = (short - before[1]) / (here - before[0])
        before, here = (here, short), here - short / slope
    return float(np.exp(here)), found
