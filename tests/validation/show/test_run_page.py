"""The page of a run: its data are the run's, it asks for nothing, and a browser moves it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.show.browser import find_browser, run_browser
from tactgen.validation.show.run import Film, film_payload
from tactgen.validation.studies.simulate import read_film


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


def test_another_netcdf_is_refused(tmp_path):
    from scipy.io import netcdf_file

    with netcdf_file(str(tmp_path / "map.nc"), "w") as file:
        file.title = "something else"
    with pytest.raises(InputError, match="no run of a generator"):
        read_film(tmp_path / "map.nc")


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
