"""The reduced solid as files: made of what ``tactgen solve`` has reduced already."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.piezo import reduction_files as kept_reductions
from tactgen.fem.piezo import state_space as state_space_file
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.show.export import write_port_files


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


@dataclass(frozen=True)
class Made:
    """A reduced solid, as far as its wiring goes."""

    stiffness: np.ndarray


@pytest.mark.parametrize(
    ("settings", "bounds", "last"),
    [
        (["frequency=10,300"], (10.0, 300.0), [1.0, 1.0, 1.0]),
        (["frequency=0,2,3000", "support.kind=clamped"], (3.0, 3000.0), [1.0, 1.0, 1.0]),
        (["frequency=200", "bimorph.wiring=series"], (200.0, 200.0), [0.5, 0.5, 0.25]),
    ],
)
def test_the_state_space_is_of_the_scenes_band_and_wiring(
    settings, bounds, last, monkeypatch, tmp_path
):
    """Down to a thousandth of the highest frequency; in series each layer takes half of U."""
    given = []
    reduced = SimpleNamespace(fine=Made(np.ones((3, 3))))
    monkeypatch.setattr(
        "tactgen.validation.models.bimorph.solid.mesh_pair",
        lambda scene: SimpleNamespace(meshes=("fine", "coarse")),
    )
    monkeypatch.setattr(
        kept_reductions,
        "reduced_solid",
        lambda *a, **b: given.append((a[1], a[2].tolist(), b)) or reduced,
    )
    monkeypatch.setattr(
        state_space_file, "write_state_space", lambda file, *a: given.append((file.name, *a))
    )
    scene, _ = load_scene("prototype", ["accuracy=1e-2", *settings])
    write_port_files(scene, {"state_space": tmp_path / "s.npz"})
    assert given[0] == ("fine", list(scene.frequency), {"tolerance": pytest.approx(1e-5)})
    file, model, base, band = given[1]
    assert (file, base, band) == ("s.npz", scene.ends.base, pytest.approx(bounds))
    np.testing.assert_array_equal(model.stiffness[-1], last)
    np.testing.assert_array_equal(model.stiffness[:, -1], last)
    np.testing.assert_array_equal(model.stiffness[:2, :2], 1.0)
    np.testing.assert_array_equal(reduced.fine.stiffness, 1.0)
