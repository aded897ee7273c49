"""Ten-node tetrahedra by scikit-fem: exact facts, a manufactured solution, quarter and whole.

On a structured mesh and on fTetWild's mesh of the CAD solids.
"""

from dataclasses import replace

import numpy as np
import pytest
from port_distance import distance

from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import materials, volts_per_unit
from tactgen.fem.piezo.tetrahedra import SkfemBody
from tactgen.fem.piezo.tetrahedra_error import goal_errors
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.tets import TetMeshing, tetrahedralise
from tactgen.geometry.device.parameters import Bimorph, Device, Shim
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, mirror_axes, whole_mesh
from tactgen.geometry.meshing.tetwild.conform import TET_FACES
from tactgen.validation.evidence.cases.manufactured import cells_space, ceramic, manufactured_errors

SHORT = Device(bimorph=Bimorph(length=6e-3))
#: A homogeneous section: shim and ceramic of one modulus.
ALIKE = SHORT.model_copy(update={"shim": Shim(poisson_ratio=0.0, youngs_modulus=1.0 / 15.8e-12)})
MOTIONS = ("bending_x", "bending_y", "torsion", "axial")


def structured_quarter(device, divisions=6):
    """A quarter of the bimorph in tetrahedra of six to a box."""
    b = device.bimorph
    half, outer = b.shim_thickness / 2, b.thickness / 2
    planes = (
        np.array([0.0, half, outer]),
        np.linspace(0.0, b.width / 2, 3),
        np.linspace(0.0, b.length, divisions + 1),
    )
    region = np.broadcast_to(np.array([1, 0])[:, None, None], (2, 2, divisions))
    mesh = box_tetrahedra(*planes, region, ("piezo_top", "shim"))
    every = np.unique(np.sort(mesh.cells[:, TET_FACES].reshape(-1, 3), axis=1), axis=0)
    inner = every[(np.abs(mesh.points[every, 0] - half) < 1e-9).all(axis=1)]
    faces = {
        "base": mesh.faces["z_low"],
        "tip": mesh.faces["z_high"],
        "electrode_top_outer": mesh.faces["x_high"],
        "electrode_top_inner": inner,
        "mirror_x": mesh.faces["x_low"],
        "mirror_y": mesh.faces["y_low"],
    }
    return replace(mesh, faces=faces)


@pytest.fixture(scope="module")
def tetwild(tmp_path_factory):
    """A quarter of the CAD solids by fTetWild, meshed anew."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("meshes")))
        return tetrahedralise(
            SHORT, "alone", options=TetMeshing(edge_length=0.4e-3, mirrors=(0, 1))
        )


@pytest.fixture(params=["structured", "tetwild"])
def mesh(request):
    if request.param == "structured":
        return structured_quarter(SHORT)
    return request.getfixturevalue("tetwild")


#: The whole has four times the cells: of fTetWild's it is heavy.
few_and_many = pytest.mark.parametrize(
    "mesh", ["structured", pytest.param("tetwild", marks=pytest.mark.heavy)], indirect=True
)


def body_of(device, mesh):
    """Unheld body with its materials and the size of the potential's unit."""
    known = materials(device, mesh.regions, device.piezo.ceramic(), lossy=False)
    unit = volts_per_unit(known)
    return SkfemBody(mesh, known, unit), known, unit


def ceramic_without(device, *, coupling=True, poisson=True):
    ceramic = device.piezo.ceramic()
    d = ceramic.d if coupling else np.zeros((3, 6))
    s = ceramic.s if poisson else np.diag(np.diag(ceramic.s))
    return replace(ceramic, d=d, s=s)


def all_ceramic(mesh):
    """The same cells, all of one piezoelectric material."""
    return replace(mesh, region_of_cell=np.zeros(len(mesh.cells), dtype=int), regions=("piezo",))


def test_quarter_of_the_cad_solids_is_exact(tetwild):
    """Volumes to rounding, cuts in their planes, and nothing of the layer on the other side."""
    b = SHORT.bimorph
    whole = whole_mesh(tetwild)
    assert tetwild.points[:, :2].min() > -1e-12
    assert set(tetwild.regions) == {"piezo_top", "shim"}
    for axis, name in enumerate(("mirror_x", "mirror_y")):
        assert np.abs(tetwild.points[tetwild.faces[name], axis]).max() < 1e-12
    corners = whole.points[whole.cells]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    layer = b.length * b.width * b.piezo_thickness
    for name in ("piezo_top", "piezo_bottom"):
        assert volumes[whole.cells_of(name)].sum() == pytest.approx(layer, rel=1e-9)


def test_constant_strain_and_field_are_exact(mesh):
    """Patch test: linear displacement and potential need no force inside, and have the energy
    of constant strain and field, coupling included."""
    body, known, unit = body_of(SHORT, all_ceramic(mesh))
    stiffness, _ = body.matrices
    gradient = np.random.default_rng(7).standard_normal((4, 3))
    y = body.basis.doflocs.T @ gradient.T
    force = (stiffness @ y.ravel()).reshape(-1, 4)
    inside = np.ones(len(y), dtype=bool)
    inside[body.basis.get_dofs().flatten()] = False
    assert np.count_nonzero(inside) > 5
    # rounding of sums over some twenty elements
    assert np.abs(force[inside]).max() < 1e-11 * np.abs(force[~inside]).max()
    b = SHORT.bimorph
    volume = b.length * b.width * b.thickness
    density = np.einsum("pa,paqb,qb", gradient, known["piezo"].flux_tensor(unit), gradient)
    assert y.ravel() @ (stiffness @ y.ravel()) == pytest.approx(density * volume, rel=1e-11)


def test_pure_bending_is_exact(mesh):
    """A homogeneous section without Poisson's effect bends under a tip moment as beams do."""
    ceramic = ceramic_without(ALIKE, coupling=False, poisson=False)
    system = assemble(ALIKE, mesh, lossy=False, ceramic=ceramic)
    compliance = np.linalg.inv(static_multiport(system).stiffness[0].real[2:4, 2:4])
    b = ALIKE.bimorph
    ei = b.width * b.thickness**3 / 12.0 / 15.8e-12
    # rounding, which grows as (L/h)⁴
    assert compliance[1, 1] == pytest.approx(b.length / ei, rel=1e-8)
    assert compliance[0, 1] == pytest.approx(-(b.length**2) / (2.0 * ei), rel=1e-8)


def test_a_tip_that_is_not_in_the_middle_turns_about_its_own():
    """Half of the layers as a body of its own: moved along z it does not turn, by u_z = x by 1."""
    mesh = structured_quarter(SHORT)
    mesh = replace(mesh, faces={n: of for n, of in mesh.faces.items() if n != "mirror_x"})
    known = materials(SHORT, mesh.regions, SHORT.piezo.ceramic(), lossy=False)
    body = SkfemBody(mesh, known, volts_per_unit(known))
    rotation = body._tip_functionals().reshape(-1, 4, 2)[:, 2, 1]
    assert abs(rotation.sum()) < 1e-12 * np.abs(rotation).sum()
    assert rotation @ body.basis.doflocs[0] == pytest.approx(1.0, rel=1e-12)


def test_uncoupled_capacitor_is_exact(mesh):
    """Without coupling the layers are two plate capacitors and nothing moves."""
    ceramic = ceramic_without(SHORT, coupling=False)
    d = static_multiport(assemble(SHORT, mesh, lossy=False, ceramic=ceramic)).stiffness[0].real
    b = SHORT.bimorph
    plates = 2.0 * ceramic.eps_t[2, 2] * b.width * b.length / b.piezo_thickness
    assert d[4, 4] == pytest.approx(plates, rel=1e-10)
    assert np.abs(d[4, :4]).max() == 0.0


def assert_one_body(device, mesh, motions):
    """Ports, goals, estimates and all modes of a part are those of the whole, mirrored.

    Of the estimates also the shares of cells in the one that stands for them.
    """
    both = mesh, whole_mesh(mesh)
    part, whole = (assemble(device, m, lossy=False) for m in both)
    assert part.node_mass.sum() == pytest.approx(whole.node_mass.sum(), rel=1e-12)
    assert (set(part.others), whole.others) == (set(motions) - {"bending_x"}, ())
    first, second = (static_multiport(s).stiffness for s in (part, whole))
    # seven digits are lost to the condition of the whole
    assert distance(first.real, second.real) < 1e-8
    found = sorted(
        (mode.frequency, mode.kind)
        for motion in motions
        for mode in natural_modes(part.related(motion), Ends(), 6)
    )[:6]
    modes = natural_modes(whole, Ends(), 6)
    assert [f for f, _ in found] == pytest.approx([m.frequency for m in modes], rel=1e-7)
    goals, all_of_it = (goal_errors(device, m, s) for m, s in zip(both, (part, whole), strict=True))
    for name, goal in goals.items():
        assert goal.value == pytest.approx(all_of_it[name].value, rel=1e-7), name
        assert goal.error == pytest.approx(all_of_it[name].error, rel=1e-5), name
        shares = all_of_it[name].shares.reshape(-1, goal.shares.size).sum(axis=0)
        assert goal.shares == pytest.approx(shares, abs=1e-6 * shares.max()), name
    return [kind for _, kind in found], [mode.kind for mode in modes]


@few_and_many
def test_quarter_and_whole_are_one_body(mesh):
    found, kinds = assert_one_body(SHORT, mesh, MOTIONS)
    assert found == kinds


def test_half_and_whole_are_one_body_of_unequal_layers():
    """Of half a body bending takes axial motion and torsion along."""
    device = Device(bimorph=Bimorph(length=6e-3, layers="brass 0.3 mm; PZT-5A 0.26 mm +x"))
    x = 1e-3 * np.array([-0.28, 0.02, 0.28])
    z, y = np.linspace(0.0, 6e-3, 7), np.linspace(0.0, 0.5 * device.bimorph.width, 3)
    regions = np.broadcast_to(np.array([0, 1])[:, None, None], (2, 2, 6))
    box = box_tetrahedra(x, y, z, regions, ("shim_1", "piezo_2"))
    inner = box.faces["x_low"] + y.size * z.size  # the next plane along x
    half = replace(box, faces={
        "base": box.faces["z_low"], "tip": box.faces["z_high"], "mirror_y": box.faces["y_low"],
        "electrode_piezo_2_upper_outer": box.faces["x_high"],
        "electrode_piezo_2_lower_inner": inner,
    })  # fmt: skip
    assert len(whole_mesh(half).cells) == 2 * len(half.cells)
    assert mirror_axes(half) == (1,)
    assert_one_body(device, half, ("bending_x", "bending_y"))


def test_manufactured_solution_on_the_mesh_of_cad(tetwild):
    """fTetWild's cells are within a factor two of what cells of their edges give: k h = 0.8."""
    material = ceramic(lossy=False)
    space, unit = cells_space(all_ceramic(tetwild), material)
    gradient, value = manufactured_errors(space, material, unit, 0.0)
    assert gradient < 2.0 * 0.8**2 / 12.0
    assert value < 2.0 * 0.8**3 / 60.0
