"""``tactgen identify``: output, files, exit codes, what bad input is told."""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.curve_fit import CurveModel


def run(capsys, *arguments):
    """Return exit code, stdout and stderr of a call in this process."""
    code = main(["identify", *map(str, arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """Return the file of a prototype's synthetic sweep: magnitudes, 2 % noise, which is stated."""
    scene, _ = load_scene("prototype")
    f = np.linspace(100.0, 1500.0, 40)
    exact = 1e3 * np.abs(CurveModel(scene, "tip_velocity", f, ())(np.zeros(0)))
    values = exact * (1.0 + 0.02 * np.random.default_rng(1).standard_normal(40))
    rows = [f"{a:.6g};{b:.6g};{c:.6g}" for a, b, c in zip(f, values, 0.02 * exact, strict=True)]
    path = tmp_path_factory.mktemp("measured") / "sweep.csv"
    header = "# synthetic\nfrequency (Hz);velocity (mm/s);uncertainty (mm/s)\n"
    path.write_text(header + "\n".join(rows) + "\n", encoding="utf-8")
    return path


def test_what_people_read(capsys, sweep, tmp_path):
    """A stated uncertainty turns the misfit into chi2; --noise then has nothing to say."""
    plot = tmp_path / "x.png"
    code, out, err = run(capsys, sweep, "--plot", plot)
    assert (code, err) == (0, "")
    assert "magnitude only" in out
    assert "chi2 per degree of freedom" in out
    assert plot.read_bytes().startswith(b"\x89PNG")
    code, _, err = run(capsys, sweep, "--noise", "relative")
    assert code == 2
    assert "states its uncertainty" in err


def test_written_scene_is_the_fitted_one(capsys, sweep, tmp_path):
    """--write gives a scene that loads, with the fitted values and all that the start set."""
    path, plot = tmp_path / "fitted.toml", tmp_path / "a.svg"
    arguments = ["--set", "piezo.density=8000 kg/m^3", "--set", "models=tmm", "--write", path]
    code, out, _ = run(capsys, sweep, *arguments, "--plot", plot, "--json")
    assert code == 0
    found = json.loads(out)
    assert found["noise"]["level"] is None
    # 99.9 % of chances with 38 degrees of freedom
    assert 0.4 < found["noise"]["reduced_chi2"] < 1.8
    scene, _ = load_scene(str(path))
    values = {p["name"]: p["value"] for p in found["parameters"]}
    assert scene.support.rotational_stiffness == pytest.approx(values["c_s"], rel=1e-9)
    assert scene.support.rotational_damping == pytest.approx(values["d_s"], rel=1e-9)
    start, _ = load_scene("prototype", ["piezo.density=8000 kg/m^3"])
    assert scene.device == start.device
    assert (scene.load, scene.drive, scene.models) == (start.load, start.drive, ("tmm",))
    assert "95 % interval" in path.read_text(encoding="utf-8")
    assert ET.parse(plot).getroot().tag.endswith("svg")
    code, _, err = run(capsys, sweep, "--write", path)
    assert code == 2
    assert "exists already" in err
