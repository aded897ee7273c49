"""Modelling errors: the quick models' answers beside what solids and fields say."""

import json

import numpy as np
import pytest

from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import quantity_from_json, quantity_json
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

ASKED = ("static_tip_displacement", "capacitance_free", "short_circuit_frequencies")
BENDER = (
    "bimorph.length=27mm", "bimorph.width=12.7mm", "bimorph.piezo_thickness=0.19mm",
    "bimorph.shim_thickness=0.13mm", "piezo.material=PZT-5A", "shim.material=brass",
    "support.kind=clamped",
)  # fmt: skip

#: Of two ceramics, each over a part of the length, one reaching the clamp.
PATCHES = "PZT-5A 0.3 mm to 7 mm -x; brass 0.3 mm; PZT-5A 0.3 mm from 3 mm to 12 mm -x"


def answers(name, *overrides, models=("tmm", "calibrated", "solid")):
    scene, _ = load_scene(name, ["mesh.level=2", "modes=1", *overrides])
    found = solve(scene, models, ASKED)
    return [tuple(found.get(q, model) for model in models) for q in ASKED]


def number(values):
    return float(np.ravel(values)[0])


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("paper", []), ("j1", []),
        pytest.param("prototype", BENDER, marks=pytest.mark.heavy),
        pytest.param(
            "prototype", [*BENDER, "load.kind=mass", "load.mass=2g"], marks=pytest.mark.heavy
        ),
        ("prototype", ["shim.youngs_modulus=20MPa", "shim.shear_modulus=7.7MPa"]),
        ("j1", ["bimorph.width=15mm"]),
        ("prototype", [f"bimorph.layers={PATCHES}", "bimorph.width=2mm", "bimorph.length=12mm",
                       "support.kind=clamped", "bimorph.tip_extension=2mm"]),
    ],
)  # fmt: skip
def test_it_covers_what_the_solid_says(name, overrides):
    """The paper's devices, a wide bender with a tip mass, a soft core, a wide plate, patches.

    Without frequencies and patches the calibrated model is nearer by a factor of five at least.
    """
    uniform = not any("layers" in one for one in overrides)
    for quick, calibrated, solid in answers(name, *overrides):
        right, bar = number(solid.value), number(solid.error)
        apart = abs(number(quick.value) - right)
        assert apart <= number(quick.modelling_error) + bar, quick.name
        assert not np.any(solid.modelling_error)
        if uniform and quick.name in ASKED[:2]:
            assert 5.0 * abs(number(calibrated.value) - right) < apart, quick.name


@pytest.mark.parametrize(
    ("name", "override", "quantity", "model"),
    [
        ("bimorph_on_rod", "modes=1", "static_tip_displacement", "tmm"),
        ("paper", "bimorph.width_profile=0 mm: 2.1 mm, 20 mm: 1 mm", "capacitance_free", "tmm"),
        ("reluctance", "modes=1", "resting_positions", "network"),
        # a transverse modulus that no solid has
        ("prototype", "shim.youngs_modulus=1 GPa", "static_tip_displacement", "tmm"),
        # couples a third more than any ceramic of the fit
        ("prototype", "piezo.d31=-533 pm/V", "static_tip_displacement", "tmm"),
        # no solid has it
        ("prototype", "piezo.constants=d31 -450 pm/V; d33 1200 pC/N", "static_tip_displacement",
         "tmm"),
    ],
)  # fmt: skip
def test_what_is_not_known_says_so(name, override, quantity, model):
    """Where the solid refuses, or the fit would have to be continued far, nothing is claimed."""
    scene, _ = load_scene(name, [f"models={model}", override])
    (found,) = solve(scene, (model,), (quantity,)).quantities
    assert np.isfinite(found.value).all()
    assert np.isnan(found.modelling_error).all()


STATE = ("magnetic_force", "flux_linkage", "coenergy")


@pytest.mark.parametrize(
    ("asked", "overrides"),
    [
        (STATE, []), (STATE, ["gap=15um"]), (STATE, ["coil.current=1A"]),
        (("inductance",), ["coil.current=1mA"]), (("inductance",), ["coil.current=0A"]),
        (STATE, ["steel.curve=linear", "steel.relative_permeability=3"]),
        pytest.param(("pull_in_current", "holding_current"), [], marks=pytest.mark.heavy),
    ],
)  # fmt: skip
def test_the_network_beside_the_field(asked, overrides):
    """The paper's actuator: almost closed, far into saturation, without a current, hardly steel."""
    scene, _ = load_scene("reluctance", ["accuracy=5%", *overrides])
    found = solve(scene, ("network", "axisymmetric"), asked)
    for name in asked:
        network, field = found.get(name, "network"), found.get(name, "axisymmetric")
        assert abs(network.value - field.value) <= network.modelling_error + field.error, name


def test_json_keeps_it_and_the_screen_shows_both_errors(capsys):
    for q in answers("paper", models=("tmm", "solid"))[0]:
        again = quantity_from_json(json.loads(json.dumps(quantity_json(q))))
        np.testing.assert_array_equal(again.modelling_error, q.modelling_error)
        assert (again.modelling is None) == (q.modelling is None)
    asked = ["--model", "tmm", "--quantity", "static_tip_displacement,short_circuit_frequencies"]
    assert main(["solve", "prototype", *asked]) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = [line for line in lines if line.startswith(("static", "short"))]
    assert all("±" in row and row.endswith("%") for row in rows[:3])
