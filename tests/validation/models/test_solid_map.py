"""The 3D co-energy map: solved row by row, each kept."""

import numpy as np
import pytest

from tactgen.fem.magnetics import actuator_3d as actuator
from tactgen.fem.magnetics.actuator_3d import SolidPoint, SolidValues
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.classes import make_model
from tactgen.validation.models.model import Stages
from tactgen.validation.scene.scene import load_scene


def test_an_interrupted_map_goes_on_where_it_was(tmp_path, monkeypatch):
    """Rows that were solved before the interruption are read, the others solved."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path))
    solved = []

    def row(_device, gap, currents, _sector):
        if len(solved) == 2:
            solved.append("interrupted")
            raise KeyboardInterrupt
        solved.append(gap)
        return tuple(_point(float(current), gap) for current in currents)

    monkeypatch.setattr(actuator, "solve_row", row)
    scene, _ = load_scene("reluctance", ["models=magnetic3d"])
    plan = make_plan(scene, ("magnetic3d",), ("pull_in_current",))
    with pytest.raises(KeyboardInterrupt):
        make_model("magnetic3d", scene, Stages(plan.keys)).map()
    found = make_model("magnetic3d", scene, Stages(plan.keys)).map()
    gaps = [gap for gap in solved if gap != "interrupted"]
    assert gaps == found.samples.gap.tolist()  # each once
    again = make_model("magnetic3d", scene, Stages(plan.keys)).map()
    assert len(solved) == len(gaps) + 1
    assert np.array_equal(again.coefficients, found.coefficients)


def _point(current, gap):
    """A coil whose inductance is L = A/(g + g0): W' = L i²/2."""
    inductance = 1e-5 / (gap + 1e-4)
    values = SolidValues(
        flux_linkage=inductance * current,
        coenergy=0.5 * inductance * current**2,
        forces=(0.5 * inductance / (gap + 1e-4) * current**2,) * 2,
        incremental_inductance=inductance,
        unknowns=1,
        iterations=1,
        beyond_table=0.0,
    )
    return SolidPoint(current, gap, values, values)


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
        bar = float(solid.error) + float(half.error)
        assert abs(float(solid.value) - float(half.value)) <= bar
        assert bar < 0.06 * float(half.value)
    maps = [solution.models[m].map() for m in ("magnetic3d", "axisymmetric")]
    for current, gap in ((0.05, 0.1e-3), (0.13, 0.2e-3), (0.02, 0.03e-3)):
        forces = [float(found.force(current, gap)) for found in maps]
        allowed = sum(found.interpolation_error.force for found in maps) + 0.03
        assert abs(forces[0] / forces[1] - 1.0) < allowed
    assert len(list(tmp_path.glob("magnetic3d.row-*"))) == 6
