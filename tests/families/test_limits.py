"""Limits in which the answer is known, by every model that has them."""

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

MODELS = ("lumped", "tmm", "beam", "solid")


def values(model, names, *overrides, scene="j1"):
    found = solve(load_scene(scene, ["mesh.level=2", "modes=1", *overrides])[0], (model,), names)
    return [q.value for q in found.quantities]


@pytest.mark.usefixtures("coarse_solid")
@pytest.mark.parametrize("model", MODELS)
def test_response_at_rest_is_the_static_one(model):
    """Ω = 0 with next to no loss: the response's amplitude is the static deflection."""
    losses = ("piezo.quality_factor=1e6", "piezo.loss_tangent=0", "frequency=0", "load.kind=none")
    static, response = values(model, ("static_tip_displacement", "tip_displacement"), *losses)
    assert response[0].real == pytest.approx(static, rel=1e-5)
    assert abs(response[0].imag) < 1e-5 * abs(static)


@pytest.mark.usefixtures("coarse_solid")
@pytest.mark.parametrize("model", MODELS)
def test_without_piezoelectricity_nothing_moves(model):
    """d31 = 0: no deflection, no coupling, one capacitance."""
    names = ("static_tip_displacement", "coupling_factor", "capacitance_free",
             "capacitance_blocked")  # fmt: skip
    moved, coupled, free, blocked = values(model, names, "piezo.d31=0 pC/N")
    usual = values(model, names[:1])[0]
    assert abs(moved) < 1e-9 * abs(usual)
    assert coupled < 1e-5
    assert free == pytest.approx(blocked, rel=1e-9)


@pytest.mark.parametrize("model", ["lumped", "tmm", "beam"])
def test_a_heavy_tip_leaves_a_spring(model):
    """Under a mass a thousand times the beam's the first mode is that of a massless spring."""
    load = ("load.kind=mass", "load.mass=1 kg")
    (frequency,) = values(model, ("short_circuit_frequencies",), *load)
    static, force = values(model, ("static_tip_displacement", "blocked_force"), "frequency=0")
    stiffness = np.abs(force[0] / static)  # lossless but for the quality factor
    assert frequency[0] == pytest.approx(np.sqrt(stiffness) / (2.0 * np.pi), rel=2e-3)
