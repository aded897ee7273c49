"""The page of a run: its data are the run's, it asks for nothing, and a browser moves it."""

import base64
import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest
from approved import described, page_text

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.studies.transient.film import read_film
from tactgen.validation.view.browser import find_browser, run_browser
from tactgen.validation.view.run.page import PHASES, Film, film_payload, run_page


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


def reader(data):
    raw = zlib.decompress(base64.b64decode(data["blob"]), -15)
    kinds = {"f4": "<f4", "u4": "<u4"}
    return lambda at: np.frombuffer(raw, kinds[at["type"]], at["count"], at["offset"])


def test_the_pages_motion_is_the_runs(approved):
    """At each instant of the page the points are displaced as the run's coordinates say."""
    film = made_up()
    data = film_payload(film)
    read = reader(data)
    at = np.linspace(0.0, data["until"], data["samples"])
    motion = read(data["coordinates"]).reshape(-1, data["width"])
    along = motion @ read(data["lateral"]).reshape(-1, data["width"]).T
    up = motion @ read(data["axial"]).reshape(-1, data["width"]).T
    exact = 1e-6 * np.sin(4.0 * np.pi * at / 4e-3)
    # straight lines between the run's longest steps: (ω h)²/8 of the swing
    chord = (np.pi / 1e-3 * 3e-3 / 59) ** 2 / 8.0 * 1e-6
    assert along[:, 2] == pytest.approx(exact, abs=1.01 * chord)
    assert up[:, 1] == pytest.approx(-1e-4 * at / 4e-3 + 0.2 * exact, abs=1e-9)
    assert read(data["curves"][0]["values"]) == pytest.approx(1e6 * up[:, 0], rel=1e-5, abs=1e-6)
    phase = read(data["phase"])
    assert {PHASES[phase[0]], PHASES[phase[-1]]} == {PHASES[0], PHASES[3]}
    assert data["phases"][phase[-1]]["name"] == PHASES[3]
    # a blow shorter than the distance of two instants is not lost
    assert read(data["forces"][0]).max() == pytest.approx(7e3)
    approved(described({key: value for key, value in data.items() if key != "blob"}))


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


def test_the_page_asks_for_nothing_and_escapes_names(approved):
    text = run_page(made_up())
    assert "a &lt;device&gt; in time" in text
    assert "± 1 µm &amp; more" in text

    assert not re.search(r'(?:src|href)="(?!data:)', text)
    assert "default-src 'none'" in text
    data = re.search(r'id="tr-data">(.*?)</script>', text, re.DOTALL)[1]
    assert json.loads(data.replace("<\\/", "</"))["samples"] == 100
    approved(page_text(text))


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
