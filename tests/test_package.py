"""What `pip install` gives: one import name, the command, and the same answers."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The wheel's content, unpacked where nothing else is."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as content:
        content.extractall(folder / "site")
    return folder / "site"


def run(installed, *command):
    """Run Python away from the checkout, the wheel before everything else."""
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    return subprocess.run(
        [sys.executable, *command],
        cwd=installed.parent, env=environment, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip


def test_everything_is_under_one_name(installed):
    """No package of a name that others use lands at the top."""
    names = {path.name for path in installed.iterdir() if not path.name.endswith(".dist-info")}
    assert names == {"tactgen"}
    assert (installed / "tactgen" / "validation" / "scene" / "scenes" / "paper.toml").is_file()


def test_import_and_command(installed):
    """`import tactgen` is the wheel's; the command's entry point is there and gives JSON."""
    (points,) = installed.glob("*.dist-info/entry_points.txt")
    name, module, function = points.read_text().replace("=", " ").replace(":", " ").split()[1:]
    assert name == "tactgen"
    script = (
        f"import sys, tactgen; from {module} import {function}; "
        "print(tactgen.__file__, flush=True); sys.argv[1:] = ['solve', '--model', 'tmm', '--json', "
        f"'--quantity', 'static_tip_displacement']; sys.exit({function}())"
    )
    place, _, answer = run(installed, "-c", script).partition("\n")
    assert Path(place).is_relative_to(installed)
    assert 4e-5 < json.loads(answer)["quantities"][0]["value"] < 6e-5


def test_unknown_names_are_no_attributes():
    """The lazy package fails as any other."""
    import tactgen

    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        tactgen.nothing  # noqa: B018
