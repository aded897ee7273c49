"""Fields of a scene: they are the models' own numbers, and agree where theories do."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import beam_pieces, row_shape
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.field import at_phase, von_mises
from tactgen.validation.show.gather import _coupling, default_models, gather, gather_from
from tactgen.validation.show.solid_fields import Sampler, points_of_regions

HZ = 300.0
MODELS = ("solid", "tmm", "beam", "lumped")


@pytest.fixture(scope="module", autouse=True)
def few(tmp_path_factory, few_bricks):
    """Divide the solid into few bricks, in a store of its own whose keys do not know."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("few")))
        patch.setattr(solid, "LEVELS", few_bricks)
        yield


@pytest.fixture(scope="module")
def solution():
    scene, _ = load_scene("j1", ["mesh.level=1", "modes=3", f"frequency={HZ}Hz"])
    quantities = [
        "short_circuit_frequencies", "open_circuit_frequencies", "static_tip_displacement",
        "tip_displacement", "input_current", "capacitance_free", "coupling_factor",
    ]  # fmt: skip
    return solve(scene, MODELS, quantities)


@pytest.fixture(scope="module")
def results(solution):
    return {m: gather_from(solution, m, (HZ,)) for m in MODELS}


@pytest.mark.parametrize("model", MODELS)
def test_numbers_beside_a_picture_are_the_quantities(solution, results, model):
    """Tip and charge of every driven state, frequencies and coupling of every mode."""
    result = results[model]
    for circuit in ("short", "open"):
        listed = solution.get(f"{circuit}_circuit_frequencies", model)
        shown = [s for s in result.states if s.circuit == circuit]
        assert [s.frequency for s in shown] == listed.value.tolist()
        assert [s.motion for s in shown] == list(listed.classes)
    static, moving = result.state("static"), result.state(f"{HZ:g} Hz")
    # the port reduction's tolerance is 1e-3 of the accuracy 1e-3
    tip = solution.get("tip_displacement", model).value[0]
    assert moving.tip == pytest.approx(tip, rel=2e-6)
    current = solution.get("input_current", model).value[0]
    assert 2j * np.pi * HZ * moving.charge == pytest.approx(current, rel=2e-6)
    at_rest = float(solution.get("static_tip_displacement", model).value)
    assert static.tip == pytest.approx(at_rest, rel=1e-6)
    free = float(solution.get("capacitance_free", model).value)
    volts = solution.scene.drive.voltage
    assert static.charge / volts == pytest.approx(free, rel=1e-6)
    coupling = float(solution.get("coupling_factor", model).value)
    assert result.states[0].coupling == pytest.approx(coupling, rel=1e-12)


def test_between_fingers_the_field_is_along_the_layer():
    """U over the pitch along z; the flux through the section is the charge of each finger."""
    layers = "brass 0.2 mm; PZT-5A 0.2 mm +z pitch 0.5 mm"
    sizes = ["bimorph.length=10mm", "bimorph.width=2mm", "drive.voltage=10V"]
    scene, _ = load_scene("j1", ["mesh.level=1", f"bimorph.layers={layers}", *sizes])
    (result,) = gather(scene, ("solid",), ())
    fields, at = result.state("static").fields, points_of_regions(result.mesh)["piezo_2"]
    field, flux = fields["electric_field"][at], fields["electric_displacement"][at]
    np.testing.assert_allclose(field, np.tile([0.0, 0.0, 20e3], (at.size, 1)), atol=1e-6)
    # 20 spaces between fingers; points are denser where the flux is not the mean
    fingers = flux[:, 2].mean() * 2e-3 * 0.2e-3 * 20.0
    assert result.state("static").charge == pytest.approx(fingers, rel=0.05)


@pytest.mark.parametrize("model", MODELS)
def test_the_tip_of_the_picture_is_the_tip(results, model):
    """The mean of u_x over the cells' faces at the tip."""
    result = results[model]
    points, state = result.mesh.points, result.state("static")
    upper = result.mesh.cells[:, [4, 5, 6, 7]]
    upper = upper[np.isclose(points[upper, 2], points[:, 2].max()).all(axis=1)]
    a, b, c, d = points[upper].transpose(1, 0, 2)
    area = 0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1)
    shown = state.fields["displacement"][upper, 0].mean(axis=1)
    # the face bends across; the mean of four corners leaves little of that
    bent = float(np.ptp(shown))
    assert area @ shown / area.sum() == pytest.approx(state.tip, abs=0.1 * bent, rel=1e-9)


def test_mode_shapes_of_a_slender_bimorph_agree(solution, results):
    """Modal assurance criterion of TMM and solid on the solid's points."""
    solid, tmm = results["solid"], results["tmm"]
    scene, points = solution.scene, solid.mesh.points
    lines = solution.models["tmm"].mode_lines(open_circuit=False)
    bending = [s for s in solid.states if s.motion == "bending_x" and s.circuit == "short"]
    assert len(bending) >= 2
    for state, line in zip(bending, lines, strict=False):
        w, psi = (np.interp(points[:, 2], line.z, v) for v in (line.w, line.psi))
        shape = np.stack([w, 0.0 * w, points[:, 0] * psi], axis=1).ravel()
        moved = state.fields["displacement"].ravel()
        mac = (shape @ moved) ** 2 / ((shape @ shape) * (moved @ moved))
        assert mac >= 0.999
    pieces = beam_pieces(scene.device, scene.support)
    shape = row_shape(pieces, scene.device, lines[0].z, scene.bimorph.length)
    assert shape.mesh.points == pytest.approx(tmm.mesh.points)


def test_rayleigh_quotient_of_the_field_is_the_frequency(solution, results):
    """Displacement and potential at the points, put back into the system's matrices."""
    system, result = solution.models["solid"].systems()[0], results["solid"]
    points, state = result.mesh.points, result.states[0]
    order = {tuple(np.round(p, 10)): k for k, p in enumerate(points)}
    at = np.array([order[tuple(np.round(p, 10))] for p in system.nodes])
    values = np.column_stack([state.fields["displacement"], state.fields["potential"]])[at]
    scale = np.repeat([1.0, 1.0, 1.0, 1.0 / system.volts_per_unit], len(at))
    expand = scale[:, None] * (system.expand @ np.eye(system.size))
    y = np.linalg.lstsq(expand, scale * values.T.ravel(), rcond=1e-14)[0]
    quotient = (y @ (system.stiffness @ y)) / (y @ (system.mass @ y))
    # the quotient's error is the square of the shape's, which was solved for to 1e-9
    assert np.sqrt(quotient) / (2.0 * np.pi) == pytest.approx(state.frequency, rel=1e-7)


def test_flux_through_the_electrodes_is_the_charge(results):
    """∫ D·n over both outer electrodes, the mean of four corners in each quadrilateral."""
    result = results["solid"]
    state, mesh = result.state("static"), result.mesh
    found = 0.0
    for side, inwards in (("top", -1.0), ("bottom", 1.0)):
        quads = mesh.faces[f"electrode_{side}_outer"]
        a, b, c, d = mesh.points[quads].transpose(1, 0, 2)
        area = 0.5 * np.linalg.norm(np.cross(c - a, d - b), axis=1)
        flux = state.fields["electric_displacement"][quads, 0].mean(axis=1)
        found += inwards * float(flux @ area)
    # D has an inverse root of a singularity at the electrodes' ends, where cells are smallest
    assert found == pytest.approx(state.charge, rel=1e-2)


def test_layers_have_points_of_their_own(solution, results):
    """Stress jumps between ceramic and shim, and the shim has no field."""
    result = results["solid"]
    regions = points_of_regions(result.mesh)
    assert sum(len(at) for at in regions.values()) == len(result.mesh.points)
    field = result.state("static").fields["electric_field"]
    assert not field[regions["shim"]].any()
    # parallel wiring: both layers between U and 0 over their thickness
    middle = np.abs(result.mesh.points[:, 2] - 10e-3) < 3e-3
    mean = np.abs(field[regions["piezo_top"]][middle[regions["piezo_top"]], 0]).mean()
    assert mean == pytest.approx(solution.scene.drive.voltage / 0.26e-3, rel=0.02)


def test_beams_carry_the_potential_linearly(solution, results):
    """On the outer faces the voltage, in the shim nothing."""
    for model in ("tmm", "beam", "lumped"):
        result = results[model]
        potential = result.state("static").fields["potential"]
        outer = np.abs(result.mesh.points[:, 0]) > 0.38e-3
        assert potential[outer] == pytest.approx(solution.scene.drive.voltage)
        assert not potential[points_of_regions(result.mesh)["shim"]].any()


def test_a_scene_with_nothing_that_moves_is_refused():
    scene, _ = load_scene("reluctance", ["models=network"])
    with pytest.raises(InputError, match="neither a bimorph that moves nor a field"):
        default_models(scene)
    with pytest.raises(InputError, match="ask for them one after the other"):
        gather(scene, ["tmm", "axisymmetric"])


def test_series_wiring_halves_charge_and_voltage_of_a_layer():
    """A quarter of the capacitance at the terminals: half the voltage, half the charge."""
    both = []
    for wiring in ("parallel", "series"):
        scene, _ = load_scene("j1", [f"bimorph.wiring={wiring}", "modes=1"])
        (result,) = gather(scene, ["tmm"], ())
        both.append(result.state("static"))
    assert both[1].charge == pytest.approx(0.25 * both[0].charge)
    assert both[1].tip == pytest.approx(0.5 * both[0].tip)


def test_a_mode_couples_with_its_partner_among_the_bending_ones():
    """Whichever of both circuits has the higher frequency; none without a partner."""

    def listed(values, classes):
        return SimpleNamespace(value=np.array(values), classes=classes)

    both = {
        "short": listed([3.0, 4.0, 6.0, 9.0], ("bending_x", "torsion", "bending_x", "bending_x")),
        "open": listed([1.0, 5.0, 4.8], ("bending_y", "bending_x", "bending_x")),
    }
    found = [[_coupling(both, c, n) for n in range(len(both[c].value))] for c in ("short", "open")]
    nan = pytest.approx(np.nan, nan_ok=True)
    assert found == [[0.8, nan, pytest.approx(0.6), nan], [nan, 0.8, pytest.approx(0.6)]]


def test_von_mises_and_phase():
    """Uniaxial and pure shear stress; a quarter period later the imaginary part counts."""
    stress = np.array([[0, 0, 5.0, 0, 0, 0], [0, 0, 0, 0, 2.0, 0]])
    assert von_mises(stress) == pytest.approx([5.0, 2.0 * np.sqrt(3.0)])
    assert at_phase(np.array([3.0 + 4.0j]), np.pi / 2) == pytest.approx([-4.0])


def test_gradients_of_polynomials_are_exact(solution):
    """On bricks up to their degree along each axis, within a layer and across its bricks."""
    model = solution.models["solid"]
    nodes = model.systems()[0].nodes
    x, y, z = nodes.T / 1e-3
    sampler = Sampler(model.meshes()[0], nodes)
    values, gradients = sampler.sample(np.stack([x**2 + x * y * z, y**2 * z**3], axis=1))
    x, y, z = sampler.mesh.points.T / 1e-3
    assert values[:, 0] == pytest.approx(x**2 + x * y * z, abs=1e-9)
    exact = np.stack(
        [[2 * x + y * z, x * z, x * y], [0 * x, 2 * y * z**3, 3 * y**2 * z**2]]
    ).transpose(2, 0, 1)
    assert 1e-3 * gradients == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())


def test_gradients_on_tetrahedra_are_exact_for_quadratics():
    """Three straight tetrahedra, two of one region; a quarter stands for the whole."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [0, 0, -1]]) + 1.0
    cells = np.array([[0, 1, 2, 3], [1, 2, 3, 4], [0, 2, 1, 5]])
    mesh = Mesh(corners, cells, "tetra", np.array([0, 1, 0]), ("shim", "piezo_top"), {})
    ends = np.array([(i, j) for c in cells for i in c for j in c if i < j])
    nodes = np.vstack([corners, np.unique(corners[ends].mean(axis=1), axis=0)])
    x, y, z = nodes.T
    sampler = Sampler(mesh, nodes)
    _, gradients = sampler.sample((x**2 + 3.0 * x * y + z)[:, None])
    x, y, z = sampler.mesh.points.T
    assert len(sampler.mesh.points) == 24  # ten more where regions meet, six shared within one
    exact = np.stack([2 * x + 3 * y, 3 * x, np.ones_like(z)], axis=1)
    assert gradients[:, 0] == pytest.approx(exact)


@pytest.mark.heavy
def test_tetrahedra_have_the_same_fields():
    """Halfway along, the axial stress over the depth has the slope that bricks give it."""
    scene, _ = load_scene("j1", ["models=cad", "mesh.level=1", "modes=1"])
    slopes = []
    for model in ("cad", "solid"):
        (result,) = gather(scene, [model], ())
        points, stress = result.mesh.points, result.state("static").fields["stress"][:, 2]
        at = points_of_regions(result.mesh)["piezo_top"]
        at = at[np.abs(points[at, 2] - 10e-3) < 3e-3]
        at = at[np.abs(points[at, 1]) < 0.6e-3]
        slopes.append(np.polyfit(points[at, 0], stress[at], 1)[0])
    # a layer has one or two tetrahedra of linear strain across it
    assert slopes[0] == pytest.approx(slopes[1], rel=0.05)


def test_a_harvester_is_shown_as_it_moves():
    """By its base, relative to which the foot is at rest; the solid's electrodes at its voltage."""
    scene, _ = load_scene("j1", [
        "mesh.level=1", "circuit.kind=load", "circuit.resistance=1 Mohm", "load.kind=mass",
        "load.mass=5 mg", "drive.base_acceleration=1 g", f"frequency={HZ}Hz",
    ])  # fmt: skip
    (result,) = gather(scene, ("solid",), (HZ,))
    (state,) = (state for state in result.states if state.circuit == "driven")
    names = ("tip_displacement", "electrode_voltage")
    tip, voltage = (q.value[0] for q in solve(scene, ("solid",), names).quantities)
    assert state.tip == pytest.approx(tip, rel=2e-6)
    moved, low = np.asarray(state.fields["displacement"]), result.mesh.points[:, 2] < 1e-9
    assert np.abs(moved[low]).max() < 1e-9 * np.abs(moved).max()
    x = np.abs(result.mesh.points[:, 0])
    outer = (x > x.max() - 1e-9) & ~low
    assert np.asarray(state.fields["potential"])[outer] == pytest.approx(voltage, rel=1e-6)


def test_a_finger_beyond_its_range_is_drawn_with_the_end_of_its_law():
    """Numbers are refused there, pictures are not; they say no modelling error."""
    (result,) = gather(load_scene("paper")[0], ("tmm",), (2000.0,))
    state = result.state("2000 Hz")
    assert abs(state.tip) > 0.0
    assert state.modelling == ""
