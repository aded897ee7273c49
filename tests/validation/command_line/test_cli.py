"""The command line as other programs see it: output, exit codes, what it imports."""

import json
import re
import shlex
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.shim_library import SHIMS
from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.export import export


def run(capsys, *arguments):
    """Return exit code, stdout and stderr of a call in this process."""
    code = main(list(arguments))
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_tmm_answer_loads_no_heavy_library():
    """A cold transfer-matrix answer imports neither CAD, nor VTK, nor finite elements."""
    script = (
        "import sys; from tactgen.validation.command_line.cli import main; "
        "code = main(['solve', 'paper', '--model', 'tmm', '--quantity', 'tip_velocity', "
        "'--frequency', '10:2000:200', '--json']); "
        "heavy = [m for m in ('cadquery', 'OCP', 'vtk', 'vtkmodules', 'pyvista', 'skfem', "
        "'scipy.sparse', 'scipy.linalg', 'scipy.optimize', 'matplotlib', 'meshio', 'pytetwild', "
        "'pint', "
        "'tactgen.fem.piezo', 'tactgen.fem.beam', 'tactgen.fem.magnetics') "
        "if m in sys.modules]; "
        "print(heavy, file=sys.stderr); sys.exit(code)"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert result.stderr.strip().endswith("[]")
    (quantity,) = json.loads(result.stdout)["quantities"]
    assert len(quantity["value"]) == len(quantity["frequency"]) == 200


def test_solve_json_contract(capsys):
    """Keys, complex numbers as pairs, arrays as lists, classes of modes, the plan."""
    code, out, err = run(
        capsys, "solve", "prototype", "--model", "tmm", "--model", "lumped",
        "--quantity", "tip_velocity", "--quantity", "short_circuit_frequencies",
        "--quantity", "dynamic_stiffness", "--quantity", "capacitance_free",
        "--frequency", "10,781.609", "--json",
    )  # fmt: skip
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert result["scene"] == "prototype"
    assert {"run", "skipped"} <= set(result["plan"])
    entries = {(q["name"], q["model"]): q for q in result["quantities"]}
    keys = {"name", "model", "value", "unit", "uncertainty", "uncertainty_method", "seconds"}
    assert all(keys <= set(q) for q in entries.values())
    velocity = entries["tip_velocity", "tmm"]
    assert velocity["frequency"] == [10.0, 781.609]
    assert abs(complex(*velocity["value"][1])) == pytest.approx(0.0227950, rel=1e-5)
    assert entries["short_circuit_frequencies", "tmm"]["classes"] == ["bending_x"] * 4
    matrix = entries["dynamic_stiffness", "lumped"]["value"]
    assert (len(matrix), len(matrix[0]), len(matrix[0][0]), len(matrix[0][0][0])) == (2, 5, 5, 2)
    assert isinstance(entries["capacitance_free", "tmm"]["value"], float)


def test_warnings_are_on_stderr(capsys):
    """A key that the chosen kinds ignore, a tenth of the length; the number stays."""
    asked = ["solve", "--model", "tmm", "--quantity", "static_tip_displacement", "--json"]
    code, _, err = run(capsys, *asked)
    assert (code, "all models are linear" in err) == (0, False)
    wrong = ["--set", "drive.voltage=2100 V", "--set", "load.stiffness=100 N/m"]
    code, out, err = run(capsys, *asked, *wrong)
    assert code == 0
    assert json.loads(out)["quantities"][0]["value"] > 2e-3
    assert err.startswith("tactgen: warning: load.stiffness = 100 N/m has no effect")
    assert "10 % of the length; all models are linear" in err


@pytest.mark.parametrize(
    ("command", "redirection", "code", "words"),
    [
        pytest.param(
            command, redirection, code, words,
            marks=[] if command == "scenes" else [pytest.mark.heavy],
        )
        for command in ("scenes", "solve --model tmm --json")
        for redirection, code, words in (
            (">/dev/full", 2, "standard output cannot be written (no space left on device)"),
            (">&-", 2, "standard output is closed"),
            ("2>&-", 0, ""),
        )
    ],
)  # fmt: skip
def test_output_that_cannot_be_written(redirection, code, words, command):
    """A full disk or a closed stream is one sentence, no traceback, also at exit."""
    shell = f"{shlex.quote(sys.executable)} -m tactgen {command} {redirection}"
    result = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, check=False)
    assert result.returncode == code, result.stderr
    assert words in result.stderr
    assert result.stderr.count("\n") == (1 if code else 0)
    assert bool(result.stdout) == (code == 0)


def test_unsolvable_scene_is_one_sentence_and_no_mistake_of_ours(capsys, monkeypatch):
    """Only failures that input can cause name the scene and what to change."""

    def fail(*_args, **_options):
        raise error

    monkeypatch.setattr("tactgen.validation.engine.solve.solve", fail)
    error = np.linalg.LinAlgError("Singular matrix")
    code, out, err = run(capsys, "solve", "prototype")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert 'scene "prototype" cannot be solved (Singular matrix); bring' in err
    assert "--set models=" in err
    error = KeyError("x")
    with pytest.raises(KeyError):
        main(["solve"])


def test_export_checks_all_places_first(capsys, tmp_path):
    """A folder, a place named twice, a missing folder: nothing is written at all."""
    good, folder = tmp_path / "a.step", tmp_path / "b.glb"
    folder.mkdir()
    for arguments, words in (
        (["--step", good, "--glb", folder], "it is a folder"),
        (["--step", good, "--glb", tmp_path / "no" / "c.glb"], "does not exist"),
        (["--step", good, "--mesh", tmp_path / ("x" * 300 + ".vtu")], "name too long"),
    ):
        code, out, err = run(capsys, "export", *map(str, arguments))
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert words in err
    assert not good.exists()


def test_export_writes_all_or_nothing(tmp_path, monkeypatch):
    """If a later file fails, the earlier ones do not appear, nor their drafts."""

    def fail(_mesh, path):
        raise InputError(f"{path} cannot be written")

    monkeypatch.setattr("tactgen.geometry.meshing.mesh_files.write_mesh", fail)
    monkeypatch.setattr(
        "tactgen.validation.models.bimorph.solid.mesh_pair",
        lambda _: SimpleNamespace(meshes=(SimpleNamespace(faces={}),) * 2),
    )
    monkeypatch.setattr(
        "tactgen.validation.show.export._export_solids",
        lambda _scene, files, _announce: files["step"].write_text("solid"),
    )
    targets = {"step": tmp_path / "a.step", "mesh": tmp_path / "a.vtu"}
    with pytest.raises(InputError) as caught:
        export(load_scene("j1")[0], targets, lambda _: None)
    assert str(caught.value) == f"{targets['mesh']} cannot be written"
    assert list(tmp_path.iterdir()) == []


def test_init_refuses_to_overwrite(capsys, tmp_path):
    """A scene that somebody wrote is not lost."""
    target = tmp_path / "mine.toml"
    assert run(capsys, "init", str(target))[0] == 0
    before = target.read_text(encoding="utf-8")
    code, _, err = run(capsys, "init", str(target))
    assert code == 2
    assert "exists already" in err
    assert target.read_text(encoding="utf-8") == before
    assert run(capsys, "solve", str(target), "--model", "tmm", "--quantity", "admittance")[0] == 0


def test_materials_are_listed_and_shown(capsys, tmp_path):
    """All in a line each, one with its constants, and what the constants of a scene come to."""
    listed = run(capsys, "materials")[1].splitlines()
    assert len(listed) == len(LIBRARY) + len(SHIMS) + 1
    code, out, _ = run(capsys, "materials", "navy II")
    assert code == 0
    assert "s11 1.64e-11 m^2/N; d31 -171 pC/N" in out
    assert "source: PZT-5A, Berlincourt" in out
    constants = re.search("constants: (.*)", out)[1]
    file = tmp_path / "mine.toml"
    file.write_text(f'[piezo]\nmaterial = "PZT-4"\nconstants = "{constants}"\n')
    found, shim = json.loads(run(capsys, "materials", str(file), "--json")[1])
    assert shim["name"] == "CFRP"
    # the constants are printed to four digits
    assert found["s11"] == pytest.approx(LIBRARY["PZT-5A"].s[0, 0], rel=1e-3)
    assert found["d31"] == pytest.approx(LIBRARY["PZT-5A"].d[2, 0], rel=1e-3)
    code, _, err = run(capsys, "materials", "pzt5")
    assert code == 2
    assert 'did you mean "PZT-5H"' in err


def test_closed_pipe_is_no_error():
    """`tactgen scenes | head -1` ends quietly."""
    command = f"{shlex.quote(sys.executable)} -m tactgen scenes | true"
    result = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert result.stderr == ""
