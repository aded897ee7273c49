"""How the bimorph bends between its ends: beam elements against the transfer matrices."""

import numpy as np
import pytest

from tactgen.tmm.ports.excitation import excitation_of, port_states
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

ENDS = [
    ("support.kind=clamped", "load.kind=none"),
    (
        "support.kind=clamped", "load.kind=mass", "load.mass=20 mg", "load.offset=1 mm",
        "circuit.kind=load", "circuit.resistance=10 kohm", "drive.base_acceleration=2 g",
        "drive.tip_force=1 mN",
    ),
    (
        "support.kind=spring", "support.rotational_inertia=1e-9 kg*m^2",
        "load.kind=spring_damper", "load.stiffness=300 N/m", "load.damping=0.02 N*s/m",
    ),
]  # fmt: skip


@pytest.fixture(scope="module", params=ENDS, ids=["clamped", "a harvester", "a spring"])
def models(request):
    """Return both models of the paper's bimorph, held and loaded in two ways."""
    scene, _ = load_scene("paper", [*request.param, "modes=2", "frequency=300, 2500"])
    names = ("static_tip_displacement", "tip_displacement", "electrode_voltage", "tip_acceleration")
    return solve(scene, ("tmm", "beam"), names, modelling=False)


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
    lines = [model.mode_lines(open_circuit=open_circuit) for model in models.models.values()]
    assert [len(each) for each in lines] == [2, 2]
    for exact, found in zip(*lines, strict=True):
        assert_alike(exact, found)


@pytest.mark.parametrize("number", [0, 1])
def test_driven_motion(models, number):
    """With losses, below and above the first resonance: as the quantities say, base and tip."""
    scene = models.scene
    excitation = excitation_of(scene.circuit, scene.drive)
    lines = []
    for name, model in models.models.items():
        state = port_states(model.ports().fine, scene.ends, excitation)[number]
        line = model.driven_line(state)
        for quantity, value in (
            ("tip_displacement", line.w[-1]),
            ("electrode_voltage", line.voltage),
        ):
            assert value == pytest.approx(models.get(quantity, name).value[number], rel=1e-9)
        acceleration = -((2.0 * np.pi * state.frequency) ** 2) * (line.w[-1] + state.ground)
        assert acceleration == pytest.approx(models.get("tip_acceleration", name).value[number])
        if scene.ends.base is None:
            assert abs(line.w[0]) < 1e-12 * abs(line.w[-1])
        lines.append(line)
    assert_alike(*lines)
