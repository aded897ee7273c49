"""Support and load as one value, at the ports, and as springs, dampers and masses."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.device.load_table import LoadTable
from tactgen.geometry.device.parameters import Load, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports import supports_and_loads as springs_dampers_masses
from tactgen.tmm.ports import supports_and_loads as t
from tactgen.tmm.ports.finger_and_pad import FINGER_RANGE, finger_impedance, finger_stiffness
from tactgen.tmm.ports.measured_loads import MeasuredLaw, PassiveFit, continued
from tactgen.tmm.ports.supports_and_loads import chain_of, finger_chain, tip_stiffness

SPRINGS = Springs(3e6, 0.24, rotational_damping=4.46e-6, rotational_inertia=1e-12)


@pytest.mark.parametrize(
    ("load", "tip"),
    [
        (Load(kind="none", mass=1.0, stiffness=1.0), TipLoad()),
        (Load(kind="mass", mass=1e-5, stiffness=1.0), TipLoad(mass=1e-5)),
        (
            Load(kind="spring_damper", stiffness=5.0, damping=9.0, mass=1.0),
            TipLoad(stiffness=5.0, damping=9.0),
        ),
        (Load(), finger_stiffness),
    ],
    ids=["none", "mass", "spring_damper", "finger"],
)
def test_only_what_the_kind_reads_is_taken(load, tip):
    """The paper's springs are the support's; of a load the numbers of its kind alone count."""
    assert t.ends_of(Support(), load) == Ends(SPRINGS, tip)


def test_statics_and_modes_leave_damping_and_the_finger_out():
    """The finger has no constant stiffness or mass: static values and modes are the free tip's."""
    held = Springs(3e6, 0.24, rotational_inertia=1e-12)
    assert Ends(SPRINGS, finger_stiffness).lossless == Ends(held)
    loaded = Ends(SPRINGS, TipLoad(stiffness=5.0, damping=9.0, mass=1e-5))
    assert loaded.lossless == Ends(held, TipLoad(stiffness=5.0, mass=1e-5))
    assert Ends().lossless == Ends()


@pytest.mark.parametrize(
    ("ends", "loose"),
    [
        (Ends(), 0),
        (Ends(Springs(0.0, 0.24)), 1),
        (Ends(Springs(3e6, 0.0)), 1),
        (Ends(Springs(0.0, 0.0), finger_stiffness), 2),
        (Ends(Springs(0.0, 0.0), TipLoad(mass=1.0)), 2),
        (Ends(Springs(3e6, 0.0), TipLoad(stiffness=1.0)), 0),
    ],
)
def test_each_spring_stops_one_rigid_motion(ends, loose):
    """Masses, dampers and a load without a constant stiffness stop none."""
    assert ends.rigid_motions == loose


def test_outside_of_the_range_is_reported():
    """The finger says where it was not measured; other loads hold everywhere."""
    f = np.array([0.0, 9.9, 10.0, 500.0, 1000.0, 1000.1])
    expected = [True, True, False, False, False, True]
    assert t.outside_known_range(Load(), f).tolist() == expected
    assert not t.outside_known_range(Load(kind="mass", mass=1e-3), f).any()


def test_a_tip_load_is_spring_damper_and_mass():
    """In the order k + jΩ d − Ω² m."""
    (found,) = t.tip_stiffness(TipLoad(300.0, 0.5, 2e-6), np.array([100.0]))
    omega = 2 * np.pi * 100.0
    assert found == pytest.approx(300.0 + 0.5j * omega - 2e-6 * omega**2)


def test_a_contact_has_no_springs_before_it_is_loaded():
    """Read as any other support it would hold the base rigidly, and nobody would know."""
    with pytest.raises(ValueError, match=r"depend on its load; see tmm\.generator\.equilibrium"):
        t.ends_of(Support(kind="contact"), Load())


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
