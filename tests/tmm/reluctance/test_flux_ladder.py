"""The magnetic circuit's solver: exact answers, energy, any saturation."""

from dataclasses import replace

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


def shifted(ladder, step):
    """Return the ladder at a gap larger by `step`, all its parts being linear in the gap."""
    moving = ("length", "reluctance", "turns")
    moved = {n: getattr(ladder, n) + step * getattr(ladder, f"d_{n}") for n in moving}
    return replace(ladder, **moved)


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


def test_derivatives_belong_to_the_coenergy():
    """Flux linkage, inductance and force are those of the co-energy, all parts moving."""
    ladder, i = random_ladder(TEAM20), np.array([0.02, 0.1, 0.5, 3.0])
    found = solve(ladder, i)
    step = 1e-5 * i
    up, down = solve(ladder, i + step), solve(ladder, i - step)
    # central differences: the square of the step, and rounding over it, 1e-15/1e-5
    linkage = (up.coenergy - down.coenergy) / (2.0 * step[:, None])
    np.testing.assert_allclose(linkage, found.flux_linkage, rtol=1e-8)
    inductance = (up.flux_linkage - down.flux_linkage) / (2.0 * step[:, None])
    # kinks in the curve's slope: a step across one shows to first order
    np.testing.assert_allclose(inductance, found.incremental_inductance, rtol=1e-4)
    h = 1e-9
    wide, close = solve(shifted(ladder, h), i), solve(shifted(ladder, -h), i)
    force = -(wide.coenergy - close.coenergy) / (2.0 * h)
    size = np.abs(found.force).max()
    np.testing.assert_allclose(force, found.force, rtol=1e-6, atol=1e-6 * size)


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
