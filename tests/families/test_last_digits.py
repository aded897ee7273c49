"""Bars that are rounding alone: inputs moved by their last digit move no answer out of its bar.

What an answer loses to rounding it also loses to the last digit of what goes in, so a bar that is
narrower than that is too narrow.
"""

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.judgement import PROMISED
from tactgen.validation.scene.load import load_scene

SCENES = (
    ("paper", ("models=lumped,tmm,beam", "frequency=10,870")),
    ("paper", ("models=lumped,tmm", "frequency=10,870", "support.kind=clamped", "load.kind=none")),
    ("generator", ("models=lumped,tmm,network", "frequency=10,870")),
    ("display", ("models=tmm", "frequency=10,870", "quantities=crosstalk_beside,frequency_spread",
                 "display.rows=2", "display.columns=2")),
    ("reluctance", ("models=network",)),
)  # fmt: skip
#: Rounding of an answer that is read off without loss, in spacings of doubles.
SPACINGS = 8.0
#: Models whose bars of rounding are estimates from a few evaluations: they promise most entries,
#: and which one leaves its own is of the processor.  By how many bars none may, as under stress.
ESTIMATES, MOST = ("beam",), 3.0


def last_digits_off(scene):
    bimorph = scene.bimorph
    moved = {
        "length": np.nextafter(bimorph.length, 1.0),
        "piezo_thickness": np.nextafter(bimorph.piezo_thickness, 0.0),
    }
    return scene.model_copy(
        update={"bimorph": bimorph.model_copy(update=moved), "gap": np.nextafter(scene.gap, 1.0)}
    )


@pytest.mark.parametrize(("name", "overrides"), SCENES)
def test_no_answer_leaves_its_bar(name, overrides):
    scene, _ = load_scene(name, overrides)
    found = (solve(which).quantities for which in (scene, last_digits_off(scene)))
    estimated = []
    for before, after in zip(*found, strict=True):
        # both answers are off by their own
        allowed = before.error + after.error
        allowed = allowed + SPACINGS * np.finfo(float).eps * np.abs(before.value)
        moved = np.nan_to_num(np.abs(after.value - before.value))
        allowed = np.maximum(np.nan_to_num(allowed, nan=np.inf), np.finfo(float).tiny)
        beyond = np.ravel(moved / allowed)
        if before.model in ESTIMATES:
            estimated += [*beyond]
        assert beyond.max() <= (MOST if before.model in ESTIMATES else 1.0), (
            before.name,
            before.model,
        )
    assert not estimated or np.mean(np.array(estimated) <= 1.0) >= PROMISED
