"""3D magnetostatic fields by both potentials: exact cases, bounds, invariants, TEAM problem 20."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from mirrored_mesh import mirrored

from tactgen.fem.magnetics.axisymmetric_space import coenergy_density, energy_density
from tactgen.fem.magnetics.problem_3d import MagneticSolid, ScalarPotential, VectorPotential, sample
from tactgen.geometry.device.magnetisation import MU0, TEAM20, linear
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, graded_planes
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh, team20_source
from tactgen.validation.evidence.cases import ball as sphere_in_field
from tactgen.validation.evidence.cases.ball import sphere_mesh

STEEL = {"pole": TEAM20, "yoke": TEAM20}
STRAIGHT = {"pole": linear(500.0), "yoke": linear(500.0)}
BOTH = pytest.mark.parametrize("potential", [VectorPotential, ScalarPotential])
ball_error = cache(sphere_in_field.ball_error)


def team20(scale, **changes):
    solid = MagneticSolid(team20_mesh(Team20Meshing(scale=scale)), STEEL, team20_source, copies=4)
    return replace(solid, **changes)


@pytest.fixture(scope="module")
def coarse():
    """TEAM problem 20 on a coarse mesh (4 thousand unknowns), both potentials."""
    solid = sample(team20(4.0))
    return VectorPotential(solid), ScalarPotential(solid)


@pytest.fixture(scope="module")
def saturated(coarse):
    return tuple(potential.solve(5000.0) for potential in coarse)


# Exact fields


@pytest.mark.parametrize(
    ("potential", "curved"),
    # B = const is curl(B x r)/2, which curved cells hold only approximately
    [(VectorPotential, False), (ScalarPotential, False), (ScalarPotential, True)],
)
def test_uniform_field_in_uniform_iron(potential, curved):
    """Patch test: iron all over in the source's uniform field has H = T0 exactly."""
    problem = MagneticSolid(
        sphere_mesh(1, curved=curved),
        {"ball": TEAM20, "air": TEAM20, "far": TEAM20},
        lambda points: np.broadcast_to([0.0, 0.0, 1.0], points.shape),
        flux_normal=("z_low", "outer"),
        copies=8,
    )
    field = potential(sample(problem)).solve(700.0)
    np.testing.assert_allclose(field.field_strength[..., 2], 700.0, rtol=1e-6)
    np.testing.assert_allclose(field.field_strength[..., :2], 0.0, atol=700.0 * 1e-6)


def test_linear_solenoidal_field_is_exact():
    """Patch test: H = T0 linear in x, y, z, with curl and without divergence, to rounding.

    B at any point inside as well.
    """
    turn = np.array([[1.0, 2.0, -0.5], [0.3, -3.0, 1.0], [0.7, 0.2, 2.0]])
    mesh = sphere_mesh(1, curved=False)
    problem = MagneticSolid(mesh, {}, lambda p: p @ turn.T, flux_normal=tuple(mesh.faces))
    solid = sample(problem)
    field = VectorPotential(solid).solve(1.0)
    np.testing.assert_allclose(field.field_strength, solid.source, atol=1e-9)
    points = np.random.default_rng(4).uniform(0.0, 1.4, (20, 3))
    np.testing.assert_allclose(field.flux_density_at(points), MU0 * points @ turn.T, atol=1e-14)


@pytest.mark.parametrize(
    ("potential", "flat"),
    [
        (VectorPotential, False),
        (ScalarPotential, True),
        pytest.param(VectorPotential, True, marks=pytest.mark.heavy),
    ],
)
def test_ball_in_a_uniform_field(potential, flat):
    """B = 3 µr B0/(µr + 2) inside; curved cells converge with order above 2, straight below.

    Measured on 2, 3, 4, 5 intervals per edge: curved 1.1e-2, 4e-3, 2e-3, 1.2e-3 (order 2.4);
    straight 4e-2 to 1e-2 (order 1.5), six to eleven times as much on the finest.
    """
    curved = [ball_error(potential, n, curved=True) for n in (2, 3)]
    assert np.log(curved[0][1] / curved[1][1]) / np.log(1.5) > 2.0
    assert curved[1][1] < 5e-3
    if flat:
        straight = [ball_error(potential, n, curved=False) for n in (2, 3)]
        assert np.log(straight[0][1] / straight[1][1]) / np.log(1.5) < 2.0
        assert curved[1][1] < straight[1][1] / 4.0


def test_ball_is_enclosed_by_both_potentials():
    """The mean B in the ball comes out too small by A and too large by φ, alike in size."""
    low, _ = ball_error(VectorPotential, 3, curved=True)
    high, _ = ball_error(ScalarPotential, 3, curved=True)
    assert low < 0.0 < high
    assert abs(low + high) < 0.2 * (high - low)


# A coil in air

BORE, RIM, HALF_HEIGHT = 15e-3, 25e-3, 10e-3


def square_coil_source(points):
    """T0 of a square coil, 30 and 50 mm wide, 20 mm high, one ampere-turn."""
    away = np.abs(points[..., :2]).max(axis=-1)
    within = np.abs(points[..., 2]) < HALF_HEIGHT
    field = np.zeros(points.shape)
    ramp = np.clip((RIM - away) / (RIM - BORE), 0.0, 1.0)
    field[..., 2] = np.where(within, ramp / (2.0 * HALF_HEIGHT), 0.0)
    return field


def straight_wire(points, start, end):
    """Biot and Savart for one ampere in a straight piece of wire (T)."""
    length = np.linalg.norm(end - start)
    unit = (end - start) / length
    along = (points - start) @ unit
    across = points - start - along[..., None] * unit
    distance2 = np.sum(across**2, axis=-1)
    ends = along / np.hypot(along, np.sqrt(distance2))
    ends -= (along - length) / np.hypot(along - length, np.sqrt(distance2))
    return MU0 / (4.0 * np.pi) * np.cross(unit, across) * (ends / distance2)[..., None]


def square_coil_field(points):
    """Biot and Savart over the coil's section by Gauss' rule, 10 x 10 loops."""
    at, weight = np.polynomial.legendre.leggauss(10)
    field = np.zeros(points.shape)
    for u, wu in zip(at, weight / 2.0, strict=True):
        half = 0.5 * (BORE + RIM) + 0.5 * (RIM - BORE) * u
        for v, wv in zip(at, weight / 2.0, strict=True):
            loop = [
                np.array([x * half, y * half, HALF_HEIGHT * v])
                for x, y in ((1, -1), (1, 1), (-1, 1), (-1, -1), (1, -1))
            ]
            field += wu * wv * sum(straight_wire(points, a, b) for a, b in pairwise(loop))
    return field


def coil_error(potential, scale):
    """Relative mean square error of B in the bore, on and off the axis."""

    def planes(edges):
        return graded_planes([(at, scale * size) for at, size in edges], growth=0.6 * scale)

    far = (0.25, 0.1)
    x = planes([(0.0, 5e-3), (BORE, 3e-3), (RIM, 4e-3), far])
    z = planes([(0.0, 5e-3), (HALF_HEIGHT, 3e-3), far])
    mesh = box_tetrahedra(x, x, z, np.zeros((x.size - 1, x.size - 1, z.size - 1), int), ("air",))
    solid = sample(MagneticSolid(mesh, {}, square_coil_source, flux_normal=("z_low",), copies=8))
    near = np.abs(solid.points[..., :2]).max(axis=-1) < 0.8 * BORE
    near &= solid.points[..., 2] < 2.0 * HALF_HEIGHT
    exact = square_coil_field(solid.points[near])
    miss = potential(solid).solve(1.0).flux_density[near] - exact
    weights = solid.weights[near][:, None]
    return float(np.sqrt(np.sum(weights * miss**2) / np.sum(weights * exact**2)))


@pytest.mark.parametrize(
    "potential", [pytest.param(VectorPotential, marks=pytest.mark.heavy), ScalarPotential]
)
def test_coil_in_air_is_that_of_biot_and_savart(potential):
    """T0 alone drives the field of the real coil, off the axis too, to discretisation error."""
    coarse, fine = (coil_error(potential, scale) for scale in (2.0, 1.0))
    assert fine < 0.012  # measured 0.010; walls at ten coil widths leave 0.001
    assert fine < coarse / 2.0  # linear B inside a cell: order 2 asymptotically, 1.5 seen


# Bounds and invariants on the saturated problem


def test_coenergy_is_enclosed(saturated):
    """W' by A < W' by φ, and their difference is the sum of a density that is nowhere negative,
    w(B) + w'(H) − B·H (Prager and Synge)."""
    vector, scalar = saturated
    gap = scalar.coenergy - vector.coenergy
    b, h = vector.flux_density, scalar.field_strength
    iron, solid = vector.solid.iron, vector.solid
    density = energy_density(iron, b) + coenergy_density(iron, h) - np.einsum("cqa,cqa->cq", b, h)
    density = solid.problem.copies * np.sum(solid.weights * density, axis=1)
    assert gap > 0.0
    assert density.min() > -1e-12 * gap
    assert density.sum() == pytest.approx(gap, rel=1e-6)  # Newton stops at 1e-7, squared in W'


@pytest.mark.heavy
@pytest.mark.parametrize("scale", [6.0, 2.8])
def test_finer_mesh_narrows_the_enclosure_from_both_sides(saturated, scale):
    """On a finer mesh the lower bound rises and the upper bound falls."""
    solid = sample(team20(scale))
    fine = VectorPotential(solid).solve(5000.0), ScalarPotential(solid).solve(5000.0)
    fine, wide = (fine, saturated) if scale < 4.0 else (saturated, fine)
    assert wide[0].coenergy < fine[0].coenergy < fine[1].coenergy < wide[1].coenergy


@pytest.mark.parametrize("which", [0, 1], ids=["vector", "scalar"])
def test_energy_balance(coarse, saturated, which):
    """W + W' = i λ, and λ = dW'/di: one co-energy gives flux and energy."""
    field = saturated[which]
    product = field.current * field.flux_linkage
    assert field.energy + field.coenergy == pytest.approx(product, rel=1e-9)
    step = 5.0
    ahead, behind = (coarse[which].solve(5000.0 + s, start=field).coenergy for s in (step, -step))
    # central difference: error of third order in 0.1 % of the current
    assert (ahead - behind) / (2.0 * step) == pytest.approx(field.flux_linkage, rel=1e-5)


@pytest.mark.parametrize(
    "which", [pytest.param(0, marks=pytest.mark.heavy), 1], ids=["vector", "scalar"]
)
def test_solution_does_not_depend_on_where_newton_starts(coarse, saturated, which):
    """The energy is convex: from rest and from another current the same field."""
    other = coarse[which].solve(1000.0)
    again = coarse[which].solve(5000.0, start=other)
    assert again.coenergy == pytest.approx(saturated[which].coenergy, rel=1e-12)
    assert saturated[which].iterations <= 12
    assert coarse[which].solve(0.0, start=again).energy == 0.0


@BOTH
def test_straight_iron_needs_one_step_and_scales(potential):
    """Linear iron: energies grow with the current squared; in metres as in millimetres."""
    problem = team20(6.0, materials=STRAIGHT)
    one = potential(sample(problem)).solve(100.0)
    assert one.iterations <= 3  # the vector potential mends what its gauge term costs
    mesh = replace(problem.mesh, points=1e3 * problem.mesh.points)
    large = replace(problem, mesh=mesh, source=lambda p: 1e-3 * team20_source(1e-3 * p))
    # inductance is in proportion to length
    assert potential(sample(large)).solve(200.0).energy == pytest.approx(4e3 * one.energy, rel=1e-9)


@BOTH
def test_half_of_the_device_gives_what_a_quarter_gives(potential):
    """Symmetry planes are no approximation: the mirrored mesh has the same energy.

    Of straight iron, which takes one step: a curve asks nothing of the planes.
    """
    quarter = team20(6.0, materials=STRAIGHT)
    half = replace(quarter, mesh=mirrored(quarter.mesh, axis=0), copies=2)
    one, other = (potential(sample(problem)).solve(100.0) for problem in (quarter, half))
    assert other.coenergy == pytest.approx(one.coenergy, rel=1e-9)


def test_gauge_term_leaves_the_field_alone(coarse, saturated, monkeypatch):
    """A hundred times the added mass changes no digit of the co-energy that Newton settles."""
    monkeypatch.setattr("tactgen.fem.magnetics.problem_3d._GAUGE", 1e-2)
    problem = saturated[0].solid
    stiff = VectorPotential(problem).solve(5000.0)
    assert stiff.coenergy == pytest.approx(saturated[0].coenergy, rel=1e-11)
    difference = stiff.flux_density - saturated[0].flux_density
    assert np.abs(difference).max() < 1e-5  # T, beside 2 T: Newton's own 1e-7 of the energy norm


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"materials": {"plunger": TEAM20}}, "materials names 'plunger'.*use some of pole, yoke"),
        ({"flux_normal": ("top",)}, "flux_normal names 'top'.*x_low"),
    ],
)
def test_unknown_names_are_refused(changes, message):
    """One sentence with what was asked and what there is."""
    with pytest.raises(InputError, match=message):
        team20(4.0, **changes)


def test_hexahedra_are_refused():
    """Edge elements are for tetrahedra."""
    mesh = replace(team20_mesh(Team20Meshing(scale=4.0)), kind="hexahedron")
    with pytest.raises(InputError, match="use tetrahedra"):
        MagneticSolid(mesh, {}, team20_source)
