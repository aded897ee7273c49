"""``tactgen design`` as people and programs call it."""

import json
import subprocess
import sys

from tactgen.validation.command_line.cli import main


def run(capsys, *arguments):
    """Return exit code, stdout and stderr of a call in this process."""
    code = main(["design", *arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


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
        "'matplotlib', 'meshio', 'pytetwild', 'tactgen.fem.piezo', 'tactgen.fem.magnetics', "
        "'tactgen.fem.beam') "
        "if m in sys.modules]; "
        "print(heavy, file=sys.stderr); sys.exit(code)"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert result.stderr.strip().endswith("[]")
