"""The sums of terms against matrices that are assembled for each bimorph anew."""

import numpy as np
import pytest

from tactgen.fem.bimorph.reduction.parametric.body import (
    rigid_motions,
    rigid_shapes,
    section_means,
    sections,
    tip_shapes,
    tip_weights,
)
from tactgen.fem.bimorph.reduction.parametric.expansion import expansion, with_values
from tactgen.fem.bimorph.reduction.parametric.growing import GrowingBasis
from tactgen.fem.bimorph.reduction.parametric.products import Shapes, TermProducts
from tactgen.fem.bimorph.reduction.parametric.sketch import SKETCHES, random_loads
from tactgen.fem.piezo.brick_matrices import brick_matrices
from tactgen.fem.piezo.bricks import assemble_bricks, quarter_unknowns
from tactgen.fem.piezo.system import materials, volts_per_unit
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing, bimorph_bricks
from tactgen.geometry.bimorph.stretching import stretched
from tactgen.geometry.device.parameters import Device

COARSE = BrickMeshing((2, 2, 2), smallest=0.5)
PLAIN = Device()
#: All pieces that there can be.
RICH = with_values(
    PLAIN,
    {"bimorph.tab_length": 2e-3, "bimorph.glue_thickness": 20e-6, "bimorph.bare_below": 1e-3,
     "bimorph.bare_above": 0.5e-3},
)  # fmt: skip
OTHER = {
    "bimorph.length": 17e-3, "bimorph.width": 2.6e-3, "bimorph.piezo_thickness": 0.2e-3,
    "bimorph.shim_thickness": 0.31e-3, "piezo.s11": 17e-12, "shim.youngs_modulus": 100e9,
    "piezo.density": 7000.0,
}  # fmt: skip
MORE = {"bimorph.tab_length": 3e-3, "bimorph.glue_thickness": 30e-6, "bimorph.bare_below": 0.4e-3,
        "glue.youngs_modulus": 4e9}  # fmt: skip


@pytest.fixture(params=["plain", "all pieces"])
def pair(request):
    """Undivided device, values of another member."""
    return (PLAIN, OTHER) if request.param == "plain" else (RICH, OTHER | MORE)


def family_of(device):
    bricks = bimorph_bricks(device, COARSE)
    known = materials(device, bricks.regions, device.piezo.ceramic(), lossy=False)
    unit = volts_per_unit(known)
    return TermProducts(bricks, expansion(device, bricks, unit)), known, unit


def some_shapes(shape, count=3):
    rng = np.random.default_rng(0)
    return Shapes(rng.standard_normal((3, *shape, count)), rng.standard_normal((*shape, count)))


def as_values(shapes, scale):
    """Return displacements û / g and potentials as values node by node (4 n, k)."""
    moved = shapes.moved / scale[:, None, None, None, None]
    together = np.concatenate([moved, shapes.charged[None]])
    return np.moveaxis(together, 0, 3).reshape(-1, moved.shape[-1])


@pytest.mark.parametrize("lossy", [False, True])
def test_terms_sum_up_to_the_assembled_matrices(pair, lossy):
    """Energies of arbitrary states of a member, to rounding."""
    device, values = pair
    products, _, unit = family_of(device)
    member = with_values(device, values)
    bricks = stretched(products.bricks, member.bimorph)
    known = materials(member, bricks.regions, member.piezo.ceramic(), lossy=lossy)
    stiffness, mass = brick_matrices(bricks, known, unit)
    one = {key: np.array([value]) for key, value in values.items()}
    c = products.terms.coefficients(device, one, lossy=lossy)
    shapes = some_shapes(bricks.shape)
    states = as_values(shapes, c.scale[0])
    elastic, coupling, dielectric, inertial = (
        np.tensordot(weights[0], terms(shapes, shapes), 1)
        for weights, terms in (
            (c.elastic, products.elastic), (c.coupling, products.coupling),
            (c.dielectric, products.dielectric), (c.inertial, products.inertial),
        )
    )  # fmt: skip
    summed = elastic + coupling + coupling.T + dielectric
    assembled = states.T @ (stiffness @ states)
    np.testing.assert_allclose(summed, assembled, atol=1e-12 * np.abs(assembled).max())
    np.testing.assert_allclose(inertial, states.T @ (mass @ states), rtol=1e-11)


def test_rigid_motions_and_the_tip_are_those_of_the_member(pair):
    device, values = pair
    products, _, unit = family_of(device)
    member = with_values(device, values)
    bricks = stretched(products.bricks, member.bimorph)
    c = products.terms.coefficients(member, {})
    moved = rigid_shapes(products.bricks).moved @ rigid_motions(c)[0]
    u = moved / c.scale[0][:, None, None, None, None]
    x, z = bricks.x.nodes[:, None, None], bricks.z.nodes
    np.testing.assert_allclose(u[0, ..., 0], 1.0)
    np.testing.assert_allclose(u[0, ..., 1], np.broadcast_to(-z, bricks.shape), atol=1e-15)
    np.testing.assert_allclose(u[2, ..., 1], np.broadcast_to(x, bricks.shape), atol=1e-15)
    system = assemble_bricks(member, bricks, lossy=False)
    unknowns = quarter_unknowns(bricks, "bending_x", unit)
    shapes = some_shapes(bricks.shape)
    states = as_values(shapes, c.scale[0])[unknowns.index]
    work = np.tensordot(tip_shapes(products.bricks).moved, shapes.moved, ([0, 1, 2, 3],) * 2)
    np.testing.assert_allclose(
        tip_weights(c)[0].T @ work, system.tip[:-3].T @ states, rtol=1e-10, atol=1e-12
    )


#: Motions of rigid sections at (x, y, z), by class.
RIGID_SECTIONS = {
    "bending_x": [lambda _x, _y, _z: (1, 0, 0), lambda x, _y, z: (-z, 0, x)],
    "bending_y": [lambda _x, _y, _z: (0, 1, 0), lambda _x, y, z: (0, -z, y)],
    "torsion": [lambda x, y, _: (-y, x, 0), lambda x, y, z: (-y * z, x * z, 0)],
    "axial": [lambda _x, _y, _z: (0, 0, 1), lambda _x, _y, z: (0, 0, z)],
}  # fmt: skip


@pytest.mark.parametrize("motion", RIGID_SECTIONS)
def test_motions_of_rigid_sections_have_all_their_energy_in_one_class(pair, motion):
    """Of a member: whatever is uniform across, turns or twists a section; squeezing it is not."""
    device, values = pair
    products, _, _ = family_of(device)
    member = with_values(device, values)
    bricks = stretched(products.bricks, member.bimorph)
    one = {key: np.array([value]) for key, value in values.items()}
    c = products.terms.coefficients(device, one)
    x, y, z = np.meshgrid(*(axis.nodes for axis in bricks.axes), indexing="ij")
    squeezed = [lambda x, y, z: (x**2, x * y, x * z)]
    moved = np.zeros((3, *bricks.shape, len(RIGID_SECTIONS[motion]) + 1))
    for k, field in enumerate(RIGID_SECTIONS[motion] + squeezed):
        for component, u in enumerate(field(x, y, z)):
            moved[component, ..., k] = u * c.scale[0, component]
    shapes = Shapes(moved, np.zeros((*bricks.shape, 0)))
    energy = np.diag(np.tensordot(c.inertial[0], products.inertial(shapes, shapes), 1))
    moved /= np.sqrt(energy)
    means = section_means(products.bricks, motion, moved)[None]
    *rigid, other = sections(products.bricks, motion).share(products.terms, c, means)[0]
    np.testing.assert_allclose(rigid, 1.0, rtol=1e-10)
    assert other < 0.999


def test_random_shapes_measure_a_residual():
    """The mean square is rᵀ X⁻¹ r within four standard deviations of its distribution."""
    products, known, unit = family_of(PLAIN)
    bricks = products.bricks
    system = assemble_bricks(PLAIN, bricks, lossy=False)
    basis = GrowingBasis(products, system, known, 1)
    loads = random_loads(bricks, known, unit)
    assert loads.moved.shape[-1] == loads.charged.shape[-1] == SKETCHES
    charged = quarter_unknowns(bricks, "bending_x", unit).index % 4 == 3
    for there, sign in ((~charged, 1.0), (charged, -1.0)):
        force = np.zeros((basis.unknowns, 1))
        some = np.flatnonzero(there)
        force[some[:: some.size // 50]] = 1.0
        exact = sign * (force * system.held_factor.solve(force)).sum()
        assert basis.measured(force) == pytest.approx(exact, rel=4.0 * np.sqrt(2.0 / SKETCHES))
