"""Loads as springs, dampers and masses: the same law, and passive everywhere."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import TipLoad
from tactgen.geometry.device.load_table import LoadTable
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports import elements as springs_dampers_masses
from tactgen.tmm.ports.elements import chain_of, finger_chain, tip_stiffness
from tactgen.tmm.ports.loads import (
    FINGER_RANGE,
    MeasuredLaw,
    PassiveFit,
    continued,
    finger_impedance,
    finger_stiffness,
)

F = np.geomspace(0.1, 1e5, 61)


def test_parts_answer_like_the_fit_they_are_made_of():
    """One resonator held to the ground, one in a row, one of both, and the plain terms."""
    omega, ratio = 2.0 * np.pi * np.array([30.0, 200.0, 2e3]), np.array([0.1, 0.7, 1.0])
    a, width = np.array([50.0, 300.0, 2e3]), 2.0 * ratio * omega
    fit = PassiveFit(2e-5, 0.3, 80.0, omega, ratio, a, a * width * np.array([1.0, 0.0, 0.4]))
    found = springs_dampers_masses._of_fit(fit, 0.0)
    assert found.mass.shape == (1 + 2 + 2 * 2, 1 + 2 + 2 * 2)
    # rounding, grown by the cancelling of parts far above or below their resonance
    assert found.stiffness_at(F) == pytest.approx(fit.stiffness_at(F), rel=1e-9)
    for matrix in (found.mass, found.damping, found.stiffness):
        assert matrix == pytest.approx(matrix.T)
        assert np.linalg.eigvalsh(matrix).min() > -1e-12 * np.abs(matrix).max()


def test_constants_are_one_part():
    load = TipLoad(100.0, 0.5, 1e-4)
    assert chain_of(load).stiffness_at(F) == pytest.approx(tip_stiffness(load, F), rel=1e-14)
    assert chain_of(load).carried == 1e-4


def test_the_finger_as_parts_is_as_near_as_it_says():
    """Over its range, at other points than it was fitted at; it takes energy everywhere."""
    f = np.geomspace(*FINGER_RANGE, 37)
    off = np.abs(finger_chain().stiffness_at(f) / finger_stiffness(f) - 1.0)
    # both ends are points of the fit, where it is worst
    assert 0.05 < off.max() <= finger_chain().misfit * (1.0 + 1e-9) < 0.25
    assert (finger_chain().stiffness_at(F).imag > 0.0).all()


def test_a_law_without_parts_is_refused():
    with pytest.raises(InputError, match=r'set load\.kind = "none"'):
        chain_of(lambda f: 1.0 * f)


def test_a_table_continued_by_a_fit_is_the_parts_of_its_fit():
    """The fit to the whole table, with its largest distance from it; a table alone has no parts."""
    f = np.geomspace(10.0, 1000.0, 40)
    table = LoadTable("a table", f, finger_impedance(f))
    law = continued(table)
    found = chain_of(law)
    assert found.misfit == law.misfit[0]
    assert found.stiffness_at(F) == pytest.approx(law.fits[0].stiffness_at(F), rel=1e-9)
    assert MeasuredLaw(table).misfit == (0.0, 0.0)
    with pytest.raises(InputError, match="passive_fit"):
        chain_of(MeasuredLaw(table))
