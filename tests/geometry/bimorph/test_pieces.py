"""The row of pieces of bimorphs that are not uniform, and who refuses them."""

import pytest

from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.geometry.device.bimorph import Dimensions
from tactgen.geometry.device.checks import check_fit
from tactgen.geometry.device.parameters import Bimorph, Device, Support
from tactgen.geometry.device.parts import layout
from tactgen.geometry.errors import InputError
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
