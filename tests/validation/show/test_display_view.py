"""``tactgen view display``: a film of the wave, drawn once for all its files, and a still."""

import numpy as np
import pytest
from PIL import Image, ImageSequence

from tactgen.validation.scene.scene import load_scene
from tactgen.validation.show import display as assembly_frames
from tactgen.validation.show import display as display_view
from tactgen.validation.show.display import travelling_wave, view_display

SMALL = ["display.rows=1", "display.columns=2", "frequency=10,430", "models=tmm"]


@pytest.fixture(scope="module")
def scene():
    return load_scene("display", SMALL)[0]


def test_each_column_follows_the_one_before(scene):
    """By a quarter period, but for what passes between them; at the livelier frequency."""
    frequency, tips = travelling_wave(scene)
    assert frequency in scene.frequency
    behind = np.degrees(np.angle(tips[1] / tips[0]))
    assert behind == pytest.approx(-90.0, abs=35.0)
    assert 1e-6 < np.abs(tips).max() < 1e-3


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
