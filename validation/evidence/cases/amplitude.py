"""Large amplitudes: oscillators with known answers, the paper's Figs 8, 14 and 15."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Contact, spreads
from tactgen.tmm.generator.small_signal import RockingHead
from tactgen.tmm.harmonic_balance.continuation import Branch, folds, peaks
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.case import Case, Check, Null, case, middle
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
from tactgen.validation.models.model import Estimate
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.published_measurements import PLACE


def _cubic_frequency(amplitude: float) -> float:
    """Free angular frequency of x'' + x + x³ = 0 from x = `amplitude` (rad/s)."""
    return oscillators.free_on_cubic(1.0, 1.0, 1.0, amplitude).omega


def _one_sided(ratio: float) -> float:
    """Free frequency on a spring stiffer on one side, over the exact one, 2 ω₁ ω₂/(ω₁ + ω₂)."""
    stiff = math.sqrt(1.0 + ratio)
    return oscillators.free_on_one_sided(ratio, 160).omega * (1.0 + stiff) / (2.0 * stiff)


_NLVIB = "NLvib, example 01 (Krack and Gross): digits that 7 and 15 harmonics share"
_ELLIPTIC = "closed form, elliptic integral of the first kind"
_TEN, _NINE = "ten digits of the reference", "nine digits of the reference"
_OSCILLATORS = case(
    "HB", "Oscillators whose large motions are known",
    "Free: a mass on a linear and a cubic spring, and on a spring that is stiffer to one side. "
    "Driven: Duffing's oscillator ẍ + 0.05 ẋ + x + 0.1 x³ = 0.18 cos Ωt (damping ratio 0.025): its "
    "peak and the two frequencies at which it jumps.",
    [
        Check("A mass on a linear and a cubic spring, five times as stiff at its turning point: "
              "its free angular frequency.", 4.357461857, "rad/s", partial(_cubic_frequency, 5.0),
              3e-10, _TEN, _ELLIPTIC),
        Check("The period of the mass on a hardening spring of VM156 (its manual says 0.1447 s).",
              0.144043869, "s", oscillators.period_of_vm156, 4e-9, _NINE, _ELLIPTIC),
        Check("The driven Duffing oscillator's first harmonic at its peak.", 2.83019806, "1",
              lambda: abs(oscillators.fundamental(oscillators.driven_duffing_peak())), 2e-9, _NINE,
              _NLVIB),
        Check("The angular frequency of that peak.", 1.26871674, "rad/s",
              lambda: oscillators.driven_duffing_peak().omega, 4e-9, _NINE, _NLVIB),
        Check("The angular frequency at which the response jumps down.", 1.26960, "rad/s",
              lambda: oscillators.driven_duffing_folds()[0].omega, 4e-6,
              "six digits of the reference", _NLVIB),
        Check("The angular frequency at which the response jumps up.", 1.11570, "rad/s",
              lambda: oscillators.driven_duffing_folds()[1].omega, 4e-6,
              "six digits of the reference", _NLVIB),
        *(
            Check(f"A spring {ratio:g} times stiffer on one side: its free angular frequency over "
                  "the exact one.", 1.0, "1", partial(_one_sided, ratio), tolerance,
                  "at most 160 harmonics of a force with a kink",
                  "closed form: half a period on each side")
            for ratio, tolerance in ((1e-2, 1e-8), (1e2, 1e-4), (1e6, 1e-3))
        ),
        *(
            Check(f"The free angular frequency on x + x³ from {amplitude:g}.", reference, "rad/s",
                  partial(_cubic_frequency, amplitude), 3e-10, _TEN, _ELLIPTIC)
            for amplitude, reference in (
                (0.1, 1.003741836), (0.5, 1.089158179), (1.0, 1.317776065), (2.0, 1.976016364),
            )
        ),
        Check("Without a law: VM86's mass of 0.5 lb s²/in on 200 lb/in and 6 lb s/in, 10 lb at 20 "
              "rad/s.", 10.0 / (6.0 * 20.0), "in",
              lambda: abs(oscillators.fundamental(oscillators.driven_vm86())), 1e-10, "rounding",
              "F/(c ω) in resonance; ANSYS Verification Manual, VM86 (Close), prints 0.0833 in"),
    ],
    model="harmonic balance with as many harmonics as the motion asks for",
)  # fmt: skip

# --- the paper's rocking head ------------------------------------------------------------------

#: Where the paper swept the small signal, and its 14 mm prototype round the peak (Hz).
_BAND, _ROUND = (10.0, 1000.0), (600.0, 1000.0)
_UP: State = "not activated"
_HELD: State = "held"


#: Where below the tip the laser may have looked in Figs 15 and 17 (m): between these.
_PLACES = (PLACE.low, PLACE.usual, PLACE.high)


#: Length of the contact (m) calibrated at 1 V, the low end of its key's range.
_AT_1_VOLT = spreads(Contact())["decay_length"].low


@cache
def _head(scene: str, state: State, load: str, below: float = 0.0, *more: str) -> RockingHead:
    overrides = ("support.kind=contact", "models=tmm", f"load.kind={load}", *STATES[state])
    overrides += (f"measurement.below_tip={1e3 * below!r} mm", *more)
    if load == "pad":  # a sixteenth of the weight of 50 g rests on each tip
        overrides += ("load.normal_force=30.65mN",)
    return held_head(load_scene(scene, overrides)[0])


@cache
def _free(scene: str, state: State, *more: str) -> tuple[RockingHead, Branch]:
    """Free actuator at 1 V with its response."""
    head = _head(scene, state, "none", 0.0, *more)
    return head, response_branch(head, 1.0, _ROUND if scene == "prototype" else _BAND)


def _peaks(scene: str, state: State, *more: str) -> list[float]:
    """Frequencies of its velocity peaks (Hz)."""
    head, branch = _free(scene, state, *more)
    return [at.orbit.frequency for at in peaks(head.oscillator, branch, speed(head))]


def _folds(scene: str, state: State) -> list[float]:
    """Frequencies at which its response turns back (Hz)."""
    head, branch = _free(scene, state)
    return [at.orbit.frequency for at in folds(head.oscillator, branch)]


def _overhang(state: State) -> float:
    """Lower over upper fold's frequency of the 20 mm actuator."""
    upper, lower = _folds("paper", state)
    return lower / upper


def _prototype_peak(*more: str) -> float:
    return _peaks("prototype", _UP, *more)[0]


def _first_frequency(*overrides: str) -> float:
    """First frequency (Hz) of the 14 mm prototype, on the paper's springs by default."""
    scene, _ = load_scene("prototype", ("models=tmm", "load.kind=none", "modes=1", *overrides))
    return float(solve(scene, ["tmm"], ["short_circuit_frequencies"]).quantities[0].value[0])


def _small() -> float:
    """Its first frequency on the contact, in small motions (Hz)."""
    return _first_frequency("support.kind=contact", *STATES[_UP])


#: Offsets (mm) and directions (degrees) of a spring that presses off both axes: what a groove or a
#: burr may do, from a third of the head's radius to half of it.
_OFFSETS = tuple((offset, angle) for offset in (0.4, 0.6) for angle in (30.0, 60.0))


def _peaks_of_offsets(state: State) -> Estimate:
    """Peaks of the tip's speed per volt in small motions up to 1000 Hz, over the offsets."""
    found = []
    for offset, angle in _OFFSETS:
        scene, _ = load_scene("generator", [
            "load.kind=none", "models=tmm", "frequency=10 Hz:1000 Hz:496", *STATES[state],
            f"spring.eccentricity={offset} mm", f"spring.eccentricity_angle={angle} deg",
        ])  # fmt: skip
        moved = solve(scene, ["tmm"], ["tip_displacement"]).quantities[0].value
        fast = np.abs(moved) * np.array(scene.frequency)
        found.append(float(np.sum((fast[1:-1] > fast[:-2]) & (fast[1:-1] > fast[2:]))))
    return middle(found)


def _over_places(read: Callable[[float], float]) -> Estimate:
    """What is read at the places where the laser may have looked."""
    return middle(map(read, _PLACES))


def _extreme(state: State, of: Callable[[Floats], float]) -> Estimate:
    """Largest or smallest deflection at 50 V from 10 to 1000 Hz on imitation skin (m)."""
    return _over_places(lambda below: float(of(np.abs(_on_skin(state, below).displacement))))


@cache
def _on_skin(state: State, below: float) -> LoadedDeflection:
    return loaded_deflection(_head("paper", state, "pad", below), 50.0, _BAND)


def _voltage_at_end(state: State) -> Estimate:
    """Voltage for 1 um at 1000 Hz under the finger (V)."""
    return _over_places(
        lambda below: voltage_for(_head("paper", state, "finger", below), 1000.0, 1e-6, 50.0)
    )


_LINEAR = "a linear support"
_NO_FOLD = Null(_LINEAR, lambda: 1.0)
_FIG_8, _FIG_14 = "paper section 4, Fig 8", "paper section 6, Fig 14"
#: Why rows on Figs 15 and 17 are no prediction of one number; each deviation is the middle's.
_OVER = (
    f"the bar spans the places {1e3 * PLACE.low:g} to {1e3 * PLACE.high:g} mm below the tip where "
    "the laser may have looked; "
)


#: The head on its stop by the law of rough contact, whose one length is calibrated to the paper's
#: c_s at small motions and 110 mN.  No row has a constant of its own, and no number of the pad was
#: fitted to these measurements.
_HEAD = case(
    "ROCK", "The bimorph on a head that may rock, against the paper's measurements",
    "The head is pressed on its stop with a force that carries a limited moment. The paper's Fig 8 "
    "(14 mm, free, 1 V), Fig 14 (20 mm, free, 1 V, held or not), Fig 15 (50 V under load) and Fig "
    "17 (voltage at the threshold) are predicted with the one constant that small motions fixed. "
    "What stays unexplained is named in each row.",
    [
        Check("Free, 14 mm, 1 V: the head that may rock has its peak where the paper's fit of that "
              "measurement has it.", 781.609, "Hz", _prototype_peak, 0.02,
              "curves that are nearly the same to the eye", _FIG_8, known=-0.0870,
              explained="the inertia of rod and coil about the head, which the paper's fit has "
              "1e-12 kg m2 for, and the softening at 1 V lower it by about as much each (ROCK-19, "
              "ROCK-20). The contact's length was calibrated to c_s at small motions "
              "although the paper fitted c_s at 1 V, and the preload of that prototype is not "
              "stated"),
        Check("Its response at 1 V does not hang over: a linear model could be fitted to it.", 0.0,
              "folds", lambda: float(len(_folds("prototype", _UP))), 0.0, "a count", _FIG_8,
              null=Null(_LINEAR, lambda: 0.0)),
        Check("Free, 20 mm, 1 V, not activated: the response hangs over to the left; the lower "
              "fold's frequency over the upper one's.", (0.0, 0.99), "1", partial(_overhang, _UP),
              0.0, "the paper shows and says it, without a number; 1 % would hardly be seen",
              f"{_FIG_14} left", null=_NO_FOLD, heavy=True),
        Check("Held by 50 mA it hangs over, too: the same ratio.", (0.0, 0.99), "1",
              partial(_overhang, _HELD), 0.0, "as ROCK-3", f"{_FIG_14} right",
              null=_NO_FOLD, heavy=True),
        Check("Held, the support is stiffer: the peak not activated over the peak held.",
              (0.0, 1.0), "1", lambda: _peaks("paper", _UP)[0] / _peaks("paper", _HELD)[0], 0.0,
              "the paper says it without a number", _FIG_14,
              null=Null("a support that is the same in both states", lambda: 1.0), heavy=True),
        Check("Not activated, a second peak stands above the first between 10 and 1000 Hz.", 2.0,
              "peaks", lambda: float(len(_peaks("paper", _UP))), 0.0, "a count", f"{_FIG_14} left",
              heavy=True, known=-0.5,
              explained="a spring that presses on the axis leaves the lateral actuator's peak "
              "alone. The paper ascribes the other to the combination with the normal actuator and "
              "sees it vanish where the magnet holds the rod: rows ROCK-22 and ROCK-23 have both "
              "states from one offset of the spring. An upper board on springs "
              "(contact.board_stiffness) would have a second peak, too"),
        *(
            Check(f"The voltage for 1 um at 1000 Hz, {state}, is 2.5 to 4 V.", (2.5, 4.0), "V",
                  partial(_voltage_at_end, state), 0.0, "the range that the paper states",
                  "paper section 6, Fig 17", id=id_, heavy=True, known=known,
                  explained=_OVER + "the model's finger was measured with 2.5 g, the paper's tip "
                  "pressed on skin imitation under 50 g, which also takes load off the upper stop")
            for id_, state, known in (("13", _HELD, 0.378), ("14", _UP, 0.502))
        ),
        *(
            Check(f"On imitation skin under 50 g at 50 V, {state}: the {words} deflection from 10 "
                  "to 1000 Hz.", printed, "m", partial(_extreme, state, of), 0.02,
                  "three printed digits and the plot's width", f"paper section 6, Fig 15 {side}",
                  id=id_, heavy=True, explained=_OVER + "the rubber is assumed", known=known)
            for id_, state, side, words, of, printed, known in (
                ("15", _UP, "left", "largest", np.max, 24.8e-6, 0.196),
                ("16", _UP, "left", "smallest", np.min, 3.1e-6, 0.0613),
                ("17", _HELD, "right", "largest", np.max, 72.4e-6, -0.785),
                ("18", _HELD, "right", "smallest", np.min, 13.6e-6, -0.754),
            )
        ),
        Check("Free, 14 mm, in small motions: the first frequency on the contact is that on the "
              "paper's springs.", 1.0, "1", lambda: _small() / _first_frequency(), 0.02,
              "curves that are nearly the same to the eye", _FIG_8, "19", known=-0.0467,
              explained="rod and coil turn with the head, and the contact holds it less along x; "
              "the paper's fit has nearly neither"),
        Check("At 1 V its peak is where it is in small motions.", 1.0, "1",
              lambda: _prototype_peak() / _small(), 0.02, "as ROCK-1", _FIG_8, "20", known=-0.0427,
              explained="a head that carries its load on one side is softer"),
        Check("Calibrated at 1 V, where the paper fitted c_s, the contact has a length of "
              f"{1e6 * _AT_1_VOLT:g} um and that peak.", 781.609, "Hz",
              lambda: _prototype_peak(f"contact.decay_length={_AT_1_VOLT!r} m"), 0.02,
              "as ROCK-1", _FIG_8, "21", fitted="contact.decay_length",
              null=Null("the paper's springs", _first_frequency)),
        *(
            Check(f"The spring presses 0.4 to 0.6 mm off the axis, 30 to 60 degrees off the plane "
                  f"of bending, {state}: peaks from 10 to 1000 Hz in small motions.", peaks_seen,
                  "peaks", partial(_peaks_of_offsets, state), 0.0, "a count", f"{_FIG_14} {side}",
                  id_, heavy=True, null=Null("a spring on the axis", lambda: 1.0))
            for id_, state, side, peaks_seen in (
                ("22", _UP, "left", 2.0), ("23", _HELD, "right", 1.0),
            )
        ),
    ],
    model="harmonic balance on the ports of model tmm", tier="validation",
)  # fmt: skip

CASES: tuple[Case, ...] = (_OSCILLATORS, _HEAD)
