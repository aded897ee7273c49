"""Bimorphs whose layers are listed one by one, by beam theories and the solid."""

import numpy as np
import pytest

import tactgen
from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.parameters import Piezo, Shim
from tactgen.geometry.device.shim_library import SHIMS
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix
from tactgen.validation.engine.warnings import request_warnings
from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.inputs import stage_key
from tactgen.validation.scene.keys import number_keys
from tactgen.validation.scene.load import checked_scene, load_scene
from tactgen.validation.scene.parameter_list import ranges

STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
NUMBERS = (*STATIC, "short_circuit_frequencies", "open_circuit_frequencies")
FREQUENCY = [50.0, 400.0]


def scene(layers, models="tmm", **bimorph):
    """Bimorph of 20 mm x 5 mm on a bench."""
    values = {"length": "20 mm", "width": "5 mm", "layers": layers, **bimorph}
    return checked_scene(
        {"start_from": "neutral", "models": models, "bimorph": values, "frequency": FREQUENCY,
         "mesh": {"level": 2}}
    )  # fmt: skip


def answers(of, *names, model="tmm"):
    """Values of quantities by name, flat."""
    found = tactgen.solve(of, (model,), names, modelling=False)
    return np.concatenate([np.atleast_1d(found.get(name, model).value) for name in names])


@pytest.mark.parametrize(
    ("model", "names"),
    [
        *((model, (*NUMBERS, "admittance")) for model in ("lumped", "tmm", "beam")),
        pytest.param("solid", (*NUMBERS, "admittance"), marks=pytest.mark.heavy),
    ],
)
@pytest.mark.parametrize("more", [{}, {"tab_length": "2 mm"}, {"bare_below": "3 mm"}])
def test_three_layers_in_a_list_are_the_bimorph(model, names, more):
    """The solid solves half of a list and a quarter of the bimorph, on other bricks in the core:
    both are right within their errors.  Beam elements have rounding of 1e-9."""
    plain = scene(
        "none", model, piezo_thickness="0.2 mm", shim_thickness="0.1 mm", poling="-x", **more
    )
    made_of = {"piezo": Piezo(material="PZT-5A"), "shim": Shim(material="brass")}
    plain = plain.model_copy(update=made_of)
    listed = scene("PZT-5A 0.2 mm -x; brass 0.1 mm; PZT-5A 0.2 mm -x", model, **more)
    one, other = (tactgen.solve(of, (model,), names, modelling=False) for of in (plain, listed))
    for name in names:
        a, b = one.get(name, model), other.get(name, model)
        bars = a.error + b.error + 1e-12 * np.abs(b.value)
        assert (np.abs(a.value - b.value) <= bars).all(), name


@pytest.mark.parametrize(
    "layers",
    [
        "PZT-5A 0.1 mm +x; spring steel 0.15 mm; PZT-5H 0.3 mm -x",
        "PZT-5A 0.15 mm +x hot +x; PZT-5A 0.2 mm +x hot -x",
        "PZT-5A 0.2 mm +x bare; brass 0.1 mm; PZT-5A 0.2 mm +x",
        "PZT-5A 0.2 mm +z pitch 0.5 mm; brass 0.1 mm; PZT-5H 0.1 mm -z pitch 1 mm shorted",
        "PZT-5A 0.2 mm from 3 mm to 15 mm +x; brass 0.1 mm; PZT-5H 0.1 mm wide 3 mm from 9 mm +x",
    ],
)
def test_beam_elements_agree_with_the_transfer_matrix(layers):
    """Their sections are integrated layer by layer, voltage and axial strain being unknowns."""
    metal = any(name in layers for name in ("brass", "steel"))
    more = {"tip_extension": "4 mm"} if metal else {}
    more |= (
        {}
        if "pitch" in layers or "from" in layers
        else {"bare_above" if metal else "bare_below": "2 mm"}
    )
    one, other = (
        answers(scene(layers, model, **more), *NUMBERS, "admittance", model=model)
        for model in ("tmm", "beam")
    )
    np.testing.assert_allclose(one, other, rtol=2e-8)


#: Interdigitated electrodes on both sides of a thin glue, the lower ceramic becoming longer.
ALONG = "PZT-5A 0.2 mm +z pitch 0.5 mm; glue 1 nm; PZT-5A 0.2 mm -z pitch 0.5 mm"


def test_poled_along_it_bends_by_d33_and_its_pitch():
    """Two layers that strain by ±d33 U/pitch bend by 3/2 of that over the thickness of one; the
    charge of a layer is D₃ on every finger, its strain half relieved by the bending."""
    of, ceramic = scene(ALONG, length="30 mm"), LIBRARY["PZT-5A"]
    deflection, free, _ = answers(of, *STATIC)
    d33, s33, eps = ceramic.d[2, 2], ceramic.s[2, 2], ceramic.eps_t[2, 2]
    assert deflection == pytest.approx(0.75 * d33 / 0.5e-3 * 0.03**2 / 0.2e-3, rel=1e-4)
    clamped = eps - d33**2 / s33
    capacity = clamped + 0.75 * d33**2 / s33
    assert free == pytest.approx(2.0 * capacity * 0.03 * 5e-3 * 0.2e-3 / 0.5e-3**2, rel=1e-4)


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_poled_along_the_solid_and_the_beam_have_one_field():
    """A narrow solid strains as a bar does: its field is that of the pitch and follows no strain.

    Its clamp keeps the layers from growing sideways: 0.1 % of the deflection; a field that followed
    the strain would take 4 %.
    """
    names, layers = ("static_tip_displacement", "capacitance_free"), ALONG.replace("1 nm", "2 um")
    beam, solid = (
        answers(scene(layers, model, length="30 mm", width="0.3 mm"), *names, model=model)
        for model in ("tmm", "solid")
    )
    np.testing.assert_allclose(beam, solid, rtol=2e-3)


@pytest.mark.usefixtures("own_store", "coarse_bricks")
@pytest.mark.parametrize("width", ["2 mm", "14 mm"])
def test_fibres_along_are_known_by_theories_alone(width):
    """The stated modelling error of beams covers the solid of a macro fibre composite on brass.

    On usual bricks the solid is off by a twentieth of that error.
    """
    fibres = "PZT-5A 0.18 mm +z pitch 0.5 mm; brass 0.5 mm; PZT-5A 0.18 mm -z pitch 0.5 mm"
    pairs = (
        tactgen.solve(scene(fibres, model, width=width), (model,), STATIC[:2]).quantities
        for model in ("tmm", "solid")
    )
    for beam, full in zip(*pairs, strict=True):
        assert beam.modelling.error < 0.1 * abs(full.value)
        assert abs(beam.modelling.expected - full.value) <= beam.modelling.error


@pytest.mark.parametrize("model", ["tmm", pytest.param("solid", marks=pytest.mark.heavy)])
def test_seen_from_the_other_side_the_tip_moves_the_other_way(model):
    """Layers in the other order, poling and voltage turned."""
    there = "brass 0.15 mm; PZT-5A 0.1 mm +x hot +x; PZT-5H 0.2 mm -x hot -x"
    back = "PZT-5H 0.2 mm +x hot +x; PZT-5A 0.1 mm -x hot -x; brass 0.15 mm"
    one, other = (answers(scene(text, model), *STATIC, model=model) for text in (there, back))
    np.testing.assert_allclose(one * [-1.0, 1.0, 1.0], other, rtol=1e-8)


@pytest.mark.parametrize(
    "model", ["lumped", "tmm", "beam", pytest.param("solid", marks=pytest.mark.heavy)]
)
def test_two_films_in_a_row_bend_as_published(model):
    """PVDF bimorph of Hwang and Park (AIAA J. 31, 1993): 100 mm x 5 mm x 1 mm, 1 V: 0.345 um.

    3 d31 U L^2 / (2 h^2); the solid's clamp and width are worth some percent.
    """
    film = {"s11": "0.5 m^2/GN", "d31": "23 pC/N", "material": "PVDF"}
    of = checked_scene({
        "start_from": "neutral", "models": model, "piezo": film,
        "bimorph": {"length": "100 mm", "width": "5 mm", "wiring": "series",
                    "layers": "piezo 0.5 mm +x; piezo 0.5 mm -x"},
    })  # fmt: skip
    found = answers(of, STATIC[0], model=model)[0]
    assert found == pytest.approx(-0.345e-6, rel=0.05 if model == "solid" else 1e-3)


def test_in_series_the_lower_ceramic_is_poled_the_other_way():
    """A list that says so is the bimorph of the scene's own keys; poled alike they stretch."""
    own = scene("none", wiring="series", piezo_thickness="0.2 mm", shim_thickness="0.1 mm")
    up, down = (
        scene(f"piezo 0.2 mm {turned}; shim 0.1 mm; piezo 0.2 mm -x", wiring="series")
        for turned in ("+x", "-x")
    )
    one, other = (answers(of, *NUMBERS, "admittance") for of in (own, up))
    np.testing.assert_allclose(one, other, rtol=1e-9)
    assert answers(down, STATIC[0])[0] == 0.0


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_the_potential_of_a_bare_ceramic_has_a_level_and_no_more():
    """Beside metal, whichever face has it: the same upside down, and near the beam.

    That one face is equipotential is felt at the edges alone, on a layer's thickness of the width.
    """
    sizes = {"length": "8 mm", "width": "2 mm"}
    there = "PZT-5H 0.1 mm +x bare; brass 0.1 mm; PZT-5A 0.1 mm +x"
    back = "PZT-5A 0.1 mm +x; brass 0.1 mm; PZT-5H 0.1 mm +x bare"
    one, other = (
        answers(scene(text, "solid", **sizes), *STATIC, model="solid") for text in (there, back)
    )
    np.testing.assert_allclose(one, other, rtol=1e-3)
    beam = answers(scene(there, **sizes), *STATIC)
    np.testing.assert_allclose(one, beam, rtol=0.1)  # what the width is worth to a beam
    shorted = answers(scene(there.replace("bare", "shorted"), **sizes), STATIC[0])[0]
    assert abs(one[0] / beam[0] - 1.0) < 0.5 * abs(one[0] / shorted - 1.0)


def test_a_narrow_solid_is_a_beam():
    """A slender unimorph as narrow as one layer is thick: no stress across it.

    Beam theories take a uniform field through the ceramic.  Without that what varies about its mean
    strain is stiffened by 1 / (1 - k²), which the frequency shows.  That the metal keeps the
    ceramic from growing sideways beside it takes 2 % of the deflection.
    """
    names = ("static_tip_displacement", "short_circuit_frequencies")
    sizes = {"width": "0.2 mm", "length": "30 mm"}
    of = [scene("brass 0.2 mm; PZT-5A 0.2 mm -x", m, **sizes) for m in ("tmm", "solid")]
    beam = answers(of[0], *names)
    found = tactgen.solve(of[1], ("solid",), names, modelling=False)
    deflection, frequencies = (found.get(name, "solid") for name in names)
    first = frequencies.value[frequencies.classes.index("bending_x")]
    ((section, _),) = transfer_matrix.sections(of[0].device, of[0].support, of[0].beam, lossy=False)
    ceramic = LIBRARY["PZT-5A"]
    k2 = ceramic.d[2, 0] ** 2 / (ceramic.s[0, 0] * ceramic.eps_t[2, 2])
    stiffer = 1.0 + k2 / (1.0 - k2) / ceramic.s[0, 0] * 0.2e-3**4 / 12.0 / section.EI
    # without it they are 0.6 % apart; metal beside ceramic stiffens by a sixth of that
    assert first == pytest.approx(beam[1] * stiffer**0.5, rel=2e-3)
    assert deflection.value == pytest.approx(beam[0] / stiffer, rel=0.025)


@pytest.mark.parametrize(
    ("layers", "words"),
    [
        ("brass 0.2 mm; PZT-5A 0.2 mm", "without a poling"),
        ("brass 0.2 mm +x; PZT-5A 0.2 mm +x", "brass is not piezoelectric"),
        ("brass 0.2 mm", "no ceramic at the drive voltage"),
        ("brass 0.2; PZT-5A 0.2 mm +x", "not begin with a material and a thickness"),
        ("brass 0.2 mm; PZT-5A 0.2 mm +x wide 4 mm", "in this order"),
        ("brass 0.2 mm; PZT-5A 0.2 mm +z", r'"\+z" is not understood.*"\+z pitch 0\.5 mm"'),
        ("brass 0.2 mm; PZT-5A 0.2 mm +z pitch 0.5 mm hot +x", "write shorted"),
        ("PZT-5A 0.2 mm +x; PZT-5A 0.2 mm +z pitch 0.5 mm", "cannot touch another ceramic"),
        ("brass 0.2 mm; PZT-5A 0.2 mm +z pitch 0.1 mm", "must lie between its thickness"),
        ("brass 0.2 mm; PZT-5A 0.1 mm to 3 mm +z pitch 5 mm", "its length, 3 mm"),
        ("", r"bimorph\.layers = .* is empty; write"),
        ("brss 0.2 mm; PZT-5A 0.2 mm +x", 'did you mean "brass"'),
        ("brass 0.2 mm; PZT-5A 0.2 mm from 9 mm to 2 mm +x", "not above its beginning at 9 mm"),
        ("brass 0.2 mm; PZT-5A 0.2 mm to 21 mm +x", "beyond bimorph.length = 20 mm"),
        ("brass 0.2 mm to 9 mm; PZT-5A 0.2 mm to 9 mm +x", "no layer all along"),
        ("brass 0.2 mm; glue 0.1 mm to 5 mm; PZT-5A 0.2 mm +x", "nothing between .* 5 to 20 mm"),
        ("brass 1 mm; PZT-5A 0.2 mm to 5 mm +x; PZT-5A 0.2 mm from 7 mm +x", "beside each other"),
        ("brass 0.2 mm; PZT-5A 0.2 mm from 5 mm to 5.00000001 mm +x", "next to nothing"),
    ],
)
def test_refusals_name_the_layer(layers, words):
    """In one sentence."""
    with pytest.raises(InputError, match=words) as refused:
        scene(layers)
    assert "\n" not in str(refused.value)


LISTED = "brass 0.2 mm; PZT-5A 0.2 mm wide 3 mm from 1 mm to 9 mm +x"


def test_a_size_is_a_key_of_its_own():
    """In place of the list's, or beside it; also where the layers come after it."""
    sizes = {"1.thickness": "0.3 mm", "1.width": "4 mm", "2.start": "2 mm", "2.end": "12 mm"}
    found, _ = load_scene(
        "prototype",
        [*(f"bimorph.layers.{name}={size}" for name, size in sizes.items()),
         f"bimorph.layers={LISTED}"],
    )  # fmt: skip
    wanted = "brass 0.3 mm wide 4 mm; PZT-5A 0.2 mm wide 3 mm from 2 mm to 12 mm +x"
    assert str(found.bimorph.layers) == wanted
    listed, _ = load_scene("prototype", [f"bimorph.layers={LISTED}"])
    assert stage_key("tmm.static", found) != stage_key("tmm.static", listed)


def test_layers_that_end_together_are_varied_together():
    """Where only one of two patches ends elsewhere, a piece appears and the slope has a kink."""
    patches = "PZT-5A 0.3 mm to 8 ± 0.2 mm -x; brass 0.3 mm; PZT-5A 0.3 mm to 8 mm -x"
    both = "bimorph.layers.1+3.end"
    found, _ = load_scene("prototype", [f"bimorph.layers={patches}"])
    assert both in number_keys(found)
    assert both.replace("1+3", "1") not in number_keys(found)
    assert ranges(found)[both][:2] == pytest.approx((7.8e-3, 8.2e-3))
    moved, _ = load_scene("prototype", [f"bimorph.layers={patches}", f"{both}=9 mm"])
    assert [layer.end for layer in moved.bimorph.layers] == [9e-3, 0.0, 9e-3]
    with pytest.raises(InputError, match="layer 1 has 8 mm, layer 2 0 mm; state them alike"):
        found.bimorph.value("layers.1+2.end")


def test_a_layer_as_wide_as_the_bimorph_has_no_width_of_its_own():
    """So its modelling errors are those of plain layers."""
    layers = "brass 0.3 mm wide 5 mm; PZT-5A 0.3 mm -x"
    sets = ["bimorph.width=5mm", f"bimorph.layers={layers}"]
    assert not load_scene("prototype", sets)[0].bimorph.stepped
    assert load_scene("prototype", [*sets, "bimorph.width=6mm"])[0].bimorph.stepped


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_bricks_of_layers_that_are_all_narrower_than_the_bimorph():
    """They are those of a narrower one."""
    layers = "brass 0.1 mm{0}; PZT-5A 0.2 mm{0} from 2 mm to 15 mm +x"
    one, other = (
        answers(scene(layers.format(own), "solid", width=width), *NUMBERS, model="solid")
        for own, width in (("", "3 mm"), (" wide 3 mm", "5 mm"))
    )
    np.testing.assert_allclose(one, other, rtol=1e-9)


@pytest.mark.heavy
@pytest.mark.usefixtures("own_store")
@pytest.mark.parametrize(
    ("layers", "more"),
    [
        ("PZT-5H 0.3 mm wide 2.5 mm -x; brass 0.2 mm; PZT-5H 0.3 mm wide 3 mm +x", {}),
        ("brass 0.3 mm; PZT-5A 0.2 mm wide 2 mm from 2 mm to 12 mm +x", {"tip_extension": "3 mm"}),
    ],
)
def test_bricks_and_tetrahedra_of_layers_of_their_own_widths(layers, more):
    """Within both errors; the first hardly bends but stretches, which is no rotation of the tip."""
    of = scene(layers, "solid,cad", length="15 mm", **more)
    found = tactgen.solve(of, ("solid", "cad"), NUMBERS, modelling=False)
    for name in NUMBERS:
        a, b = (found.get(name, model) for model in ("solid", "cad"))
        assert (np.abs(a.value - b.value) <= a.error + b.error).all(), name


@pytest.mark.parametrize(
    ("layers", "override", "words"),
    [
        (LISTED, "layers.3.end=9mm", r"size of layer 3, and bimorph\.layers lists 2"),
        ("none", "layers.1.end=9mm", "none is listed; set bimorph.layers"),
        (LISTED, "layers.2.length=9mm", "thickness, width, pitch, start, end"),
        (LISTED, "layers.2.pitch=1mm", "without interdigitated electrodes"),
        (LISTED, "layers.1+1.end=9mm", "names a layer twice"),
        ("brass 0.2 m", "layers.1.width=1mm", 'bimorph.layers = "brass 0.2 m" has the layer'),
    ],
)
def test_a_size_that_cannot_be_is_refused(layers, override, words):
    """In one sentence with its key, or with what is wrong with the list."""
    with pytest.raises(InputError, match=words):
        load_scene("prototype", [f"bimorph.layers={layers}", f"bimorph.{override}"])


def test_what_a_list_cannot_be_combined_with_is_refused():
    """A rod, unequal layers in series, lengths without a layer."""
    series = {"wiring": "series"}
    for layers, more, words in (
        ("PZT-5A 0.2 mm wide 4 mm +x; brass 0.1 mm; PZT-5A 0.2 mm -x", series, "mirror each other"),
        ("PZT-5A 0.2 mm +z pitch 1 mm; brass 0.1 mm; PZT-5A 0.2 mm -z pitch 1 mm", series,
         "interdigitated electrodes; use parallel"),
        ("PZT-5A 0.2 mm +x hot -x; PZT-5A 0.2 mm -x hot +x", series, "leave out hot"),
        ("PZT-5A 0.1 mm -x; brass 0.1 mm; PZT-5A 0.2 mm -x hot -x", {},
         r"joins layer 1 \(PZT-5A 0\.1 mm -x\) and layer 3"),
        ("PZT-5A 0.1 mm +x; PZT-5A 0.1 mm -x hot +x", {"tip_extension": "2 mm"},
         "no layer that goes on"),
        ("brass 0.2 mm; PZT-5A 0.2 mm from 2 mm +x", {"bare_above": "1 mm"},
         "whose electrodes cover them"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=words):
            scene(layers, **more)
    uni = "brass 0.2 mm; PZT-5A 0.2 mm +x"
    with pytest.raises(InputError, match="whose rod holds a shim"):
        checked_scene({"bimorph": {"layers": uni}, "support": {"kind": "rod"}})


def test_what_couples_along_must_be_passive():
    """By k33 and by the losses, as across by k31."""
    sets = ["models=tmm", "piezo.material=PZT-5A", "piezo.loss_tangent=0.03",
            "piezo.quality_factor=60",
            "bimorph.layers=piezo 0.2 mm +z pitch 0.5 mm; brass 0.2 mm"]  # fmt: skip
    for stated in ("piezo.constants=d33 2000 pC/N", "piezo.coupling_loss=0.033"):
        with pytest.raises(InputError, match=r"layer 1 .* k33"):
            load_scene("prototype", [*sets, stated])


@pytest.mark.parametrize("t", [5e-3, 2.5e-3])
def test_a_narrower_layer_counts_by_its_width(t):
    """Half as wide: half of its stiffness and moment about the same axis, by hand.

    As wide as the metal: Timoshenko's bimetal (1925).
    """
    of = scene(f"brass 0.3 mm; PZT-5A 0.2 mm wide {t} m +x")
    found = answers(of, "static_tip_displacement")[0]
    length, width, h, hp = 20e-3, 5e-3, 0.3e-3, 0.2e-3
    metal, ceramic = SHIMS["brass"].youngs_modulus, LIBRARY["PZT-5A"]
    young, d31 = 1.0 / ceramic.s[0, 0], ceramic.d[2, 0]
    stretch = [metal * width * h, young * t * hp]
    apart = 0.5 * (h + hp)
    own = (metal * width * h**3 + young * t * hp**3) / 12.0
    bending = own + stretch[0] * stretch[1] / sum(stretch) * apart**2
    moment = -young * t * d31 * stretch[0] / sum(stretch) * apart  # of 1 V on the outer face
    assert abs(found) == pytest.approx(abs(moment) * length**2 / (2.0 * bending), rel=1e-12)


@pytest.mark.usefixtures("coarse_solid")
@pytest.mark.parametrize(
    ("model", "names", "poling"),
    [*((model, NUMBERS, "+x") for model in ("lumped", "tmm")),
     *(("solid", STATIC, poling) for poling in ("+x", "+z pitch 0.5 mm"))],
)  # fmt: skip
def test_a_patch_is_the_ceramic_between_tab_and_tip_extension(model, names, poling):
    """The same device in other words: equal to rounding."""
    layers = "brass 0.3 mm; PZT-5A 0.2 mm {}" + poling
    bare = {"length": "9 mm", "tab_length": "2 mm", "tip_extension": "9 mm"}
    patch = scene(layers.format("from 2 mm to 11 mm "), model)
    whole = scene(layers.format(""), model, **bare)
    one, other = (answers(of, *names, model=model) for of in (patch, whole))
    np.testing.assert_allclose(one, other, rtol=2e-8)


@pytest.mark.parametrize(("poling", "warned"), [("-x", True), ("+x", False)])
def test_ceramics_that_only_stretch_are_named(poling, warned):
    """Driven outside and poled away from each other both grow: no voltage from any bending."""
    of = scene(f"PZT-5A 0.2 mm +x; brass 0.1 mm; PZT-5A 0.2 mm {poling}")
    found = request_warnings(of, of.models, of.quantities)
    assert any("stretch it and do not bend it" in w for w in found) is warned
    apart = f"PZT-5A 0.2 mm to 8 mm +x; brass 0.1 mm; PZT-5A 0.2 mm from 12 mm {poling}"
    found = request_warnings(scene(apart), of.models, of.quantities)
    assert not any("do not bend it" in w for w in found)


def test_more_layers_than_the_memory_holds_are_refused(monkeypatch):
    """Before anything is meshed, with a model that answers; a few layers are not looked at."""
    monkeypatch.setattr(solid, "memory_size", lambda: 8e9)
    stack = "; ".join(["piezo 0.03 mm +x hot -x", "piezo 0.03 mm -x hot +x"] * 8)
    scene, _ = load_scene("prototype", [f"bimorph.layers={stack}", "support.kind=clamped"])
    with pytest.raises(InputError, match=r"16 layers.*GB.*--model calibrated"):
        solid.SolidModel.check(scene)
    monkeypatch.setattr(solid, "memory_size", lambda: 1e12)
    solid.SolidModel.check(scene)
