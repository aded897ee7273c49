"""``tactgen design`` as people and programs call it."""

import json
import subprocess
import sys

import numpy as np
import pytest

from tactgen.validation.command_line.cli import main


def run(capsys, *arguments):
    """Return exit code, stdout and stderr of a call in this process."""
    code = main(["design", *arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def refuse(token):
    raise AssertionError(f"{token} is no JSON")


def test_table_and_statement_on_stdout(capsys):
    """What was found, all feasible lengths, the scene's own, the map, the sensitivities."""
    code, out, err = run(capsys)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == "Driven with 50 V, wired in parallel, under the finger."
    assert lines[1].startswith("The shortest length of 20 mm to 40 mm that keeps |w| / threshold")
    assert lines[2].startswith("Lengths that keep the margin: 22.643 mm")
    assert lines[3].startswith("The scene's own length, 20 mm, has |w| / threshold 0.76")
    assert "stated at 10, 250 and 1000 Hz; between them it is interpolated" in lines[4]
    assert sum(" mm " in line and " µm " in line for line in lines) == 9
    assert " um" not in out
    assert "-0.000" not in out
    assert any(line.startswith("piezo.density") and "assumed" in line for line in lines)
    assert lines[-1].startswith("less than 0.0005: ")


@pytest.mark.parametrize(
    "arguments",
    [
        ["--aim", "margin"],
        ["--margin", "50"],
        pytest.param([], marks=pytest.mark.heavy),
        pytest.param(["prototype"], marks=pytest.mark.heavy),
    ],
)
def test_json_contract(capsys, arguments):
    """Strict JSON in SI units, whatever decides the length; exit code 0 also if none keeps it."""
    code, out, err = run(capsys, "--json", *arguments)
    assert (code, err) == (0, "")
    found = json.loads(out, parse_constant=refuse)
    assert set(found) == {
        "scene", "setting", "aim", "length", "margin", "frequency", "limit", "feasible", "present",
        "map", "sensitivity", "statements", "warnings",
    }  # fmt: skip
    assert found["limit"] in {"threshold", "peak", "end", "compromise"}
    assert 20e-3 <= found["length"] <= 40e-3
    assert set(found["setting"]) == {"voltage", "wiring", "load"}
    columns = len(found["sensitivity"]["lengths"])
    assert all(len(p["slopes"]) == columns for p in found["sensitivity"]["parameters"])
    assert all(point["source"].startswith("paper") for point in found["aim"]["threshold"])
    assert [row["length"] for row in found["map"]] == pytest.approx(
        np.arange(20e-3, 41e-3, 2.5e-3), rel=1e-12
    )


def test_the_scenes_own_drive_and_load_are_named(capsys):
    """The prototype's 1 V and free tip decide; its 14 mm lie outside the range searched."""
    code, out, _ = run(capsys, "prototype")
    assert code == 0
    assert out.startswith("Driven with 1 V, wired in parallel, with a free tip.\n")
    assert "The scene's own length, 14 mm, outside that range, has" in out


def test_units_at_the_edge(capsys):
    """The band takes Hz and kHz, the lengths any length."""
    one = run(capsys, "--band", "50Hz:0.5kHz", "--lengths", "2cm:40mm", "--json")
    other = run(capsys, "--band", "50:500", "--lengths", "0.02m:40mm", "--json")
    assert one == other
    assert one[0] == 0


def test_overrides_reach_the_design(capsys):
    """Half the voltage asks for a longer actuator."""
    lengths = [
        json.loads(run(capsys, "--json", *extra)[1])["length"]
        for extra in ([], ["--set", "drive.voltage=25V"])
    ]
    assert lengths[0] < lengths[1]


def test_stubby_lengths_warn(capsys):
    """A beam five times as long as thick: answered, with a warning on stderr and in the JSON."""
    code, out, err = run(capsys, "--lengths", "2mm:40mm", "--json")
    assert code == 0
    assert "warning: at 4.0" in err
    assert "too stubby" in json.loads(out)["warnings"][0]


def test_plot_is_a_whole_svg(capsys, tmp_path):
    """One SVG element, the same bytes every time."""
    files = [tmp_path / "a.svg", tmp_path / "b.svg"]
    for file in files:
        assert run(capsys, "--lengths", "22mm:24mm", "--plot", str(file))[0] == 0
    text = files[0].read_text(encoding="utf-8")
    assert text.startswith("<svg")
    assert text.rstrip().endswith("</svg>")
    assert text == files[1].read_text(encoding="utf-8")
    assert sorted(tmp_path.iterdir()) == files


def test_design_loads_no_finite_elements():
    """CAD, VTK and finite elements stay out; matplotlib too if nothing is drawn."""
    script = (
        "import sys; from tactgen.validation.command_line.cli import main; "
        "code = main(['design', '--lengths', '22mm:23mm', '--json']); "
        "heavy = [m for m in ('cadquery', 'OCP', 'vtk', 'vtkmodules', 'pyvista', 'skfem', "
        "'matplotlib', 'meshio', 'pytetwild', 'tactgen.fem.bimorph', 'tactgen.fem.reluctance', "
        "'tactgen.fem.beam') "
        "if m in sys.modules]; "
        "print(heavy, file=sys.stderr); sys.exit(code)"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert result.stderr.strip().endswith("[]")
