"""What the rows of :mod:`validation.checks.amplitude` measure."""

from __future__ import annotations

from functools import cache

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.rocking import RockingHead
from tactgen.tmm.harmonic_balance.balance import Orbit
from tactgen.tmm.harmonic_balance.continuation import Branch, folds, peaks
from tactgen.validation.checks.cases import oscillators
from tactgen.validation.models.backbone import response_branch, speed
from tactgen.validation.models.rocking import (
    STATES,
    LoadedDeflection,
    State,
    held_head,
    loaded_deflection,
    voltage_for,
)
from tactgen.validation.scene.scene import load_scene

#: Where the paper swept the small signal (Hz).
_BAND = (10.0, 1000.0)


def cubic_frequency(amplitude: float) -> float:
    """Free angular frequency of x'' + x + x³ = 0 from x = `amplitude` (rad/s)."""
    return oscillators.free_on_cubic(1.0, 1.0, 1.0, amplitude).omega


def vm86_amplitude() -> float:
    """Amplitude of VM86's driven mass on a spring and a damper (in)."""
    return abs(oscillators.fundamental(oscillators.driven_vm86()))


def vm156_period() -> float:
    """Period of VM156 (s)."""
    return oscillators.period_of_vm156()


def duffing_peak_height() -> float:
    """Largest first harmonic of the driven Duffing oscillator."""
    return abs(oscillators.fundamental(oscillators.driven_duffing_peak()))


def duffing_peak_place() -> float:
    """Angular frequency of that peak (rad/s)."""
    return oscillators.driven_duffing_peak().omega


def duffing_fold(number: int) -> float:
    """Angular frequency of a fold, in the order in which they are met (rad/s)."""
    return oscillators.driven_duffing_folds()[number].omega


def one_sided(ratio: float) -> float:
    """Free frequency on a spring that is stiffer on one side, over the exact one."""
    found = oscillators.free_on_one_sided(ratio, 160).omega
    return found / oscillators.one_sided_frequency(ratio)


@cache
def _head(scene: str, state: State, load: str) -> RockingHead:
    overrides = ("support.kind=contact", "models=tmm", f"load.kind={load}", *STATES[state])
    if load == "pad":  # a sixteenth of the weight of 50 g rests on each tip
        overrides += ("load.normal_force=30.65mN",)
    return held_head(load_scene(scene, overrides)[0])


@cache
def _prototype() -> Branch:
    # round its peak at 1 V
    return response_branch(_head("prototype", "not activated", "none"), 1.0, (600.0, 1000.0))


def prototype_peak() -> float:
    """Frequency of the free 14 mm prototype's velocity peak at 1 V (Hz)."""
    head = _head("prototype", "not activated", "none")
    return peaks(head.oscillator, _prototype(), speed(head))[0].orbit.frequency


def prototype_folds() -> float:
    """How often its response turns back."""
    head = _head("prototype", "not activated", "none")
    return float(len(folds(head.oscillator, _prototype())))


@cache
def _free(state: State) -> Branch:
    return response_branch(_head("paper", state, "none"), 1.0, _BAND)


def _overhang(state: State) -> float:
    head = _head("paper", state, "none")
    upper, lower = (at.orbit.frequency for at in folds(head.oscillator, _free(state)))
    return lower / upper


def overhang_up() -> float:
    """Lower over upper fold's frequency of the free 20 mm actuator at 1 V, not activated."""
    return _overhang("not activated")


def overhang_held() -> float:
    """Lower over upper fold's frequency of the same, held."""
    return _overhang("held")


def _peaks(state: State) -> list[Orbit]:
    head = _head("paper", state, "none")
    return [at.orbit for at in peaks(head.oscillator, _free(state), speed(head))]


def peaks_up() -> float:
    """How many peaks the velocity of the same has, not activated."""
    return float(len(_peaks("not activated")))


def peak_up_over_held() -> float:
    """Frequency of the peak not activated over that held."""
    up, held = (_peaks(state)[0].frequency for state in ("not activated", "held"))
    return up / held


@cache
def _loaded(state: State, load: str = "finger") -> LoadedDeflection:
    return loaded_deflection(_head("paper", state, load), 50.0, _BAND)


def _slope(state: State) -> float:
    return _loaded(state).fitted_slope


def slope_held() -> float:
    """Slope of the line fitted to the loaded deflection at 50 V, held (m/Hz)."""
    return _slope("held")


def slope_up() -> float:
    """Slope of the same, not activated (m/Hz)."""
    return _slope("not activated")


def slope_ratio() -> float:
    """Slope held over slope not activated."""
    return _slope("held") / _slope("not activated")


def extreme_deflection(state: State, extreme: str, load: str = "finger") -> float:
    """Largest or smallest loaded deflection at 50 V from 10 to 1000 Hz (m)."""
    sizes: Floats = np.abs(_loaded(state, load).displacement)
    return float(sizes.max() if extreme == "largest" else sizes.min())


def threshold_voltage_at_end(state: State) -> float:
    """Voltage for 1 um at 1000 Hz under the finger (V)."""
    return voltage_for(_head("paper", state, "finger"), 1000.0, 1e-6, 50.0)
