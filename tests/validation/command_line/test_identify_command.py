"""``tactgen identify``: output, files, exit codes, what bad input is told."""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.curve_fit import curve_model
from tactgen.validation.studies.identify import identify
from tactgen.validation.studies.identify_output import write_plot
from tactgen.validation.studies.measured_data import read_measured


def run(capsys, *arguments):
    """Return exit code, stdout and stderr of a call in this process."""
    code = main(["identify", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """Return the file of a prototype's synthetic sweep: 2 % noise, magnitude and phase."""
    frequencies = np.linspace(10.0, 2000.0, 80)
    exact = curve_model(load_scene("prototype")[0], "tip_velocity", frequencies, ())(np.zeros(0))
    rng = np.random.default_rng(11)
    errors = rng.standard_normal(80) + 1j * rng.standard_normal(80)
    values = 1e3 * exact * (1.0 + 0.02 * errors)
    rows = [
        f"{f:.6g},{abs(v):.6g},{np.degrees(np.angle(v)):.5g}"
        for f, v in zip(frequencies, values, strict=True)
    ]
    path = tmp_path_factory.mktemp("measured") / "sweep.csv"
    header = "# synthetic\nfrequency (Hz),velocity (mm/s),velocity_phase (deg)\n"
    path.write_text(header + "\n".join(rows) + "\n", encoding="utf-8")
    return path


def test_uncertainty_in_table_and_json(capsys, tmp_path):
    """A stated uncertainty turns the misfit into chi2; --noise then has nothing to say."""
    scene, _ = load_scene("prototype")
    f = np.linspace(100.0, 1500.0, 40)
    exact = 1e3 * np.abs(curve_model(scene, "tip_velocity", f, ())(np.zeros(0)))
    values = exact * (1.0 + 0.02 * np.random.default_rng(1).standard_normal(40))
    rows = [f"{a:.6g};{b:.6g};{c:.6g}" for a, b, c in zip(f, values, 0.02 * exact, strict=True)]
    path = tmp_path / "x.csv"
    header = "frequency (Hz);velocity (mm/s);uncertainty (mm/s)\n"
    path.write_text(header + "\n".join(rows), encoding="utf-8")
    code, out, err = run(capsys, path)
    assert (code, err) == (0, "")
    assert "magnitude only" in out
    assert "chi2 per degree of freedom" in out
    noise = json.loads(run(capsys, path, "--json")[1])["noise"]
    assert noise["level"] is None
    assert 0.4 < noise["reduced_chi2"] < 1.8  # 99.9 % of chances with 38 degrees of freedom
    code, _, err = run(capsys, path, "--noise", "relative")
    assert code == 2
    assert "states its uncertainty" in err


def test_written_scene_is_the_fitted_one(capsys, sweep, tmp_path):
    """--write gives a scene that loads, with the fitted values and all that the start set."""
    path = tmp_path / "fitted.toml"
    arguments = ["--set", "piezo.density=8000 kg/m^3", "--set", "models=tmm", "--write", path]
    code, out, _ = run(capsys, sweep, *arguments, "--json")
    assert code == 0
    scene, _ = load_scene(str(path))
    values = {p["name"]: p["value"] for p in json.loads(out)["parameters"]}
    assert scene.support.rotational_stiffness == pytest.approx(values["c_s"], rel=1e-9)
    assert scene.support.rotational_damping == pytest.approx(values["d_s"], rel=1e-9)
    start, _ = load_scene("prototype", ["piezo.density=8000 kg/m^3"])
    assert scene.device == start.device
    assert (scene.load, scene.drive, scene.models) == (start.load, start.drive, ("tmm",))
    assert "95 % interval" in path.read_text(encoding="utf-8")
    code, _, err = run(capsys, sweep, "--write", path)
    assert code == 2
    assert "exists already" in err


def test_plots(capsys, sweep, tmp_path):
    """--plot writes a well-formed SVG, the same every time, or a PNG."""
    first, second, image = (tmp_path / name for name in ("a.svg", "b.svg", "c.png"))
    assert run(capsys, sweep, "--plot", first)[0] == 0
    found = identify(load_scene("prototype")[0], read_measured(sweep))
    for path in (second, image):
        write_plot(found, path)
    assert ET.parse(first).getroot().tag.endswith("svg")
    assert first.read_bytes() == second.read_bytes()
    assert image.read_bytes().startswith(b"\x89PNG")
