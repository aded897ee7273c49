"""What holds for every model of an actuator, whatever solves it."""

import numpy as np
import pytest

from tactgen.tmm.ports.multiport import passivity_margin, reciprocity_error
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene


def lateral(model, *overrides, scene="j1"):
    return load_scene(scene, ["mesh.level=2", "frequency=0,100,1500", *overrides])[0], (model,)


@pytest.mark.usefixtures("coarse_solid")
@pytest.mark.parametrize("model", ["lumped", "tmm", "beam", "solid"])
def test_ports_are_reciprocal_and_passive(model):
    """What one port does to another is mutual, and no port gives off power."""
    solution = solve(*lateral(model), ("dynamic_stiffness",))
    port = solution.models[model].ports().fine
    # condensing a field model leaves rounding; a wrong sign or term shows at order one
    assert reciprocity_error(port).max() < 1e-6
    assert passivity_margin(port).min() > -1e-6


@pytest.mark.usefixtures("coarse_solid")
@pytest.mark.parametrize("model", ["lumped", "tmm", "beam", "solid"])
def test_open_circuit_is_stiffer_and_the_held_capacitor_smaller(model):
    """f_open above f_short, C_blocked below C_free: energy that turns back into voltage."""
    names = (
        "short_circuit_frequencies", "open_circuit_frequencies",
        "capacitance_blocked", "capacitance_free", "coupling_factor",
    )  # fmt: skip
    short, opened, blocked, free, k = solve(*lateral(model, "modes=1"), names).quantities
    assert short.value[0] < opened.value[0]
    assert blocked.value < free.value
    assert k.value == pytest.approx(np.sqrt(1.0 - (short.value[0] / opened.value[0]) ** 2))


@pytest.mark.parametrize("model", ["network", "axisymmetric"])
def test_the_pull_does_not_know_the_currents_sign(model):
    """Force and co-energy are even in the current, flux linkage is odd."""
    found = [
        solve(load_scene("reluctance", [f"coil.current={i} mA", "accuracy=1%"])[0], (model,),
              ("magnetic_force", "coenergy", "flux_linkage")).quantities
        for i in (80, -80)
    ]  # fmt: skip
    for plus, minus, sign in zip(*found, (1.0, 1.0, -1.0), strict=True):
        # Newton's method stops at 1e-7 of the field
        assert minus.value == pytest.approx(sign * plus.value, rel=1e-5)
