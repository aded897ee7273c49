"""The law of rough contact: one energy, its limits, integrals of the pressure, and two stops."""

import math

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Coil, Contact, Device, Spring, Support
from tactgen.geometry.device.parts import closed_form_volumes, moving_rings
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.contact import RoughContact, contact_of, moving_rod, stops_of
from tactgen.tmm.generator.equilibrium import held_support
from tactgen.tmm.reluctance.map_range import network_map

R, U0, LOAD = 1.15e-3, 0.3e-6, 0.11
SHAPES = ("ring", "disc")
#: Tilts from far below to far above what unloads one side, either way.
TILTS = np.array([-1e-2, -3e-4, -1e-5, 0.0, 1e-9, 2e-4, 1e-3, 5e-2])


def law(shape="ring", **more):
    return RoughContact(R, U0, shape, **more)


def energy(law, approach, tilt):
    """Return V = u₀ N, whose derivative by the approach is the load as it grows as e^{δ/u₀}."""
    return law.decay_length * law.load(approach, tilt)


def integrated(shape, tilt):
    """Return load and moment at approach 0 by summing the pressure over the head.

    The trapezoidal rule over a period is exact to rounding.  x = R cos t stands for the rim, or
    with the length of its chord for a strip of the disc.
    """
    t = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    x = R * np.cos(t)
    pressure = 0.1 * np.exp(x * tilt / U0) * (1.0 if shape == "ring" else 2.0 * np.sin(t) ** 2)
    return pressure.mean(), (x * pressure).mean()


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("tilt", [0.0, 1e-5, -2e-4, 1e-3])
def test_the_closed_form_is_the_integral_of_the_pressure(shape, tilt):
    """Bessel functions against quadrature, to rounding."""
    load, moment = integrated(shape, tilt)
    found = law(shape)
    assert found.load(0.0, tilt) == pytest.approx(load, rel=1e-13)
    assert found.moment(0.0, tilt) == pytest.approx(moment, rel=1e-12, abs=1e-13 * load * R)


@pytest.mark.parametrize("shape", SHAPES)
def test_forces_are_the_gradient_of_one_energy(shape):
    """Central differences; a step h leaves h²/6 of the third derivative, here below 1e-6."""
    found = law(shape)
    d, psi = np.meshgrid([-1e-6, 0.0, 4e-7], [-2e-4, 0.0, 3e-5, 8e-4])
    hd, hp = 1e-3 * U0, 1e-3 * U0 / R
    by_psi = (energy(found, d, psi + hp) - energy(found, d, psi - hp)) / (2 * hp)
    scale = found.load(d, psi)
    np.testing.assert_array_less(np.abs(found.moment(d, psi) - by_psi), 1e-6 * R * scale)
    stiffness = found.tangent(d, psi)
    assert stiffness.shape == (4, 3, 2, 2)
    np.testing.assert_array_equal(stiffness, np.swapaxes(stiffness, -1, -2))
    assert (np.linalg.eigvalsh(stiffness * [[1, 1 / R], [1 / R, 1 / R**2]]) > 0.0).all()
    for at, other, step in ((0, (hd, 0.0), hd), (1, (0.0, hp), hp)):
        for row, value in enumerate((found.load, found.moment)):
            slope = (value(d + other[0], psi + other[1]) - value(d - other[0], psi - other[1])) / (
                2 * step
            )
            size = scale / U0 * R ** (row + at)
            np.testing.assert_array_less(np.abs(stiffness[..., row, at] - slope), 1e-6 * size)


@pytest.mark.parametrize(("shape", "part"), [("ring", 2.0), ("disc", 4.0)])
def test_under_a_constant_load(shape, part):
    """A rotational spring first, N R at last; the slope agrees with the moment."""
    found = law(shape)
    assert found.stiffness_under(LOAD) == pytest.approx(LOAD * R**2 / (part * U0), rel=1e-14)
    moment = found.moment_under(LOAD, TILTS)
    np.testing.assert_allclose(moment, -found.moment_under(LOAD, -TILTS), rtol=1e-14)
    assert (np.abs(moment) <= found.tipping_moment(LOAD)).all()
    # on a long lever the ring's Bessel functions differ by 1/(2a), the disc's by 3/(2a)
    assert found.moment_under(LOAD, 1.0) == pytest.approx(LOAD * R, rel=2.0 * U0 / R)
    step = 1e-9
    slope = (found.moment_under(LOAD, TILTS + step) - found.moment_under(LOAD, TILTS - step)) / (
        2 * step
    )
    size = found.stiffness_under(LOAD)
    np.testing.assert_array_less(np.abs(found.stiffness_under(LOAD, TILTS) - slope), 1e-5 * size)
    assert found.uplift_moment(LOAD) == pytest.approx(LOAD * R / part)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_approach_carries_its_load(shape):
    """Load and approach are inverse, tilted or not, and the moment is the same by either."""
    found = law(shape)
    d = found.approach(LOAD, TILTS)
    np.testing.assert_allclose(found.load(d, TILTS), LOAD, rtol=1e-9)  # of e^(a), a up to 200
    bound = 1e-9 * LOAD * R
    np.testing.assert_allclose(
        found.moment(d, TILTS), found.moment_under(LOAD, TILTS), rtol=1e-9, atol=bound
    )
    assert found.approach(found.reference_load) == 0.0


def test_a_stray_guess_does_not_overflow():
    """A solver that goes far too deep is told a huge force and not infinity."""
    assert np.isfinite(law().load(1.0, 1.0))
    assert law().load(-1.0, 0.0) == 0.0


def test_the_papers_fit_at_the_rated_preload():
    """c_s and d_s of section 4, to the ten digits of the calibrated constants."""
    device, fit = Device(), Support()
    found = contact_of(device, "upper")
    c_s = found.stiffness_under(device.spring.preload)
    assert c_s == pytest.approx(fit.rotational_stiffness, rel=1e-9)
    assert found.relaxation_time * c_s == pytest.approx(fit.rotational_damping, rel=1e-9)
    disc = contact_of(Device(contact=Contact(shape="disc", decay_length=0.5 * U0)), "upper")
    ring = contact_of(Device(contact=Contact(decay_length=U0)), "upper")
    assert disc.stiffness_under(LOAD) == pytest.approx(ring.stiffness_under(LOAD), rel=1e-14)


def test_both_stops_act_on_one_head():
    """Far apart each acts alone; nearly closed, forces and energies add up."""
    stops = stops_of(Device(gap=0.2e-3, spring=Spring(stop_gap=20e-6)))
    assert stops.stroke == pytest.approx(180e-6)
    assert stops.loads(0.0) == pytest.approx((0.1, 0.0))
    assert stops.loads(-stops.stroke) == pytest.approx((0.0, 0.1))
    assert stops.forces(-stops.stroke, 1e-5)[0] < 0.0  # it must be held down on the lower stop
    near = stops_of(Device(gap=21e-6, spring=Spring(stop_gap=20e-6)))
    u, psi = np.array([-4e-7, -2e-7]), np.array([1e-4, -3e-4])
    h = np.array([1e-10, 1e-7])
    for k in range(2):
        step = h * (np.arange(2) == k)
        ahead, back = (
            energy(near.upper, u + s * step[0], psi + s * step[1])
            + energy(near.lower, -u - s * step[0] - near.stroke, psi + s * step[1])
            for s in (1, -1)
        )
        slope = (ahead - back) / (2 * h[k])
        np.testing.assert_allclose(near.forces(u, psi)[..., k], slope, rtol=1e-5)
    with pytest.raises(InputError, match="no stroke"):
        stops_of(Device(gap=20e-6, spring=Spring(stop_gap=20e-6)))


def test_what_is_apart_bears_nothing_at_its_lowest_point():
    """A tilt brings one edge nearer: e^-92 of the reference load there, whichever way it tilts."""
    law = RoughContact(R, U0)
    tilt = 10.0 * U0 / R  # the edge is ten decay lengths nearer than the middle
    for sign in (-1.0, 1.0):
        assert law.is_apart(-103.0 * U0, sign * tilt)
        assert not law.is_apart(-101.0 * U0, sign * tilt)
    assert float(law.load(-103.0 * U0, tilt)) < 1e-40 * law.reference_load


#: The board above, the sleeve below, each with a contact of its own.
OWN = Device(contact=Contact(lower_decay_ratio=0.5, lower_relaxation_ratio=0.25))


@pytest.mark.parametrize(("end", "shape"), [(0.0, "disc"), (-1.0, "ring")])
def test_slopes_and_losses_are_each_stops_own(end, shape):
    """Against central differences of the forces, near either stop; the loss is its own time's."""
    contact = OWN.contact.model_copy(update={"shape": shape})
    stops = stops_of(OWN.model_copy(update={"contact": contact}))
    law = stops.lower if end else stops.upper
    lift, tilt = end * stops.stroke + 0.3 * law.decay_length, 0.7 * law.decay_length / law.radius
    rate = np.array([[0.2, -30.0]])
    at, *slopes = stops.moving(np.array([lift]), np.array([tilt]), rate)
    stiffness, damping, change = (found[0] for found in slopes)
    np.testing.assert_allclose(at[0], stops.forces(lift, tilt), rtol=1e-13)
    np.testing.assert_allclose(stiffness, stops.tangent(lift, tilt), rtol=1e-13)
    for k, by in enumerate(1e-4 * law.decay_length * np.array([1.0, 1.0 / law.radius])):
        du, dpsi = by * np.eye(2)[k]
        moved = stops.forces(lift + du, tilt + dpsi) - stops.forces(lift - du, tilt - dpsi)
        np.testing.assert_allclose(stiffness[:, k], moved / (2.0 * by), rtol=1e-6)
    time = 1e-4 * law.decay_length / 0.2
    ahead, behind = (
        stops.moving(*(np.array([[lift], [tilt]]) + s * time * rate.T), rate)[2][0] for s in (1, -1)
    )
    np.testing.assert_allclose(change, (ahead - behind) / (2.0 * time), rtol=1e-5)
    # the other stop is hundreds of decay lengths away
    np.testing.assert_allclose(damping, law.relaxation_time * stiffness, rtol=1e-12)


def test_only_a_rod_held_down_feels_the_lower_one():
    """Half the decay length is twice the stiffness there, in any direction, and half the loss."""
    pull = network_map(OWN)
    for device in (Device(), OWN):
        assert stops_of(device).holding(-1e-7) == contact_of(device, "upper")
    assert held_support(OWN, pull, 50e-3, "rising") == held_support(Device(), pull, 50e-3, "rising")
    (place, own), (same, usual) = (
        held_support(device, pull, 50e-3, "falling") for device in (OWN, Device())
    )
    # the surfaces give way by less, so the gap is some nanometres wider and the pull smaller
    assert place.contact_force == pytest.approx(same.contact_force, rel=2e-2)
    load, guide = place.contact_force / same.contact_force, Device().guide
    for name, rest in (("rotational_stiffness", guide.rotational_stiffness),
                       ("lateral_stiffness", guide.lateral_stiffness)):  # fmt: skip
        ratio = (getattr(own, name) - rest) / (getattr(usual, name) - rest)
        assert ratio == pytest.approx(2.0 * load, rel=1e-9)
    assert own.rotational_damping == pytest.approx(0.5 * load * usual.rotational_damping, rel=1e-9)


def test_sums_over_thin_discs():
    """Mass, centre and inertia from slices; midpoints of n slices leave 1/n² of a ring's own."""
    device = Device()
    density = {"rod": device.rod.density, "coil": 0.5 * device.coil.copper_density}
    m = s = second = 0.0
    for name, rings in moving_rings(device).items():
        for ring in rings:
            edges = np.linspace(ring.low, ring.high, 401) * 1e-3
            z, h = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
            inner, outer = 1e-3 * ring.inner, 1e-3 * ring.outer
            slices = density[name] * math.pi * (outer**2 - inner**2) * h * np.ones_like(z)
            m, s = m + slices.sum(), s + slices @ z
            second += slices @ (z**2 + (inner**2 + outer**2) / 4)
    body = moving_rod(device)
    assert body.mass == pytest.approx(m, rel=1e-12)
    assert body.centre == pytest.approx(s / m, rel=1e-12)
    assert body.mass_matrix[1, 1] == pytest.approx(second, rel=1e-5)


def test_the_rod_is_that_of_the_cad_parts():
    """Its volume with the slot filled, and the winding's window."""
    device = Device()
    volumes = closed_form_volumes(Device(bimorph={"tab_length": 2e-3}))
    glue, bond = device.glue.thickness, device.rod.slot_depth
    b = device.bimorph
    slot = (b.shim_thickness + 2 * glue) * (b.width + 2 * glue) * bond
    steel = moving_rod(Device(coil=Coil(copper_density=1e-9))).mass / device.rod.density
    assert steel == pytest.approx(volumes["rod"] + slot, rel=1e-6)
    copper = moving_rod(device).mass - steel * device.rod.density
    filled = device.coil.fill_factor * device.coil.copper_density
    assert copper == pytest.approx(volumes["coil"] * filled, rel=1e-6)
