"""What pictures are made of: surfaces, colours, eye, words and rulers, without painting them."""

import base64
import io
import zlib
from types import SimpleNamespace

import numpy as np
import pytest
from approved import described
from PIL import Image
from unpainted import as_text, unpainted

from tactgen.geometry.meshing.tensor_tets import box_tetrahedra
from tactgen.validation.fields.moving import MovingBody
from tactgen.validation.fields.over_length import LengthRange, ModeOverLength
from tactgen.validation.fields.result import FieldResult, State
from tactgen.validation.view.assembly_frames import assembly_frames
from tactgen.validation.view.page import shown
from tactgen.validation.view.page.display import DrawnPart
from tactgen.validation.view.pictures import assembly_picture, mesh_picture, solids_pictures
from tactgen.validation.view.run.frames import Instant, run_frames, run_still
from tactgen.validation.view.shading import SHADES
from tactgen.validation.view.stills import Picture, frames, still

SHADE = {shade.key: shade for shade in SHADES}
#: A post of three regions, 2 by 1 by 10 mm.
POST = box_tetrahedra(
    np.array([0.0, 5e-4, 2e-3]), np.array([0.0, 1e-3]), np.array([0.0, 4e-3, 1e-2]),
    np.array([[[0, 2]], [[1, 1]]]), ("rod", "shim", "own part"),
)  # fmt: skip


@pytest.fixture
def kept(monkeypatch):
    return unpainted(monkeypatch)


def state(kind, size=1.0, **more):
    """Return a state in which the post bends, and all else follows its height."""
    x, y, z = POST.points.T
    moved = size * 1e-6 * np.stack([(z / 1e-2) ** 2, 0.3 * y / 1e-3, -x / 1e-2], axis=1)
    stress = size * np.outer(z / 1e-2, [1e3, -2e3, 3e6, 1e4, 2e4, 5e3])
    found = {"displacement": moved, "stress": stress, "flux_density": np.abs(stress[:, 2:5])}
    return State(name=kind, kind=kind, circuit="short", bar=0.02, fields=found, **more)


STATES = (
    state("mode", frequency=371.2, motion="bending_x", coupling=0.31),
    state("harmonic", 0.4 - 0.2j, frequency=100.0, tip=3e-7 - 1e-7j),
    state("static", 2.0, frequency=0.0, tip=2e-6),
)
MOVING = FieldResult("post", "solid", POST, STATES, 5.0, "solid")
AT_REST = State(
    "20 mA, gap 80 µm", "static", "driven", 0.0, np.nan,
    {"flux_density": STATES[2].fields["flux_density"]}, pull=(0.012, 3e-5),
)  # fmt: skip
OPENED = FieldResult(
    "post",
    "axisymmetric",
    POST,
    (AT_REST,),
    0.0,
    "field",
    1e-3 * np.array([[[0.0, 0, 0], [1, 0, 2]], [[0, 1, 3], [2, 1, 4]]]),
)
STOOD = FieldResult("post", "tmm", POST, STATES, 5.0, "beam", rigid=("rod",))


#: What is drawn, in which state, how, at which phase.
STILLS = {
    "standing still": (MOVING, 2, Picture(300, 200), 1.0),
    "upright": (MOVING, 1, Picture(200, 300, SHADE["stress_zz"], mesh=False), 1.0),
    "by size": (MOVING, 1, Picture(300, 240, SHADE["von_mises"]), 0.5),
    "on a rod": (STOOD, 0, Picture(300, 200, SHADE["size"]), np.pi),
    "rod without a field": (STOOD, 0, Picture(200, 300, SHADE["stress_zz"]), 0.0),
    "opened": (OPENED, 0, Picture(300, 200, SHADE["flux_density"]), 1.0),
    "opened, upright": (OPENED, 0, Picture(200, 300), 0.0),
}


@pytest.mark.parametrize("name", STILLS)
def test_a_still(kept, approved, name):
    """The shape at a phase in its colours, from where it is seen; words, bar, ruler."""
    result, number, picture, phase = STILLS[name]
    said = []
    (image,) = frames(result, result.states[number], picture, [phase], said.append)
    assert image.size == (picture.width, picture.height)
    assert said == ["picture 1 of 1"]
    approved(as_text(kept))


def test_a_still_is_a_png(kept):
    assert still(MOVING, STATES[0], Picture(60, 40)).startswith(b"\x89PNG")


def test_a_run(kept, approved):
    """The body enlarged each way by a factor of its own, and its curves with the instant."""
    body = MovingBody(
        POST,
        np.outer((POST.points[:, 2] / 1e-2) ** 2, [0.0, 1.0, 0.2]),
        np.outer(POST.points[:, 0] / 1e-2, [0.0, -1.0, 0.1]) + np.array([1.0, 0.0, 0.0]),
    )
    instants = [
        Instant(t, np.array([lift, w, 1e-7, 5.0]), lift, w, current, phase)
        for t, lift, w, current, phase in (
            (0.0, 0.0, 0.0, 0.0, "pressed"), (1e-3, -3e-5, -4e-6, 0.02, "falling"),
            (4e-3, -8e-5, 2e-6, 0.12, "held"),
        )
    ]  # fmt: skip
    said = []
    images = run_frames(body, instants, said.append)
    assert said == [f"picture {k} of 3" for k in (1, 2, 3)]
    assert {image.size for image in images} == {(800, 640)}
    approved(as_text(kept))
    run_still(body, instants)
    approved(as_text(kept), "still")
    standing = [Instant(0.0, np.zeros(3), 0.0, 0.0, 0.0, "rising")]
    run_frames(body, standing)
    approved(as_text(kept), "at rest")


CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 2.0) for z in (0.0, 8.0)])
FACES = np.array([[0, 1, 3], [4, 5, 7], [0, 2, 6]])
PARTS = (
    DrawnPart("shim", (0.9, 0.6, 0.1), CUBE, FACES, np.array([[0.0, 0, 0], [3, 0, 1]]), moves=True),
    DrawnPart("board", (0.1, 0.4, 0.2), 5.0 * CUBE - 3.0, FACES, np.zeros((1, 3)), moves=False),
)  # fmt: skip


def test_a_display(kept, approved):
    """Copies at their places; only what moves does, as a parabola above its base."""
    said = []
    tips = np.array([1e-5, -4e-6j])
    images = assembly_frames(PARTS, tips, (2.0, 4.0), 30.0, "words", [0.0, 1.0], said.append)
    assert said == ["picture 1 of 2", "picture 2 of 2"]
    assert [image.size for image in images] == 2 * [(640, 720)]
    approved(as_text(kept))


def pictured(png):
    with Image.open(io.BytesIO(png)) as image:
        return image.size


def test_geometry(kept, approved):
    """Parts, solids and meshes: to scale, cut open where they hide what is in them, cropped."""
    sizes = {
        "parts": pictured(assembly_picture(PARTS)),
        "cut": pictured(assembly_picture(PARTS, 2.5)),
    }
    solids = {name: solid(k) for k, name in enumerate(("rod", "coil", "sleeve"))}
    small, large = solids_pictures([{"rod": solids["rod"]}, solids])
    sizes |= {"rod": pictured(small), "actuator": pictured(large)}
    sizes |= {
        "mesh": pictured(mesh_picture(KNOWN)),
        "end": pictured(mesh_picture(KNOWN, close_up=True)),
    }
    approved(as_text(kept) + "\n" + described(sizes))


#: Of regions that have colours.
KNOWN = box_tetrahedra(
    np.array([0.0, 1e-3]), np.array([0.0, 1e-3]), np.array([1e-3, 4e-3, 1e-2]),
    np.array([[[0, 1]]]), ("rod", "shim"),
)  # fmt: skip


def solid(number):
    """Return a stand-in for a CAD solid: a corner of triangles and its bounding box."""
    high = 2.0 + number
    corners = np.array([[0.0, 0, -1], [1, 0, -1], [0, 1, -1], [0, 0, high]]) * (1.0 + number)
    points = [SimpleNamespace(toTuple=lambda c=c: tuple(c)) for c in corners]
    faces = [(0, 1, 2), (0, 1, 3)]
    box = SimpleNamespace(zmin=corners[:, 2].min(), zmax=corners[:, 2].max())
    return SimpleNamespace(tessellate=lambda *_: (points, faces), BoundingBox=lambda: box)


#: The post at other lengths: it becomes stiffer and then is not known; a mode that it has not.
OTHERS = LengthRange(
    "solid", 0.01, POST, np.array([0.008, 0.01, 0.012]), np.array([0.009, 0.011]),
    np.stack([POST.points * [1.0, 1.0, share] for share in (0.9, 1.1)]),
    tuple(
        ModeOverLength(
            "short", motion, 0, np.array([400.0, 371.2, np.nan]), np.array([1.0, 0.5, np.nan]),
            np.stack([STATES[0].fields["displacement"] * share for share in (1.0, 1.2)]),
        )
        for motion in ("bending_x", "torsion")
    ),
    0.0123, "by hand",
)  # fmt: skip


@pytest.mark.parametrize("most", [6000, 5])
def test_all_that_goes_into_the_page(most, monkeypatch, approved):
    """Every array of three results, of which large ones have their surface alone."""
    monkeypatch.setattr(shown, "_MOST_CELLS", most)
    data = shown.payload([MOVING, STOOD, OPENED], [OTHERS, None, None])
    raw = zlib.decompress(base64.b64decode(data.pop("blob")), -15)
    kinds = {"f4": "<f4", "u4": "<u4", "i2": "<i2"}

    def unpacked(value):
        if isinstance(value, list):
            return [unpacked(one) for one in value]
        if not isinstance(value, dict):
            return value
        if "offset" in value:
            packed = np.frombuffer(raw, kinds[value["type"]], value["count"], value["offset"])
            whole = packed * value["scale"]
            return np.append(whole, whole @ np.arange(whole.size))  # their order, too
        return {key: unpacked(one) for key, one in value.items() if key != "palettes"}

    approved(described(unpacked(data)))
