"""A run seen: its page has the run's data, the body follows the coordinates."""

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from tactgen.tmm.generator.transient.waveform import Sources, Step
from tactgen.validation.command_line.cli import main
from tactgen.validation.models.transient import run_scene
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show import run as run_motion
from tactgen.validation.show.browser import find_browser, run_browser
from tactgen.validation.show.gather import body_of
from tactgen.validation.show.pictures import save_film
from tactgen.validation.show.run import Film, film_payload, write_run_film


def made_up():
    """A triangle that is lifted by 0.1 mm and bends by a coordinate that swings twice."""
    time = np.concatenate([np.linspace(0.0, 1e-3, 40), np.linspace(1e-3, 4e-3, 60)])
    lift, bent = -1e-4 * time / 4e-3, 1e-6 * np.sin(4.0 * np.pi * time / 4e-3)
    blow = np.where(np.arange(100) == 33, 7.0, 0.0)
    return Film(
        scene="a <device>", time=time, coordinates=np.column_stack([lift, bent]),
        points=np.array([[0.0, 0.0, 0.0], [1e-3, 0.0, 0.0], [0.0, 0.0, 1e-2]]),
        triangles=np.array([[0, 1, 2]]), regions=("shim",), region_of_triangle=np.array([0]),
        lateral=np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 1.0]]),
        axial=np.array([[1.0, 0.0], [1.0, 0.2], [1.0, 0.0]]),
        curves={"rod": (lift, "µm", 1e-6), "voltage": (10.0 * bent, "V", 1.0)},
        forces=(blow, 0.0 * blow), phase=np.where(time < 2e-3, 0, 3), stroke=1e-4, rim=1e-3,
        words="± 1 µm & more",
    )  # fmt: skip


def test_what_is_drawn_is_of_a_size_that_is_seen():
    """The largest motions are drawn as the shares of the height that films use, rounded down."""
    film = made_up()
    drawn = film_payload(film)["drawn"]
    for factor, largest, share in ((drawn["lift"], 1e-4, 0.06), (drawn["lateral"], 1e-6, 0.12)):
        assert 0.4 * share <= factor * largest / 1e-2 <= share * 1.001
    # a rod that tilts more than the bimorph bends decides
    tilting = replace(film, axial=np.array([[1.0, 0.0], [1.0, 5.0], [1.0, 0.0]]))
    lateral = film_payload(tilting)["drawn"]["lateral"]
    assert 0.4 * 0.12 <= lateral * 5e-6 / 1e-2 <= 0.12 * 1.001
    still = replace(film, coordinates=0.0 * film.coordinates)
    assert np.isfinite(list(film_payload(still)["drawn"].values())).all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--run", "nowhere.nc"], "cannot be read (No such file or directory)"),
        (["--run", "nowhere.nc", "--model", "tmm"], "without --model"),
        (["--run", "nowhere.nc", "--set", "load.kind=none"], "without --set"),
        (["--run", "nowhere.nc", "--out", "film.gif"], "must end in .html"),
        (["--run", "text.nc"], "--run"),
    ],
)
def test_bad_runs_get_one_sentence(capsys, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.nc").write_text("no run", encoding="utf-8")
    assert main(["view", *arguments]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.err.count("\n") == 1
    assert not list(tmp_path.glob("*.html"))


@pytest.mark.heavy
def test_a_browser_moves_the_papers_run(tmp_path):
    """Fig 16's run: below 1.2 MB, no error, and another picture 4 ms later."""
    browser = find_browser()
    if browser is None:
        pytest.skip("no Chromium")
    from PIL import Image

    run, page = tmp_path / "run.nc", tmp_path / "run.html"
    drives = ["--voltage", "10 V sine 200 Hz", "--coil", "120 mA square 100 Hz"]
    assert main(["simulate", "generator", *drives, "--until", "12 ms", "--out", str(run)]) == 0
    assert main(["view", "--run", str(run), "--out", str(page)]) == 0
    assert page.stat().st_size < 1_200_000
    pictures = []
    for instant in ("0ms", "4ms"):
        shot = tmp_path / f"{instant}.png"
        done = run_browser(
            browser, f"{page.as_uri()}#{instant}", "--window-size=1200,800",
            "--virtual-time-budget=4000", "--enable-logging=stderr", f"--screenshot={shot}",
        )  # fmt: skip
        assert not re.search(r"Uncaught|Refused|net::ERR", done.stderr), done.stderr[-2000:]
        pictures.append(np.asarray(Image.open(shot).convert("RGB")).astype(float))
    body = [picture[60:440, 100:780] for picture in pictures]
    assert np.std(body[0]) > 5.0  # something is drawn
    assert np.mean(np.abs(body[1] - body[0]) > 40.0) > 2e-3  # and has moved


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


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="no ffmpeg on the path")
def test_an_mp4_is_made_by_ffmpeg_the_same_twice(tmp_path):
    pictures = [Image.new("RGB", (64, 48), (k * 60, 0, 0)) for k in range(4)]
    paths = [tmp_path / name for name in ("one.mp4", "two.mp4")]
    for path in paths:
        save_film(path, pictures, 40)
    assert paths[0].read_bytes()[4:8] == b"ftyp"
    assert paths[0].read_bytes() == paths[1].read_bytes()
