"""Stills and films; pictures against coarse grids of those that were looked at.

After an intended change look at the pictures and write the grids anew: TACTGEN_WRITE_GRIDS=1.
"""

import io
import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show import pictures, stills
from tactgen.validation.show.colours import SHADES
from tactgen.validation.show.display import drawn_parts
from tactgen.validation.show.export import normal_actuator_solids, scene_solids
from tactgen.validation.show.field import drawn_size
from tactgen.validation.show.pictures import assembly_picture, mesh_picture, solids_picture
from tactgen.validation.show.stills import Picture, check_film, still, write_film

SMALL = {"width": 300, "height": 200}
STRESS = next(shade for shade in SHADES if shade.key == "stress_zz")


def pixels(png):
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


def test_a_still_is_the_same_twice_and_moves_with_the_phase(seen):
    """The same bytes; half a period later the mode bends the other way and colours swap."""
    result = seen[0]
    state = result.state("mode 1, short circuit")
    picture = Picture(**SMALL, shade=STRESS)
    first, again, other = (still(result, state, picture, p) for p in (0.0, 0.0, np.pi))
    assert first == again
    assert pixels(first).shape == (200, 300, 3)
    middle = slice(60, 130)
    blue, red = (pixels(png)[middle].sum(axis=(0, 1)) @ [-1, 0, 1] for png in (first, other))
    assert blue * red < 0


def test_a_film_is_one_period(seen, tmp_path, monkeypatch):
    """Its pictures are shown without end, and differ."""
    monkeypatch.setattr(stills, "_FRAMES", 4)
    path = tmp_path / "mode.gif"
    write_film(path, seen[1], seen[1].states[0], Picture(**SMALL, shade=SHADES[1]))
    with Image.open(path) as film:
        assert film.n_frames == 4
        assert (film.info["loop"], film.info["duration"]) == (0, 80)
        first = np.asarray(film.convert("RGB"))
        film.seek(2)
        assert not np.array_equal(first, np.asarray(film.convert("RGB")))


def test_films_that_cannot_be_made_are_refused(seen, tmp_path, monkeypatch):
    result = seen[1]
    with pytest.raises(InputError, match='state "static" does not move'):
        check_film(tmp_path / "a.gif", result.state("static"))
    monkeypatch.setattr(pictures.shutil, "which", lambda _: None)
    with pytest.raises(InputError, match=r"--mp4 .* needs the program ffmpeg"):
        check_film(tmp_path / "a.mp4", result.states[0])


def test_a_twist_is_drawn_small():
    """A tip that turns about its middle by half a radian, one that goes aside by 12 % of height."""
    corners = np.array([[x, y, z] for z in (0.0, 1.0) for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
    turned = np.column_stack([-corners[:, 1], corners[:, 0], 0 * corners[:, 0]]) * corners[:, 2:]
    aside = np.zeros_like(corners)
    aside[:, 0] = corners[:, 2]
    assert drawn_size(corners, turned) == pytest.approx(0.5 * np.hypot(0.1, 0.1))
    assert drawn_size(corners, aside) == pytest.approx(0.12)


GRIDS = Path(__file__).with_name("pictures.json")
COLUMNS, ROWS = 18, 24
#: Mean and largest difference of cells (of 255): a shifted edge changes a cell by some units, a
#: part that is not there by the contrast of its colour.
USUAL, LARGEST = 3.0, 40.0


def grid(png):
    """Return the picture's colours averaged over cells, (ROWS, COLUMNS, 3)."""
    from PIL import Image

    with Image.open(io.BytesIO(png)) as image:
        small = image.convert("RGB").resize((COLUMNS, ROWS), Image.Resampling.BOX)
    return np.asarray(small, dtype=float)


def apart(one, other):
    """Return mean and largest difference of two grids."""
    difference = np.abs(one - other)
    return float(difference.mean()), float(difference.max())


def alike(one, other):
    mean, largest = apart(one, other)
    return mean <= USUAL and largest <= LARGEST


@pytest.fixture(scope="module")
def taken(seen):
    """Return the pictures by name."""
    solid = seen[0]
    scene, _ = load_scene("bimorph_on_rod")
    display, _ = load_scene("display", ["display.rows=2", "display.columns=2"])
    first, second = (solid.state(f"mode {n}, short circuit") for n in (1, 2))
    plain = Picture(340, 600, shade=SHADES[0])
    return {
        "mode 1": still(solid, first, plain),
        "mode 1, half a period later": still(solid, first, plain, np.pi),
        "mode 2": still(solid, second, plain),
        "mode 1 by u_x": still(solid, first, Picture(340, 600, shade=SHADES[1])),
        "held end": mesh_picture(solid.mesh),
        "generator": solids_picture(scene_solids(scene)),
        "normal actuator": solids_picture(normal_actuator_solids(scene.device)),
        "display": assembly_picture(drawn_parts(display)),
    }


def test_the_held_end_is_drawn_to_scale_by_its_regions():
    """From the front right: as wide as both sides seen aslant; a fifth of the length fills it."""
    from PIL import Image

    x, y, z = np.linspace(0.0, 0.5e-3, 3), np.array([0.0, 1e-3]), np.linspace(0.0, 10e-3, 5)
    region = np.broadcast_to([[[0]], [[1]]], (2, 1, 4))
    mesh = box_tetrahedra(x, y, z, region, ("shim", "piezo_top"))
    with Image.open(io.BytesIO(mesh_picture(mesh))) as image:
        shown = np.asarray(image.convert("RGB"), dtype=float)
    width = (2.2 * 0.5 + 3.0 * 1.0) / np.hypot(3.0, 2.2)
    assert shown.shape[1] - 2 * 12 == pytest.approx(width * 840 / 2.2, abs=4.0)
    grey = np.ptp(shown, axis=2) < 20.0
    dark = grey & (shown.max(axis=2) < 100.0)
    assert 0.02 < dark.mean() < 0.4  # the shim, on the left
    assert np.flatnonzero(dark.any(axis=0)).mean() < 0.5 * shown.shape[1]
    assert 0.3 < (~grey).mean() < 0.95
    assert 700 < shown.shape[0] < 840  # the lower edge is in the picture, the upper one is not


@pytest.mark.heavy
def test_pictures_are_those_that_were_looked_at(taken):
    """All of them; and each is told apart from every other one."""
    grids = {name: grid(png) for name, png in taken.items()}
    if os.environ.get("TACTGEN_WRITE_GRIDS"):
        rows = {name: g.round().astype(int).reshape(ROWS, -1).tolist() for name, g in grids.items()}
        GRIDS.write_text(json.dumps(rows, separators=(",", ":")) + "\n", encoding="utf-8")
    known = json.loads(GRIDS.read_text(encoding="utf-8"))
    assert known.keys() == grids.keys()
    for name, found in grids.items():
        for other, rows in known.items():
            close = alike(found, np.array(rows, dtype=float).reshape(found.shape))
            assert close == (name == other), (name, other)
