"""The reduced solid as files: made of what ``tactgen solve`` has reduced already."""

import numpy as np
import pytest

from tactgen.fem.bimorph.reduction import kept_reductions
from tactgen.validation.engine.solve import solve
from tactgen.validation.export.ports import write_port_files
from tactgen.validation.scene.scene import load_scene


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
