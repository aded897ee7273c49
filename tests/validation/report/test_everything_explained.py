"""Every number that two models give in a built-in scene: what measured causes leave of it."""

import numpy as np
import pytest

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
