"""Tetrahedral meshes: exact regions and faces, honest failure, cache and files."""

import resource
from dataclasses import fields, replace

import meshio
import numpy as np
import pytest

from tactgen.geometry.bimorph import tets
from tactgen.geometry.bimorph.bricks import bimorph_bricks
from tactgen.geometry.bimorph.tets import TetMeshing, squeezed, tetrahedralise
from tactgen.geometry.device.parameters import Bimorph, Device, Shim
from tactgen.geometry.device.parts import closed_form_volumes, layout
from tactgen.geometry.errors import InputError, MeshError
from tactgen.geometry.meshing.mesh import (
    Mesh,
    jacobian_coefficients,
    smallest_dihedral_angles,
    tet_volumes,
    triangle_areas,
)
from tactgen.geometry.meshing.mesh_files import write_mesh
from tactgen.geometry.meshing.tetwild import mesher as ftetwild
from tactgen.geometry.meshing.tetwild.conform import TET_FACES
from tactgen.geometry.meshing.tetwild.mesher import Mesher

GENERATOR = Device(bimorph=Bimorph(tab_length=0.4e-3))
#: Finer at the root.
GRADED = TetMeshing(edge_length=0.8e-3, root_edge_length=0.2e-3, grading=0.3)
#: The rod's lower end (m): 0.5 mm of head, 0.2 mm of gap and 4.7 mm from there.
BOTTOM = -5.4e-3
ON_ROD = ("piezo_top", "piezo_bottom", "shim", "glue", "rod")


@pytest.fixture(autouse=True, scope="module")
def _own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("meshes")))
        yield


@pytest.fixture(scope="module")
def mesher():
    """One process for all meshes: to start it takes longer than most of them."""
    with Mesher() as process:
        yield process


@pytest.fixture(scope="module")
def bimorph(mesher):
    return tetrahedralise(Device(), "alone", options=GRADED, mesher=mesher)


@pytest.fixture(scope="module")
def coil(mesher):
    return tetrahedralise(GENERATOR, "rod", ("coil",), mesher=mesher)


@pytest.fixture(scope="module")
def bricks(few_bricks):
    return bimorph_bricks(Device(), few_bricks[0]).corner_mesh()


def test_tapers_are_cut_as_they_are_stated(mesher):
    """A quarter of three tapered layers: volumes, sloping electrodes, both ends."""
    tapers = {
        "width_profile": ((0.0, 2e-3), (3e-3, 1e-3), (6e-3, 1e-3)),
        "shim_thickness_profile": ((0.0, 0.3e-3), (6e-3, 0.1e-3)),
        "piezo_thickness_profile": ((0.0, 0.3e-3), (6e-3, 0.2e-3)),
    }
    device = Device(bimorph=Bimorph(length=6e-3, **tapers))
    options = TetMeshing(edge_length=0.5e-3, mirrors=(0, 1))
    mesh = tetrahedralise(device, "alone", options=options, mesher=mesher)
    volumes, wanted = region_volumes(mesh), closed_form_volumes(device, "alone")
    assert 2.0 * volumes["piezo_top"] == pytest.approx(wanted["piezo_top"], rel=1e-9)
    assert 4.0 * volumes["shim"] == pytest.approx(wanted["shim"], rel=1e-9)
    plan = 0.5 * 3e-3 * (2e-3 + 1e-3) + 3e-3 * 1e-3
    for face, rise in (("electrode_top_inner", 0.1e-3), ("electrode_top_outer", 0.2e-3)):
        slope = np.hypot(1.0, rise / 6e-3)
        assert 2.0 * area(mesh, face) == pytest.approx(plan * slope, rel=1e-9), face
    assert 4.0 * area(mesh, "base") == pytest.approx(2e-3 * 0.9e-3, rel=1e-9)
    assert 4.0 * area(mesh, "tip") == pytest.approx(1e-3 * 0.5e-3, rel=1e-9)


def cell_volumes(mesh):
    if mesh.kind == "tetra":
        return tet_volumes(mesh.points[mesh.cells])
    return jacobian_coefficients(mesh.points[mesh.cells]).mean(axis=1) / 6.0


def region_volumes(mesh):
    sums = np.bincount(mesh.region_of_cell, cell_volumes(mesh), minlength=len(mesh.regions))
    return dict(zip(mesh.regions, sums, strict=True))


def area(mesh, face):
    a, b, c = np.moveaxis(mesh.points[mesh.faces[face]], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0


def assert_conforming(mesh):
    """Every face belongs to one or two cells, and every point to some cell."""
    triangles = np.sort(mesh.cells[:, TET_FACES].reshape(-1, 3), axis=1)
    _, count = np.unique(triangles, axis=0, return_counts=True)
    assert set(count) == {1, 2}
    assert len(np.unique(mesh.cells)) == len(mesh.points)


def assert_same(first, second):
    for field in fields(Mesh):
        a, b = getattr(first, field.name), getattr(second, field.name)
        if isinstance(a, dict):
            assert list(a) == list(b)
            assert all(np.array_equal(a[name], b[name]) for name in a)
        else:
            assert np.array_equal(a, b), field.name


def test_bimorph_volumes_and_areas_are_exact(bimorph):
    assert bimorph.kind == "tetra"
    expected = closed_form_volumes(Device(), "alone")
    assert region_volumes(bimorph) == pytest.approx(expected, rel=1e-9)
    b = Device().bimorph
    for side in ("top", "bottom"):
        for face in ("inner", "outer"):
            name = f"electrode_{side}_{face}"
            assert area(bimorph, name) == pytest.approx(b.length * b.width, rel=1e-9), name
    for name in ("tip", "base"):
        assert area(bimorph, name) == pytest.approx(b.thickness * b.width, rel=1e-9), name


def test_listed_layers_are_boxes_of_their_own(mesher):
    """Also of another width and place, and where they go on; half of them is meshed."""
    layers = "brass 1.2 mm; glue 0.9 mm; PZT-5A 1 mm wide 3 mm from 1 mm to 5 mm -x"
    bimorph = Bimorph(length=6e-3, width=4e-3, tab_length=1e-3, tip_extension=2e-3, layers=layers)
    device = Device(bimorph=bimorph)
    expected = closed_form_volumes(device, "alone")
    assert list(expected) == ["shim_1", "glue_2", "piezo_3"]
    assert expected["shim_1"] == pytest.approx(1.2e-3 * 4e-3 * 9e-3)
    assert expected["piezo_3"] == pytest.approx(1e-3 * 3e-3 * 4e-3)
    options = TetMeshing(edge_length=2e-3, mirrors=(1,))
    half = tetrahedralise(device, "alone", options=options, mesher=mesher)
    halves = {name: 0.5 * volume for name, volume in expected.items()}
    assert region_volumes(half) == pytest.approx(halves, rel=1e-9)
    electrodes = {n for n in half.faces if n.startswith("electrode")}
    assert electrodes == {"electrode_piezo_3_upper_outer", "electrode_piezo_3_lower_inner"}
    for name in electrodes:
        assert area(half, name) == pytest.approx(0.5 * 3e-3 * 4e-3, rel=1e-9)
    for name in ("tip", "base"):
        assert area(half, name) == pytest.approx(0.5 * 1.2e-3 * 4e-3, rel=1e-9)


def test_bimorph_is_conforming_and_well_shaped(bimorph):
    assert_conforming(bimorph)
    assert cell_volumes(bimorph).min() > 0.0
    # the mesher promises shapes where it works, in the space squeezed along the bimorph
    shown = squeezed(Device(), "alone", bimorph.points)
    assert smallest_dihedral_angles(shown[bimorph.cells]).min() > 3.0


def test_named_faces_lie_on_their_planes_to_the_picometre(bimorph):
    """Electrodes are seen from outside the ceramic; inner ones are faces of ceramic and shim."""
    planes = {
        "electrode_top_outer": (0, 0.385e-3, 1),
        "electrode_top_inner": (0, 0.125e-3, -1),
        "electrode_bottom_inner": (0, -0.125e-3, 1),
        "electrode_bottom_outer": (0, -0.385e-3, -1),
        "base": (2, 0.0, 0),
        "tip": (2, 20e-3, 0),
    }
    assert set(bimorph.faces) == set(planes)
    for name, (axis, offset, seen_along) in planes.items():
        corners = bimorph.points[bimorph.faces[name]]
        assert np.abs(corners[..., axis] - offset).max() <= 1e-12, name
        a, b, c = np.moveaxis(corners, 1, 0)
        assert not seen_along or (seen_along * np.cross(b - a, c - a)[:, 0] > 0.0).all(), name
    for region in ("piezo_top", "shim"):
        cells = bimorph.cells[bimorph.cells_of(region)]
        own = {tuple(t) for t in np.sort(cells[:, TET_FACES].reshape(-1, 3), axis=1)}
        electrode = np.sort(bimorph.faces["electrode_top_inner"], axis=1)
        assert own.issuperset(map(tuple, electrode)), region


def test_graded_mesh_is_finer_at_the_root(bimorph):
    height = bimorph.points[bimorph.cells].mean(axis=1)[:, 2]
    size = np.cbrt(cell_volumes(bimorph))
    assert np.median(size[height < 0.5e-3]) < 0.5 * np.median(size[height > 10e-3])


def test_coil_is_curved_and_its_middle_nodes_lie_on_the_cylinders(coil):
    assert coil.kind == "tetra10"
    expected = closed_form_volumes(GENERATOR)["coil"]
    assert region_volumes(coil)["coil"] == pytest.approx(expected, rel=1e-4)
    assert jacobian_coefficients(coil.points[coil.cells]).min() > 0.0
    radius = np.hypot(coil.points[:, 0], coil.points[:, 1])
    vertices = np.zeros(len(coil.points), dtype=bool)
    vertices[coil.cells[:, :4]] = True
    for r in (GENERATOR.coil.inner_radius, GENERATOR.coil.outer_radius):
        on = np.abs(radius - r) < 1e-12
        assert (on & vertices).any()
        assert (on & ~vertices).any()


@pytest.mark.heavy
def test_straight_elements_on_request_lose_only_what_lies_beyond_the_chords(coil):
    straight = tetrahedralise(GENERATOR, "rod", ("coil",), TetMeshing(curved=False))
    assert straight.kind == "tetra"
    assert straight.cells.shape[1] == 4
    volume = closed_form_volumes(GENERATOR)["coil"]
    assert region_volumes(straight)["coil"] == pytest.approx(volume, rel=0.05)


@pytest.mark.heavy
@pytest.mark.parametrize("root", [None, 0.1e-3], ids=str)
def test_bimorph_on_rod_meshes(root):
    """What the model cad solves on; coil and sleeve have meshes of their own."""
    options = TetMeshing(edge_length=0.3e-3, root_edge_length=root)
    mesh = tetrahedralise(GENERATOR, "rod", ON_ROD, options)
    expected = closed_form_volumes(GENERATOR)
    assert_conforming(mesh)
    for region, volume in region_volumes(mesh).items():
        curved = region == "rod"
        assert volume == pytest.approx(expected[region], rel=1e-5 if curved else 1e-9), region
    b, rod = GENERATOR.bimorph, GENERATOR.rod
    assert area(mesh, "electrode_top_outer") == pytest.approx(b.length * b.width, rel=1e-9)
    assert area(mesh, "tip") == pytest.approx(b.thickness * b.width, rel=1e-9)
    # straight triangles fall short of the flange's circle
    assert area(mesh, "base") == pytest.approx(np.pi * rod.flange_radius**2, rel=0.02)
    assert np.abs(mesh.points[mesh.faces["base"], 2] - BOTTOM).max() <= 1e-12
    assert jacobian_coefficients(mesh.points[mesh.cells]).min() > 0.0
    shown = squeezed(GENERATOR, "rod", mesh.points)
    assert smallest_dihedral_angles(shown[mesh.cells[:, :4]]).min() > 3.0


@pytest.mark.heavy
def test_time_limit_is_kept_and_explained():
    words = r"within 0\.5 s of processor time; raise the time limit"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with pytest.raises(MeshError, match=words):
        tetrahedralise(Device(), "alone", options=TetMeshing(edge_length=0.1e-3, time_limit=0.5))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # five attempts, each with its libraries to load and its limit rounded up to whole seconds
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 15.0


def test_mesher_that_crashes_is_explained(monkeypatch):
    monkeypatch.setattr(ftetwild, "_WORKER", "-c import os; os.abort()")
    with pytest.raises(MeshError, match="fTetWild failed"):
        tetrahedralise(Device(), "alone", options=TetMeshing(edge_length=0.45e-3))


@pytest.mark.parametrize("failures", [3, 5])
def test_mesh_that_fails_its_checks_is_tried_otherwise(failures, bimorph, monkeypatch):
    """First closer to the surface, then with smaller elements too; the fifth refusal stands."""
    tried = []

    def recorded(*_, edge_length, envelope, sizing, **__):
        tried.append((envelope, edge_length, sizing.lengths.min()))
        return np.zeros((0, 3)), np.zeros((0, 4), dtype=int)

    def checked(*_):
        if len(tried) <= failures:
            raise MeshError(f"no good: {len(tried)}")
        return bimorph

    monkeypatch.setattr(tets, "run_ftetwild", recorded)
    monkeypatch.setattr(tets, "conform", checked)
    options = replace(GRADED, edge_length=0.5e-3 + failures * 1e-6)  # none that is kept
    if failures == 5:
        with pytest.raises(MeshError, match="no good: 5"):
            tetrahedralise(Device(), "alone", options=options)
    else:
        assert_same(tetrahedralise(Device(), "alone", options=options), bimorph)
    envelope, edge_length, sizes = (np.array(tried) / tried[0]).T
    assert envelope.size == min(failures + 1, 5)
    assert np.all(np.diff(envelope[:3]) < 0.0)
    assert np.all(envelope[1:] < 1.0)
    assert edge_length[:3] == pytest.approx(1.0)
    assert np.all(np.diff(edge_length[2:]) < 0.0)
    assert sizes == pytest.approx(edge_length)


def test_options_out_of_range_are_explained():
    with pytest.raises(InputError, match="time_limit = -1 must be a positive number"):
        TetMeshing(time_limit=-1.0)
    with pytest.raises(InputError, match="root_edge_length = 1 mm must be positive and at most"):
        TetMeshing(root_edge_length=1e-3)


def test_cache_returns_the_identical_mesh(bimorph, monkeypatch):
    monkeypatch.setattr(ftetwild, "_WORKER", "no mesher here")
    again = tetrahedralise(Device(), "alone", options=GRADED)
    assert_same(bimorph, again)
    # a material does not enter the mesh, a time limit does not either
    softer = Device(shim=Shim(youngs_modulus=100e9))
    patient = replace(GRADED, time_limit=1000.0)
    assert_same(bimorph, tetrahedralise(softer, "alone", options=patient))


def assert_written(path, mesh):
    """Points, and under each name of a region or a face its cells in their order, and no other."""
    file = meshio.read(path)
    assert np.array_equal(file.points, mesh.points)

    def named(name, dimension):
        if file.field_data:  # of Gmsh: numbers of physical groups, and their dimensions
            marks = file.cell_data["gmsh:physical"]
            mark, found = file.field_data[name]
            assert found == dimension
        else:
            marks, mark = file.cell_data[f"{'region' if dimension == 3 else 'face'} {name}"], 1
        chosen = [b.data[m == mark] for b, m in zip(file.cells, marks, strict=True)]
        return np.concatenate([cells for cells in chosen if len(cells)])

    assert file.cells[0].type == mesh.kind
    for region in mesh.regions:
        assert np.array_equal(named(region, 3), mesh.cells[mesh.cells_of(region)]), region
    for name, corners in mesh.faces.items():
        assert np.array_equal(named(name, 2), corners), name
    sizes = [len(mesh.cells), *map(len, mesh.faces.values())]
    assert sum(len(block.data) for block in file.cells) == sum(sizes)
    if path.suffix == ".vtu":
        assert np.array_equal(file.cell_data["region"][0], mesh.region_of_cell)


@pytest.mark.parametrize("suffix", [".vtu", ".msh"])
@pytest.mark.parametrize("which", ["bimorph", "coil", "bricks"])
def test_files_hold_the_mesh(which, suffix, request, tmp_path, capfd):
    mesh = request.getfixturevalue(which)
    path = tmp_path / f"mesh{suffix}"
    fields = {"mode 1": np.sin(mesh.points + 1.0), "potential": np.arange(len(mesh.points)) * 1.0}
    write_mesh(mesh, path, point_data=fields)
    assert capfd.readouterr().out == ""
    assert_written(path, mesh)
    found = meshio.read(path).point_data
    assert {of: values.tolist() for of, values in found.items()} == {
        of: values.tolist() for of, values in fields.items()
    }


def test_a_file_of_another_kind_is_refused(bimorph, tmp_path):
    with pytest.raises(InputError, match=r"does not end in \.vtu or \.msh"):
        write_mesh(bimorph, tmp_path / "mesh.stl")


def test_curved_triangles_have_the_area_of_the_cylinder():
    angles, heights = np.meshgrid(np.linspace(0, 0.3, 3), [0.0, 0.2, 0.4], indexing="ij")
    p = np.stack([np.cos(angles), np.sin(angles), heights], axis=-1)
    first = [p[0, 0], p[2, 0], p[2, 2], p[1, 0], p[2, 1], p[1, 1]]
    second = [p[0, 0], p[2, 2], p[0, 2], p[1, 1], p[1, 2], p[0, 1]]
    assert triangle_areas(np.array([first, second])).sum() == pytest.approx(0.12, rel=1e-4)


def test_the_base_of_what_stands_on_the_rod_is_the_rods_lower_end():
    faces = tets._named_faces(GENERATOR, "rod", layout(GENERATOR, "rod", ON_ROD))
    assert faces["base"].planes[0].offset == pytest.approx(1e3 * BOTTOM, rel=1e-12)
    assert faces["base"].regions == ("rod",)
