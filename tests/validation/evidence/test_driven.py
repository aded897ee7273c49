"""Scenes driven to extremes: second models agree, or a sentence says why there is no answer."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem import beam
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.time_integration import output_at
from tactgen.validation.evidence import stress_driven as sweep
from tactgen.validation.evidence import stress_machine as machine
from tactgen.validation.evidence.stress import PartRequest
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import load_scene


def test_beam_elements_are_right_or_say_how_many_they_would_need():
    """Waves too short for dense matrices are refused at once, with what answers instead."""
    row = sweep._BEAM.row(sweep.FREQUENCY, True)
    assert row.verdict == "holds or says why not"
    assert row.points
    (outside,) = row.refusals
    assert "at most 10 MHz" in outside
    scene, _ = load_scene("prototype")
    assert beam.elements_for(scene.device, 2e3) < beam.MOST_ELEMENTS
    with pytest.raises(InputError, match=r"would need.* elements.* or take the model tmm"):
        beam.elements_for(scene.device, 1e9)


@pytest.mark.heavy
def test_slow_motion_is_the_derivative_of_rest():
    """Two ways to one number: the linear machine at 1 µHz, differences of where the rod rests."""
    row = machine.slow_row(True)
    assert row.verdict == "holds", row
    assert row.worst.bound < 1e-3  # a bar that could hide the effect would prove nothing


def quantity(values, bars):
    return Quantity(name="x", model="m", unit="1", value=np.array(values), error=np.array(bars))


def test_the_worst_entry_is_that_beyond_its_bar():
    """Not the largest error; and what is no number is no answer."""
    one = quantity([1.0, 2.0], [0.5, 1e-9])
    assert sweep.worst(one, quantity([1.2, 2.01], [0.0, 0.0])) == pytest.approx(
        (0.01 / 2.01, 1e-9 / 2.01)
    )
    error, bound = sweep.worst(quantity([math.nan], [0.1]), quantity([1.0], [0.1]))
    assert not error <= bound
    assert sweep.worst(quantity([0.0], [0.0]), quantity([0.0], [0.0]))[0] == 0.0
    # what is exact, with a bar or without one, hides no other
    for values, bars in (([0.0, 1.2], [0.0, 0.1]), ([1.0, 1.2], [0.1, 100.0])):
        right = quantity([values[0], 1.0], [0.0, 0.0])
        assert sweep.worst(quantity(values, bars), right)[0] == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("off", "judged"), [((2.0, 2.5), 0.5), ((2.0, 3.1), 3.1), ((2.0,) * 3, 2.0)]
)
def test_of_a_response_one_value_in_twenty_may_miss(off, judged):
    """Two of forty are passed over, but not a third, nor one beyond three bars."""
    errors = np.full(40, 0.5)
    errors[5 : 5 + len(off)] = off
    right = quantity(np.full(40, 100.0), np.zeros(40))
    error, bound = sweep.worst(quantity(right.value + errors, np.ones(40)), right)
    assert (error, bound) == (pytest.approx(judged / 100.0), 0.01)


@pytest.mark.heavy
@pytest.mark.parametrize("run", [sweep.run_lateral, machine.run], ids=["lateral", "machine"])
@pytest.mark.parametrize("quick", [True, False])
def test_no_family_fails(run, quick):
    """All models and the machine, over their whole ranges."""
    found = run(PartRequest(quick))
    assert [(row.family, row.worst) for row in found.rows if row.verdict == "fails"] == []


@pytest.mark.heavy
def test_the_machine_in_time_holds_its_bars():
    """Blows up to 2 m/s, nothing damped, circuits of 10 ohm to 1 Mohm: each against a finer run."""
    for row in machine.motion_rows(quick=False):
        assert row.verdict == "holds", row
        assert row.points >= 12
        assert row.worst.bound < 0.2  # a bar that could hide the effect would prove nothing


def test_values_between_a_runs_times_are_those_of_the_cubic():
    """A cubic over time comes back from its values and rates, whatever the steps."""
    time = np.array([0.0, 0.1, 0.4, 1.0])
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0])
    run = SimpleNamespace(
        time=time, position=cubic(time)[:, None], velocity=cubic.deriv()(time)[:, None]
    )
    at = np.linspace(0.0, 1.0, 9)
    assert output_at(run, np.ones(1), at) == pytest.approx(cubic(at), rel=1e-12)


def test_quick_runs_reach_both_ends_of_a_range():
    """Of every sweep: some of its points, none twice, among them the last."""
    for one in (*(s for _, sweeps in sweep.LATERAL for s in sweeps), *sweep.MACHINE):
        chosen = list(one.chosen(True))
        assert len(chosen) == len(set(chosen)) <= len(one.points)
        if len(chosen) > 1:
            assert one.points[-1] in chosen, one.family
        assert list(one.chosen(False)) == list(one.points)
