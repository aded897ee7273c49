"""Support and load at the ports."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Beam, Device, Load, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.ports import elements as t
from tactgen.tmm.ports.multiport import respond

FREQUENCIES = np.array([0.0, 10.0, 300.0, 1000.0])


def tip(support, load, frequencies=FREQUENCIES):
    port = tmm.multiport(Device(), support, Beam(), frequencies)
    return respond(t.attach(port, t.ends_of(support, load)), {"voltage": 50.0}).motion["w_tip"]


def test_outside_of_the_range_is_reported():
    """The finger says where it was not measured; other loads hold everywhere."""
    f = np.array([0.0, 9.9, 10.0, 500.0, 1000.0, 1000.1])
    expected = [True, True, False, False, False, True]
    assert t.outside_known_range(Load(), f).tolist() == expected
    assert not t.outside_known_range(Load(kind="mass", mass=1e-3), f).any()


def test_support_is_the_papers():
    """jΩ R32 = c_s + jΩ d_s − Ω² θ and jΩ R41 = c_sl (eqs 7 and 8)."""
    f = np.array([0.0, 500.0])
    lateral, rotational = t.base_stiffness(t.ends_of(Support(), Load()).base, f)
    omega = 2 * np.pi * 500.0
    assert lateral.tolist() == [3e6, 3e6]
    assert rotational[0] == 0.24
    assert rotational[1] == pytest.approx(0.24 + 1j * omega * 4.46e-6 - omega**2 * 1e-12)


@pytest.mark.parametrize("kind", ["clamped", "rod"])
def test_rigid_supports_hold_the_base(kind):
    """A clamp, and the rod's own lower end, leave no motion at the base: it is no port."""
    port = tmm.multiport(Device(), Support(kind="clamped"), Beam(), FREQUENCIES)
    held = t.attach(port, t.ends_of(Support(kind=kind), Load()))
    assert held.names == ("w_tip", "psi_tip", "voltage")


def test_stiff_spring_is_a_clamp():
    """As the support's springs grow the response tends to the clamped one, in proportion to 1/c."""
    clamped = tip(Support(kind="clamped"), Load())
    gaps = []
    for factor in (1e4, 1e6):
        support = Support(
            rotational_stiffness=0.24 * factor, lateral_stiffness=3e6 * factor,
            rotational_damping=0.0, rotational_inertia=0.0,
        )  # fmt: skip
        gaps.append(np.abs(tip(support, Load()) / clamped - 1.0))
    # c_s = 0.24 against EI/l = 0.26: at factor 1e6 a gap of order 1e-6
    assert (gaps[1] < 1e-5).all()
    np.testing.assert_allclose(gaps[0][1:] / gaps[1][1:], 100.0, rtol=1e-2)


def test_loads_reduce_to_each_other():
    """No load, a massless mass and a spring-damper of zero are the same; Z is jΩ times less."""
    free = tip(Support(), Load(kind="none"))
    np.testing.assert_array_equal(tip(Support(), Load(kind="mass", mass=0.0)), free)
    np.testing.assert_array_equal(tip(Support(), Load(kind="spring_damper")), free)
    f = np.array([100.0])
    mass = t.tip_stiffness(t.ends_of(Support(), Load(kind="mass", mass=2e-6)).tip, f)
    assert mass[0] == pytest.approx(-((2 * np.pi * 100.0) ** 2) * 2e-6)
    damping = Load(kind="spring_damper", stiffness=300.0, damping=0.5)
    damper = t.tip_stiffness(t.ends_of(Support(), damping).tip, f)
    assert damper[0] == pytest.approx(300.0 + 0.5j * 2 * np.pi * 100.0)


def test_a_contact_has_no_springs_before_it_is_loaded():
    """Read as any other support it would hold the base rigidly, and nobody would know."""
    with pytest.raises(ValueError, match=r"depend on its load; see tmm\.generator\.equilibrium"):
        t.ends_of(Support(kind="contact"), Load())
