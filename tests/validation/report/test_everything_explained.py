"""Every number that two models give in a built-in scene: what measured causes leave of it."""

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph.bridge.swept import swept_bridge
from tactgen.validation.models.comparison import UNEXPLAINED
from tactgen.validation.report.request import is_of_rest
from tactgen.validation.report.study import Study
from tactgen.validation.scene.scene import load_scene

#: Scenes, what is asked otherwise of them so that all is compared, and how many differences.
SCENES = {
    "paper": (("models=lumped,tmm,beam,solid",), 18),
    "prototype": (("models=lumped,tmm,beam,solid",), 18),
    "j1": (("models=lumped,tmm,beam,solid",), 18),
    "bimorph_on_rod": (("models=lumped,tmm,beam,solid",), 18),
    "generator": ((), 12),
    "reluctance": ((), 8),
}


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["paper", "prototype", "j1"])
def test_steps_leave_a_tenth_of_a_percent_of_the_driven_tip(name):
    """From rest to 1 kHz, near resonance and minimum: transfer matrices against the solid."""
    frequencies = [10.0, 100.0, 500.0, 1000.0]
    asked = ["models=tmm,solid", "quantities=tip_displacement"]
    scene, _ = load_scene(name, ["frequency=10Hz,100Hz,500Hz,1000Hz", *asked])
    solution = solve(scene)
    beam, solid = (np.abs(solution.get("tip_displacement", m).value) for m in ("tmm", "solid"))
    steps = swept_bridge(scene, np.array(frequencies), lambda _: None)
    assert np.abs(beam / solid - 1.0 - sum(step.share for step in steps)).max() < 1e-3


@pytest.mark.heavy
@pytest.mark.parametrize("name", SCENES)
def test_causes_leave_at_most_a_fifth_of_a_percent(name):
    """All is explained by measured causes: none in words alone, and 0.2 % left at most.

    But for where the rod rests, which is not in proportion to the pull: at 130 mA the network draws
    it down and the field does not, as their pull-in currents say.
    """
    asked, count = SCENES[name]
    study = Study(*load_scene(name, ["frequency=100Hz", *asked]), lambda _: None, quick=False)
    rows = [row for row in study.compared if not is_of_rest(row.quantity)]
    cells = [cell for row in rows for cell in row.cells[:-1]]
    assert len(cells) == count
    assert {cell.verdict for cell in cells} <= {"explained", "agrees"}
    assert (np.array([cell.left for cell in cells]) <= UNEXPLAINED).all()
