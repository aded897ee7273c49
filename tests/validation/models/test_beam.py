"""Beam elements and transfer matrices: their bars, and how the bimorph bends between its ends."""

import numpy as np
import pytest

from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.ports.excitation_and_circuit import excitation_of, port_states
from tactgen.tmm.ports.multiport import in_series, respond, round_off
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

CASES = {
    "soft spring": ("prototype", "support.rotational_stiffness=0.002 N*m/rad"),
    "slender": ("paper", "bimorph.length=200mm", "load.kind=none"),
    "stubby": ("paper", "bimorph.length=2mm"),
    "glued": ("bimorph_on_rod",),
}
QUANTITIES = (
    "tip_displacement", "admittance", "blocked_force", "static_tip_displacement",
    "capacitance_free", "short_circuit_frequencies", "open_circuit_frequencies",
)  # fmt: skip


def solved(scene, *overrides, quantities=QUANTITIES):
    of, _ = load_scene(scene, ["frequency=10,100,300,999", *overrides])
    return solve(of, ("tmm", "beam"), quantities, modelling=False)


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


ENDS = {
    "clamped": ("support.kind=clamped", "load.kind=none"),
    "a harvester": (
        "support.kind=clamped", "load.kind=mass", "load.mass=20 mg", "load.offset=1 mm",
        "circuit.kind=load", "circuit.resistance=10 kohm", "drive.base_acceleration=2 g",
        "drive.tip_force=1 mN",
    ),
    "a spring": (
        "support.kind=spring", "support.rotational_inertia=1e-9 kg*m^2",
        "load.kind=spring_damper", "load.stiffness=300 N/m", "load.damping=0.02 N*s/m",
    ),
}  # fmt: skip


@pytest.fixture(scope="module", params=ENDS)
def both(request):
    """Return both models of the paper's bimorph, held and loaded in different ways."""
    names = ("static_tip_displacement", "tip_displacement", "electrode_voltage", "tip_acceleration")
    asked = (*ENDS[request.param], "modes=2", "frequency=300, 2500")
    return solved("paper", *asked, quantities=names)


def assert_alike(exact, found):
    """64 elements of third order: 1e-6 of a line is left at the second mode."""
    at = np.interp(found.z, exact.z, np.arange(exact.z.size))
    whole = np.isclose(at, np.rint(at))
    assert whole.sum() > 10
    for name in ("w", "psi"):
        one, other = (getattr(line, name) for line in (exact, found))
        same = one[np.rint(at[whole]).astype(int)]
        assert other[whole] == pytest.approx(same, abs=1e-5 * np.abs(one).max())
    assert found.charge == pytest.approx(exact.charge, rel=1e-5, abs=1e-16)
    assert found.voltage == pytest.approx(exact.voltage, rel=1e-5)
    assert found.frequency == pytest.approx(exact.frequency, rel=1e-6)


def test_modes_are_alike_between_the_ends(both):
    """Frequency, shape, and the charge or voltage of unit tip displacement."""
    for opened in (False, True):
        lines = [model.mode_lines(open_circuit=opened) for model in both.models.values()]
        assert [len(each) for each in lines] == [2, 2]
        for exact, found in zip(*lines, strict=True):
            assert_alike(exact, found)


@pytest.mark.parametrize("number", [0, 1])
def test_driven_motion_is_alike_between_the_ends(both, number):
    """With losses, below and above the first resonance: as the quantities say, base and tip."""
    ends, excitation = both.scene.ends, excitation_of(both.scene.circuit, both.scene.drive)
    lines = []
    for name, model in both.models.items():
        state = port_states(model.ports().fine, ends, excitation)[number]
        line = model.driven_line(state)
        tip, voltage, acceleration = (
            both.get(quantity, name).value[number]
            for quantity in ("tip_displacement", "electrode_voltage", "tip_acceleration")
        )
        assert [line.w[-1], line.voltage] == pytest.approx([tip, voltage], rel=1e-9)
        moved = -((2.0 * np.pi * state.frequency) ** 2) * (line.w[-1] + state.ground)
        assert moved == pytest.approx(acceleration)
        if ends.base is None:
            assert abs(line.w[0]) < 1e-12 * abs(line.w[-1])
        lines.append(line)
    assert_alike(*lines)


@pytest.mark.parametrize(("kind", "wiring"), [("clamped", "series"), ("spring", "parallel")])
def test_closed_form_against_elimination(kind, wiring):
    """What tmm answers and the elimination from D(Ω) agree within their two bars."""
    names = ("tip_displacement", "tip_rotation", "input_current")
    scene, _ = load_scene("paper", [f"support.kind={kind}", f"bimorph.wiring={wiring}"])
    solution = solve(scene, ("tmm",), names, modelling=False)
    f, voltage = np.array(scene.frequency), scene.drive.voltage
    port = multiport(scene.device, scene.support, scene.beam, f)
    mounted = attach(in_series(port) if wiring == "series" else port, scene.ends)
    witness = respond(mounted, {"voltage": voltage})
    current = 2j * np.pi * f * witness.effort["voltage"]
    values = (witness.motion["w_tip"], witness.motion["psi_tip"], current)
    for name, value in zip(names, values, strict=True):
        found = solution.get(name, "tmm")
        bars = found.error + round_off(mounted) * np.abs(value)
        assert (np.abs(found.value - value) <= bars).all(), name
