"""Loads: what was measured and its error bars, the paper's finger, imitation skin."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tactgen.geometry.bimorph.boundary_conditions import Ends, TipLoad
from tactgen.geometry.device.load_table import LoadTable
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.finger_and_pad import (
    FINGER_RANGE,
    REFERENCE,
    SkinPad,
    finger_impedance,
    finger_spring_damper,
    finger_stiffness,
)
from tactgen.tmm.ports.measured_loads import MeasuredLaw, continued, disturbed, passive_fit

BAND = np.geomspace(10.0, 1000.0, 40)


def chain(rng):
    """Return the impedance of three masses on springs and dampers, drawn at random."""
    links = [
        (10 ** rng.uniform(-6, -3.5), 10 ** rng.uniform(-2, 0.3), 10 ** rng.uniform(1, 3.3))
        for _ in range(3)
    ]
    damping, stiffness = 10 ** rng.uniform(-2, 0), 10 ** rng.uniform(0, 3)

    def impedance(f):
        s, z = 2j * np.pi * f, 0.0
        for m, d, k in links:
            z = 1.0 / (1.0 / (z + m * s) + 1.0 / (d + k / s))
        return z + damping + stiffness / s

    return impedance


def table(impedance, f=BAND):
    return LoadTable("a table", f, impedance(f))


def stiffness(impedance, f):
    return 2j * np.pi * f * impedance(f)


def test_at_its_points_a_table_says_what_was_measured():
    law = MeasuredLaw(table(finger_impedance))
    np.testing.assert_allclose(law(BAND), stiffness(finger_impedance, BAND), rtol=1e-13)


def test_between_points_it_takes_energy_if_it_does_at_them():
    """A jagged table whose real part touches 0: no value between is below."""
    rng = np.random.default_rng(3)
    z = rng.uniform(0.0, 1.0, 30) * (rng.uniform(size=30) > 0.3) - 1j * rng.uniform(size=30)
    law = MeasuredLaw(LoadTable("a table", np.geomspace(10.0, 1000.0, 30), z))
    fine = np.geomspace(10.0, 1000.0, 5000)
    assert (law(fine).imag >= -1e-12).all()


def test_bars_between_points_and_beyond_them_hold():
    """Of random chains nine of ten bars hold, as far as a fit is believed; they are no walls."""
    rng = np.random.default_rng(1)
    inside, beyond, width = [], [], []
    for _ in range(25):
        z = chain(rng)
        at, out = np.geomspace(10.0, 1000.0, 57), np.array([10 / 2.9, 10 / 1.5, 1500.0, 2900.0])
        plain, fitted = MeasuredLaw(table(z)), continued(table(z))
        inside.append(np.abs(plain(at) - stiffness(z, at)) <= plain.error(at))
        beyond.append(np.abs(fitted(out) - stiffness(z, out)) <= fitted.error(out))
        width.append(fitted.error(out)[1:3] / np.abs(fitted(out)[1:3]))
    assert np.mean(inside) > 0.93
    assert np.mean(beyond) > 0.87
    assert np.median(width) < 1.0  # half as far again there is still something said


def test_beyond_its_band_a_table_is_refused():
    law = MeasuredLaw(table(finger_impedance))
    with pytest.raises(InputError, match=r"1500 Hz is outside the table a table \(10 to 1000 Hz\)"):
        law(np.array([20.0, 1500.0]))
    with pytest.raises(InputError, match="factor of 3"):
        continued(table(finger_impedance))(np.array([3.2]))


@pytest.mark.parametrize("seed", range(3))
def test_a_fit_takes_energy_at_every_frequency(seed):
    """Whatever the data, here noise: Re Z ≥ 0 far beyond the band, and finite down to 0 Hz."""
    rng = np.random.default_rng(seed)
    z = rng.normal(size=BAND.size) + 1j * rng.normal(size=BAND.size)
    fit = passive_fit(BAND, z)
    at = np.geomspace(1e-3, 1e6, 2000)
    found = fit.stiffness_at(at)
    assert (found.imag >= -1e-12 * np.abs(found)).all()
    assert np.isfinite(fit.stiffness_at(np.zeros(1))).all()
    assert min(fit.mass, fit.damping, fit.stiffness) >= 0.0
    assert (fit.b >= 0.0).all()
    # a rounding of b at its most
    assert (fit.b <= 2.0 * fit.ratio * fit.omega * fit.a * (1.0 + 1e-12)).all()


def test_a_fit_finds_springs_dampers_and_masses():
    """What is such a load is fitted to rounding of the least squares, and continued."""
    z = chain(np.random.default_rng(5))
    law = continued(table(z))
    assert law.misfit[0] < 0.02
    assert law(np.array([500.0]))[0] == pytest.approx(stiffness(z, np.array([500.0]))[0], rel=0.02)


def test_the_papers_finger_is_no_passive_load():
    """Its magnitude and phase, fitted apart, belong to none: the nearest is 5 to 10 % off."""
    assert 0.05 < continued(table(finger_impedance)).misfit[1] < 0.1


def test_only_a_table_is_disturbed():
    law = MeasuredLaw(table(finger_impedance))
    in_phase, later = disturbed(Ends(tip=law))
    at = np.array([33.0, 700.0])
    np.testing.assert_allclose(in_phase.tip(at) - law(at), law.error(at), rtol=1e-6)
    np.testing.assert_allclose(later.tip(at) - law(at), 1j * law.error(at), rtol=1e-6)
    assert disturbed(Ends(tip=TipLoad(5.0))) == ()


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


WIDE = np.geomspace(1.0, 1e4, 400)


def pad(**changed):
    numbers = {
        "shear_modulus": 0.25e6, "loss_factor": 0.3, "thickness": 5e-3, "contact_radius": 0.6e-3,
        "weight": 50e-3, "backing_stiffness": 5e3,
    }  # fmt: skip
    return SkinPad(**{**numbers, **changed})


def test_on_rigid_backing_it_is_mindlins_disc():
    """Thick and held: 32 (1 − ν) G R / (7 − 8ν) with ν = 1/2, at the reference."""
    held = pad(thickness=10.0, backing_stiffness=1e15)
    expected = 32.0 * 0.5 * 0.25e6 * 0.6e-3 / (7.0 - 4.0) * (1.0 + 0.3j)
    assert held(np.array([REFERENCE]))[0] == pytest.approx(expected, rel=1e-4)  # R/2H = 3e-5
    thin = pad(thickness=0.3e-3, backing_stiffness=1e15)
    assert thin(np.array([REFERENCE]))[0] == pytest.approx(2.0 * expected, rel=1e-9)


def test_with_nothing_behind_it_is_the_weight():
    """A sheet much stiffer than the weight's inertia moves with it."""
    stiff = pad(shear_modulus=1e13, backing_stiffness=0.0, loss_factor=0.0)
    expected = -((2.0 * np.pi * WIDE[:100]) ** 2) * 0.05
    np.testing.assert_allclose(stiff(WIDE[:100]), expected, rtol=1e-4)


@pytest.mark.parametrize("loss", [0.0, 0.1, 0.6])
@pytest.mark.parametrize("backing", [0.0, 1e3, 5e4])
def test_it_only_takes_energy(loss, backing):
    found = pad(loss_factor=loss, backing_stiffness=backing)(WIDE)
    assert (found.imag >= -1e-12 * np.abs(found)).all()


def test_the_rubber_is_causal():
    """Springs and dampers can follow it, so that it has a past and no future."""
    band = np.geomspace(1.0, 1e4, 120)
    found = pad(backing_stiffness=1e15)(band)
    fit = passive_fit(band, found / (2j * np.pi * band))
    # the dictionary's poles stand at tenths of a decade
    np.testing.assert_allclose(fit.stiffness_at(band), found, rtol=1e-3)


def test_its_modulus_rises_as_its_loss_says():
    """A constant loss factor η goes with f^α, α = 2/π arctan η: a spring-pot."""
    held = pad(backing_stiffness=1e15)
    low, high = held(np.array([10.0, 1000.0]))
    assert np.log(high.real / low.real) / np.log(100.0) == pytest.approx(
        2.0 / np.pi * np.arctan(0.3), rel=1e-6
    )
    assert low.imag / low.real == pytest.approx(0.3, rel=1e-6)


def test_at_rest_it_holds_nothing():
    assert pad()(np.array([0.0]))[0] == 0.0
