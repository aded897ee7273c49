"""What the tip touches: its impedance alone, and the force and power that it takes."""

import numpy as np
import pytest

from tactgen.tmm.ports.loads import finger_impedance
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.scene.load import load_scene

F = np.array([10.0, 300.0, 900.0])


def solved(*overrides, models=("tmm",), quantities=("load_impedance",)):
    scene, _ = load_scene("paper", ("frequency=10,300,900", *overrides))
    return solve(scene, models, quantities)


@pytest.mark.parametrize(
    ("overrides", "impedance"),
    [
        ((), finger_impedance(F)),
        (("load.kind=none",), 0.0 * F),
        (("load.kind=mass", "load.mass=2mg"), 2j * np.pi * F * 2e-6),
        (
            ("load.kind=spring_damper", "load.stiffness=300N/m", "load.damping=0.5N*s/m"),
            0.5 + 300.0 / (2j * np.pi * F),
        ),
    ],
)
def test_the_impedance_is_that_of_what_is_stated(overrides, impedance):
    """By the formulas of a finger (eqs 1-3), a mass, a spring and a damper, to rounding."""
    found = solved(*overrides).get("load_impedance", "tmm")
    np.testing.assert_allclose(found.value, impedance, rtol=1e-13)
    assert found.frequency == tuple(F)


def test_the_impedance_needs_no_model():
    """It is of the load alone: no stage runs for it."""
    scene, _ = load_scene("paper", ("frequency=10,300,900",))
    assert make_plan(scene, ("tmm",), ("load_impedance",)).run == ()


@pytest.mark.parametrize("overrides", [(), ("bimorph.wiring=series",)])
def test_force_and_power_follow_from_the_velocity(overrides):
    """F = Z v and P = Re(F v*)/2, by a model with a closed form and by one with ports only."""
    names = ("load_impedance", "tip_velocity", "load_force", "load_power")
    found = solved(*overrides, models=("lumped", "tmm", "beam"), quantities=names)
    z = found.get("load_impedance", "tmm").value
    for model in ("lumped", "tmm", "beam"):
        v, force, power = (found.get(name, model) for name in names[1:])
        np.testing.assert_allclose(force.value, z * v.value, rtol=1e-9)
        expected = 0.5 * (force.value * v.value.conj()).real
        np.testing.assert_allclose(power.value, expected, rtol=1e-9)
        assert (power.value > 0.0).all()
        # the power goes with the square of the motion; elements' bars are read off each alone
        relative = power.error / power.value, v.error / np.abs(v.value)
        assert model == "beam" or (relative[0] >= 1.5 * relative[1]).all()


def test_every_model_takes_imitation_skin():
    """The same load on the same theory by two ways of solving it."""
    found = solved("load.kind=pad", models=("tmm", "beam"), quantities=("load_force",))
    exact, elements = (found.get("load_force", model) for model in ("tmm", "beam"))
    apart = np.abs(exact.value - elements.value)
    assert (apart <= exact.error + elements.error).all()
    assert found.warnings == ()
