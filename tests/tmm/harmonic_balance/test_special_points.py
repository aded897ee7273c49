"""Zeros along a branch that rounding moves beside the points between which they were seen."""

from types import SimpleNamespace

import pytest

from tactgen.tmm.harmonic_balance import continuation as special_points


@pytest.mark.parametrize(("here", "there", "nearer"), [(1e-17, -1.0, 0), (1.0, -1e-17, 1)])
def test_a_zero_beside_a_point_is_that_point(monkeypatch, here, there, nearer):
    """With more harmonics there is no change of sign any more: the point of less is taken."""
    first, after = (
        SimpleNamespace(value=value, length=1.0, orbit=SimpleNamespace(harmonics=3))
        for value in (here, there)
    )
    sign = -1.0 if nearer == 0 else 1.0
    solved = SimpleNamespace(value=sign, at=lambda oscillator, s: solved)
    monkeypatch.setattr(special_points, "with_harmonics", lambda step, harmonics: solved)
    branch = SimpleNamespace(steps=(first, after))
    (found,) = special_points._zeros(None, branch, lambda step: step.value, falling=True)
    assert found.orbit is (first, after)[nearer].orbit
    assert found.after == 0
