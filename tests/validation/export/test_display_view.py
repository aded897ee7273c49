"""``tactgen view display``: a film of the wave, drawn once for all its files, and a still."""

import itertools
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from approved import described, page_text
from PIL import Image, ImageSequence
from unpainted import as_text, unpainted

from tactgen.validation.export import display_view
from tactgen.validation.export.display_view import drawn_parts, travelling_wave, view_display
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.view import assembly_frames
from tactgen.validation.view.page.html import inline

SMALL = ["display.rows=1", "display.columns=2", "frequency=10,430", "models=tmm"]


@pytest.fixture(scope="module")
def scene():
    return load_scene("display", SMALL)[0]


@pytest.fixture(scope="module")
def boxes(scene):
    """Return the display's parts as boxes: how solids are cut into triangles is the kernel's."""
    ends = np.array(list(itertools.product((0, 1), repeat=3)))
    found = []
    for part in drawn_parts(scene):
        low, high = part.points.min(axis=0), part.points.max(axis=0)
        assert part.triangles.min() == 0
        assert part.triangles.max() == len(part.points) - 1
        corners = np.round(low + ends * (high - low), 6)
        found.append(replace(part, points=corners, triangles=np.array([[0, 1, 2], [5, 6, 7]])))
    return tuple(found)


@pytest.fixture
def kept(monkeypatch, boxes):
    """Return what pictures are told to draw, which is nothing but boxes."""
    monkeypatch.setattr(display_view, "drawn_parts", lambda _: boxes)
    return unpainted(monkeypatch)


def test_each_column_follows_the_one_before(scene):
    """By a quarter period, but for what passes between them; at the livelier frequency."""
    frequency, tips = travelling_wave(scene)
    assert frequency in scene.frequency
    behind = np.degrees(np.angle(tips[1] / tips[0]))
    assert behind == pytest.approx(-90.0, abs=35.0)
    assert 1e-6 < np.abs(tips).max() < 1e-3


def test_a_film_is_drawn_once(scene, kept, tmp_path, monkeypatch, approved):
    """Both files hold its pictures: tips elsewhere in each, words, what stands round left out."""
    saved, said = [], []
    monkeypatch.setattr(display_view, "_FRAMES", 3)
    monkeypatch.setattr(display_view, "check_ffmpeg", lambda _: None)
    monkeypatch.setattr(display_view, "save_film", lambda *given: saved.append(given))
    files = {"gif": tmp_path / "a.gif", "mp4": tmp_path / "a.mp4"}
    assert view_display(scene, files, said.append) == list(files.values())
    assert [path for path, *_ in saved] == list(files.values())
    assert saved[0][1] is saved[1][1]
    assert [len(saved[0][1]), *saved[0][2:]] == [3, 80, 4]
    approved("\n".join([*said, as_text(kept)]))


def test_a_page_and_a_still(scene, boxes, kept, tmp_path, approved):
    """The whole display at rest, its page with parts and motions."""
    said = []
    files = {"out": tmp_path / "a.html", "png": tmp_path / "a.png"}
    assert view_display(scene, files, said.append) == list(files.values())
    page = files["out"].read_text(encoding="utf-8")
    data = json.loads(re.search(r'id="td-data">(.*?)</script>', page, re.DOTALL)[1])
    del data["parts"]
    parts = [
        [part.name, part.moves, part.colour, part.points[[0, -1]], part.places] for part in boxes
    ]
    approved("\n".join([*said, page_text(page), described([data, parts]), as_text(kept)]))
    assert files["png"].read_bytes().startswith(b"\x89PNG")
    assert inline(files["png"].read_bytes()) in page


def test_a_gif_goes_round(scene, tmp_path, monkeypatch):
    """Its pictures, each shown for 80 ms, without end."""
    plain = [Image.new("RGB", (16, 16)) for _ in range(3)]
    for k, image in enumerate(plain):
        image.putpixel((k, 0), (250, 0, 0))
    monkeypatch.setattr(display_view, "_film", lambda *_: plain)
    path = tmp_path / "a.gif"
    view_display(scene, {"gif": path}, lambda _: None)
    with Image.open(path) as film:
        assert film.info["loop"] == 0
        shown = [frame.info["duration"] for frame in ImageSequence.Iterator(film)]
    assert shown == [80, 80, 80]


def test_motions_are_enlarged_to_a_share_of_the_pitch():
    """Whatever their size; none where nothing moves."""
    for tips, pitch in ((np.array([1e-6, -3e-6j]), 2.4), (np.array([5e-3]), 10.0)):
        drawn = 1e3 * np.abs(tips).max() * assembly_frames.enlargement(tips, pitch)
        assert 0.1 * pitch < drawn < 0.5 * pitch  # seen, and clear of the neighbour
        assert drawn == pytest.approx(pitch * assembly_frames.enlargement(np.array([1e-3]), 1.0))
    assert assembly_frames.enlargement(np.zeros(2), 2.4) == 0.0
