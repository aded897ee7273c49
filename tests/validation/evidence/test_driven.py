"""Scenes driven to extremes: second models agree, or a sentence says why there is no answer."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem import beam
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.time_integration import output_at
from tactgen.validation.evidence import stress_driven as sweep
from tactgen.validation.evidence import stress_machine as machine
from tactgen.validation.evidence.judgement import Family, rows
from tactgen.validation.evidence.stress import RULE
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import load_scene


def judged(judge, quick):
    """Return the answers of a family."""
    family = Family("family")
    judge(family, quick)
    return family.answers


def test_beam_elements_are_right_or_say_how_many_they_would_need():
    """Waves too short for dense matrices are refused at once, with what answers instead."""
    answers = judged(partial(sweep._BEAM.judge, sweep.FREQUENCY), quick=True)
    (row,) = rows(answers, RULE)
    assert row.verdict == "holds or says why not"
    assert row.count
    (outside,) = (one.refusal for one in answers if one.refusal)
    assert "at most 10 MHz" in outside
    scene, _ = load_scene("prototype")
    assert beam.elements_for(scene.device, 2e3) < beam.MOST_ELEMENTS
    with pytest.raises(InputError, match=r"would need.* elements.* or take the model tmm"):
        beam.elements_for(scene.device, 1e9)


def judged_entries(monkeypatch, values, bars, right):
    """Return what is made of one quantity's entries beside exact ones."""

    def quantity(values, bars):
        value, error = np.broadcast_arrays(np.array(values, float), np.array(bars, float))
        return Quantity(name="x", model="m", unit="1", value=value, error=error)

    found = {"beam": quantity(values, bars), "tmm": quantity(right, 0.0)}
    monkeypatch.setattr(sweep, "solve", lambda *_: SimpleNamespace(get=lambda _, m: found[m]))
    family = Family("family")
    sweep.Pair("beam", "tmm", ("x",), "prototype").add(family, "here", None)
    (one,) = family.answers
    return one


def test_the_worst_entry_is_that_beyond_its_bar(monkeypatch):
    """Not the largest error; and what is no number is no answer."""
    one = judged_entries(monkeypatch, [1.0, 2.0], [0.5, 1e-9], [1.2, 2.01, 3.0])
    assert (one.error, one.bar) == pytest.approx((0.01 / 2.01, 1e-9 / 2.01))
    assert (one.quantity, one.which) == ("family", "x 2")
    for value, bar in ((np.nan, 0.1), (1.0, np.inf)):
        assert not judged_entries(monkeypatch, [value], [bar], [1.0]).within
    assert judged_entries(monkeypatch, [0.0], [0.0], [0.0]).error == 0.0
    # what is exact, with a bar or without one, hides no other
    for values, bars in (([0.0, 1.2], [0.0, 0.1]), ([1.0, 1.2], [0.1, 100.0])):
        one = judged_entries(monkeypatch, values, bars, [values[0], 1.0])
        assert one.error == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("off", "judged"), [((2.0, 2.5), 0.5), ((2.0, 3.1), 3.1), ((2.0,) * 3, 2.0)]
)
def test_of_a_response_one_value_in_twenty_may_miss(monkeypatch, off, judged):
    """Two of forty are passed over, but not a third, nor one beyond three bars."""
    errors = np.full(40, 0.5)
    errors[5 : 5 + len(off)] = off
    one = judged_entries(monkeypatch, 100.0 + errors, 1.0, np.full(40, 100.0))
    assert (one.error, one.bar) == (pytest.approx(judged / 100.0), 0.01)


@pytest.mark.heavy
@pytest.mark.parametrize("title", [t for t in machine.FAMILIES if "against" not in t])
def test_the_machine_in_time_holds_its_bars(title):
    """Blows up to 2 m/s, nothing damped, circuits of 10 ohm to 1 Mohm: each against a finer run."""
    answers = judged(machine.FAMILIES[title], quick=False)
    (row,) = rows(answers, RULE)
    assert row.verdict == "holds", row
    assert row.count >= 12
    assert max(one.bar for one in answers) < 0.2  # one that could hide the effect proves nothing


def test_values_between_a_runs_times_are_those_of_the_cubic():
    """A cubic over time comes back from its values and rates, whatever the steps."""
    time = np.array([0.0, 0.1, 0.4, 1.0])
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0])
    run = SimpleNamespace(
        time=time, position=cubic(time)[:, None], velocity=cubic.deriv()(time)[:, None]
    )
    at = np.linspace(0.0, 1.0, 9)
    assert output_at(run, np.ones(1), at) == pytest.approx(cubic(at), rel=1e-12)
