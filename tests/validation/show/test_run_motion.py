"""A run seen: the body follows the coordinates, films repeat, time steps hold what they say."""

import shutil

import numpy as np
import pytest
from PIL import Image

from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.waveform import Sources, Step
from tactgen.validation.models.generator.transient import run_scene
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.show import run as run_motion
from tactgen.validation.show.gather import body_of
from tactgen.validation.show.run import write_run_film
from tactgen.validation.show.stills import save_film


@pytest.fixture(scope="module")
def found():
    """The rod leaves its stop, and the bimorph bends."""
    scene = load_scene("generator", [])[0]
    return run_scene(scene, Sources(Step(50.0), Step(0.15)), 2e-4, coil="current", accuracy=0.3)


@pytest.fixture(scope="module")
def body(found):
    return body_of(found)


def test_the_tip_is_where_the_run_says(found, body):
    tip = body.mesh.points[:, 2] > body.mesh.points[:, 2].max() - 1e-9
    moved = body.displacement(found.answer.run.position[-1])
    expected = found.answer.outputs["lateral_tip"][-1]
    assert abs(expected) > 1e-7
    assert moved[tip, 0] == pytest.approx(expected, rel=1e-12)
    assert moved[tip, 2].mean() == pytest.approx(found.answer.outputs["rod_lift"][-1], rel=1e-9)
    assert not moved[:, 1].any()


def test_lift_and_tilt_are_rigid_motions_of_the_whole(body):
    """u_x = −z ψ, u_z = u + x ψ on rod, coil and bimorph alike: no point strays from its place."""
    lift, tilt = 1e-4, 1e-3
    x, _, z = body.mesh.points.T
    moved = body.displacement(np.array([lift, 0.0, tilt, *np.zeros(body.lateral.shape[1] - 3)]))
    # the beam's rigid tilt is a solution of its stiffness matrix
    assert moved[:, 0] == pytest.approx(-z * tilt, rel=1e-6, abs=1e-12)
    assert moved[:, 2] == pytest.approx(lift + x * tilt, rel=1e-6, abs=1e-12)
    assert {"rod", "coil", "shim", "piezo_top"} <= set(body.mesh.regions)


@pytest.mark.heavy
def test_a_film_is_the_same_twice(found, tmp_path, monkeypatch):
    monkeypatch.setattr(run_motion, "_FRAMES", 5)
    paths = [tmp_path / name for name in ("one.gif", "two.gif")]
    for path in paths:
        write_run_film(path, found)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_films_need_their_program(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(InputError, match="ffmpeg"):
        save_film(tmp_path / "run.mp4", [Image.new("RGB", (8, 8))], 40)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="no ffmpeg on the path")
def test_an_mp4_is_made_by_ffmpeg_the_same_twice(tmp_path):
    pictures = [Image.new("RGB", (64, 48), (k * 60, 0, 0)) for k in range(4)]
    paths = [tmp_path / name for name in ("one.mp4", "two.mp4")]
    for path in paths:
        save_film(path, pictures, 40)
    assert paths[0].read_bytes()[4:8] == b"ftyp"
    assert paths[0].read_bytes() == paths[1].read_bytes()
