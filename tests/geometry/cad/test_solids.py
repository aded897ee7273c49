"""CAD solids: exact volumes, faces shared by neighbours, files that other programs read."""

import json
import struct
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.cad.display import display_assembly
from tactgen.geometry.cad.solids import (
    build_solids,
    fuse,
    solids_assembly,
    thinnest_feature,
    write_glb,
    write_step,
)
from tactgen.geometry.cad.tessellation import tessellate
from tactgen.geometry.device.parameters import Bimorph, Coil, Device, Display, Glue, Rod, Sleeve
from tactgen.geometry.device.parts import closed_form_volumes
from tactgen.geometry.display.layout import display_parts
from tactgen.geometry.errors import InputError

GENERATOR = Device(bimorph=Bimorph(tab_length=0.4e-3))

DEVICES = {
    "paper": GENERATOR,
    "raised ceramic, small gap": Device(bimorph=Bimorph(tab_length=1.1e-3), gap=0.05e-3),
    "narrow, short": Device(
        bimorph=Bimorph(length=5e-3, width=1.2e-3, piezo_thickness=0.13e-3, tab_length=0.6e-3),
        glue=Glue(thickness=0.02e-3),
    ),
    "no step at flange or collar": Device(
        bimorph=Bimorph(tab_length=0.5e-3),
        rod=Rod(radius=0.6e-3, flange_position=2.5e-3, flange_thickness=0.5e-3, length=3.4e-3),
        coil=Coil(inner_radius=0.65e-3, outer_radius=0.8e-3, position=0.4e-3),
        sleeve=Sleeve(collar_radius=0.96e-3),
    ),
}


@pytest.mark.parametrize("name", DEVICES)
def test_cad_volumes_equal_closed_forms(name):
    device = DEVICES[name]
    solids = build_solids(device)
    expected = closed_form_volumes(device)
    assert list(solids) == list(expected)
    for region, solid in solids.items():
        assert solid.isValid()
        assert solid.Volume() * 1e-9 == pytest.approx(expected[region], rel=1e-9), region


#: How many faces touching solids share: where the ceramic hangs clear of the rod, and besides where
#: it stands on the rod's head and on the bond line's rim.
CLEAR = {
    ("piezo_top", "shim"): 1, ("piezo_bottom", "shim"): 1, ("shim", "glue"): 5, ("glue", "rod"): 5,
    ("rod", "coil"): 1,
}  # fmt: skip
STANDING = {(side, on): 1 for side in ("piezo_top", "piezo_bottom") for on in ("rod", "glue")}


@pytest.mark.parametrize(("tab_length", "expected"), [(0.4e-3, CLEAR | STANDING), (0.6e-3, CLEAR)])
def test_fused_solids_share_faces_and_keep_volumes_and_names(tab_length, expected):
    solids = build_solids(Device(bimorph=Bimorph(tab_length=tab_length)))
    fused = fuse(solids)
    names = list(fused)
    assert names == list(solids)
    for region, solid in fused.items():
        assert solid.Volume() == pytest.approx(solids[region].Volume(), rel=1e-12), region
    shared = {
        (a, b): len(set(fused[a].Faces()) & set(fused[b].Faces()))
        for i, a in enumerate(names)
        for b in names[i + 1 :]
    }
    assert {pair: n for pair, n in shared.items() if n} == expected


@pytest.mark.parametrize(
    ("device", "standing", "names", "thickness"),
    [
        (Device(), "alone", None, 0.25),
        (GENERATOR, "rod", ("coil",), 0.26),
        # the wall between the slot's corner and the head's side
        (GENERATOR, "rod", ("glue", "rod"), 1.15 - (0.175**2 + 1.1**2) ** 0.5),
        # the gap between ceramic and rod
        (Device(bimorph=Bimorph(tab_length=0.42e-3)), "rod", ("piezo_top", "rod"), 0.02),
    ],
)
def test_thinnest_feature_is_found(device, standing, names, thickness):
    fused = fuse(build_solids(device, names, standing))
    assert thinnest_feature(fused) == pytest.approx(thickness, rel=1e-6)


def test_step_file_holds_the_same_solids(tmp_path):
    import cadquery as cq

    solids = build_solids(GENERATOR)
    path = tmp_path / "generator.step"
    write_step(solids_assembly(solids), path)
    again = cq.importers.importStep(str(path)).solids().vals()
    volumes = sorted(solid.Volume() for solid in again)
    assert volumes == pytest.approx(sorted(s.Volume() for s in solids.values()), rel=1e-9)
    text = path.read_text()
    assert all(f"PRODUCT('{name}'" in text for name in solids)
    assert [p.name for p in tmp_path.iterdir()] == [path.name], "a temporary file was left"


def test_glb_file_is_valid_named_and_in_metres(tmp_path):
    solids = build_solids(GENERATOR)
    path = tmp_path / "generator.glb"
    write_glb(solids_assembly(solids), path)
    data = path.read_bytes()
    magic, version, length, json_length, json_kind = struct.unpack_from("<4sIIII", data)
    assert (magic, version, length, json_kind) == (b"glTF", 2, len(data), 0x4E4F534A)
    content = json.loads(data[20 : 20 + json_length])
    assert set(solids) <= {node["name"] for node in content["nodes"]}
    assert len(content["materials"]) == len(solids)
    corners = [a for a in content["accessors"] if len(a.get("max", ())) == 3]
    height = max(a["max"][1] for a in corners) - min(a["min"][1] for a in corners)
    assert height == pytest.approx(20e-3 + 19.4e-3, rel=1e-6)  # from the sleeve's end to the tip


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((Device(), ("rod",), "alone"), '"rod" does not exist'),
        ((Device(), ()), "no region is chosen"),
        ((Device(),), r"bimorph.tab_length = 0 mm is too short"),
        (
            (GENERATOR.model_copy(update={"sleeve": Sleeve(collar_thickness=20e-3)}),),
            "sleeve.collar_thickness = 20 mm",
        ),
    ],
)
def test_impossible_input_is_explained(arguments, message):
    with pytest.raises(InputError, match=message):
        build_solids(*arguments)


def test_overlap_is_refused():
    # the coil starts inside the collar
    device = GENERATOR.model_copy(
        update={
            "coil": Coil(position=0.1e-3, outer_radius=0.92e-3),
            "sleeve": Sleeve(collar_radius=0.85e-3),
        }
    )
    with pytest.raises(InputError, match="coil and sleeve overlap"):
        fuse(build_solids(device, ("coil", "sleeve")))


def test_a_display_has_every_part_at_its_places():
    """The assembly places them where the list of parts does (mm)."""
    device, display = Device(), Display(rows=1, columns=2)
    children = display_assembly(device, display).children
    found = [child.loc.toTuple()[0] for child in children]
    wanted = [place for part in display_parts(device, display) for place in part.places]
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert np.ptp(found, axis=0).min() > 1.0
    # what every unit has is named after it; what the display has once or elsewhere is counted
    names = [child.name for child in children]
    assert {"rod_r1c1", "rod_r1c2"} <= set(names)
    assert len(set(names)) == len(names)


def test_faces_of_other_kinds_are_refused():
    """Only planes and cylinders about z have a distance that the mesh can be held against."""
    import cadquery as cq

    for solid in (cq.Solid.makeSphere(1.0), cq.Solid.makeCylinder(1.0, 1.0, cq.Vector(3, 0, 0))):
        with pytest.raises(InputError, match="neither a plane nor a cylinder about the z axis"):
            tessellate({"it": solid}, 0.1, 0.5)


def test_a_kernel_that_fails_is_one_sentence(monkeypatch, tmp_path):
    """Solids that cannot be put together, and a file that is not written."""
    fails = SimpleNamespace(
        AddArgument=lambda _: None, Perform=lambda *_: False, HasErrors=lambda: True,
        ChangeCoordinateSystemConverter=lambda: SimpleNamespace(
            SetInputLengthUnit=lambda _: None, SetInputCoordinateSystem=lambda _: None
        ),
    )  # fmt: skip
    monkeypatch.setattr("OCP.BOPAlgo.BOPAlgo_Builder", lambda: fails)
    parts = build_solids(Device(), ("piezo_top", "shim"), "alone")
    with pytest.raises(InputError, match="the solids piezo_top, shim cannot be put together"):
        fuse(parts)
    monkeypatch.setattr("OCP.RWGltf.RWGltf_CafWriter", lambda *_: fails)
    with pytest.raises(InputError, match=r"cannot be written \(the CAD kernel does not say why\)"):
        write_glb(solids_assembly(parts), tmp_path / "a.glb")
    assert not list(tmp_path.iterdir())
