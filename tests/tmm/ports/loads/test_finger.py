"""The finger's law: the paper's constants, their limits, and the guard on its fit."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tactgen.tmm.ports.loads import (
    FINGER_RANGE,
    finger_impedance,
    finger_spring_damper,
    finger_stiffness,
)


def test_finger_as_stored(state_space):
    """Impedance, stiffness and damping of the fit at seven frequencies, to 1e-14."""
    for key, stored in state_space["finger"].items():
        f = np.array([float(key)])
        assert finger_impedance(f)[0] == pytest.approx(complex(*stored["impedance"]), rel=1e-14)
        if FINGER_RANGE[0] <= f[0] <= FINGER_RANGE[1]:
            stiffness, damping = finger_spring_damper(f)
            assert stiffness[0] == pytest.approx(stored["stiffness"], rel=1e-13)
            assert damping[0] == pytest.approx(stored["damping"], rel=1e-14)


def test_raw_fit_leaves_physics_beyond_its_range():
    """Beyond 1183 Hz the raw fit's stiffness is negative, beyond 1705 Hz it creates energy."""
    negative = brentq(lambda f: finger_impedance(np.array([f])).imag[0], 1000, 1500)
    active = brentq(lambda f: finger_impedance(np.array([f])).real[0], 1500, 2000)
    assert (negative, active) == (pytest.approx(1183, abs=1), pytest.approx(1705, abs=1))
    assert finger_impedance(np.array([1800.0])).real[0] < 0.0


def test_finger_is_held_outside_its_range():
    """Outside 10–1000 Hz the constants stay those of the nearer end, so the finger is passive."""
    low, high = finger_spring_damper(np.array([10.0, 1000.0])), FINGER_RANGE
    for f, end in ((0.0, 0), (1.0, 0), (9.99, 0), (1000.01, 1), (1800.0, 1), (1e5, 1)):
        stiffness, damping = finger_spring_damper(np.array([f]))
        assert (stiffness[0], damping[0]) == (low[0][end], low[1][end])
    z = finger_stiffness(np.linspace(0.0, 1e4, 2001))
    assert (z.imag >= 0.0).all()
    assert (z.real > 0.0).all()
    assert high == (10.0, 1000.0)
