"""The beam elements' error bars hold against the exact transfer-matrix model, rounding included."""

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

CASES = {
    "soft spring": ("prototype", "support.rotational_stiffness=0.002 N*m/rad"),
    "slender": ("paper", "bimorph.length=200mm", "load.kind=none"),
    "stubby": ("paper", "bimorph.length=2mm"),
    "glued": ("bimorph_on_rod",),
    "series": ("prototype", "bimorph.wiring=series"),
}


QUANTITIES = (
    "tip_displacement", "admittance", "blocked_force", "static_tip_displacement",
    "capacitance_free", "short_circuit_frequencies", "open_circuit_frequencies",
)  # fmt: skip


def solved(scene, *overrides, quantities=QUANTITIES):
    of, _ = load_scene(scene, [*overrides, "models=tmm,beam", "frequency=10,100,300,999"])
    return solve(of, None, quantities, modelling=False)


@pytest.mark.parametrize("case", CASES)
def test_bars_cover_the_distance_from_tmm(case):
    """Both solve one theory, so what separates them is error, and their bars say how much."""
    solution = solved(*CASES[case])
    for name in dict.fromkeys(q.name for q in solution.quantities):
        exact, found = (solution.get(name, model) for model in ("tmm", "beam"))
        distance = np.abs(found.value - exact.value)
        assert (distance <= found.error + exact.error).all(), name


def test_rounding_of_a_mode_is_its_own():
    """The slowest mode loses most digits; each of them no less than it is off by."""
    name, clamped = "short_circuit_frequencies", ("support.kind=clamped", "bimorph.length=40mm")
    solution = solved("paper", *clamped, "modes=4", quantities=(name,))
    exact, found = (solution.get(name, model) for model in ("tmm", "beam"))
    relative = found.error / found.value
    assert (np.abs(found.value - exact.value) <= found.error + exact.error).all()
    assert relative[0] > 2.0 * relative[1]
    assert relative[:2].max() < 1e-9
