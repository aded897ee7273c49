"""Classes of motion side by side, or one after another where that would take too much memory."""

import pytest

from tactgen.fem.bimorph.bricks.assembly import assemble_bricks
from tactgen.geometry.bimorph.brick_family import LEVELS, bimorph_bricks
from tactgen.validation.models.bimorph import lowest_modes
from tactgen.validation.scene.scene import load_scene


def test_classes_one_by_one_have_the_modes_that_they_have_side_by_side(monkeypatch):
    """Of a system that counts as large none is beside another, and no number is another one."""
    device = load_scene("paper")[0].device
    system = assemble_bricks(device, bimorph_bricks(device, LEVELS[0]), lossy=False)
    monkeypatch.setenv("TACTGEN_THREADS", "2")
    together = lowest_modes.coarse_modes(system, 2)
    monkeypatch.setattr(lowest_modes, "_MOST_TOGETHER", system.size - 1)
    monkeypatch.setattr(lowest_modes, "side_by_side", None)
    alone = lowest_modes.coarse_modes(system, 2)
    assert set(alone.others) == {"bending_y", "torsion", "axial"}
    for motion, found in together.others.items():
        assert [m.kind for m in found] == [m.kind for m in alone.others[motion]]
        # the factor's rounding depends on how many threads made it
        assert [m.frequency for m in found] == pytest.approx(
            [m.frequency for m in alone.others[motion]], rel=1e-9
        )
