"""The co-simulation unit: the same motion as the steps in Python, the balance, what it holds."""

import math
import shutil
import zipfile

import numpy as np
import pytest
from fmpy import extract, instantiate_fmu, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.step import Stepper
from tactgen.validation.command_line.cli import main
from tactgen.validation.models.transient import scene_machine
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.fmu import write_fmu

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler on the path")
#: Two stops that differ, so that a mistaken one is seen.
OWN = ("contact.lower_decay_ratio=0.6", "contact.lower_relaxation_ratio=0.5")
SCENE = load_scene("paper", ["load.kind=none", *OWN])[0]


class Slave:
    """A unit run by the program that the standard's makers test with, variables by name."""

    def __init__(self, path, folder):
        about = read_model_description(str(path))
        self.references = {v.name: v.valueReference for v in about.modelVariables}
        self.unit = instantiate_fmu(extract(str(path), str(folder)), about, "CoSimulation")
        self.unit.setupExperiment()
        self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()

    def set(self, name, value):
        self.unit.setReal([self.references[name]], [value])

    def get(self, name):
        return self.unit.getReal([self.references[name]])[0]

    def step(self, time, size):
        self.unit.doStep(time, size)


@pytest.fixture(scope="module")
def machine():
    return scene_machine(SCENE, coil="current", volts=10.0)


@pytest.fixture(scope="module")
def unit(machine, tmp_path_factory):
    """Its unit, built once."""
    path = tmp_path_factory.mktemp("unit") / "generator.fmu"
    assert write_fmu(path, machine, "paper")
    return path


@needs_compiler
def test_it_moves_like_the_steps_in_python(machine, unit, tmp_path):
    """The rod leaves its stop under 150 mA, the bimorph bends under a sine held piecewise."""
    assert unit.stat().st_size < 200_000
    assert validate_fmu(str(unit)) == []
    slave = Slave(unit, tmp_path)
    stepper = Stepper(machine.system)
    state = stepper.start(machine.rest, 0.0 * machine.rest, 0.0, 0.0)
    size, pieces = 4e-6, 4
    for k in range(25):
        voltage = 10.0 * math.sin(2.0 * math.pi * 1000.0 * k * size)
        slave.set("voltage", voltage)
        slave.set("coil", 0.15)
        slave.step(k * size, size)
        state, _ = stepper.jump(state, voltage, 0.15)
        for _ in range(pieces):
            state, _ = stepper.step(state, size / pieces, voltage, (0.15, 0.15))
    system = machine.system
    row = system.outputs["lateral_tip"].row
    # both iterate to 1e-9 of a step, which the stiff contact amplifies on the way
    for name, value in (
        ("rod_lift", state.position[0]),
        ("lateral_tip", row @ state.position),
        ("head_tilt", state.position[2]),
        ("coil_current", state.current),
        ("flux_linkage", state.field.flux_linkage),
        ("magnetic_pull", state.field.force),
        ("charge", system.coupling @ state.position + system.capacitance * state.voltage),
    ):
        assert slave.get(name) == pytest.approx(float(value), rel=1e-5), name
    assert slave.get("rod_lift") < -1e-7
    assert abs(slave.get("imbalance")) < 1e-12 * abs(slave.get("energy"))


@needs_compiler
def test_the_balance_holds_through_pull_in_and_release(tmp_path):
    """20 ms on and off, driven by voltage: stops hit at both ends, and energy is kept."""
    path, machine = tmp_path / "generator.fmu", scene_machine(SCENE, coil="voltage", volts=10.0)
    write_fmu(path, machine, "paper")
    slave = Slave(path, tmp_path / "unit")
    resistance = machine.system.coil.resistance
    stroke = SCENE.gap - SCENE.spring.stop_gap
    lifts, energies = [], []
    for k in range(2000):
        slave.set("coil", 0.15 * resistance if k < 1000 else 0.0)
        slave.set("voltage", 10.0 * math.sin(2.0 * math.pi * 200.0 * k * 1e-5))
        slave.step(k * 1e-5, 1e-5)
        lifts.append(slave.get("rod_lift"))
        energies.append(slave.get("energy"))
    lifts = np.array(lifts)
    # the contact gives way by less than 1 um
    assert lifts[999] == pytest.approx(-stroke, abs=2e-6)
    assert lifts[-1] == pytest.approx(0.0, abs=2e-6)
    assert abs(slave.get("imbalance")) < 1e-10 * np.ptp(energies)


def test_a_bore_with_play_is_refused(tmp_path):
    """Its sources know no bore; nothing is written."""
    scene, _ = load_scene("paper", ["load.kind=none", "guide.clearance=5um"])
    with pytest.raises(InputError, match=r"set guide\.clearance = 0 mm"):
        write_fmu(tmp_path / "x.fmu", scene_machine(scene, coil="current", volts=1.0), "paper")
    assert not list(tmp_path.iterdir())


@needs_compiler
def test_it_refuses_what_is_no_number(unit, tmp_path):
    slave = Slave(unit, tmp_path)
    for refused in (
        lambda: slave.set("voltage", math.nan), lambda: slave.set("rod_lift", 1.0),  # an output
        lambda: slave.step(0.0, -1.0),
    ):  # fmt: skip
        with pytest.raises(FMICallException):
            refused()


def test_a_compiler_that_fails_is_quoted(machine, tmp_path, monkeypatch):
    """In one sentence, and nothing is written."""
    compiler = tmp_path / "cc"
    compiler.write_text(f"#!/bin/sh\necho no such flag {300 * 'x'} >&2\nexit 1\n", encoding="utf-8")
    compiler.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda _: str(compiler))
    with pytest.raises(InputError, match=r"cc fails \(no such flag x{187}\); mend it, or take it"):
        write_fmu(tmp_path / "x.fmu", machine, "paper")
    assert list(tmp_path.iterdir()) == [compiler]


def test_the_command_writes_it(unit, capsys, tmp_path):
    """With the finger it moves more coordinates than without."""
    path = tmp_path / "generator.fmu"
    on_rod = ["export", "paper", "--set", "support.kind=contact", "--set", "coil.current=0mA"]
    assert main([*on_rod, "--fmu", str(path)]) == 0
    assert capsys.readouterr().out.strip() == str(path)
    assert _coordinates(path) > _coordinates(unit)


def test_a_held_bimorph_has_no_unit(capsys, tmp_path):
    """The unit is of the generator on its rod: a clamp would pass unnoticed."""
    for kind in ("clamped", "spring"):
        asked = ["export", "paper", "--set", f"support.kind={kind}"]
        assert main([*asked, "--fmu", str(tmp_path / "x.fmu")]) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert f'support.kind = "{kind}"' in said
    assert not list(tmp_path.iterdir())


def _coordinates(path):
    with zipfile.ZipFile(path) as unit:
        header = unit.read("sources/model.h").decode()
    return next(
        int(line.split()[2]) for line in header.splitlines() if line.startswith("#define N ")
    )
