"""A rocking head under any model of the bimorph: the ports are all that harmonic balance knows."""

import numpy as np
import pytest

from tactgen.tmm.generator.transient.waveform import Sources, Step
from tactgen.tmm.harmonic_balance.continuation import steady_orbit
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import RESOLUTION, five_port, held_head
from tactgen.validation.models.transient import phases, run_scene, scene_machine
from tactgen.validation.scene.scene import load_scene

#: Below the peak, where the moment softens the support a little.
FREQUENCY, VOLTAGE = 380.0, 0.3


def scene_of(model):
    overrides = ["load.kind=none", f"models={model}", "accuracy=0.01", f"frequency={FREQUENCY}",
                 f"drive.voltage={VOLTAGE}V", "quantities=tip_displacement"]  # fmt: skip
    return load_scene("generator", overrides)[0]


def rocking(model):
    """First harmonic of the tip (m)."""
    head = held_head(scene_of(model), model)
    orbit = steady_orbit(head.oscillator, 2.0 * np.pi * FREQUENCY, VOLTAGE, resolution=RESOLUTION)
    return complex(head.response(orbit).motion["w_tip"][1])


def linear(model):
    """The same on the springs of small motions."""
    return complex(solve(scene_of(model), modelling=False).quantities[0].value[0])


def test_beam_elements_rock_as_the_transfer_matrix_does():
    """Within what the ports differ by and the harmonics leave out."""
    tmm, beam = rocking("tmm"), rocking("beam")
    # elements of order five; the ends of two iterations
    assert beam == pytest.approx(tmm, rel=1e-6)
    assert abs(tmm / linear("tmm") - 1.0) > 1e-3  # and it softens, a thousand times as much


@pytest.mark.heavy
def test_the_solid_rocks_as_it_differs_on_springs():
    """Solid over transfer-matrix, rocking: the ratio on springs, but for the smaller moment."""
    ratios = [of("solid") / of("tmm") for of in (rocking, linear)]
    # softening itself is worth two thousandths here, and goes with the moment
    assert abs(ratios[0]) == pytest.approx(abs(ratios[1]), rel=2e-3)


def test_layers_in_series_take_half_the_voltage_each():
    """So half the force per volt, a quarter of the charge, and the same stiffness."""
    frequency = np.array([100.0])
    one, other = (
        five_port(load_scene("paper", [f"bimorph.wiring={wiring}"])[0], "tmm")(frequency)
        for wiring in ("parallel", "series")
    )
    share = {"voltage": 0.5}
    for row in one.names:
        for column in one.names:
            expected = one[row, column] * share.get(row, 1.0) * share.get(column, 1.0)
            np.testing.assert_allclose(other[row, column], expected, rtol=1e-9)


def in_time(scene):
    """Tip per volt over frequency of the system in time, linearised where it rests (m)."""
    made = scene_machine(scene, coil="current", volts=1.0)
    system, rest = made.system, made.rest
    stiffness, damping = system.stiffness.copy(), system.damping.copy()
    for element in system.elements:
        at = element.direction @ rest + element.offset
        still, step = np.zeros_like(at), 1e-10
        slope = (element.law.force(at + step, still) - element.law.force(at - step, still)) / 2e-10
        loss = (element.law.force(at, still + 1e-6) - element.law.force(at, still)) / 1e-6
        stiffness += element.direction.T @ (slope[:, None] * element.direction)
        damping += element.direction.T @ (loss[:, None] * element.direction)
    for friction in system.frictions:
        of = system.elements[friction.element]
        load = of.law.force(of.direction @ rest + of.offset, np.zeros(len(of.direction))).sum()
        rate = friction.coefficient * load / friction.speed
        damping += rate * np.outer(friction.direction, friction.direction)
    found = []
    for w in 2.0 * np.pi * np.array(scene.frequency):
        dynamic = stiffness + 1j * w * damping - w**2 * system.mass
        moved = np.linalg.solve(dynamic, system.coupling.astype(complex))
        found.append(abs(system.outputs["lateral_tip"].row @ moved))
    return found


def test_an_eccentric_spring_counts_alike_everywhere():
    """It tilts the head at rest, whose contact is softer then: the bimorph on its springs, the
    machine in small motions, harmonic balance at a small voltage and the system in time."""
    volts = 1e-3
    scene, _ = load_scene("generator", [
        "spring.eccentricity=0.4 mm", "load.kind=none", "frequency=10,200,350",
        "models=tmm", "drive.voltage=1V", "quantities=tip_displacement,lateral_tip_per_voltage",
        "coil.current=0mA",
    ])  # fmt: skip
    springs, machine = (np.abs(q.value) for q in solve(scene, modelling=False).quantities)
    head = held_head(scene)
    orbits = [
        steady_orbit(head.oscillator, 2.0 * np.pi * f, volts, resolution=RESOLUTION)
        for f in scene.frequency
    ]
    balanced = [abs(head.response(o).motion["w_tip"][1]) / volts for o in orbits]
    # springs have no axial inertia, a run in time friction for the contact's lateral spring: each
    # moves the peak at 440 Hz by a thousandth, which the response at 350 Hz triples
    for other in (machine, balanced, in_time(scene)):
        np.testing.assert_allclose(other, springs, rtol=1e-2)


def test_an_eccentric_spring_softens_the_support():
    """By a third of its stiffness at 0.4 mm, whichever side it presses on."""
    stiff = [
        load_scene("generator", [f"spring.eccentricity={e} mm"])[0].held.rotational_stiffness
        for e in (0.0, 0.4, -0.4)
    ]
    assert stiff[1] == pytest.approx(stiff[2], rel=1e-9)
    assert 0.6 < stiff[1] / stiff[0] < 0.9


def test_friction_in_the_bore_slows_the_rod():
    """Half of what pulls beyond the spring's force is lost; twice of it, and the rod stays up."""
    until, pull = 2.5e-3, Sources(coil=Step(0.14))
    arrivals = []
    for friction in (0.0, 8.0, 60.0):
        scene, _ = load_scene("generator", ["load.kind=none", f"guide.friction={friction} mN"])
        run = run_scene(scene, pull, until, coil="current", accuracy=0.2)
        assert run.answer.run.worst_imbalance < 1e-9
        arrivals.append(next((p.start for p in phases(run) if p.name == "held"), until))
    assert 0.0 < arrivals[0] < arrivals[1] < until
    assert arrivals[2] == until
