"""A held bimorph in time: its own support and load, as the frequency domain has them."""

import json

import numpy as np
import pytest
from scipy.io import netcdf_file

from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.waveform import Step
from tactgen.tmm.ports.supports_and_loads import chain_of
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.held_bimorph import held_system, oscillations, run_held
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.simulate import read_film

#: Own bimorph of an engineer: clamped, with a heavy tip, in series.
CLAMPED = ["bimorph.length=27mm", "bimorph.width=12.7mm", "bimorph.piezo_thickness=0.19mm",
           "bimorph.shim_thickness=0.13mm", "piezo.material=PZT-5A", "shim.material=brass",
           "bimorph.wiring=series", "support.kind=clamped", "load.kind=mass", "load.mass=2g",
           "drive.voltage=60V"]  # fmt: skip


def system_of(scene):
    return held_system(scene, chain_of(scene.ends.tip), scene.drive.voltage)


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("paper", CLAMPED),
        # the damper of the fitted springs counts by the root of 1 - zeta^2 and its coupling of
        # modes: 4e-4 of the first, so that it is left out here
        ("prototype", ["support.rotational_damping=0 N*m*s/rad"]),
        ("prototype", ["support.rotational_damping=0 N*m*s/rad", "load.kind=spring_damper",
                       "load.stiffness=500N/m"]),
        ("bimorph_on_rod", ["load.kind=none"]),
    ],
)  # fmt: skip
def test_its_frequencies_are_those_of_the_scene(name, overrides):
    """By the transfer matrix; a loss factor shifts the viscous poles by zeta^2/2 of 1e-4 or less.

    A viscous mode has the size |p| that the lossless one has, to rounding.
    """
    scene, _ = load_scene(name, overrides)
    exact = solve(scene, ("tmm",), ("short_circuit_frequencies",)).quantities[0].value
    below = exact[exact < 20e3]
    found = [frequency for frequency, _ in oscillations(system_of(scene))]
    np.testing.assert_allclose(found[: below.size], below, rtol=1e-6)


@pytest.mark.parametrize("below", [0, 8])
def test_its_response_is_that_of_the_scene(below):
    """Static, and at resonance: viscous damping takes there what the loss factor does.

    Where the motion is measured, the tip or a place below it.
    """
    place = f"measurement.below_tip={below} mm"
    scene, _ = load_scene("paper", [*CLAMPED, place, "frequency=1,119.9"])
    system, found = system_of(scene), []
    omega = 2.0 * np.pi * np.array(scene.frequency)
    for w in omega:
        dynamic = system.stiffness + 1j * w * system.damping - w**2 * system.mass
        motion = np.linalg.solve(dynamic, system.coupling * scene.drive.voltage)
        found.append(system.outputs["lateral_tip"].row @ motion)
    exact = solve(scene, ("tmm",), ("tip_displacement",)).quantities[0].value
    # a hysteretic loss also acts at rest, on the phase only to first order: 1/Q = 1.3 % at 1 Hz;
    # at resonance the modes above share in the damping by their static part, some 1e-3
    np.testing.assert_allclose(np.abs(found), np.abs(exact), rtol=2e-3)


def test_a_free_decay_rings_at_the_first_frequency():
    """Twelve periods after a step, about the static deflection, losing as the damping ratio says.

    Crossings are interpolated; the error bar of 1 % of the deflection moves one by 1e-3 of a
    period, of twelve periods by 2e-4.
    """
    scene, _ = load_scene("paper", CLAMPED)
    result = run_held(scene, Step(60.0), 0.105, accuracy=0.01)
    (first, ratio), *_ = oscillations(result.system)
    static = solve(scene, ("tmm",), ("static_tip_displacement",)).quantities[0].value
    time = np.linspace(0.0, 0.105, 20001)
    tip = np.interp(time, result.answer.run.time, result.answer.outputs["lateral_tip"]) - static
    up = np.flatnonzero((tip[:-1] < 0.0) & (tip[1:] >= 0.0))
    crossed = time[up] - tip[up] * (time[1] - time[0]) / (tip[up + 1] - tip[up])
    assert crossed.size == 13
    ringing = (crossed.size - 1) / (crossed[-1] - crossed[0])
    assert ringing == pytest.approx(first * np.sqrt(1.0 - ratio**2), rel=3e-4)
    tops = [tip[(time >= t) & (time < t + 1.0 / first)].max() for t in crossed[[0, -2]]]
    decay = np.log(tops[0] / tops[1]) / (2.0 * np.pi * (crossed.size - 2))
    # the second mode, 1 % of the motion at first, rides on the tops
    assert decay == pytest.approx(ratio, rel=0.05)
    assert result.answer.run.worst_imbalance < 1e-12


def test_a_load_of_several_parts_and_a_law_without_parts():
    """The finger has coordinates of its own; imitation skin is refused with loads that do."""
    finger, free = (load_scene("paper", [f"load.kind={kind}"])[0] for kind in ("finger", "none"))
    parts = chain_of(finger.ends.tip).mass.shape[0] - 1
    assert parts > 0
    assert system_of(finger).mass.shape[0] == system_of(free).mass.shape[0] + parts
    with pytest.raises(InputError, match=r'set load\.kind = "none"'):
        chain_of(load_scene("paper", ["load.kind=pad"])[0].ends.tip)
    with pytest.raises(InputError, match=r"support\.lateral_stiffness = 0 N/m does not hold"):
        system_of(load_scene("paper", ["load.kind=none", "support.lateral_stiffness=0 N/m"])[0])


def run(capsys, *arguments):
    sets = [word for one in CLAMPED for word in ("--set", one)]
    code = main(["simulate", "paper", *sets, *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_the_command_runs_it_and_writes_it(capsys, tmp_path):
    out = tmp_path / "run.nc"
    asked = ("--voltage", "60 V step at 1 ms", "--until", "3 ms")
    code, text, err = run(capsys, *asked)
    assert (code, err) == (0, "")
    assert "natural frequencies: 119.9 Hz" in text
    found = json.loads(run(capsys, *asked, "--json", "--out", out)[1])
    assert found["oscillations"][0]["frequency_hz"] == pytest.approx(119.896, rel=1e-5)
    with netcdf_file(str(out), "r", mmap=False) as file:
        tip = file.variables["lateral_tip"]
        assert tip.units == b"m"
        assert tip[:].max() == found["quantities"]["lateral_tip"]["largest"]
    with pytest.raises(InputError, match=r"is not a run of a generator on its rod; write it"):
        read_film(out)


@pytest.mark.parametrize("arguments", [("--coil", "9 mA"), ("--gif", "a.gif")])
def test_what_is_of_the_rod_is_refused(capsys, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, "--voltage", "1 V", *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"{arguments[0]} is of the generator on its rod" in err
