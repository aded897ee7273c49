"""3D magnetostatic fields by both potentials: exact cases, bounds, invariants, TEAM problem 20."""

from dataclasses import replace

import numpy as np
import pytest
from mirrored_mesh import mirrored

from tactgen.fem.magnetics.axisymmetric_space import coenergy_density, energy_density
from tactgen.fem.magnetics.problem_3d import MagneticSolid, ScalarPotential, VectorPotential, sample
from tactgen.geometry.device.magnetisation import MU0, TEAM20, linear
from tactgen.geometry.errors import InputError
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh, team20_source
from tactgen.validation.evidence.cases.ball import sphere_mesh

STEEL = {"pole": TEAM20, "yoke": TEAM20}
STRAIGHT = {"pole": linear(500.0), "yoke": linear(500.0)}
BOTH = pytest.mark.parametrize("potential", [VectorPotential, ScalarPotential])


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
    stiff = VectorPotential(problem).solve(5000.0, start=saturated[0])
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
