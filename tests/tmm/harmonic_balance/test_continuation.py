"""Branches followed over frequency and drive, and what is said where that cannot be done."""

import itertools

import numpy as np
import pytest

from tactgen.tmm.harmonic_balance import continuation
from tactgen.tmm.harmonic_balance import steady as response
from tactgen.tmm.harmonic_balance.balance import NoConvergence, Orbit
from tactgen.tmm.harmonic_balance.continuation import folds, follow, steady_orbit
from tactgen.tmm.harmonic_balance.steady import Resolution, equilibrium, resolved
from tactgen.validation.evidence.cases import oscillators as cases

ROUGH = Resolution(missing=1e-5, least=5, most=40)


def crossings(oscillator, branch, parameter, value):
    """Return the amplitudes at which a branch passes a value, ascending."""
    orbits, found = branch.orbits, []
    for before, after in itertools.pairwise(orbits):
        low, high = sorted(getattr(o, parameter) for o in (before, after))
        if low <= value < high:
            orbit = resolved(oscillator, Orbit(1.2, 1.0, after.spectrum), ROUGH)
            found.append(abs(cases.fundamental(orbit)))
    return sorted(found)


def test_over_the_drive_and_over_the_frequency_the_same_orbits():
    """At Ω = 1.2 and full drive three orbits, whichever way the branch came."""
    oscillator = cases.driven_duffing()
    start = steady_orbit(oscillator, 1.2, 0.01, resolution=ROUGH)
    branch = follow(oscillator, start, "level", 0.01, 2.5, resolution=ROUGH)
    assert not branch.ended
    assert len(folds(oscillator, branch)) == 2
    by_drive = crossings(oscillator, branch, "level", 1.0)
    by_frequency = crossings(oscillator, cases.driven_duffing_branch(), "omega", 1.2)
    assert len(by_drive) == 3
    assert by_drive == pytest.approx(by_frequency, rel=1e-6)


def test_a_drive_exactly_at_a_fold():
    """Newton's matrix is singular at one orbit there; from rest the other, small one is found."""
    oscillator = cases.driven_duffing()
    fold = cases.driven_duffing_folds()[0]
    orbit = steady_orbit(oscillator, fold.omega, 1.0)
    assert abs(cases.fundamental(orbit)) < 0.5 * abs(cases.fundamental(fold))
    with pytest.raises(NoConvergence, match="did not settle"):
        resolved(oscillator, Orbit(fold.omega * (1.0 + 1e-4), 1.0, fold.spectrum), ROUGH)


def test_a_branch_that_is_too_long_says_so():
    """The points met are kept, and each is told as it is met."""
    told = []
    oscillator = cases.driven_duffing()
    start = steady_orbit(oscillator, 0.5, 1.0, resolution=ROUGH)
    branch = follow(
        oscillator, start, "omega", 0.5, 1.6, resolution=ROUGH, most=7, announce=told.append
    )
    assert branch.ended == "the branch was left after 7 points"
    assert len(branch.orbits) == 7
    assert branch.orbits == (start, *told)


def test_what_nothing_holds_is_refused():
    """A mass without spring has no state of rest."""
    with pytest.raises(NoConvergence, match=r"no state of rest .* nothing holds a coordinate"):
        equilibrium(cases.one_mass(lambda x: (0.0 * x, 0.0 * x)))


def test_what_has_no_orbit_says_how_far_it_came():
    """A spring that softens to nothing: x - x³/5 pushed slowly beyond its largest force."""
    weak = cases.one_mass(cases.cubic(-0.2), stiffness=1.0, damping=0.1, force=2.0)
    with pytest.raises(NoConvergence, match=r"no orbit was found at a drive of 1, the highest"):
        steady_orbit(weak, 0.05, 1.0, resolution=Resolution(1e-3, 3, 7))
    assert np.isfinite(steady_orbit(weak, 0.05, 0.3).spectrum).all()


@pytest.mark.parametrize(("had", "least", "left"), [(20, 5, 15), (7, 5, 5), (6, 5, 6)])
def test_harmonics_that_nothing_moves_in_are_dropped(had, least, left):
    """A quarter of them at each step where far less is missing than may be, down to the fewest."""
    oscillator = cases.driven_duffing()
    start = steady_orbit(oscillator, 1.2, 1e-3, resolution=ROUGH).with_harmonics(had)
    branch = follow(
        oscillator, start, "level", 1e-3, 1.02e-3, resolution=Resolution(1e-5, least, 40)
    )
    assert branch.orbits[1].harmonics == left


def test_a_step_that_finds_nothing_is_halved(monkeypatch):
    """Until it finds something, which is the same branch; if it never does, that is said."""
    oscillator = cases.driven_duffing()
    start = steady_orbit(oscillator, 0.5, 1.0, resolution=ROUGH)
    plain = follow(oscillator, start, "omega", 0.5, 0.6, resolution=ROUGH)
    whole, tried = continuation._advance_resolved, []

    def stumbling(oscillator, step, length, resolution):
        tried.append(length)
        if len(tried) <= stumbles:
            raise NoConvergence("lost")
        return whole(oscillator, step, length, resolution)

    monkeypatch.setattr(continuation, "_advance_resolved", stumbling)
    stumbles = 2
    found = follow(oscillator, start, "omega", 0.5, 0.6, resolution=ROUGH)
    assert found.steps[0].length == tried[2] == 0.5 * tried[1] == 0.25 * tried[0]
    assert not found.ended
    last = [branch.orbits[-1] for branch in (plain, found)]
    assert last[0].omega == last[1].omega == 0.6
    np.testing.assert_allclose(last[1].spectrum, last[0].spectrum, rtol=1e-9, atol=1e-12)
    stumbles = 10**6
    none = follow(oscillator, start, "omega", 0.5, 0.6, resolution=ROUGH)
    assert none.ended == "the branch could not be followed further: lost"
    assert none.orbits == (start,)


def test_no_more_harmonics_than_may_be_taken():
    """However much they miss: a cubic spring has all odd ones."""
    oscillator = cases.driven_duffing()
    start = steady_orbit(oscillator, 1.2, 1.0, resolution=ROUGH)
    found = resolved(oscillator, start.with_harmonics(3), Resolution(1e-15, 3, 8))
    assert found.harmonics == 8


def test_an_orbit_reached_from_rest_is_as_fine_as_asked(monkeypatch):
    """Where Newton's method finds none at once, the drive is raised: to the same orbit."""
    oscillator, few = cases.driven_duffing(), Resolution(1e-9, 3, 5)
    at_once = steady_orbit(oscillator, 0.8, 1.0, resolution=few)

    def lost(*_):
        raise NoConvergence("lost")

    monkeypatch.setattr(response, "resolved", lost)
    raised = steady_orbit(oscillator, 0.8, 1.0, resolution=few)
    assert (raised.omega, raised.level, raised.harmonics) == (0.8, 1.0, at_once.harmonics)
    np.testing.assert_allclose(raised.spectrum, at_once.spectrum, atol=1e-9)
