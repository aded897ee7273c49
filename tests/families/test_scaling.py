"""A device many times larger or smaller is the same device in other units."""

import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import load_scene

FACTOR = 1e-2
LENGTHS = ("length", "width", "piezo_thickness", "shim_thickness")


@pytest.mark.usefixtures("coarse_solid")
@pytest.mark.parametrize("model", ["lumped", "tmm", "beam", "solid"])
def test_bimorph(model):
    """All lengths by a hundredth, s, at the same voltage: deflection as before, frequencies by 1/s,
    capacitance by s, and the coupling factor as before."""
    names = (
        "static_tip_displacement", "short_circuit_frequencies", "capacitance_free",
        "coupling_factor",
    )  # fmt: skip
    small, _ = load_scene("j1", ["mesh.level=2", "modes=2"])
    bimorph = small.bimorph
    larger = bimorph.model_copy(update={n: FACTOR * getattr(bimorph, n) for n in LENGTHS})
    large = small.model_copy(update={"bimorph": larger})
    one, other = (solve(scene, (model,), names).quantities for scene in (small, large))
    for before, after, power in zip(one, other, (0, -1, 1, 0), strict=True):
        # the rounding that the bars tell, which is the solid's at 1e-6
        expected = FACTOR**power * before.value
        assert after.value == pytest.approx(expected, rel=1e-6), before.name
