"""The magnetic circuit's solver: exact answers, energy, any saturation."""

import numpy as np
import pytest

from tactgen.geometry.device import magnetisation as steel
from tactgen.geometry.device.magnetisation import TEAM20
from tactgen.tmm.reluctance import flux_ladder
from tactgen.tmm.reluctance.flux_ladder import Ladder, solve


def random_ladder(curve, seed=0, m=3, n=6):
    """Return a ladder whose every number differs, with two iron elements in every cell."""
    rng = np.random.default_rng(seed)
    draw = rng.uniform
    return Ladder(
        curve=curve,
        area=draw(1e-6, 2e-6, (m, 2 * n)),
        length=draw(1e-4, 1e-3, (m, 2 * n)),
        d_length=draw(-0.5, 0.5, (m, 2 * n)),
        cell=np.tile(np.arange(n), 2),
        reluctance=draw(1e7, 1e8, (m, n + 1)),
        d_reluctance=draw(1e10, 1e11, (m, n + 1)),
        turns=draw(10.0, 100.0, (m, n)),
        d_turns=draw(-1e3, 1e3, (m, n)),
    )


def test_linear_ladder_against_a_full_matrix():
    """All cells at once: the same circuit as one dense matrix of mesh equations."""
    ladder = random_ladder(steel.linear(500.0))
    found = solve(ladder, np.array([0.3]))
    slope = 1.0 / (steel.MU0 * 500.0)
    for k in range(3):
        iron = np.zeros(6)
        np.add.at(iron, ladder.cell, slope * ladder.length[k] / ladder.area[k])
        r = ladder.reluctance[k]
        matrix = np.diag(iron + r[:-1] + r[1:]) - np.diag(r[1:-1], 1) - np.diag(r[1:-1], -1)
        flux = np.linalg.solve(matrix, 0.3 * ladder.turns[k])
        np.testing.assert_allclose(found.flux[0, k], flux, rtol=1e-11)  # rounding, condition 1e2


def test_from_far_away_steps_are_halved_until_the_energy_falls(monkeypatch):
    """A hundred times too much flux, steel and all, and the same state; too few steps are said."""
    ladder, currents = random_ladder(TEAM20), np.array([0.1, -3.0, 40.0])
    plain = solve(ladder, currents)
    guess = flux_ladder._first_guess
    monkeypatch.setattr(flux_ladder, "_first_guess", lambda *given: 100.0 * guess(*given))
    found = solve(ladder, currents)
    for name in ("flux", "coenergy", "force", "incremental_inductance"):
        np.testing.assert_allclose(getattr(found, name), getattr(plain, name), rtol=1e-9)
    monkeypatch.setattr(flux_ladder, "_STEPS", 2)
    with pytest.raises(ArithmeticError, match="did not settle"):
        solve(ladder, currents)
