"""A rocking head under any model of the bimorph, pressed by an eccentric spring, on a sprung board.

The ports are all that harmonic balance knows.
"""

import numpy as np
import pytest

from tactgen.geometry.display.bill import bill_of_parts
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.waveform import Sources, Step
from tactgen.tmm.harmonic_balance.continuation import steady_orbit
from tactgen.tmm.ports.multiport import (
    LATERAL,
    Multiport,
    Port,
    connect,
    reduce,
    respond,
    terminate,
)
from tactgen.tmm.ports.supports_and_loads import attach, spring
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import (
    RESOLUTION,
    STATES,
    LoadedDeflection,
    five_port,
    held_head,
    loaded_deflection,
    voltage_for,
)
from tactgen.validation.models.transient import phases, run_scene, scene_machine
from tactgen.validation.scene.load import load_scene

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
    one, other = (
        five_port(load_scene("paper", [f"bimorph.wiring={wiring}"])[0], "tmm")(np.array([100.0]))
        for wiring in ("parallel", "series")
    )
    share = np.array([0.5 if name == "voltage" else 1.0 for name in one.names])
    np.testing.assert_allclose(other.stiffness, one.stiffness * share[:, None] * share, rtol=1e-9)


def loaded(state):
    return load_scene("paper", ("support.kind=contact", "models=tmm", *STATES[state]))[0]


@pytest.mark.heavy
def test_at_50_v_the_head_takes_what_the_linear_support_does_not():
    """At 30 Hz, not activated: less than the linear 39 um, since the head rocks."""
    scene = loaded("not activated")
    head = held_head(scene)
    port = attach(five_port(scene, "tmm")(np.array([30.0])), scene.ends)
    linear = float(np.abs(respond(port, {"voltage": 50.0}).motion["w_tip"][0]))
    found = loaded_deflection(head, 50.0, (30.0, 30.1))
    assert 0.5 * linear < np.abs(found.displacement[0]) < 0.95 * linear


def test_deflection_under_load_has_a_line_and_a_largest_voltage():
    """The fitted line is even in frequency, however unevenly the branch was met."""
    at = np.geomspace(10.0, 1000.0, 40)
    line = LoadedDeflection(at, (5e-5 - 3e-8 * at).astype(complex), "")
    assert line.fitted_slope == pytest.approx(-3e-8, rel=1e-9)
    with pytest.raises(InputError, match=r"1e\+06 um at 60 Hz is not reached with 0.001 V"):
        voltage_for(held_head(loaded("held")), 60.0, 1.0, 1e-3)


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


def small(*overrides):
    """Scene of small motions without a current, seen by springs and by the machine."""
    return load_scene("generator", [
        "load.kind=none", "models=tmm", "drive.voltage=1V", "coil.current=0mA",
        "quantities=tip_displacement,lateral_tip_per_voltage", *overrides,
    ])[0]  # fmt: skip


def balanced(scene, volts=1e-3):
    """Tip per volt over frequency by harmonic balance at a small voltage (m)."""
    head = held_head(scene)
    orbits = [
        steady_orbit(head.oscillator, 2.0 * np.pi * f, volts, resolution=RESOLUTION)
        for f in scene.frequency
    ]
    return [abs(head.response(o).motion["w_tip"][1]) / volts for o in orbits]


def test_an_eccentric_spring_counts_alike_everywhere():
    """It tilts the head at rest, whose contact is softer then, by a third at 0.4 mm, whichever side
    it presses on: the bimorph on its springs, the machine in small motions, harmonic balance at a
    small voltage and the system in time."""
    stiff = [
        load_scene("generator", [f"spring.eccentricity={e} mm"])[0].held.rotational_stiffness
        for e in (0.0, 0.4, -0.4)
    ]
    assert stiff[1] == pytest.approx(stiff[2], rel=1e-9)
    assert 0.6 < stiff[1] / stiff[0] < 0.9
    scene = small("spring.eccentricity=0.4 mm", "frequency=10,200,350")
    springs, machine = (np.abs(q.value) for q in solve(scene, modelling=False).quantities)
    # springs have no axial inertia, a run in time friction for the contact's lateral spring: each
    # moves the peak at 440 Hz by a thousandth, which the response at 350 Hz triples
    for other in (machine, balanced(scene), in_time(scene)):
        np.testing.assert_allclose(other, springs, rtol=1e-2)


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


F = np.array([30.0, 300.0, 420.0, 600.0, 900.0])
BOARD = ("contact.board_stiffness=75 kN/m", "frequency=30,300,420,600,900")


def test_a_board_is_a_mass_between_two_springs():
    """Joined port by port, the tip moves as the scene says; machine and harmonic balance have the
    board too.  Where the magnet holds the rod, its sleeve stands in the lower board: no effect."""
    scene = small(*BOARD)
    contact, plain = scene.contact, small(*BOARD[1:])
    guide = scene.guide.lateral_stiffness
    along = plain.held.lateral_stiffness - guide
    omega = 2.0 * np.pi * F
    port = terminate(five_port(plain, "tmm")(F), {
        "w_base": guide,
        "psi_base": plain.held.rotational_stiffness + 1j * omega * plain.held.rotational_damping
        - omega**2 * plain.held.rotational_inertia,
    })  # fmt: skip
    pressed = spring(F, LATERAL, stiffness=along, damping=along * contact.relaxation_time,
                     ends=("w_base", "w_board"))  # fmt: skip
    held = contact.board_stiffness * (1.0 + 1j * contact.board_loss_factor)
    board = Multiport(F, (held - omega**2 * contact.board_mass)[:, None, None], (
        Port("w_board", LATERAL),))  # fmt: skip
    whole = connect(port, connect(pressed, board, {"w_board": "w_board"}), {"w_base": "w_base"})
    seen = respond(reduce(whole, ["w_tip", "voltage"]), {"voltage": 1.0}).motion["w_tip"]
    springs, machine = (q.value for q in solve(scene, modelling=False).quantities)
    np.testing.assert_allclose(springs, seen, rtol=1e-9)
    # springs have no lateral inertia of the rod, whose 0.3 g are a twentieth of the board's: that
    # shifts the second peak by some percent, on whose flank 600 Hz are
    size, away = np.abs(springs), F != 600.0
    np.testing.assert_allclose(np.abs(machine)[away], size[away], rtol=0.08)
    assert (np.abs(machine) > 2.0 * size)[~away].all()
    np.testing.assert_allclose(balanced(scene), size, rtol=2e-2)
    held = ("coil.current=50mA", "coil.history=falling")
    assert small(*held).ends.base == small(*held, *BOARD).ends.base != scene.ends.base


def test_a_board_has_the_bills_mass_and_no_run_in_time():
    scene = small()
    lines = bill_of_parts(scene.device, scene.display)
    (board,) = (line.mass for line in lines if line.name == "upper_board")
    assert scene.contact.board_mass == pytest.approx(board, rel=0.02)
    with pytest.raises(InputError, match=r"contact\.board_stiffness = 75000 N/m has no time"):
        scene_machine(small(*BOARD), coil="current", volts=1.0)
