"""Files of fields and of the reduced solid."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from tactgen.fem.piezo import reduction_files as kept_reductions
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.export import export, write_port_files
from tactgen.validation.show.field_files import STEPS, moving_state, write_fields
from tactgen.validation.show.gather import gather


@pytest.fixture(scope="module")
def scene():
    return load_scene("j1", ["mesh.level=1", "modes=1", "models=solid"])[0]


@pytest.fixture(scope="module")
def result(scene, tmp_path_factory, few_bricks):
    """On few bricks, with a store of their own whose keys do not know."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("few")))
        patch.setattr(solid, "LEVELS", few_bricks)
        return gather(scene, ["solid"], (300.0,), "edges")[0]


def test_a_period_is_a_series_of_steps(result, tmp_path):
    """The eighth of 24 steps is at a third of the period, and has its phase."""
    path = tmp_path / "swing.pvd"
    write_fields(path, result)
    reader = pv.PVDReader(path)
    assert reader.time_values == pytest.approx(np.arange(STEPS) / STEPS / 300.0)
    reader.set_active_time_point(STEPS // 3)
    (block,) = reader.read()
    expected = (result.state("300 Hz").fields["displacement"] * np.exp(2j * np.pi / 3)).real
    assert block.point_data["300 Hz: displacement (m)"] == pytest.approx(expected)


def test_export_writes_both_or_none(tmp_path):
    """A scene with no bimorph is refused before anything is solved."""
    scene, _ = load_scene("j1", ["modes=1", "models=tmm"])
    files = {"fields": tmp_path / "f.vtu", "animated_glb": tmp_path / "f.glb"}
    for models, words in (("network", "neither a bimorph"), ("axisymmetric", "is for what moves")):
        lonely, _ = load_scene("reluctance", [f"models={models}"])
        with pytest.raises(InputError, match=words):
            export(lonely, files, lambda _: None)
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match=r"--fields .* must end in .vtu or .vtkhdf or .pvd"):
        export(scene, {"fields": tmp_path / "f.txt"}, lambda _: None)
    export(scene, files, lambda _: None)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["f.glb", "f.vtu"]


def test_what_moves_is_the_first_driven_state_else_the_first(result):
    """Of modes alone the first."""
    assert moving_state(result).kind == "harmonic"
    modes = tuple(state for state in result.states if state.kind == "mode")
    assert moving_state(replace(result, states=modes)) is modes[0]


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_nothing_is_reduced_anew(monkeypatch, tmp_path):
    """One accuracy and one band give one reduction; the file is of the scene's finer mesh."""
    scene, _ = load_scene("prototype", ["models=solid", "mesh.level=2", "frequency=10,300"])
    solve(scene, ("solid",), ("tip_displacement",))
    monkeypatch.setattr(kept_reductions, "reduce_to_ports", None)
    files = {kind: tmp_path / f"{kind}.npz" for kind in ("ports", "state_space")}
    write_port_files(scene, files)
    for file in files.values():
        with np.load(file) as held:
            assert all(np.all(np.isfinite(held[n])) for n in held if held[n].dtype.kind in "fc")
