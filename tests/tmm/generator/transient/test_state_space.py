"""The machine's state space against its ports: poles, axial transfers, lateral at low frequency."""

import numpy as np
import pytest

from tactgen.tmm.generator.small_signal import axial_poles
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.small_signal import rod_of
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show import export as machine_state_space
from tactgen.validation.show.export import scene_state_space

FREQUENCIES = (1.0, 30.0, 500.0, 8000.0)
HELD = ("load.kind=none", "coil.current=50mA", "coil.history=falling",
        "frequency=1,30,500,8000")  # fmt: skip
TRANSFERS = (
    "lateral_tip_per_voltage", "axial_tip_per_current", "axial_tip_per_coil_voltage",
    "coil_impedance", "axial_tip_per_voltage",
)  # fmt: skip


@pytest.fixture(scope="module", params=["current", "voltage"])
def found(request):
    scene, _ = load_scene("generator", [*HELD, f"coil.supply={request.param}"])
    made = scene_state_space(scene)
    s = 2j * np.pi * np.array(FREQUENCIES)[:, None, None]
    response = made.c @ np.linalg.solve(s * np.eye(len(made.a)) - made.a, made.b) + made.d
    return scene, made, response, solve(scene, ("tmm",), TRANSFERS).by_model


def test_its_poles_are_the_axial_ones_and_decay(found):
    """To 1e-9: an eigenvalue of a matrix whose entries span ten decades, against a cubic's root."""
    scene, made, *_ = found
    poles = np.linalg.eigvals(made.a)
    assert (poles.real < 0.0).all()
    for pole in axial_poles(rod_of(scene, map_of(scene)), voltage=scene.coil.supply == "voltage"):
        assert np.abs(poles - pole).min() < 1e-9 * abs(pole)


def test_its_file_holds_all_of_it(found, tmp_path, monkeypatch):
    """Every matrix and name under its letter, without code in the file."""
    scene, made, *_ = found
    monkeypatch.setattr(machine_state_space, "scene_state_space", lambda _: made)
    machine_state_space.write_machine(tmp_path / "machine.npz", scene)
    with np.load(tmp_path / "machine.npz", allow_pickle=False) as file:
        for name in ("a", "b", "c", "d", "inputs", "outputs"):
            np.testing.assert_array_equal(file[name], getattr(made, name))
        assert {"title", "conventions"} < set(file)


def test_its_transfers_are_those_of_the_ports(found):
    """Axial ones to rounding.  Lateral ones by another model of the bimorph, beam elements with
    damping mode by mode: 1e-3 up to 30 Hz, of the loss that Q = 60 takes there."""
    scene, made, response, by = found
    coil = made.inputs.index(f"coil {scene.coil.supply} ({'A' if len(made.outputs) == 2 else 'V'})")
    name = "axial_tip_per_current" if scene.coil.supply == "current" else TRANSFERS[2]
    np.testing.assert_allclose(response[:, 1, coil], by(name)["tmm"].value, rtol=1e-9)
    if scene.coil.supply == "voltage":
        np.testing.assert_allclose(
            response[:, 2, coil], 1.0 / by("coil_impedance")["tmm"].value, rtol=1e-9
        )
    lateral = by("lateral_tip_per_voltage")["tmm"].value
    np.testing.assert_allclose(np.abs(response[:2, 0, 0]), np.abs(lateral[:2]), rtol=1e-3)
    assert np.abs(response[:, 1, 0]).max() == 0.0  # an upright head keeps the motions apart


def test_a_tilted_head_lets_the_voltage_lift_the_rod():
    """As the ports say, within the bimorph's own damping."""
    scene, _ = load_scene("generator", [*HELD, "spring.eccentricity=0.1mm"])
    made = scene_state_space(scene)
    exact = solve(scene, ("tmm",), ("axial_tip_per_voltage",)).quantities[0].value[1]
    s = 2j * np.pi * FREQUENCIES[1]
    lifted = (made.c @ np.linalg.solve(s * np.eye(len(made.a)) - made.a, made.b))[1, 0]
    assert abs(lifted) == pytest.approx(abs(exact), rel=1e-2)
