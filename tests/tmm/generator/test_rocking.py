"""The bimorph on a rocking head: its linear limit, its derivatives, and time integration."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tactgen.tmm.beam.lumped import lumped_model
from tactgen.tmm.beam.transfer_matrix import sections
from tactgen.tmm.generator.equilibrium import axial_forces, resting_place
from tactgen.tmm.generator.small_signal import rocking_head
from tactgen.tmm.harmonic_balance.continuation import steady_orbit
from tactgen.tmm.harmonic_balance.steady import Resolution
from tactgen.tmm.ports.multiport import BIMORPH, Multiport, respond
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.models.backbone import five_port, held_head
from tactgen.validation.scene.load import load_scene

UP = ("support.kind=contact", "coil.current=0mA", "models=tmm")
HELD = ("support.kind=contact", "coil.current=50mA", "coil.history=falling", "models=tmm")


def prototype(*overrides):
    return load_scene("prototype", overrides)[0]


@pytest.mark.parametrize("place", [UP, HELD], ids=["up", "held"])
def test_small_motions_are_those_on_the_contacts_springs(place):
    """At 0.1 mV the answer is the linear one; what is left goes with the square of the tilt."""
    scene = prototype(*place)
    head = held_head(scene)
    frequencies = np.array([100.0, 760.0, 1500.0])
    linear = respond(attach(five_port(scene, "tmm")(frequencies), scene.ends), {"voltage": 1e-4})
    for frequency, expected in zip(frequencies, linear.motion["w_tip"], strict=True):
        orbit = steady_orbit(head.oscillator, 2.0 * np.pi * frequency, 1e-4)
        assert head.response(orbit).motion["w_tip"][1] == pytest.approx(expected, rel=1e-7)


OWN = ("contact.lower_decay_ratio=0.5", "contact.lower_relaxation_ratio=3", "guide.clearance=0.5um",
       "guide.rotational_stiffness=1N*m/rad")  # fmt: skip


@pytest.mark.parametrize("place", [UP, HELD, HELD + OWN], ids=["up", "held", "own"])
def test_derivatives_of_what_acts_on_the_head(place):
    """Against central differences, by motions of some decay lengths and their rates."""
    head = held_head(prototype(*place))
    law, scale = head.oscillator.law, head.oscillator.scales
    rng = np.random.default_rng(1)
    motion, rate = rng.normal(size=(2, 7, 2)) * scale
    rate *= 2.0 * np.pi * 800.0
    at, step = law(motion, rate), 1e-4
    size = np.abs(at.by_motion * scale).max(axis=(0, 2))
    for k in range(2):
        by = np.eye(2)[k] * scale[k] * step
        slope = (law(motion + by, rate).effort - law(motion - by, rate).effort) / (2 * step)
        assert (np.abs(at.by_motion[:, :, k] * scale[k] - slope) < 1e-6 * size).all()
        by = by * 2.0 * np.pi * 800.0
        slope = (law(motion, rate + by).effort - law(motion, rate - by).effort) / (2 * step)
        assert (np.abs(at.by_rate[:, :, k] * by[k] / step - slope) < 1e-6 * size).all()


def test_over_a_period_forces_balance_and_energy_is_lost():
    """The mean load is what rests on the stop; the voltage does work; no moment passes N R."""
    scene = prototype(*UP)
    head = held_head(scene)
    orbit = steady_orbit(head.oscillator, 2.0 * np.pi * 735.0, 1.0)
    load, moment = head.contact(orbit, 512)
    sunk = scene.spring.stiffness * orbit.spectrum[0, 0].real  # the return spring's part
    assert load.mean() == pytest.approx(head.place.contact_force - sunk, rel=1e-4)
    assert (np.abs(moment) < load * scene.rod.head_radius).all()
    assert np.abs(moment).max() > 0.3 * load.mean() * scene.rod.head_radius
    charge = head.response(orbit).effort["voltage"][1]
    assert -charge.imag * orbit.level > 0.0


def reduced_model():
    """Return the lumped model on its head for harmonic balance, and its matrices over time.

    Unknowns over time are w_base, psi_base, w_tip, psi_tip and the lift.
    """
    scene = prototype(*UP, "bimorph.length=14mm")
    row = sections(scene.device, scene.support, scene.beam, lossy=False)
    model = lumped_model(row)
    forces = axial_forces(scene.device, None)
    place = resting_place(forces, 0.0, "rising")

    def ports(frequencies):
        o2 = (2.0 * np.pi * frequencies)[:, None, None] ** 2
        return Multiport(frequencies, model.stiffness - o2 * model.mass, BIMORPH)

    head = rocking_head(ports, scene.ends.tip, forces, place, 0.0, 1e-4)
    body = head.support
    mass, stiffness = np.zeros((5, 5)), np.zeros((5, 5))
    mass[:4, :4], stiffness[:4, :4] = model.mass[:4, :4], model.stiffness[:4, :4].real
    mass[1, 1] += body.rotational_inertia
    stiffness[0, 0] += body.lateral_stiffness
    stiffness[1, 1] += scene.guide.rotational_stiffness
    linear = head.oscillator.linear(np.array([1.0]))[0]
    mass[4, 4] = -linear[0, 0].real
    push = np.append(-model.stiffness[:4, 4].real, 0.0)
    return head, mass, stiffness, push, scene.guide.axial_damping


def rates(head, mass, stiffness, push, damping, omega, level):
    """Return what integrates the motion in time, by the same law of the contact."""
    inverse = np.linalg.inv(mass)

    def rate(t, y):
        q, v = y[:5], y[5:]
        at = head.oscillator.law(q[[4, 1]][None], v[[4, 1]][None]).effort[0]
        force = push * level * np.cos(omega * t) - stiffness @ q
        force[1] -= at[1]
        force[4] -= at[0] + damping * v[4]
        return np.concatenate([v, inverse @ force])

    return rate


def state(head, orbit):
    """Return motions and rates of the reduced model at the drive's peak, from an orbit."""
    found = head.response(orbit).motion
    spectrum = np.stack(
        [found["w_base"], orbit.spectrum[:, 1], found["w_tip"], found["psi_tip"],
         orbit.spectrum[:, 0]], axis=1,
    )  # fmt: skip
    n = np.arange(orbit.harmonics + 1)[:, None]
    return np.concatenate([spectrum.sum(0).real, (1j * n * orbit.omega * spectrum).sum(0).real])


@pytest.mark.parametrize(
    ("frequency", "level"), [(740.0, 1.0), pytest.param(640.0, 4.0, marks=pytest.mark.heavy)]
)
def test_an_orbit_returns_in_time(frequency, level):
    """An independent integration of the reduced model, begun on the orbit, ends where it began.

    What is left over is what the harmonics leave out, here below 1e-6 of the motion.
    """
    head, *matrices = reduced_model()
    fine = Resolution(missing=1e-7, least=9, most=60)
    omega = 2.0 * np.pi * frequency
    orbit = steady_orbit(head.oscillator, omega, level, resolution=fine)
    assert head.contact(orbit, 256)[1].max() > 0.3 * 0.11 * 1.15e-3  # far from linear
    begin = state(head, orbit)
    found = solve_ivp(
        rates(head, *matrices, omega, level), (0.0, 2.0 * np.pi / omega), begin,
        method="LSODA", rtol=1e-8, atol=1e-8 * np.abs(begin),
    )  # fmt: skip
    # lift and tilt have their own size, the tip's motion is the largest
    size = np.abs(found.y).max(axis=1)
    assert (np.abs(found.y[:, -1] - begin) < 1e-4 * size).all()
    assert found.y[2, -1] == pytest.approx(begin[2], abs=1e-5 * size[2])
