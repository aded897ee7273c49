"""An upper board on springs: a mass between the contact and the ground, seen by every answer."""

import numpy as np
import pytest

from tactgen.geometry.display.bill import bill_of_parts
from tactgen.geometry.errors import InputError
from tactgen.tmm.harmonic_balance.continuation import steady_orbit
from tactgen.tmm.ports.elements import spring
from tactgen.tmm.ports.multiport import (
    LATERAL,
    Multiport,
    Port,
    connect,
    reduce,
    respond,
    terminate,
)
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import RESOLUTION, five_port, held_head
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.scene import load_scene

F = np.array([30.0, 300.0, 420.0, 600.0, 900.0])
BOARD = ("contact.board_stiffness=75 kN/m",)


def scene_of(*overrides, frequency="30,300,420,600,900"):
    return load_scene("generator", [
        "load.kind=none", f"frequency={frequency}", "models=tmm", "drive.voltage=1V",
        "quantities=tip_displacement,lateral_tip_per_voltage", "coil.current=0mA", *overrides,
    ])[0]  # fmt: skip


def test_it_is_a_mass_between_two_springs():
    """Joined port by port, the tip moves as the scene says."""
    scene = scene_of(*BOARD)
    contact, plain = scene.contact, scene_of()
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
    found = solve(scene, modelling=False).quantities[0].value
    np.testing.assert_allclose(found, seen, rtol=1e-9)


def test_machine_and_harmonic_balance_have_it_too():
    scene = scene_of(*BOARD)
    springs, machine = (np.abs(q.value) for q in solve(scene, modelling=False).quantities)
    # springs have no lateral inertia of the rod, whose 0.3 g are a twentieth of the board's: that
    # shifts the second peak by some percent, on whose flank 600 Hz are
    away = F != 600.0
    np.testing.assert_allclose(machine[away], springs[away], rtol=0.08)
    assert (machine > 2.0 * springs)[~away].all()
    head = held_head(scene)
    orbits = [
        steady_orbit(head.oscillator, 2.0 * np.pi * f, 1e-3, resolution=RESOLUTION) for f in F
    ]
    balanced = [abs(head.response(o).motion["w_tip"][1]) / 1e-3 for o in orbits]
    np.testing.assert_allclose(balanced, springs, rtol=2e-2)


def peaks(*overrides):
    at = np.linspace(300.0, 1100.0, 1601)
    scene = scene_of(*overrides).model_copy(update={"frequency": tuple(at.tolist())})
    found = solve(scene, ("tmm",), ("tip_displacement",), modelling=False)
    size = np.abs(found.quantities[0].value)
    inside = (size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])
    return at[1:-1][inside]


def test_its_second_peak_goes_with_the_root_of_its_mass():
    """And there is none where the magnet holds the rod, whose sleeve stands in the lower board."""
    light, heavy = peaks(*BOARD, "contact.board_mass=4 g"), peaks(*BOARD, "contact.board_mass=8 g")
    assert len(light) == len(heavy) == 2
    # nearly a free board: the contact is four times stiffer than its springs
    assert light[1] / heavy[1] == pytest.approx(np.sqrt(2.0), rel=0.1)
    assert len(peaks()) == 1
    assert len(peaks(*BOARD, "coil.current=50mA", "coil.history=falling")) == 1


def test_its_mass_is_the_bills():
    scene = scene_of()
    (board,) = (
        line for line in bill_of_parts(scene.device, scene.display) if line.name == "upper_board"
    )
    assert scene.contact.board_mass == pytest.approx(board.mass, rel=0.02)


def test_a_run_in_time_refuses_it():
    with pytest.raises(InputError, match=r"contact\.board_stiffness = 75000 N/m has no time"):
        scene_machine(scene_of(*BOARD), coil="current", volts=1.0)
