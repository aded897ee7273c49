"""The generator in time: rest, rim, modes, files, refusals."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.io import netcdf_file

from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.generator.contact import moving_rod
from tactgen.tmm.generator.equilibrium import axial_forces, resting_place
from tactgen.tmm.generator.small_signal import linearised
from tactgen.tmm.generator.small_signal import machine as machine_of_ports
from tactgen.tmm.generator.transient.machine import machine
from tactgen.tmm.generator.transient.step import Stepper
from tactgen.tmm.generator.transient.system import Friction
from tactgen.tmm.generator.transient.waveform import Sine, Sources, Step
from tactgen.tmm.ports.multiport import respond, terminate
from tactgen.tmm.ports.supports_and_loads import chain_of
from tactgen.tmm.reluctance.map_range import network_map
from tactgen.validation.command_line.cli import main
from tactgen.validation.command_line.commands import simulate
from tactgen.validation.models import transient
from tactgen.validation.models.transient import (
    _NEAR,
    Phase,
    above_the_head,
    common_oscillation,
    phases,
    run_scene,
    scene_machine,
    scene_modes,
)
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.run import PHASES, run_page
from tactgen.validation.studies.simulate import TITLE, read_film, write_run

FREE = ["load.kind=none"]
ON_ROD = ("--set", "load.kind=none", "--set", "support.kind=contact", "--set", "coil.current=0mA")


@pytest.fixture(scope="module")
def scene():
    return load_scene("paper", FREE)[0]


@pytest.fixture(scope="module")
def still(scene):
    return scene_machine(scene, coil="current", volts=1.0)


def test_modes_answer_like_the_transfer_matrices(scene):
    """Base held, 1 V: tip and charge at 0 Hz and away from resonance, two methods of one beam."""
    modes = scene_modes(scene)
    assert modes.omega[0] / (2.0 * np.pi) == pytest.approx(1044.16, abs=0.01)  # by TMM, two digits
    # in a slot only the free part of the tab bends
    slotted = load_scene("bimorph_on_rod")[0].device
    assert above_the_head(slotted, Support(kind="rod")).bimorph.tab_length == pytest.approx(1.6e-3)
    assert above_the_head(slotted, Support()) is slotted
    for frequency in (0.0, 300.0, 3000.0):
        square = modes.omega**2 - (2.0 * np.pi * frequency) ** 2
        tip = float(np.sum(modes.tip[2:] * modes.coupling / square))
        charge = float(np.sum(modes.coupling**2 / square)) + modes.capacitance
        port = transfer_matrix.multiport(
            Device(), Support(), Beam(), np.array([frequency]), lossy=False
        )
        exact = respond(port, {"w_base": 0.0, "psi_base": 0.0, "voltage": 1.0})
        # the statics of modes above 20 kHz: (3 kHz / 20 kHz)⁴ of their small share
        assert tip == pytest.approx(exact.motion["w_tip"][0].real, rel=1e-6)
        assert charge == pytest.approx(exact.effort["voltage"][0].real, rel=1e-6)


def test_without_drive_the_generator_stays(scene):
    """On its upper stop, to rounding, with the preload on the stop."""
    found = run_scene(scene, Sources(), 1e-4, coil="current", accuracy=0.1)
    run = found.answer.run
    assert np.ptp(run.position[:, 0]) < 1e-15
    assert np.abs(run.velocity).max() < 1e-9
    assert run.worst_imbalance < 1e-10  # of what is stored: what it exchanges is rounding
    spring = scene.device.spring
    expected = spring.preload - spring.stiffness * run.position[0, 0]
    assert found.stop_force["upper_stop"] == pytest.approx(expected, rel=1e-9)


def test_a_short_run_is_written_whole(scene, tmp_path):
    """A step of current and a sine: everything over time, units, bars, provenance."""
    sources = Sources(Sine(10.0, 200.0), Step(0.15))
    found = run_scene(scene, sources, 2e-4, coil="current", accuracy=0.1)
    run = found.answer.run
    assert run.position[-1, 0] < -1e-6  # the pull exceeds the preload
    # a flange of 3 mm whose top is 2 mm or so below the head, on a head that hardly moves
    depth = np.abs(run.position[:, 2]) * 6e-3 + np.abs(run.position[:, 1])
    assert np.all(found.sideways <= depth)
    assert 0.0 < found.sideways.max() < found.flange_gap == pytest.approx(50e-6)
    path = tmp_path / "run.nc"
    write_run(path, found, {"bimorph_voltage": "10 V sine 200 Hz"})
    with netcdf_file(str(path), "r", mmap=False) as file:
        assert file.bimorph_voltage == b"10 V sine 200 Hz"
        assert b"spring.preload = 0.11" in file.parameters
        lift = file.variables["rod_lift"]
        assert lift.units == b"m"
        assert float(lift.error_bar) == found.answer.errors["rod_lift"]
        assert lift[:] == pytest.approx(run.position[:, 0])
        assert float(file.energy_imbalance) == run.worst_imbalance
    film = read_film(path)
    tip = np.argmax(film.points[:, 2])
    lateral = film.coordinates @ film.lateral[tip]
    assert lateral == pytest.approx(found.answer.outputs["lateral_tip"], rel=1e-9, abs=1e-18)
    assert set(film.regions) >= {"rod", "coil", "shim"}
    assert PHASES[film.phase[0]] == "pressed"
    assert len(run_page(film).encode()) < 1_200_000


def test_a_coil_driven_by_voltage_fills_with_current(scene):
    """The rod still on its stop: i' = (v − R i)/L at the start."""
    found = run_scene(scene, Sources(coil=Step(1.0)), 2e-5, coil="voltage", accuracy=0.1)
    coil = found.machine.system.coil
    inductance = coil.coenergy.at(1e-4, scene.device.gap).inductance
    last = found.answer.run.current[-1]
    exact = -np.expm1(-coil.resistance / inductance * 2e-5) / coil.resistance
    assert last == pytest.approx(exact, rel=0.05)  # the inductance changes with the current


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ([*FREE, "spring.preload=0 mN"], "does not hold the rod up"),
        ([*FREE, "contact.shape=disc"], "has no time simulation"),
        ([*FREE, "spring.stop_gap=0.3 mm"], "no stroke"),
    ],
)
def test_scenes_that_cannot_move_are_refused(overrides, words):
    scene = load_scene("paper", overrides)[0]
    with pytest.raises(InputError, match=words):
        run_scene(scene, Sources(), 1e-3, coil="current", accuracy=0.1)


def test_up_and_down_it_weighs_what_its_parts_do(scene, still):
    """Rod with coil, the layers by their volumes, and a mass at the tip, which also moves with the
    tip to either side."""
    b, device = scene.device.bimorph, scene.device
    layers = (2.0 * b.piezo_thickness * device.piezo.density
              + b.shim_thickness * device.shim.density) * b.width * b.length  # fmt: skip
    mass, whole = still.system.mass, moving_rod(device).mass + layers
    assert np.diag(mass)[:2] == pytest.approx([whole, whole], rel=1e-12)
    assert (mass[0, 1:] == 0.0).all()
    loaded = load_scene("paper", ["load.kind=mass", "load.mass=0.1 g"])[0]
    heavy = scene_machine(loaded, coil="current", volts=1.0).system
    row = heavy.outputs["lateral_tip"].row
    added = 1e-4 * np.outer(row, row)
    added[0, 0] = 1e-4
    assert heavy.mass - mass == pytest.approx(added, abs=1e-12)


def test_the_command_says_what_it_did(capsys, tmp_path, monkeypatch):
    out, picture = tmp_path / "run.nc", tmp_path / "run.svg"
    solved = []

    def once(*arguments, **options):
        solved[:] = solved or [whole(*arguments, **options)]
        return solved[0]

    whole = transient.run_scene
    monkeypatch.setattr(transient, "run_scene", once)
    asked = ["simulate", "paper", *ON_ROD, "--voltage", "10 V sine 200 Hz",
             "--until", "50 us", "--accuracy", "0.2"]  # fmt: skip
    assert main(asked) == 0
    lines, answer = capsys.readouterr().out.splitlines(), solved[0].answer
    assert lines[2].split()[:3] == ["pressed", "0.000", "0.050"]
    last = int(np.searchsorted(answer.run.time, answer.certain_until))
    bars = {name: f"{1e6 * answer.bars[name][last]:.2g} um" for name in answer.bars}
    assert f"rod_lift {bars['rod_lift']}, lateral_tip {bars['lateral_tip']}; energy" in lines[-1]
    assert main([*asked, "--out", str(out), "--plot", str(picture), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["phases"][0]["name"] == "pressed"
    assert found["energy_imbalance"] < 1e-10
    assert found["quantities"]["voltage"]["largest"] == pytest.approx(
        10.0 * np.sin(2.0 * np.pi * 200.0 * 50e-6)
    )
    assert out.stat().st_size > 0
    assert picture.read_text(encoding="utf-8").startswith("<svg")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--out", "run.txt"], "must end in .nc"),
        (["--plot", "nowhere/run.svg"], "folder does not exist"),
        (["--gif", "run.mp4"], "must end in .gif"),
        (["--fields", "run.vtu"], "must end in .pvd"),
        (["--map", "nowhere.nc"], "cannot be read"),
    ],
)
def test_bad_options_get_one_sentence(capsys, arguments, words):
    code = main(["simulate", "paper", *ON_ROD, *arguments])
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


def test_what_a_run_is_warned_of(capsys):
    """Nothing that drives it; a load off its law, wide errors, a rod through its sleeve."""
    assert main(["simulate", "paper", *ON_ROD, "--until", "0.1 ms"]) == 0
    assert "nothing drives it; give --voltage or --coil" in capsys.readouterr().err
    run = SimpleNamespace(time=np.array([0.0, 1e-3, 2e-3, 3e-3]))
    answer = SimpleNamespace(error=0.5, accuracy=0.1, certain_until=1.5e-3, run=run)
    result = SimpleNamespace(
        load_misfit=0.02, sideways=np.array([0.0, 1e-6, 3e-6, 2.5e-6]), flange_gap=2e-6,
        answer=answer,
    )  # fmt: skip
    driven = {Step(1.0), Step(0.0)}
    load, errors, rod = simulate._doubts(result, driven)
    assert "up to 2 % off its law of frequency" in load
    assert "the accuracy of 0.1 holds until 1.5 ms" in errors
    assert "from 2 ms on the flange is up to 3 um off the middle" in rod
    answer.accuracy, result.load_misfit, result.flange_gap = 0.5, 0.0, 4e-6
    assert not simulate._doubts(result, driven)


def test_phases_begin_where_the_rod_leaves_and_meets_its_stops():
    """Up to 2 ms pressed, down by 3 ms, held to 6 ms, up by 7 ms; a bounce of 3 µs is none."""
    time = np.linspace(0.0, 10e-3, 10001)
    lift = -2e-4 * np.interp(time, [0.0, 2e-3, 3e-3, 6e-3, 7e-3, 10e-3], [0, 0, 1, 1, 0, 0])
    lift[4000:4003] = -1e-4
    tip = 1e-6 * np.sin(2.0 * np.pi * 5e3 * time) + np.where(time > 6.5e-3, 4e-6, 0.0)
    outputs = {"lateral_tip": tip, "rod_lift": lift}
    run = SimpleNamespace(answer=SimpleNamespace(run=SimpleNamespace(time=time), outputs=outputs),
                          stroke=2e-4)  # fmt: skip
    found = phases(run)
    assert [phase.name for phase in found] == ["pressed", "falling", "held", "rising", "pressed"]
    near = 1e-3 * _NEAR / 2e-4  # so long before and after, the rod is as good as on its stop
    for (start, end), phase in zip(
        [(0.0, 2e-3 + near), (2e-3 + near, 3e-3 - near), (3e-3 - near, 6e-3 + near),
         (6e-3 + near, 7e-3 - near), (7e-3 - near, 10e-3)], found, strict=True
    ):  # fmt: skip
        # the first time of a state is the next of the run: up to 1 µs later
        assert 0.0 <= phase.start - start <= 1.001e-6
        assert 0.0 <= phase.end - end <= 1.001e-6
    assert [phase.amplitude for phase in found] == pytest.approx(
        [1e-6, 1e-6, 1e-6, 3e-6, 1e-6], rel=1e-6
    )


def test_an_oscillation_is_told_from_a_drift():
    """Half a period of two tips that swing by 3 µm, one drifting by 20: the phase's own, 3 µm."""
    time = np.linspace(0.0, 4e-3, 3000) ** 2 / 4e-3  # steps of all lengths, as a run's
    half, seen = Phase("held", 0.5e-3, 3.1e-3, 0.0), []
    for angle, drift in ((0.0, -20e-6), (0.5 * np.pi, 0.0)):
        tip = 3e-6 * np.sin(2.0 * np.pi * 200.0 * time + 1.0 + angle) + drift * time / 4e-3
        answer = SimpleNamespace(run=SimpleNamespace(time=time), outputs={"lateral_tip": tip})
        seen.append((SimpleNamespace(answer=answer), half, angle))
    # straight lines between the longest steps: (ω h)²/8 = 1.4e-6
    amplitude = common_oscillation(seen, 200.0)
    assert amplitude == pytest.approx(3e-6 * np.exp(1j * (1.0 - 0.5 * np.pi)), rel=1e-5)


def pressed(scene):
    """Return the rod in small motions, on a spring and, as time takes its contact with friction,
    creeping by a damper in place of it; and the tip's load."""
    device, pull = scene.device, network_map(scene.device)
    place = resting_place(axial_forces(device, pull, 0.0), 0.0, "rising")
    rod, lateral = linearised(device, scene.beam, place, 0.0, pull), np.diag([1.0, 0.0, 0.0])
    creep = device.contact.friction * place.contact_force / Friction(0, lateral[0], 1.0).speed
    stiff = device.guide.lateral_stiffness - rod.stiffness[0, 0]
    creeping = replace(
        rod,
        stiffness=rod.stiffness + stiff * lateral,
        damping=rod.damping + (creep - rod.damping[0, 0]) * lateral,
    )
    return rod, creeping, chain_of(scene.ends.tip)


def tip_of(scene, rod, load, frequencies):
    """Return the tip's motion per volt (m) by the small signal's ports, without losses."""
    bimorph = transfer_matrix.multiport(
        scene.device, Support(), scene.beam, frequencies, lossy=False
    )
    port = terminate(machine_of_ports(bimorph, rod), {"w_tip": load.stiffness_at(frequencies)})
    return respond(port, {"voltage": 1.0, "current": 0.0}).motion["w_tip"]


def test_small_motions_under_the_finger_are_those_of_the_machine():
    """Steady motion at 150 Hz over a hundredth of a period, against the small signal's ports, 1e-6.

    Without losses in the bimorph, which time takes mode by mode, and with the lateral contact as
    time takes it: creeping under friction, in place of a spring.
    """
    scene, drive, frequency = load_scene("generator", [])[0], 1e-6, 150.0
    _, rod, load = pressed(scene)
    exact = drive * tip_of(scene, rod, load, np.array([frequency]))[0]
    modes = replace(scene_modes(scene), damping=np.zeros_like(scene_modes(scene).damping))
    moved = machine(scene.device, modes, network_map(scene.device), load=load, source="current")
    system, per_period = moved.system, 20_000
    h = 1.0 / frequency / per_period
    # the midpoint rule's own frequency: it turns by as much a step as the drive
    s = 2j / h * np.tan(np.pi / per_period)
    rim = system.elements[0]
    each = rim.law.force(rim.direction @ moved.rest + rim.offset, 0.0 * rim.direction[:, 0])
    near = (rim.direction.T * each / rim.law.decay_length) @ rim.direction
    stuck = rod.damping[0, 0] * np.outer(np.eye(near.shape[0])[1], np.eye(near.shape[0])[1])
    whole = system.mass * s**2 + system.stiffness + near
    whole = whole + (system.damping + rim.law.relaxation_time * near + stuck) * s
    steady = np.linalg.solve(whole, system.coupling * drive)
    stepper, period = Stepper(system), np.exp(2j * np.pi * np.arange(201) / per_period)
    state = stepper.start(moved.rest + steady.real, (s * steady).real, drive, 0.0)
    row = system.outputs["lateral_tip"].row
    found = [row @ state.position]
    for turn in period[1:]:
        state, _ = stepper.step(state, h, drive * turn.real, (0.0, 0.0))
        found.append(row @ state.position)
    assert np.abs(found - (exact * period).real).max() < 1e-6 * abs(exact)


def test_friction_creeps_where_small_motions_have_a_spring():
    """Under the finger the two differ by percents below 2 Hz, and by less than 1 % from 10 to 500
    Hz."""
    scene = load_scene("generator", [])[0]
    *rods, load = pressed(scene)
    f = np.array([1.0, 10.0, 50.0, 200.0, 500.0])
    spring, creeping = (tip_of(scene, rod, load, f) for rod in rods)
    apart = np.abs(creeping / spring - 1.0)
    assert apart[0] > 0.02
    assert np.all(apart[1:] < 0.01)


def test_why_a_run_cannot_be_read(tmp_path):
    """It is another file, or its phases have other names."""
    path = tmp_path / "run.nc"
    for title, words in (("map", "not a run of a generator"), (TITLE, "phases have other names")):
        with netcdf_file(str(path), "w") as file:
            file.title, file.phases = title.encode(), b"up down"
        with pytest.raises(InputError, match=words):
            read_film(path)
