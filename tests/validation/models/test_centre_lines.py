"""How the bimorph bends between its ends: beam elements against the transfer matrices."""

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

ENDS = [
    ("support.kind=clamped", "load.kind=none"),
    (
        "support.kind=spring", "support.rotational_inertia=1e-9 kg*m^2",
        "load.kind=spring_damper", "load.stiffness=300 N/m", "load.damping=0.02 N*s/m",
    ),
]  # fmt: skip


@pytest.fixture(scope="module", params=ENDS, ids=["clamped", "a spring"])
def models(request):
    """Return both models of the paper's bimorph, held and loaded in two ways."""
    scene, _ = load_scene("paper", [*request.param, "modes=2"])
    found = solve(scene, ("tmm", "beam"), ("static_tip_displacement",), modelling=False)
    return found.models["tmm"], found.models["beam"]


def assert_alike(exact, found):
    """64 elements of third order: 1e-6 of a line is left at the second mode."""
    for name in ("w", "psi"):
        one, other = (getattr(line, name) for line in (exact, found))
        at = np.interp(found.z, exact.z, np.arange(exact.z.size))
        whole = np.isclose(at, np.rint(at))
        assert whole.sum() > 10
        same = one[np.rint(at[whole]).astype(int)]
        assert other[whole] == pytest.approx(same, abs=1e-5 * np.abs(one).max())
    assert found.charge == pytest.approx(exact.charge, rel=1e-5, abs=1e-16)
    assert found.voltage == pytest.approx(exact.voltage, rel=1e-5)
    assert found.frequency == pytest.approx(exact.frequency, rel=1e-6)


@pytest.mark.parametrize("open_circuit", [False, True])
def test_modes(models, open_circuit):
    """Frequency, shape, and the charge or voltage of unit tip displacement."""
    lines = [model.mode_lines(open_circuit=open_circuit) for model in models]
    assert [len(each) for each in lines] == [2, 2]
    for exact, found in zip(*lines, strict=True):
        assert_alike(exact, found)


@pytest.mark.parametrize("frequency", [0.0, 2500.0])
def test_driven_motion(models, frequency):
    """With losses, at rest and above the first resonance."""
    assert_alike(*(model.driven_line(frequency, 2.0, lossy=True) for model in models))
