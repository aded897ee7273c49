"""Bars that are rounding alone: inputs moved by their last digit move no answer out of its bar.

What an answer loses to rounding it also loses to the last digit of what goes in, so a bar that is
narrower than that is too narrow.
"""

import numpy as np
import pytest

from tactgen.validation.checks.coverage.result import PROMISED
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import load_scene

SCENES = (
    ("paper", ("models=lumped,tmm,beam", "frequency=10,300,870")),
    ("paper", ("models=lumped,tmm", "frequency=10,870", "support.kind=clamped", "load.kind=none")),
    ("generator", ("models=lumped,tmm,network", "frequency=10,300,870")),
    ("display", ("models=tmm", "frequency=10,870", "quantities=crosstalk_beside,frequency_spread")),
    ("reluctance", ("models=network",)),
)
#: Rounding of an answer that is read off without loss, in spacings of doubles; and how many bars an
#: answer may move by: both answers are off by their own.
SPACINGS, BARS = 8.0, 2.0


def last_digits_off(scene):
    bimorph = scene.bimorph
    moved = {
        "length": np.nextafter(bimorph.length, 1.0),
        "piezo_thickness": np.nextafter(bimorph.piezo_thickness, 0.0),
    }
    return scene.model_copy(
        update={
            "bimorph": bimorph.model_copy(update=moved),
            "gap": np.nextafter(scene.gap, 1.0),
        }
    )


@pytest.mark.parametrize(("name", "overrides"), SCENES)
def test_no_answer_leaves_its_bar(name, overrides):
    scene, _ = load_scene(name, overrides)
    found = (solve(which).quantities for which in (scene, last_digits_off(scene)))
    for before, after in zip(*found, strict=True):
        allowed = BARS * before.uncertainty
        allowed = allowed + SPACINGS * np.finfo(float).eps * np.abs(before.value)
        moved = np.nan_to_num(np.abs(after.value - before.value))
        within = moved <= np.nan_to_num(allowed, nan=np.inf)
        # of the many entries of a matrix one in twenty may: bars of the beam elements are estimates
        assert within.mean() >= PROMISED, (before.name, before.model)
