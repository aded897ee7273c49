"""The row of pieces of bimorphs that are not uniform, who refuses them, and its solid shape."""

import itertools

import numpy as np
import pytest

from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.geometry.bimorph.segments import CentreLine, beam_pieces, row_shape
from tactgen.geometry.device.bimorph import Dimensions
from tactgen.geometry.device.checks import check_fit
from tactgen.geometry.device.parameters import Bimorph, Device, Support
from tactgen.geometry.device.parts import layout
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.validation.engine.solve import make_plan
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.warnings import scene_warnings

STEP = ((0.0, 2.1e-3), (8e-3, 2.1e-3), (8e-3, 1e-3), (20e-3, 1e-3))
TAPER = ((0.0, 0.26e-3), (20e-3, 0.13e-3))
ODD = "width_profile=0 mm: 2.1 mm, 20 mm: 1 mm"


def ceramic(**keys):
    return beam_pieces(Device(bimorph=Bimorph(**keys)), Support())


def test_cuts_at_steps_and_electrode_edges():
    """Pieces end at every point of a profile and where an electrode begins or ends; an electrode's
    edge at a step leaves no sliver between them."""
    row = ceramic(width_profile=STEP, bare_below=2e-3, bare_above=5e-3)
    assert [p.length for p in row] == pytest.approx([2e-3, 6e-3, 7e-3, 5e-3])
    assert [p.electrode for p in row] == [False, True, True, False]
    assert [p.ends[0].width for p in row] == [2.1e-3, 2.1e-3, 1e-3, 1e-3]
    assert not any(p.tapered for p in row)
    assert len(ceramic(width_profile=STEP, bare_above=20e-3 - 8e-3 * (1.0 + 1e-15))) == 2


def test_tapers_meet_at_their_ends():
    """A taper cut in two by a step of another dimension is continuous."""
    low, high = ceramic(width_profile=STEP, piezo_thickness_profile=TAPER)
    assert low.tapered
    assert low.ends[1].piezo_thickness == pytest.approx(high.ends[0].piezo_thickness, rel=1e-15)
    assert low.layers(Bimorph(), 0.5).piezo_thickness == pytest.approx(0.234e-3)
    assert low.layers(Bimorph(), 0.5).shim_thickness == 0.25e-3


def test_the_tab_keeps_the_constants():
    """The profile is the ceramic's; the tab below it has the plain width and thickness."""
    device = Device(bimorph=Bimorph(tab_length=2e-3, width_profile=STEP))
    tab = beam_pieces(device, Support())[0]
    assert tab.layers(device.bimorph) == Dimensions(2.1e-3, 0.26e-3, 0.25e-3)


@pytest.mark.parametrize(
    ("bimorph", "words"),
    [
        (Bimorph(bare_below=12e-3, bare_above=8e-3), ("no electrode", "make them shorter")),
        (
            Bimorph(shim_thickness_profile=((0.0, 1e-4), (19e-3, 1e-4))),
            ("bimorph.shim_thickness_profile ends at 19 mm", "20 mm"),
        ),
    ],
)
def test_ceramic_that_does_not_fit_is_refused(bimorph, words):
    """One sentence with key, values and remedy."""
    with pytest.raises(InputError) as caught:
        check_fit(Device(bimorph=bimorph), Support())
    assert all(word in str(caught.value) for word in words), caught.value


# parts and tetrahedra know tapers, but none with listed layers, and no step of a thickness
@pytest.mark.parametrize(
    "settings",
    [
        (ODD, "layers=brass 0.2 mm; PZT-5A 0.26 mm +x"),
        ("shim_thickness_profile=0 mm: 0.2 mm, 10 mm: 0.2 mm, 10 mm: 0.1 mm, 20 mm: 0.1 mm",),
        ("bare_below=1 mm",),
        ("glue_thickness=10 um",),
    ],
)
def test_cad_and_tetrahedra_do_not_know_them(settings):
    """Plan and CAD refuse before any work, naming the key and the models that can."""
    words = f"bimorph.{settings[0].split('=')[0]} .* models=lumped,tmm,beam"
    scene, _ = load_scene("j1", [f"bimorph.{each}" for each in settings])
    with pytest.raises(InputError, match=words):
        make_plan(scene, ("tmm", "cad"), ("capacitance_free",))
    with pytest.raises(InputError, match=words):
        layout(scene.device, "alone")
    assert make_plan(scene, ("lumped", "tmm", "beam"), ("capacitance_free",)).run


def test_bricks_know_what_keeps_the_section_constant():
    """Bare ends and glue layers are in the bricks; profiles are refused, in plan and mesh."""
    scene, _ = load_scene("paper", ["bimorph.bare_above=1 mm", "bimorph.glue_thickness=10 um"])
    make_plan(scene, ("tmm", "solid"), ("capacitance_free",))
    assert bimorph_bricks(scene.device, LEVELS[0]).slabs
    scene, _ = load_scene("paper", [f"bimorph.{ODD}"])
    with pytest.raises(InputError, match=r"bimorph.width_profile .* models=lumped,tmm,beam"):
        make_plan(scene, ("tmm", "solid"), ("capacitance_free",))
    with pytest.raises(InputError, match=r"bimorph\.width_profile "):
        bimorph_bricks(scene.device, LEVELS[0])


def test_a_constant_that_a_profile_replaces_is_said_to_be_idle():
    """Setting both warns, unless the tab still takes the constant; that nobody stated it, too."""
    both = [f"bimorph.{ODD}", "bimorph.width=2 mm"]
    assert (
        "has no effect with bimorph.width_profile" in scene_warnings(*load_scene("paper", both))[0]
    )
    for bare in ("tab_length", "tip_extension"):
        assert not scene_warnings(*load_scene("paper", [*both, f"bimorph.{bare}=1 mm"]))
        (found,) = scene_warnings(*load_scene("j1", [both[0], f"bimorph.{bare}=1 mm"]))
        assert found.startswith(f"bimorph.width = 2.1 mm is that of the bare shim (bimorph.{bare})")


def test_glue_between_layers_is_not_idle():
    """Glue constants count with a glue layer, also without the rod."""
    settings = ["bimorph.glue_thickness=10 um", "glue.youngs_modulus=2 GPa"]
    assert not scene_warnings(*load_scene("paper", settings))
    assert scene_warnings(*load_scene("paper", settings[1:]))


GLUED = Device(bimorph=Bimorph(glue_thickness=10e-6, bare_above=1e-3))
TOP = GLUED.bimorph.length


@pytest.fixture(scope="module")
def shape_and_line():
    """The row on its rod, two stations at each joint, and some motion of its centre line."""
    pieces = beam_pieces(GLUED, Support(kind="rod"))
    ends = np.cumsum([0.0, *(p.length for p in pieces if p.section != "bond")])
    z = np.concatenate([np.linspace(a, b, 3) for a, b in itertools.pairwise(ends)])
    line = CentreLine(z, 1e-6 * np.cos(300.0 * z), 1e-3 * np.sin(200.0 * z), 0.0, 3.0, 0.0)
    return row_shape(pieces, GLUED, z, TOP), line, pieces


def volumes(mesh):
    """Return the volume of each hexahedron, cut as a box is cut into six tetrahedra."""
    two = np.array([0.0, 1.0])
    box = box_tetrahedra(two, two, two, np.zeros((1, 1, 1), dtype=int), ("",))
    place = {(0, 0, 0): 0, (1, 0, 0): 1, (1, 1, 0): 2, (0, 1, 0): 3}
    place |= {(x, y, 1): corner + 4 for (x, y, _), corner in place.items()}
    corner = np.array([place[tuple(p.astype(int))] for p in box.points])
    tets = mesh.points[mesh.cells[:, corner[box.cells]]]
    return np.linalg.det(tets[:, :, 1:] - tets[:, :, :1]).sum(axis=1) / 6.0


def test_every_region_has_its_volume(shape_and_line):
    """Layers to rounding; the rod as a prism on its rim, 1 % less than the cylinders."""
    shape, _, pieces = shape_and_line
    found = np.bincount(shape.mesh.region_of_cell, volumes(shape.mesh))
    found = dict(zip(shape.mesh.regions, found, strict=True))
    b = GLUED.bimorph
    length = {
        name: sum(p.length for p in pieces if p.section == name) for name in ("bimorph", "shim")
    }
    ceramic = b.width * b.piezo_thickness * length["bimorph"]
    assert found["piezo_top"] == pytest.approx(ceramic, rel=1e-9)
    assert found["piezo_bottom"] == pytest.approx(ceramic, rel=1e-9)
    assert found["glue"] == pytest.approx(2.0 * b.width * 10e-6 * length["bimorph"], rel=1e-9)
    assert found["shim"] == pytest.approx(
        b.width * b.shim_thickness * sum(length.values()), rel=1e-9
    )
    assert shape.mesh.points[:, 2].max() == pytest.approx(TOP, rel=1e-12)
    rod = sum(np.pi * p.radius**2 * p.length for p in pieces if p.section == "cylinder")
    assert 0.98 * rod < found["rod"] < rod
    assert volumes(shape.mesh).min() > 0.0


def test_sections_stay_plane_and_outer_electrodes_have_the_voltage(shape_and_line):
    """At every point what the centre line does at its height, from either side of a joint."""
    shape, line, _ = shape_and_line
    points, mesh = shape.mesh.points, shape.mesh
    height = points[:, 2] - points[:, 2].min()
    u_x, u_y, u_z, potential = shape.values(line).T
    np.testing.assert_allclose(u_x, np.interp(height, line.z, line.w), rtol=1e-9)
    np.testing.assert_allclose(
        u_z, points[:, 0] * np.interp(height, line.z, line.psi), rtol=1e-9, atol=1e-20
    )
    assert not u_y.any()
    b = GLUED.bimorph
    inner = 0.5 * b.shim_thickness + b.glue_thickness
    share = (np.abs(points[:, 0]) - inner) / b.piezo_thickness
    electrode = TOP - b.bare_above
    for side in ("piezo_top", "piezo_bottom"):
        at = np.unique(mesh.cells[mesh.cells_of(side)])
        below = at[points[at, 2] < electrode - 1e-9]
        np.testing.assert_allclose(potential[below], line.voltage * share[below], atol=1e-9)
        assert not potential[at[points[at, 2] > electrode + 1e-9]].any()
    for name in ("shim", "glue", "rod"):
        assert not potential[np.unique(mesh.cells[mesh.cells_of(name)])].any()
