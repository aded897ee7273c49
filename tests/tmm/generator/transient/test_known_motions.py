"""Time integration against motions that are known, its error bars, and what drives it."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from ideal_gap import IdealGap

from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient import step
from tactgen.tmm.generator.transient import time_integration as passes
from tactgen.tmm.generator.transient.step import StepTooLongError
from tactgen.tmm.generator.transient.system import (
    Coil,
    CubicSpring,
    Element,
    Friction,
    Output,
    RoughPoint,
    Stop,
    System,
)
from tactgen.tmm.generator.transient.time_integration import error_bar, simulate, simulate_steps
from tactgen.tmm.generator.transient.waveform import Chirp, Sampled, Sine, Sources, Square, Step
from tactgen.validation.evidence.cases.oscillators import free_on_cubic

ONE, UNIT = np.ones(1), np.eye(1)


def oscillator(law, *, mass=1.0, damping=0.0, stiffness=0.0, load=0.0, sign=1.0, scale=1.0):
    """One mass on a linear spring, a damper and a law along sign · x."""
    return System(
        mass * UNIT, damping * UNIT, stiffness * UNIT, load * ONE, 0.0 * ONE, 0.0,
        (Element("spring", law, sign * ONE),), (), None, {"x": Output(ONE, "m", scale)},
    )  # fmt: skip


def circuit(inductance, resistance):
    """A coil whose gap stands still, beside a mass that nothing moves."""
    coil = Coil(IdealGap(inductance), 0.0 * ONE, 1.0, resistance, "voltage")
    outputs = {"x": Output(ONE, "m", 1.0)}
    return System(UNIT, 0.0 * UNIT, UNIT, 0.0 * ONE, 0.0 * ONE, 0.0, (), (), coil, outputs)


def moving_gap(source, resistance=1.0):
    """A mass on a spring that a coil with an ideal gap of 1 m pulls at."""
    coil = Coil(IdealGap(1.0), -ONE, 1.0, resistance, source, width=0.1)
    return System(
        UNIT, 0.01 * UNIT, 4.0 * UNIT, 0.0 * ONE, 0.0 * ONE, 0.0, (), (), coil,
        {"x": Output(ONE, "m", 0.1)},
    )  # fmt: skip


def zero_crossing(time, x):
    """Return when x passes 0 first, by a cubic through the four points around."""
    k = int(np.flatnonzero(x[:-1] * x[1:] <= 0.0)[0])
    near = slice(k - 1, k + 3)
    weights = [
        math.prod(-other / (own - other) for other in x[near] if other != own) for own in x[near]
    ]
    return float(np.dot(weights, time[near]))


@pytest.mark.parametrize("amplitude", [0.1, 1.0, 5.0])
def test_a_hardening_spring_swings_in_its_period(amplitude):
    """Duffing's quarter period within the run's own error bar, over the speed at the crossing."""
    quarter = 0.5 * math.pi / free_on_cubic(1.0, 1.0, 1.0, amplitude).omega
    system = oscillator(CubicSpring(1.0, 1.0), scale=amplitude)
    told = []
    found = simulate(
        system, Sources(), 1.2 * quarter, position=amplitude * ONE, accuracy=1e-4,
        announce=told.append,
    )  # fmt: skip
    # shares of the work as it goes on, from the start again in each round
    assert told[-1] == pytest.approx(1.0)
    assert 0.0 <= told[0] < 0.1
    steps = np.diff(told)
    assert (steps < 0.0).sum() == found.rounds - 1
    assert 0.0 < steps.max() < 0.05
    x = found.outputs["x"]
    off = zero_crossing(found.run.time, x) - quarter
    speed = math.sqrt(amplitude**2 + 0.5 * amplitude**4)
    assert found.error <= 1e-4
    assert 0.0 < abs(off) * speed < found.errors["x"]


def test_a_driven_damped_mass_follows_its_closed_form():
    """m x'' + c x' + k x = θ U sin Ωt from rest: transient and forced motion."""
    m, c, k, theta, omega = 2.0, 0.3, 50.0, 4.0, 3.0
    system = System(
        m * UNIT, c * UNIT, k * UNIT, 0.0 * ONE, theta * ONE, 1e-3, (), (), None,
        {"x": Output(ONE, "m", 0.1)},
    )  # fmt: skip
    found = simulate(system, Sources(Sine(2.0, omega / (2.0 * math.pi))), 4.0)
    t = found.run.time
    steady = theta * 2.0 / (k - m * omega**2 + 1j * omega * c)
    decay, ring = 0.5 * c / m, math.sqrt(k / m - 0.25 * (c / m) ** 2)
    free = -(1j * omega * steady - 0.0).imag
    a = -steady.imag
    b = (free + decay * a) / ring
    exact = (steady * np.exp(1j * omega * t)).imag
    exact += np.exp(-decay * t) * (a * np.cos(ring * t) + b * np.sin(ring * t))
    off = np.abs(found.outputs["x"] - exact).max()
    assert 0.0 < off < found.errors["x"] < 1e-3
    charge = theta * found.outputs["x"] + 1e-3 * found.run.voltage
    assert found.run.charge == pytest.approx(charge, rel=1e-14)


@pytest.mark.parametrize("stiffness", [1e1, 1e5, 1e9])
def test_stops_over_eight_decades_settle_and_keep_the_balance(stiffness):
    """Undamped stops from soft to hard, hit at 1 m/s: no step fails, no energy appears."""
    system = oscillator(Stop(stiffness), mass=1e-3, sign=-1.0, scale=1e-2)
    back = 5e-3 + math.pi * math.sqrt(1e-3 / stiffness)
    found = simulate(system, Sources(), back + 5e-3, position=5e-3 * ONE, velocity=-ONE)
    assert found.run.position[-1, 0] == pytest.approx(5e-3, abs=found.errors["x"])
    assert found.run.velocity[-1, 0] == pytest.approx(1.0, rel=1e-9)  # nothing lost
    assert found.run.worst_imbalance < 1e-12


def over_a_step(law, before, moved):
    """Return force, slope and elastic part of one spring over 0.1 s."""
    force, slope, elastic = law.means([before], [moved], 0.1)
    return force[0], slope[0], elastic[0]


@pytest.mark.parametrize("law", [Stop(3.0), CubicSpring(1.0, 2.0), RoughPoint(0.3, 0.5, 0.1)])
def test_laws_balance_whatever_the_step(law):
    """The elastic force does what the energy changes by; the rest takes, and nothing pulls."""
    pushes_only = not isinstance(law, CubicSpring)
    for before, after in ((-1.0, 0.7), (0.7, -1.0), (0.2, 0.9), (0.9, 0.2), (0.4, 0.4 + 1e-9)):
        force, slope, elastic = over_a_step(law, before, after - before)
        change = law.energy(after) - law.energy(before)
        assert elastic * (after - before) == pytest.approx(change, rel=1e-7, abs=1e-16)
        assert (force - elastic) * (after - before) >= 0.0
        assert force >= 0.0 or not pushes_only
        if abs(after - before) > 1e-6:
            moved = [over_a_step(law, before, after - before + d)[0] for d in (-1e-6, 1e-6)]
            assert slope == pytest.approx((moved[1] - moved[0]) / 2e-6, rel=1e-5, abs=1e-9)
        energies = law.energy(np.array([after - 1e-6, after + 1e-6]))
        at_rest = over_a_step(law, after, 0.0)[0]
        assert at_rest == pytest.approx(np.diff(energies)[0] / 2e-6, rel=1e-5)


@pytest.mark.parametrize(("before", "after"), [(-40.0, 0.7), (0.7, -40.0), (-40.0, -35.0)])
def test_rough_surfaces_that_come_from_far_apart(before, after):
    """Beyond 60 decay lengths nothing acts; from there and to there the energy changes by all."""
    law = RoughPoint(0.3, 0.5, 0.1)
    assert law.apart == -30.0
    force, slope, elastic = over_a_step(law, before, after - before)
    first, last = (0.3 * np.exp(at / 0.5) if at > -30.0 else 0.0 for at in (before, after))
    assert elastic * (after - before) == pytest.approx(0.5 * (last - first), rel=1e-12)
    # a relaxation time as long as the step: what the force rises by is added
    assert force == pytest.approx(max(elastic + last - first, 0.0), rel=1e-12)
    assert (slope > 0.0) is (force > 0.0)


@pytest.mark.parametrize("deep", [5.0, 50.0, 500.0])
def test_a_guess_deep_inside_a_stop_does_not_move_the_answer(deep):
    """A step after a violent one starts far off; the pressure there is e^deep times the usual.

    The iteration ends when its corrections are below 1e-13 of the motion.
    """
    stepper, h = step.Stepper(oscillator(RoughPoint(1.0, 0.1), stiffness=1.0)), 0.1
    calm = stepper.start(0.0 * ONE, ONE, 0.0, 0.0)
    wild = replace(calm, acceleration=2.0 * deep * 0.1 / h**2 * ONE, lasted=h)
    found, expected = (stepper.step(state, h, 0.0, (0.0, 0.0))[0] for state in (wild, calm))
    np.testing.assert_allclose(found.position, expected.position, rtol=1e-12)


@pytest.mark.parametrize("constant", [False, True])
def test_friction_stops_what_slides(constant):
    """Under what pushes, or constant: µ N over m, but for the speed at which it is rounded off.

    All motion is lost in it.
    """
    mass, pressed, start = 0.1, 2.0, 0.05
    system = System(
        mass * np.eye(2), np.zeros((2, 2)), np.diag([0.0, 1.0]), np.array([0.0, pressed]),
        np.zeros(2), 0.0, (Element("floor", Stop(1e4), np.array([0.0, 1.0])),),
        (Friction(None if constant else 0, np.array([1.0, 0.0]), 0.3, 1e-6, pressed),), None,
        {"x": Output(np.array([1.0, 0.0]), "m", 1e-3)},
    )  # fmt: skip
    deceleration = 0.3 * pressed / (1.0 + 1e-4) / mass
    way, time = 0.5 * start**2 / deceleration, start / deceleration
    at = np.array([0.0, pressed / (1e4 + 1.0)])
    run = simulate_steps(
        system, Sources(), 1.2 * time, 1000, position=at, velocity=np.array([start, 0.0])
    )
    assert run.position[-1, 0] == pytest.approx(way, rel=1e-3)  # it creeps for its last 1e-3
    assert run.element_loss[-1] == pytest.approx(0.5 * mass * start**2, rel=1e-6)
    assert run.worst_imbalance < 1e-12


@pytest.mark.parametrize("resistance", [0.0, 1e-9, 1e4])
def test_circuits_from_no_resistance_to_one_that_answers_at_once(resistance):
    """The current of a stepped voltage, within the error bar; the balance to rounding."""
    inductance = 1e-3
    found = simulate(circuit(inductance, resistance), Sources(coil=Step(1.0)), 1e-3)
    t = found.run.time
    exact = (
        t / inductance
        if resistance == 0.0
        else (-np.expm1(-resistance / inductance * t) / resistance)
    )
    bar = found.errors["current"] + 1e-12 * exact.max()
    assert np.abs(found.run.current - exact)[2:].max() < bar
    assert found.run.worst_imbalance < 1e-12


@pytest.mark.parametrize("source", ["current", "voltage"])
def test_a_pulled_mass_keeps_the_balance(source):
    """Field, coil, spring, damper: what the source gives is found again, to rounding.

    The balance is of the method, not of small steps: with ten a period, far from the truth.
    """
    run = simulate_steps(moving_gap(source), Sources(coil=Sine(0.5, 0.4)), 25.0, 100)
    assert np.ptp(run.position) > 1e-3
    assert run.worst_imbalance < 1e-13
    assert abs(run.coil_work[-1]) > 1e-6


@pytest.mark.heavy
def test_the_balance_over_a_million_steps():
    """No step's imbalance, nor their sum, reaches 1e-10 of what the run exchanged."""
    run = simulate_steps(moving_gap("voltage"), Sources(coil=Sine(0.3, 0.4)), 5000.0, 1_000_000)
    each = np.abs(np.diff(run.imbalance)).max()
    assert each / (run.throughput[-1] / run.time.size) < 1e-10
    assert run.worst_imbalance < 1e-10


def test_a_run_says_until_when_it_is_certain(monkeypatch):
    """Bars grow with time, and cross the accuracy where the answer says, if no round is left."""
    monkeypatch.setattr(passes, "_ROUNDS", 1)
    monkeypatch.setattr(passes, "_LOCAL", 0.1)  # too long steps for what is asked
    system = oscillator(Stop(1e5), mass=1e-3, load=-9.81e-3, sign=-1.0, scale=1e-3)
    found = simulate(system, Sources(), 0.1, position=1e-3 * ONE, accuracy=1e-5)
    bar = found.bars["x"] / 1e-3
    assert (np.diff(bar) >= 0.0).all()
    assert found.error == pytest.approx(bar[-1])
    assert found.error > found.accuracy
    before = found.run.time <= found.certain_until
    assert 0 < before.sum() < before.size
    assert bar[before].max() <= found.accuracy < bar[~before].min()
    easy = simulate(system, Sources(), 0.02, position=1e-3 * ONE, accuracy=0.3)
    assert easy.certain_until == easy.run.time[-1]


def test_runs_that_lead_nowhere_are_refused(monkeypatch):
    """Too many steps, a circuit too fast to follow, a current beyond the map, steps that never
    settle: in either pass."""
    spring = oscillator(CubicSpring(1.0, 1.0))

    def run(system=spring, **sources):
        return simulate(system, Sources(**sources), 4.0, position=ONE, accuracy=1e-4)

    with monkeypatch.context() as patch:
        patch.setattr(passes, "MOST_STEPS", 99)  # no step is longer than a hundredth
        with pytest.raises(InputError, match=r"changes within .* need more than 99 steps; ask for"):
            run()
    with pytest.raises(InputError, match="prescribe the coil's current"):
        simulate(circuit(1e-9, 1e6), Sources(coil=Step(1.0)), 1.0)
    coil = replace(circuit(1.0, 1.0).coil, largest_current=0.5)
    with pytest.raises(InputError, match="beyond the 500 mA to which the co-energy map goes"):
        run(replace(circuit(1.0, 1.0), coil=coil), coil=Step(1.0))

    def never(*_):
        raise StepTooLongError("never")

    whole = passes.Marcher.follow

    def follow(marcher, *args, **options):
        monkeypatch.setattr(passes.Marcher, "_stepped", never)
        return whole(marcher, *args, **options)

    monkeypatch.setattr(passes, "_DEEPEST", 8)
    monkeypatch.setattr(passes.Marcher, "follow", follow)
    for _ in ("in the second pass", "in the first"):
        with pytest.raises(InputError, match="settle"):
            run()


@pytest.mark.parametrize(
    ("larger", "smaller", "error"),
    [
        (4.0, 1.0, 1.0 / 3.0),  # order two
        (2.0, 1.0, 1.0),  # order one
        (1.0, 1.0, 2.0),  # no order: as if it were 0.58
        (1.0, 5.0, 10.0),
        (4.0, 1e-3, 1.0 / 3.0),  # agreement by chance
        (0.0, 1.0, 2.0),  # no steps in pairs
        (0.0, 0.0, 0.0),
    ],
)
def test_an_error_follows_the_observed_order(larger, smaller, error):
    """Richardson's error of the last pass, times the safety factor."""
    (found,) = error_bar(np.array([larger]), np.array([smaller]), 1.25)
    assert found == pytest.approx(1.25 * error, rel=1e-12)


def test_the_bar_of_a_smooth_run_is_half_as_wide_again_as_its_error():
    """A mass on a spring: order two, so the largest error is two thirds of the bar.

    In steps as long as allowed, so that all have partners; the next term is smaller by (ω h)².
    """
    system = System(
        UNIT, 0.0 * UNIT, UNIT, 0.0 * ONE, 0.0 * ONE, 0.0, (), (), None,
        {"x": Output(ONE, "m", 1.0)},
    )  # fmt: skip
    found = simulate(system, Sources(), 10.0, position=ONE, longest=0.02)
    off = np.abs(found.outputs["x"] - np.cos(found.run.time)).max()
    assert found.errors["x"] / off == pytest.approx(1.5, rel=0.03)


def test_the_bar_holds_over_impacts():
    """A mass that bounces on a hard stop without loss, against its closed form between impacts."""
    mass, g, k, height = 1e-3, 9.81, 1e5, 1e-3
    system = System(
        mass * UNIT, 0.0 * UNIT, 0.0 * UNIT, -mass * g * ONE, 0.0 * ONE, 0.0,
        (Element("stop", Stop(k), -ONE),), (), None, {"x": Output(ONE, "m", height)},
    )  # fmt: skip
    fall = math.sqrt(2.0 * height / g)
    omega, sag = math.sqrt(k / mass), mass * g / k
    touch = 2.0 * (math.pi - math.atan(g * fall / omega / sag)) / omega
    period = 2.0 * fall + touch
    found = simulate(system, Sources(), 4.0 * period, position=height * ONE, accuracy=1e-2)
    since = (found.run.time + 0.5 * period) % period - 0.5 * period  # from the nearest top
    flies = np.abs(since) < 0.99 * fall
    off = np.abs(found.outputs["x"] - (height - 0.5 * g * since**2))[flies]
    bar = found.bars["x"][flies]
    assert (off <= bar + 1e-9 * height).all()
    assert off.max() > 1e-6 * height


#: Each with the time over which it changes smoothly.
WAVES = [
    (Step(-3.0, 0.2, 0.7), math.inf),
    (Sine(-2.0, 5.0, 0.3, 0.1), 0.2),
    (Square(-3.0, 4.0, 2.0, 0.3), math.inf),
    (Chirp(-2.0, 2.0, 8.0, 0.6), 0.125),
    (Chirp(2.0, 8.0, 2.0, 0.6), 0.125),
    (Sampled((0.0, 0.4, 0.4, 0.9), (1.0, -2.0, 0.5, 1.5)), math.inf),
]


@pytest.mark.parametrize(("wave", "shortest"), WAVES)
def test_peak_and_shortest_time(wave, shortest):
    """The peak is the largest size over time; 2e-4 is what 5,000 times leave of a crest."""
    ends = [0.0, *wave.breaks(1.0), 1.0]
    sizes = [
        abs(wave.value(time, 0.5 * (low + high)))
        for low, high in itertools.pairwise(ends)
        for time in np.linspace(low, high, 5000 // len(ends))
    ]
    assert max(sizes) == pytest.approx(wave.peak, rel=2e-4)
    assert wave.shortest == shortest


def test_samples_are_held_before_the_first_and_after_the_last():
    """Between them the straight line, a time at a jump by the side it is asked for."""
    wave = Sampled((0.1, 0.5, 0.5, 0.6), (2.0, -1.0, 3.0, 4.0))
    asked = [(0.0, 0.05), (0.2, 0.3), (0.5, 0.4), (0.5, 0.55), (0.7, 0.7)]
    found = [wave.value(time, inside) for time, inside in asked]
    assert found == pytest.approx([2.0, 1.25, -1.0, 3.0, 4.0], rel=1e-14)
    assert wave.breaks(2.0) == (0.1, 0.5, 0.6)


def test_steps_squares_and_chirps_are_where_they_say():
    square = Square(0.12, 100.0, duty=0.3, start=1e-3)
    assert square.breaks(0.02) == pytest.approx((1e-3, 4e-3, 11e-3, 14e-3))
    assert [square.value(4e-3, t) for t in (3.9e-3, 4.1e-3)] == [0.12, 0.0]
    assert [Step(2.0, 1.0, 3.0).value(1.0, t) for t in (0.9, 1.1)] == [0.0, 2.0]
    assert Step(3.0).breaks(1.0) == ()
    chirp = Chirp(1.0, 10.0, 30.0, 2.0)
    rate = (chirp.value(1.0 + 1e-7, 1.0) - chirp.value(1.0 - 1e-7, 1.0)) / 2e-7
    # half way the frequency is the mean of both, and 15 turns are done
    assert rate == pytest.approx(2.0 * math.pi * 20.0, rel=1e-6)
