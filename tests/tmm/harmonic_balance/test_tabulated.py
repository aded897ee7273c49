"""A table of a frequency function: the function to rounding, and asked far less often."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.tmm.harmonic_balance import steady as tabulated
from tactgen.tmm.harmonic_balance.steady import Tabulated


class Counted:
    """Two resonators and what has a kink, and how many calls and frequencies were asked for."""

    def __init__(self, losses=0.02, kink=False, end=np.inf):
        self.losses, self.kink, self.end, self.calls, self.places = losses, kink, end, 0, []

    def __call__(self, f):
        if f.size and f.max() > self.end:
            raise InputError("beyond the end")
        self.calls += 1
        self.places.append(f)
        first, second = (
            1.0 / (place**2 * (1.0 + 1j * self.losses) - f**2) for place in (700.0, 8100.0)
        )
        third = np.maximum(f - 950.0, 0.0) if self.kink else f**2
        return np.stack([first, 1e-3 * first + second, third + 0j], axis=1)


def assert_alike(found, expected):
    """To 1e-11 of each value; what is 0 to the rounding of the largest."""
    size = np.abs(expected)
    assert (np.abs(found - expected) <= 1e-11 * size + 1e-16 * size.max(axis=0)).all()


def made(function, monkeypatch):
    monkeypatch.setattr(tabulated, "_FIRST_TABLE", 0)
    return Tabulated(function)


@pytest.mark.parametrize("kink", [False, True])
def test_it_is_the_function(kink, monkeypatch):
    """Anywhere in the range, its ends and 0 among it, to 1e-11 of each value: ten times what the
    intervals were held to, since a value may be that much smaller than the largest near it."""
    function = Counted(kink=kink)
    table = made(function, monkeypatch)
    table(np.array([20e3]))
    calls = function.calls
    for f in (
        np.random.default_rng(3).uniform(0.0, 20e3, 400),
        np.array([0.0, 20e3, 700.0, 950.0]),
    ):
        assert_alike(table(f), Counted(kink=kink)(f))
    assert function.calls <= calls + 2 * kink  # a kink's own interval is asked of the function


def test_a_pole_without_losses_is_asked_of_the_function(monkeypatch):
    """Round it no polynomial will do, and none is taken; elsewhere there are some."""
    function = Counted(losses=0.0)
    table = made(function, monkeypatch)
    table(np.array([2000.0]))
    function.places.clear()
    f = np.array([300.0, 700.0 * (1.0 + 1e-7), 1500.0])
    np.testing.assert_allclose(table(f), Counted(losses=0.0)(f), rtol=1e-11)
    assert np.concatenate(function.places).tolist() == [f[1]]


def test_where_the_function_ends_it_is_asked_itself(monkeypatch):
    """A table would look beyond; what the function refuses is refused."""
    table = made(Counted(end=1000.0), monkeypatch)
    f = np.array([10.0, 990.0])
    np.testing.assert_array_equal(table(f), Counted()(f))
    with pytest.raises(InputError, match="beyond"):
        table(np.array([1001.0]))


def test_what_is_nowhere_smooth_is_soon_given_up(monkeypatch):
    """Rounding above the tolerance: a bounded table, and the function itself.

    At 0, where no interval is short enough by its own upper end, a root is divided to an end.
    """
    asked = []

    def function(f):
        asked.append(f.size)
        return (np.sqrt(f) + 1e-9 * np.sin(1e9 * f) + 0j)[:, None]

    table = made(function, monkeypatch)
    f = np.array([0.0, 1e-3, 50.0, 900.0])
    np.testing.assert_array_equal(table(f), function(f))
    assert sum(asked) < 50 * tabulated._MOST * 4
    root = made(lambda f: (np.sqrt(f) + 0j)[:, None], monkeypatch)
    np.testing.assert_allclose(root(f)[:, 0], np.sqrt(f), rtol=1e-11)
