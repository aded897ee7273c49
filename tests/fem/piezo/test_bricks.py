"""The piezoelectric solid on bricks: exact facts, and scikit-fem's elements as witness."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.fem.piezo.bricks import assemble_bricks, brick_matrices, nodal_mass
from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.symmetry import lumped
from tactgen.fem.piezo.system import materials
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.bricks import LEVELS, Axis, BrickMeshing, bimorph_bricks
from tactgen.geometry.device.parameters import Bimorph, Device, Shim

MOTIONS = ("bending_x", "bending_y", "torsion", "axial")
#: For what holds on any bricks: a few for each piece.
COARSE = BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0))
VARIANTS = (
    {},
    {"tab_length": 1.6e-3},
    {"bare_below": 1e-3, "bare_above": 0.4e-3},
    {"glue_thickness": 10e-6},
    {"layers": "shim 0.2 mm; piezo 0.3 mm wide 1.2 mm to 12 mm +x", "tip_extension": 2e-3},
)


def ceramic_without(device, *, coupling=True, poisson=True):
    ceramic = device.piezo.ceramic()
    d = ceramic.d if coupling else np.zeros((3, 6))
    s = ceramic.s if poisson else np.diag(np.diag(ceramic.s))
    return replace(ceramic, d=d, s=s)


@pytest.mark.parametrize(
    ("level", "variant"),
    [(0, variant) for variant in VARIANTS]
    + [pytest.param(1, variant, marks=pytest.mark.heavy) for variant in VARIANTS],
)
def test_rigid_motion_needs_no_force(variant, level):
    """Translating and turning the whole body leaves all ports free of force and charge."""
    device = Device(bimorph=Bimorph(**variant))
    bricks = bimorph_bricks(device, LEVELS[level])
    system = assemble(device, bricks, lossy=False)
    d = static_multiport(system).stiffness[0].real
    length = bricks.z.breaks[-1]
    energy = {"translation": [1.0, 0.0, 1.0, 0.0], "turn": [0.0, 1.0, -length, 1.0]}
    tip = 1.0 / np.linalg.inv(d[2:4, 2:4])[0, 0]
    # the bound that the system states of its own rounding, for unit motion of the tip
    allowed = system.spurious_stiffness + 1e-12 * tip
    assert abs(np.array(energy["translation"]) @ d[:4, :4] @ energy["translation"]) < allowed
    turned = np.array(energy["turn"]) @ d[:4, :4] @ energy["turn"]
    assert abs(turned) < allowed * length**2
    for motion in energy.values():
        charge = d[4, :4] @ motion
        assert abs(charge) < 1e-7 * (np.abs(d[4, :4]) @ np.abs(motion))
    assert system.spurious_stiffness < 1e-6 * tip


@pytest.mark.parametrize(
    ("level", "variant"),
    [
        (0, {}),
        (0, {"tab_length": 1.6e-3}),
        (0, {"glue_thickness": 10e-6}),
        pytest.param(1, {"tab_length": 1.6e-3}, marks=pytest.mark.heavy),
        pytest.param(1, {"glue_thickness": 10e-6}, marks=pytest.mark.heavy),
    ],
)
def test_uncoupled_capacitor_is_exact(variant, level):
    """Without coupling the layers are two plate capacitors and nothing moves."""
    device = Device(bimorph=Bimorph(**variant))
    ceramic = ceramic_without(device, coupling=False)
    system = assemble(device, bimorph_bricks(device, LEVELS[level]), lossy=False, ceramic=ceramic)
    d = static_multiport(system).stiffness[0].real
    b = device.bimorph
    plates = 2.0 * ceramic.eps_t[2, 2] * b.width * b.length / b.piezo_thickness
    assert d[4, 4] == pytest.approx(plates, rel=1e-10)
    assert np.abs(d[4, :4]).max() == 0.0


@pytest.mark.parametrize("level", [0, pytest.param(1, marks=pytest.mark.heavy)])
def test_pure_bending_is_exact(level):
    """A homogeneous section without Poisson's effect bends under a tip moment as beams do."""
    device = Device(shim=Shim(poisson_ratio=0.0, youngs_modulus=1.0 / 15.8e-12))
    ceramic = ceramic_without(device, coupling=False, poisson=False)
    system = assemble(device, bimorph_bricks(device, LEVELS[level]), lossy=False, ceramic=ceramic)
    compliance = np.linalg.inv(static_multiport(system).stiffness[0].real[2:4, 2:4])
    b = device.bimorph
    ei = b.width * b.thickness**3 / 12.0 / 15.8e-12
    # rounding, which grows as (L/h)⁴
    assert compliance[1, 1] == pytest.approx(b.length / ei, rel=1e-7)
    assert compliance[0, 1] == pytest.approx(-(b.length**2) / (2.0 * ei), rel=1e-7)


@pytest.mark.parametrize("variant", VARIANTS[2:])
@pytest.mark.parametrize("motion", MOTIONS)
def test_negative_pivots_are_the_potentials(variant, motion):
    """Stiffness is positive, permittivity negative: as many negative pivots as potentials."""
    device = Device(bimorph=Bimorph(**variant))
    system = assemble_bricks(device, bimorph_bricks(device, COARSE), lossy=False, motion=motion)
    pivots = system.held_factor.negative_pivots
    if pivots is None:
        pytest.skip("this solver does not count pivots")
    assert pivots == (system.mass.inner.diagonal() == 0.0).sum() > 0


def test_prescribed_field_leaves_a_definite_system():
    """With the potential prescribed everywhere no unknown potential is left."""
    bricks = bimorph_bricks(Device(), COARSE)
    system = assemble_bricks(Device(), bricks, lossy=False, uniform_field=True)
    assert (system.mass.inner.diagonal() > 0.0).all()
    assert system.held_factor.negative_pivots in (0, None)


def linear_bricks(device):
    """Bricks of degree 1: scikit-fem's trilinear hexahedra on the corner mesh."""
    bricks = bimorph_bricks(device, COARSE)
    return replace(
        bricks, x=Axis(bricks.x.breaks, 1), y=Axis(bricks.y.breaks, 1), z=Axis(bricks.z.breaks, 1)
    )


def skfem_energies(device, mesh, displacement, potential):
    """Twice the elastic, coupling, electric and kinetic energy by ElementHex1, in Voigt form."""
    from skfem import Basis, ElementHex1, ElementVector

    from tactgen.fem.elements.skfem_mesh import to_skfem

    domain = to_skfem(mesh)
    energies = np.zeros(4)
    for region, material in materials(
        device, mesh.regions, device.piezo.ceramic(), lossy=False
    ).items():
        cells = domain.subdomains[region]
        vector = Basis(domain, ElementVector(ElementHex1()), intorder=4, elements=cells)
        values = np.zeros(vector.N)
        values[vector.nodal_dofs] = displacement
        u = vector.interpolate(values)
        g = u.grad
        strain = np.stack(
            [g[0, 0], g[1, 1], g[2, 2], g[1, 2] + g[2, 1], g[0, 2] + g[2, 0], g[0, 1] + g[1, 0]]
        )
        elastic = np.einsum("i...,ij,j...", strain, material.c, strain)
        kinetic = material.density * np.einsum("i...,i...", u, u)
        coupling = electric = 0.0 * elastic
        if material.piezo is not None:
            field = vector.with_element(ElementHex1()).interpolate(potential).grad
            coupling = 2.0 * np.einsum("i...,ij,j...", field, material.piezo.e, strain)
            electric = -np.einsum("i...,ij,j...", field, material.piezo.eps, field)
        parts = np.stack([elastic, coupling, electric, kinetic])
        energies += (parts * vector.dx).sum(axis=(1, 2))
    return energies


@pytest.mark.parametrize(
    ("motion", "variant"),
    [
        *((motion, VARIANTS[3]) for motion in MOTIONS),
        *(("bending_x", variant) for variant in VARIANTS[:3]),
    ],
)
def test_energies_are_those_of_the_expanded_field(variant, motion):
    """Degree 1: random unknowns, mirrored to the whole, have the energy that scikit-fem's
    trilinear elements give to the same nodal values, elastic, electric and kinetic."""
    device = Device(bimorph=Bimorph(**variant))
    bricks = linear_bricks(device)
    system = assemble_bricks(device, bricks, lossy=False, motion=motion)
    mesh = bricks.node_mesh()
    assert system.nodes == pytest.approx(mesh.points, abs=1e-15)
    rng = np.random.default_rng(5)
    y = rng.standard_normal(system.size)
    # the last three unknowns are base motion and voltage, in their own units
    y[-3:] = [1.0, 1e3, 1e9] * rng.standard_normal(3) if system.has_ports else 0.0
    *displacement, potential = (system.expand @ y).reshape(4, -1)
    *stored, kinetic = skfem_energies(device, mesh, displacement, potential)
    # rounding of sums over all entries
    assert abs(y @ (system.stiffness @ y) - sum(stored)) < 1e-12 * np.abs(stored).sum()
    assert y @ (system.mass @ y) == pytest.approx(kinetic, rel=1e-12)


@pytest.mark.parametrize("variant", VARIANTS[2:])
def test_a_hierarchy_with_all_products_is_the_polynomials_of_nodes(variant):
    """The same space, so the same ports and modes up to the rounding of both matrices."""
    device = Device(bimorph=Bimorph(**variant))
    systems = [
        assemble(device, bimorph_bricks(device, replace(COARSE, richness=of)), lossy=False)
        for of in (None, 3.0)
    ]
    assert systems[0].size == systems[1].size
    nodal, hierarchic = (static_multiport(s).stiffness[0].real for s in systems)
    size = np.sqrt(np.abs(np.outer(np.diag(nodal), np.diag(nodal))))
    assert np.abs(hierarchic - nodal).max() > 0.0
    assert (np.abs(hierarchic - nodal) < 1e-6 * size).all()
    for motion in MOTIONS:
        one, other = (
            natural_modes(s if motion == "bending_x" else s.related(motion), Ends(), 1)[0]
            for s in systems
        )
        assert one.frequency == pytest.approx(other.frequency, rel=1e-7)
        assert one.kind == other.kind
        # the shapes at all nodes of the whole body, up to the sign
        moved, again = (m.values[:, :3] / np.abs(m.values[:, :3]).max() for m in (one, other))
        assert moved == pytest.approx(np.sign((moved * again).sum()) * again, abs=1e-5)


def test_products_that_are_left_out_stiffen_little():
    """Ritz: the fewer functions, the higher the frequency; a quarter of them is worth 1e-3."""
    device = Device()
    meshing = replace(COARSE, degree=(4, 4, 4))
    found, sizes = [], []
    for richness in (3.0, 1.5, 1.25, 1.0):
        system = assemble(
            device, bimorph_bricks(device, replace(meshing, richness=richness)), lossy=False
        )
        # in torsion no voltage softens what has fewer potentials
        found.append(natural_modes(system.related("torsion"), Ends(), 1)[0].frequency)
        sizes.append(system.size)
    assert sizes == sorted(sizes, reverse=True)
    assert found == sorted(found)
    assert sizes[2] < 0.4 * sizes[0]
    assert found[2] == pytest.approx(found[0], rel=1e-3)


@pytest.mark.parametrize("variant", VARIANTS[2:])
def test_nodal_masses_are_in_proportion_to_the_diagonal(variant):
    """Of the mass over values at nodes, as it is assembled."""
    device = Device(bimorph=Bimorph(**variant))
    bricks = bimorph_bricks(device, COARSE)
    known = materials(device, bricks.regions, device.piezo.ceramic(), lossy=False)
    assembled = lumped(brick_matrices(bricks, known, 1.0)[1])
    assert nodal_mass(bricks, known) == pytest.approx(assembled, rel=1e-12)


@pytest.mark.parametrize("motion", MOTIONS)
def test_nodal_masses_add_up(motion):
    """The lumped masses of the mirrored whole are the mass of the bimorph, for every motion."""
    device = Device(bimorph=Bimorph(tab_length=1e-3))
    system = assemble_bricks(device, bimorph_bricks(device, LEVELS[0]), lossy=False, motion=motion)
    b = device.bimorph
    shim = (b.length + b.tab_length) * b.shim_thickness * device.shim.density
    ceramic = 2.0 * b.length * b.piezo_thickness * device.piezo.density
    assert system.node_mass.sum() == pytest.approx(b.width * (shim + ceramic), rel=1e-12)


@pytest.mark.heavy
def test_frequencies_are_those_of_quadratic_hexahedra():
    """The four motions together have the modes that scikit-fem's 20-node elements find on the
    whole, on meshes of which each is fine enough for 1e-3 by its own coarser one."""
    device = Device(bimorph=Bimorph(length=8e-3))
    bricks = bimorph_bricks(device, LEVELS[2])
    found = sorted(
        mode.frequency
        for motion in MOTIONS
        for mode in natural_modes(
            assemble_bricks(device, bricks, lossy=False, motion=motion), Ends(), 4
        )
    )[:4]
    fine = BrickMeshing(
        (2, 2, 2), (0.2, 0.6, 0.2), side=0.1, smallest=0.2, growth=2.0, longest=0.7,
        pieces=(10.0, 1e3),
    )  # fmt: skip
    mesh = bimorph_bricks(device, fine).corner_mesh()
    whole = natural_modes(assemble(device, mesh, lossy=False), Ends(), 4)
    assert [m.frequency for m in whole] == pytest.approx(found, rel=1e-3)


def test_no_interval_is_rounding():
    """Widths that the grading fills to the last bit leave no interval of 1e-16 over."""
    rng = np.random.default_rng(4)
    widths = [1.694e-3, *np.exp(rng.uniform(np.log(2e-4), np.log(2e-2), 300))]
    for width in widths:
        bimorph = Bimorph(width=width, piezo_thickness=0.1074e-3, shim_thickness=0.4536e-3)
        y = bimorph_bricks(Device(bimorph=bimorph), LEVELS[1]).y.breaks
        assert np.diff(y).min() > 1e-3 * width
