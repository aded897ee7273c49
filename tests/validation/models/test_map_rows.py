"""Rows of the 3D map on disk: solved once, read back whole, solved again if damaged."""

import numpy as np
import pytest

from geometry.device.parameters import Device
from geometry.reluctance.sector_tets import Sector
from validation.engine.solve import solve
from validation.models.reluctance import map_rows as solid_map_rows
from validation.scene.scene import load_scene


def test_a_row_is_solved_once(tmp_path, monkeypatch):
    """The second call reads; other currents or a damaged file are solved again."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path))
    calls = []

    def counted(*arguments):
        calls.append(arguments)
        return original(*arguments)

    original = solid_map_rows.solve_row
    monkeypatch.setattr(solid_map_rows, "solve_row", counted)
    arguments = ("key", Device(), 0.2e-3, np.array([0.0, 0.1]), Sector(refinement=0.5))
    first, second = (solid_map_rows.kept_row(*arguments) for _ in range(2))
    assert first == second
    assert len(calls) == 1
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    for damaged in (whole[: len(whole) // 2], b"[{}]", b"[1]", b"{}", b"\xff"):
        file.write_bytes(damaged)
        assert solid_map_rows.kept_row(*arguments) == first
    assert len(calls) == 6


@pytest.mark.heavy
def test_the_3d_map_switches_like_the_half_sections(tmp_path, monkeypatch):
    """Map, pull-in and holding current in 3D, by rows that are kept, within the error bars of
    the axisymmetric field's; the map itself to what it says of its interpolation."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path))
    scene, _ = load_scene("reluctance", ["models=magnetic3d,axisymmetric", "accuracy=5%"])
    names = ("pull_in_current", "holding_current")
    solution = solve(scene, None, names)
    for name in names:
        solid, half = (solution.get(name, model) for model in ("magnetic3d", "axisymmetric"))
        bar = float(solid.uncertainty) + float(half.uncertainty)
        assert abs(float(solid.value) - float(half.value)) <= bar
        assert bar < 0.06 * float(half.value)
    maps = [solution.models[m].map() for m in ("magnetic3d", "axisymmetric")]
    for current, gap in ((0.05, 0.1e-3), (0.13, 0.2e-3), (0.02, 0.03e-3)):
        forces = [float(found.force(current, gap)) for found in maps]
        allowed = sum(found.interpolation_error.force for found in maps) + 0.03
        assert abs(forces[0] / forces[1] - 1.0) < allowed
    assert len(list(tmp_path.glob("*.json"))) == 6
