"""Every number that two models give in a built-in scene: what measured causes leave of it."""

import numpy as np
import pytest

from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph.bridge.assumptions import solid_steps
from tactgen.validation.models.bimorph.bridge.stepped import bridged, stepped
from tactgen.validation.models.comparison import UNEXPLAINED
from tactgen.validation.report.request import is_of_rest, prepared
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


#: Of these there is nothing where the tip is free, and where the head stands upright.
_NOTHING = (
    "load_force", "load_power",
    "axial_tip_per_voltage", "lateral_tip_per_current",
    "axial_tip_per_current", "axial_tip_per_coil_voltage",
)  # fmt: skip


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("paper", 0),
        ("prototype", 0),
        ("j1", 0),
        ("display", 4),
        ("generator", 6),
        ("bimorph_on_rod", 0),
    ],
)
def test_steps_leave_a_tenth_of_a_percent_of_every_response_and_bending_mode(name, more):
    """From rest to 1 kHz, near resonances and minima: transfer matrices against the solid.

    Of the display also what one unit moves at the others, beside the poles of its board; of the
    machine also its small motions.
    """
    asked = ["models=tmm,solid", "frequency=10Hz,100Hz,500Hz,785Hz,1000Hz", "modes=12"]
    scene = prepared(load_scene(name, asked)[0], quick=False)
    # five points are no sweep that is to be made denser
    scene = scene.model_copy(update={"frequency": (10.0, 100.0, 500.0, 785.0, 1000.0)})
    names = bridged(scene)
    assert len(names) == 15 + more
    solution = solve(scene, quantities=names)
    for steps in stepped(scene, names, lambda _: None, solid_steps(scene)):
        both = [_bending(solution.get(steps.row.name, m)) for m in ("tmm", "solid")]
        count = min(len(one) for one in (*both, steps.together))
        beam, solid, told = (one[:count] for one in (*both, steps.together))
        size = solid if solid.ndim == 1 else steps.size
        known = size != 0.0  # a free tip gives no power
        left = (beam - solid)[known] / size[known] - told[known]
        assert (np.abs(left) < 1e-3).all(), steps.row.name
        assert known.all() or steps.row.name in _NOTHING


def _bending(quantity):
    """Return the magnitude of a quantity; of modes those that bend in x."""
    size = np.abs(quantity.value)
    return size if quantity.classes is None else size[np.array(quantity.classes) == "bending_x"]


@pytest.mark.heavy
@pytest.mark.parametrize("name", SCENES)
def test_causes_leave_at_most_a_fifth_of_a_percent(name):
    """All is explained by measured causes: none in words alone, and 0.2 % left at most.

    But for where the rod rests and what it presses with there, which is not in proportion to the
    pull.
    """
    asked, count = SCENES[name]
    study = Study(*load_scene(name, ["frequency=100Hz", *asked]), lambda _: None, quick=False)
    rows = [row for row in study.compared if not is_of_rest(row.quantity)]
    cells = [cell for row in rows for cell in row.cells[:-1]]
    assert len(cells) == count
    assert {cell.verdict for cell in cells} <= {"explained", "agrees"}
    assert (np.array([cell.left for cell in cells]) <= UNEXPLAINED).all()
