"""The transfer-matrix model at many values of its parameters at once, and its centre line."""

from functools import partial

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import centre_line, transfer_matrix
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.parametric import Actuator, parameter_keys
from tactgen.tmm.beam.port_quantities import evaluate, first_frequency, resonance_peak
from tactgen.tmm.beam.transfer_matrix import sections
from tactgen.tmm.ports.excitation_and_circuit import PortState
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.scene.load import load_scene

VELOCITY = QUANTITIES["tip_velocity"].read


def actuator(name, *overrides):
    scene, _ = load_scene(name, overrides)
    return Actuator(scene.device, scene.support, scene.load, scene.beam, scene.drive)


PAPER, PROTOTYPE = actuator("paper"), actuator("prototype")
ROWS = {
    "paper": PAPER,
    "rod": actuator("bimorph_on_rod", "load.kind=none"),
    "taper": actuator("prototype", "bimorph.width_profile=0 mm: 2.1 mm, 14 mm: 1 mm"),
    "series": actuator("prototype", "bimorph.wiring=series", "bimorph.bare_below=2mm"),
    "mass": actuator("prototype", "load.kind=mass", "load.mass=5mg", "support.kind=clamped"),
    "layers": actuator(
        "prototype",
        "bimorph.tab_length=1mm",
        "bimorph.layers=PZT-5A 0.1 mm +z pitch 0.5 mm; brass 0.2 mm; glue 20 um from 2 mm; "
        "PZT-5A 0.2 mm wide 1.8 mm from 3 mm to 12 mm +x",
    ),
    "spring": actuator(
        "paper", "load.kind=spring_damper", "load.stiffness=700N/m", "load.damping=0.5N*s/m"
    ),
}


def first(device, *, open_circuit):
    pieces = sections(device.device, device.support, device.beam, lossy=False)
    return bending_frequencies(pieces, device.ends, 1, open_circuit=open_circuit)


@pytest.mark.parametrize("name", ROWS)
def test_a_varied_value_is_that_of_another_device(name):
    """Every parameter, tab, rod, taper, bare ceramic, series wiring, layers, mass, spring: 1e-9."""
    device, at = ROWS[name], np.array([40.0, 120.0])
    for key in parameter_keys(device):
        moved = 1.001 * device.value(key)
        other = evaluate(device.with_values({key: moved}), VELOCITY, {}, at)
        found = evaluate(device, VELOCITY, {key: np.full(2, moved)}, at)
        assert found == pytest.approx(other, rel=1e-9), key


def test_keys_are_those_that_matter():
    """No magnetics, no rod unless it holds the bimorph, no length at which a piece appears."""
    assert not [k for k in parameter_keys(PAPER) if k.startswith(("rod", "glue", "load", "coil"))]
    sizes = {key for key in parameter_keys(ROWS["layers"]) if ".layers." in key}
    # not those by which the field of interdigitated electrodes is solved
    wanted = ["2.thickness", "3.thickness", "3.start", "4.thickness", "4.width", "4.start", "4.end"]
    assert sizes == {f"bimorph.layers.{size}" for size in wanted}
    rod = parameter_keys(ROWS["rod"])
    assert {"rod.radius", "glue.thickness", "bimorph.tab_length"} <= set(rod)
    assert not [key for key in rod if key.startswith("support")]
    # this rod ends at its flange: its length can only grow, with a new piece
    assert "rod.length" not in rod
    assert {"load.stiffness", "load.damping"} <= set(parameter_keys(ROWS["spring"]))
    with pytest.raises(InputError, match=r"rod\.length.*smoothly; this scene's depends on"):
        evaluate(ROWS["rod"], VELOCITY, {"rod.length": np.ones(1)}, np.ones(1))


@pytest.mark.parametrize("open_circuit", [False, True])
def test_sampled_first_frequency_is_the_counted_one(open_circuit):
    """Newton's method on many samples finds the mode that counting modes finds, at both ends."""
    points = {"piezo.density": np.array([6000.0, 7900.0, 9000.0]), "bimorph.length": 0.014}
    points["support.rotational_stiffness"] = np.array([0.05, 0.24, 1.0])
    start = np.full(3, first(PROTOTYPE, open_circuit=open_circuit)[0])
    found = first_frequency(PROTOTYPE, points, start, open_circuit=open_circuit)
    for i in range(3):
        one = PROTOTYPE.with_values(
            {k: float(np.ravel(v)[i % np.size(v)]) for k, v in points.items()}
        )
        # counting converges to 1e-14, Newton to 1e-12
        assert found[i] == pytest.approx(first(one, open_circuit=open_circuit)[0], rel=1e-11)


def test_resonance_peak_is_a_maximum():
    """Beside it the velocity is less."""
    of = partial(evaluate, PROTOTYPE, VELOCITY)
    at, height = resonance_peak(of, {}, first(PROTOTYPE, open_circuit=False))
    beside = np.abs(evaluate(PROTOTYPE, VELOCITY, {}, at[0] * np.array([1 - 1e-5, 1 + 1e-5])))
    assert (beside < height[0]).all()


def test_ends_that_move_rigidly_move_the_whole_line_so():
    """A row that nobody bends is straight, and ends where it was put; each counts (w' = -ψ)."""
    device, clamped = Device(bimorph=Bimorph(tab_length=1.5e-3)), Support(kind="clamped")
    row = transfer_matrix.sections(device, clamped, Beam(), lossy=False)
    height = sum(float(length) for _, length in row)
    base, turned = 3e-6, 2e-4
    ports = np.array([base, turned, base - turned * height, turned, 0.0])
    line = centre_line.line_between(row, PortState(1.0, ports, 0.0), inertia=False)
    np.testing.assert_allclose(line.w, base - turned * line.z, rtol=1e-9)
    np.testing.assert_allclose(line.psi, turned, rtol=1e-9)
    ports = np.array([base, turned, -2.0 * base, -3.0 * turned, 7.0])
    line = centre_line.line_between(row, PortState(1.0, ports, 0.0))
    ends = [line.w[0], line.psi[0], line.w[-1], line.psi[-1], line.voltage]
    np.testing.assert_allclose(ends, ports, rtol=1e-14)
