"""Measured loads: between their points, beyond them, and what their error bars are worth."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends, TipLoad
from tactgen.geometry.device.load_table import LoadTable
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.loads import MeasuredLaw, continued, disturbed, finger_impedance, passive_fit

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
