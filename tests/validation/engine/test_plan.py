"""The plan runs what is needed, skips the rest, and says why; keys follow the inputs read."""

import pytest

from tactgen.validation.catalogue.models import gives, stage_reads
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.model import Stages
from tactgen.validation.models.reluctance import field
from tactgen.validation.scene.inputs import stage_key
from tactgen.validation.scene.load import load_scene

#: Quantities of the normal actuator at one current and gap.
MAGNETIC_POINT = tuple(n for n, info in QUANTITIES.items() if info.needs == ("magnetic_point",))


def test_only_what_is_needed_runs():
    """A static value by TMM touches no mesh, no mode, no other model; what does is a defect."""
    scene, _ = load_scene("paper")
    plan = make_plan(scene, ("tmm",), ("capacitance_free",))
    assert [s.stage for s in plan.run] == ["tmm.static"]
    assert plan.skipped["solid.mesh"] == "model solid is not among the models"
    with pytest.raises(RuntimeError, match="although the plan skips it"):
        Stages({}).run("tmm.static", lambda: 1)


@pytest.mark.usefixtures("own_store")
def test_a_point_in_3d_needs_no_map(monkeypatch):
    """Quantities of one current and gap solve that alone; those of the stroke plan the map."""
    monkeypatch.setattr(field, "_SECTOR_REFINEMENTS", ((0.0, 0.4),))
    scene, _ = load_scene("reluctance", ["accuracy=0.1"])
    solution = solve(scene, ("magnetic3d",), MAGNETIC_POINT)
    assert set(solution.stages.seconds) == {"magnetic3d.point"}
    assert {q.name for q in solution.quantities} == set(MAGNETIC_POINT)
    plan = make_plan(scene, ("magnetic3d",), ("pull_in_current",))
    assert [step.stage for step in plan.run] == ["magnetic3d.map", "magnetic3d.switching"]


def _each_once():
    """All quantities of all cheap models; the second with like needs is heavy.

    So is the second model of a display, which solves many units.
    """
    seen = set()
    for model in ("lumped", "tmm", "beam", "network"):
        for name, row in QUANTITIES.items():
            if gives(model, name):
                like = ("any" if row.actuator == "display" else model, row.needs)
                yield pytest.param(model, name, marks=[pytest.mark.heavy] if like in seen else [])
                seen.add(like)


@pytest.mark.parametrize(("model", "quantity"), list(_each_once()))
@pytest.mark.usefixtures("own_store")
def test_what_ran_is_what_was_planned(model, quantity):
    """For every quantity: executed stages = planned stages."""
    machine = QUANTITIES[quantity].actuator in ("generator", "display")
    support = ["support.kind=contact", "display.rows=1", "display.columns=2"] if machine else []
    scene, _ = load_scene("prototype", ["frequency=100,500", "modes=1", *support])
    solution = solve(scene, (model,), (quantity,))
    assert set(solution.stages.seconds) == set(solution.plan.keys)


MAGNETIC = {
    f"{model}.{stage}"
    for model in ("network", "axisymmetric", "magnetic3d")
    for stage in ("point", "map", "switching", "rest")
}
POINTS = {stage for stage in MAGNETIC if stage.endswith("point")}
#: The machine in small motions, on each model of the bimorph.
MACHINE = {f"{model}.machine" for model in ("lumped", "tmm", "beam", "calibrated", "solid", "cad")}
#: Many of these beside each other, and units that differ.
SPREAD = {f"{model}.spread" for model in ("lumped", "tmm", "beam", "calibrated")}
DISPLAY = SPREAD | {stage.replace("machine", "crosstalk") for stage in MACHINE}
#: The field between them.
NEIGHBOURS = {f"{model}.neighbours" for model in ("network", "magnetic3d")}
#: Modes of rows of beams, and of the two field models.
BEAM_MODES = {f"{model}.modes" for model in ("lumped", "tmm", "beam", "calibrated")}
FIELD_MODES = {f"{model}.modes_{end}" for model in ("solid", "cad") for end in ("short", "open")}


@pytest.mark.parametrize(
    ("override", "stale"),
    [
        ("drive.voltage=7V", set()),
        ("coil.length=1.5mm", MAGNETIC | MACHINE | DISPLAY | NEIGHBOURS),
        ("rod.density=7800kg/m^3", MACHINE | DISPLAY),
        # the map's range is decided by the spring
        ("spring.preload=90mN", MAGNETIC - POINTS | MACHINE | DISPLAY),
        ("load.kind=none", BEAM_MODES | FIELD_MODES | DISPLAY),
        ("support.rotational_stiffness=0.4N*m/rad", BEAM_MODES | FIELD_MODES | SPREAD),
        ("modes=3", {*(BEAM_MODES - {"lumped.modes"}), "solid.modal", "cad.modal", *FIELD_MODES,
                     *SPREAD}),
        ("accuracy=3e-3", {s for s in stage_reads() if s.startswith(("solid", "cad"))} - MACHINE
         | {f"{m}.{s}" for m in ("axisymmetric", "magnetic3d")
            for s in ("point", "switching", "rest")}),
        ("mesh.level=3", {s for s in stage_reads() if s.startswith(("solid", "cad"))} - MACHINE),
        ("piezo.density=7800kg/m^3", set(stage_reads()) - MAGNETIC - NEIGHBOURS),
    ],
)  # fmt: skip
def test_keys_change_with_the_inputs_that_a_stage_reads(override, stale):
    """A changed voltage re-meshes nothing; a changed coil turns no piezo matrix stale."""
    before, _ = load_scene("paper")
    after, _ = load_scene("paper", [override])
    changed = {s for s in stage_reads() if stage_key(s, before) != stage_key(s, after)}
    assert changed == stale
