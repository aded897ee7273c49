"""The checks of large amplitudes as declarative rows; see :mod:`validation.evidence.case`."""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.small_signal import RockingHead
from tactgen.tmm.harmonic_balance.balance import Orbit
from tactgen.tmm.harmonic_balance.continuation import Branch, folds, peaks
from tactgen.validation.evidence.case import Check
from tactgen.validation.evidence.cases import oscillators
from tactgen.validation.models.backbone import (
    STATES,
    LoadedDeflection,
    State,
    held_head,
    loaded_deflection,
    response_branch,
    speed,
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
    """Number of folds of its response."""
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
    """Number of velocity peaks, not activated."""
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


_NLVIB = "NLvib, example 01 (Krack and Gross): digits that 7 and 15 harmonics share"


_ELLIPTIC = "closed form, elliptic integral of the first kind"


_UP: State = "not activated"


_HELD: State = "held"


_FIG_8 = "paper section 4, Fig 8"


_FIG_14 = "paper section 6, Fig 14"


_FIG_15 = "paper section 6, Fig 15"


_OTHER_LOAD = (
    "the model's finger was measured with 2.5 g, the paper's tip pressed on skin imitation under "
    "50 g, which also takes load off the upper stop"
)


#: Ratio of the stiffnesses of a one-sided spring, with the error of so many harmonics.
_CONTACT = ((1e-2, 1e-8), (1e2, 1e-4), (1e6, 1e-3))


_SOLVER: tuple[Check, ...] = (
    Check(
        "HB-1", "code verification",
        "A mass on a linear and a cubic spring, five times as stiff at its turning point: its free "
        "angular frequency.",
        4.357461857, "rad/s", _ELLIPTIC, 3e-10, "ten digits of the reference",
        partial(cubic_frequency, 5.0),
    ),
    Check(
        "HB-2", "code verification",
        "The period of the mass on a hardening spring of VM156 (its manual says 0.1447 s).",
        0.144043869, "s", _ELLIPTIC, 4e-9, "nine digits of the reference", vm156_period,
    ),
    Check(
        "HB-3", "code verification",
        "The driven Duffing oscillator's first harmonic at its peak.",
        2.83019806, "1", _NLVIB, 2e-9, "nine digits of the reference", duffing_peak_height,
    ),
    Check(
        "HB-4", "code verification",
        "The angular frequency of that peak.",
        1.26871674, "rad/s", _NLVIB, 4e-9, "nine digits of the reference", duffing_peak_place,
    ),
    *(
        Check(
            f"HB-{5 + i}", "code verification",
            f"The angular frequency at which the response jumps {way}.",
            reference, "rad/s", _NLVIB, 4e-6, "six digits of the reference",
            partial(duffing_fold, i),
        )
        for i, (reference, way) in enumerate(((1.26960, "down"), (1.11570, "up")))
    ),
    *(
        Check(
            f"HB-{7 + i}", "code verification",
            f"A spring {ratio:g} times stiffer on one side: its free angular frequency over the "
            "exact one.",
            1.0, "1", "closed form: half a period on each side", tolerance,
            "at most 160 harmonics of a force with a kink", partial(one_sided, ratio),
        )
        for i, (ratio, tolerance) in enumerate(_CONTACT)
    ),
    *(
        Check(
            f"HB-{10 + i}", "code verification",
            f"The free angular frequency on x + x³ from {amplitude:g}.",
            reference, "rad/s", _ELLIPTIC, 3e-10, "ten digits of the reference",
            partial(cubic_frequency, amplitude),
        )
        for i, (amplitude, reference) in enumerate(
            ((0.1, 1.003741836), (0.5, 1.089158179), (1.0, 1.317776065), (2.0, 1.976016364))
        )
    ),
    Check(
        "HB-14", "code verification",
        "Without a law: VM86's mass of 0.5 lb s²/in on 200 lb/in and 6 lb s/in, 10 lb at 20 rad/s.",
        10.0 / (6.0 * 20.0), "in", "F/(c ω) in resonance; ANSYS Verification Manual, VM86 (Close), "
        "prints 0.0833 in", 1e-10, "rounding", vm86_amplitude,
    ),
)  # fmt: skip


#: The head on its stop by the law of rough contact, whose one length is calibrated to the paper's
#: c_s at small motions and 110 mN.  No row has a constant of its own.
_PAPER: tuple[Check, ...] = (
    Check(
        "ROCK-1", "validation",
        "Free, 14 mm, 1 V: the head that may rock has its peak where the paper's fit of that "
        "measurement has it.",
        781.609, "Hz", _FIG_8, 0.02, "curves that are nearly the same to the eye",
        prototype_peak,
        explained="4.7 % is the inertia of rod and coil about the head, 1.1e-9 kg m2 as "
        "reconstructed where the paper's fit has 1e-12; 4.2 % the softening at 1 V. The contact's "
        "length was calibrated to c_s at small motions although the paper fitted c_s at 1 V; "
        "calibrated at 1 V it would be shorter. The preload of that prototype is not stated either",
        known=-0.0870,
    ),
    Check(
        "ROCK-2", "validation",
        "Its response at 1 V does not hang over: a linear model could be fitted to it.",
        0.0, "folds", _FIG_8, 0.0, "a count", prototype_folds,
    ),
    Check(
        "ROCK-3", "validation",
        "Free, 20 mm, 1 V, not activated: the response hangs over to the left; the lower fold's "
        "frequency over the upper one's.",
        (0.0, 0.99), "1", f"{_FIG_14} left", 0.0,
        "the paper shows and says it, without a number; 1 % would hardly be seen",
        overhang_up, heavy=True,
    ),
    Check(
        "ROCK-4", "validation",
        "Held by 50 mA it hangs over, too: the same ratio.",
        (0.0, 0.99), "1", f"{_FIG_14} right", 0.0, "as ROCK-3", overhang_held, heavy=True,
    ),
    Check(
        "ROCK-5", "validation",
        "Held, the support is stiffer: the peak not activated over the peak held.",
        (0.0, 1.0), "1", _FIG_14, 0.0, "the paper says it without a number",
        peak_up_over_held, heavy=True,
    ),
    Check(
        "ROCK-6", "validation",
        "Not activated, a second peak stands above the first between 10 and 1000 Hz.",
        2.0, "peaks", f"{_FIG_14} left", 0.0, "a count", peaks_up, heavy=True,
        explained="the model has the lateral actuator's peak alone. The paper ascribes the other "
        "to the combination with the normal actuator and sees it vanish where the magnet holds the "
        "rod; friction of the rod in its bore is not in the model, and its play (guide.clearance) "
        "takes away springs that are 0.04 % of the contact's",
        known=-0.5,
    ),
    Check(
        "ROCK-7", "validation",
        "Under load at 50 V, held: the line fitted to the deflection from 10 to 1000 Hz falls as "
        "the measured one.",
        -3.441e-8, "m/Hz", f"{_FIG_15} right", 2e-4, "four printed digits; that the line falls "
        "follows from its start near the simulated 45 um and the span of 13.6 to 72.4 um, which a "
        "rising line of this slope would leave",
        slope_held, heavy=True,
        explained=_OTHER_LOAD,
        known=0.3415,
    ),
    Check(
        "ROCK-8", "validation",
        "Not activated: the same line.",
        -1.164e-8, "m/Hz", f"{_FIG_15} left", 2e-4, "four printed digits; falling as ROCK-7",
        slope_up, heavy=True,
        explained=_OTHER_LOAD,
        known=0.1385,
    ),
    Check(
        "ROCK-9", "validation",
        "The slope held over the slope not activated: what holding is worth, the load apart.",
        2.956, "1", _FIG_15, 0.1,
        "quotient of two printed fits; the paper does not say how their points are spaced",
        slope_ratio, heavy=True,
        explained="it rests on the rod's inertia, which is reconstructed: with a third of it the "
        "quotient is 3.04",
        known=0.1783,
    ),
    *(
        Check(
            f"ROCK-{number}", "validation",
            f"Under load at 50 V, {state}: the {extreme} deflection from 10 to 1000 Hz.",
            reference, "m", f"{_FIG_15} {side}", 0.02, "three printed digits and the plot's width",
            partial(extreme_deflection, state, extreme), heavy=True,
            explained=f"{why}; {_OTHER_LOAD}", known=known,
        )
        for number, state, extreme, reference, side, why, known in (
            (10, _UP, "largest", 24.8e-6, "left",
             "at 10 Hz the model's moment is far below what tips the head: it moves as if held",
             0.818),
            (11, _UP, "smallest", 3.1e-6, "left",
             "the model passes a minimum near 465 Hz that losses of the head would fill", -0.871),
            (12, _HELD, "largest", 72.4e-6, "right",
             "the model has no peak under the finger's damping and is largest at 10 Hz", -0.342),
            (13, _HELD, "smallest", 13.6e-6, "right",
             "the model passes a minimum near 850 Hz", -0.909),
        )
    ),
    *(
        Check(
            f"ROCK-{14 + i}", "validation",
            f"The voltage for 1 um at 1000 Hz, {state}, is 2.5 to 4 V.",
            (2.5, 4.0), "V", "paper section 6, Fig 17", 0.0, "the range that the paper states",
            partial(threshold_voltage_at_end, state), heavy=True,
            explained="a head that rocks moves the tip more than the linear support, which asks "
            "for 42.9 V, but not enough; " + _OTHER_LOAD,
            known=known,
        )
        for i, (state, known) in enumerate(((_HELD, 0.577), (_UP, 2.115)))
    ),
)  # fmt: skip


#: The same with what was on the tip: 50 g on imitation skin, a sixteenth of it on each tip.  No
#: number of the pad was fitted to these measurements.
_ON_SKIN: tuple[Check, ...] = tuple(
    Check(
        f"ROCK-{number}", "validation",
        f"On imitation skin under 50 g at 50 V, {state}: the {extreme} deflection from 10 to 1000 "
        "Hz.",
        reference, "m", f"{_FIG_15} {side}", 0.02, "three printed digits and the plot's width",
        partial(extreme_deflection, state, extreme, "pad"), heavy=True,
        explained=f"{why}; the rubber is assumed, and the paper measured below the finger's "
        "support plate, not at the tip",
        known=known,
    )
    for number, state, extreme, reference, side, why, known in (
        (16, _UP, "largest", 24.8e-6, "left",
         "the head, half lifted off, resonates near 730 Hz; its losses there are not known", 0.583),
        (17, _UP, "smallest", 3.1e-6, "left",
         "the model passes a minimum near 380 Hz that losses of the head would fill", -0.8887),
        (18, _HELD, "largest", 72.4e-6, "right",
         "a rocking head has not the resonance near 1 kHz of a linear contact (PAD-4)", -0.549),
        (19, _HELD, "smallest", 13.6e-6, "right",
         "the model passes a minimum near 925 Hz", -0.6054),
    )
)  # fmt: skip


#: Every row about amplitudes.
CASES: tuple[Check, ...] = (*_SOLVER, *_PAPER, *_ON_SKIN)
