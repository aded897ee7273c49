"""The plan for anything that can be asked: each stage once, exactly those that are needed, and
keys that follow from what a stage reads and from nothing else."""

from hypothesis import given
from hypothesis import strategies as st

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS, gives, stage_reads
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.solve import make_plan, stages_for
from tactgen.validation.scene.inputs import keys_read, stage_keys
from tactgen.validation.scene.load import load_scene

SCENES = {
    name: load_scene(name)[0] for name in ("paper", "prototype", "generator", "reluctance", "j1")
}
KEYS = {name: stage_keys(stage_reads(), scene) for name, scene in SCENES.items()}
#: One change of a scene by text, of many kinds.
CHANGES = (
    "bimorph.length=19mm", "piezo.d31=-380 pC/N", "shim.youngs_modulus=150GPa", "gap=0.15mm",
    "support.rotational_stiffness=0.2 N*m/rad", "load.kind=mass", "drive.voltage=3V", "modes=3",
    "frequency=200Hz", "bimorph.wiring=series", "accuracy=1e-2", "coil.current=20mA",
    "spring.stiffness=90N/m", "mesh.level=3", "coil.turns=700", "sleeve.length=5mm",
)  # fmt: skip


@st.composite
def requests(draw):
    """A scene, models and quantities that some of the models give."""
    name = draw(st.sampled_from(sorted(SCENES)))
    models = draw(st.lists(st.sampled_from(sorted(MODELS)), min_size=1, max_size=4, unique=True))
    given_here = sorted(q for q in QUANTITIES if any(gives(model, q) for model in models))
    quantities = draw(st.lists(st.sampled_from(given_here), min_size=1, max_size=6, unique=True))
    return name, tuple(models), tuple(quantities)


def planned(name, models, quantities):
    """Return the plan, None where the models cannot take the scene."""
    try:
        return make_plan(SCENES[name], models, quantities)
    except InputError:
        return None


@given(requests())
def test_every_stage_runs_or_is_skipped_and_for_a_reason(request):
    """No stage is both, none is neither; what runs serves a quantity that was asked for."""
    plan = planned(*request)
    if plan is None:
        return
    name, models, quantities = request
    run, skipped = [s.stage for s in plan.run], list(plan.skipped)
    assert sorted(run + skipped) == sorted(stage_reads())
    scene = SCENES[name].asking(models)
    needed = {
        stage
        for model in models
        for quantity in quantities
        if gives(model, quantity)
        for stage in stages_for(scene, model, quantity)
    }
    assert set(run) == needed
    assert all(step.reason and any(q in step.reason for q in quantities) for step in plan.run)
    assert all(plan.skipped.values())


@given(requests(), st.randoms(use_true_random=False))
def test_more_questions_change_no_answer(request, chance):
    """A part of the quantities, in any order: the same stages under the same keys."""
    name, models, quantities = request
    whole = planned(name, models, quantities)
    if whole is None:
        return
    mixed = list(quantities)
    chance.shuffle(mixed)
    again = planned(name, models, tuple(mixed))
    assert again is not None
    assert again.keys == whole.keys
    part = planned(name, models, tuple(mixed[: (len(mixed) + 1) // 2]))
    assert part is not None
    assert part.keys.items() <= whole.keys.items()


@given(st.sampled_from(sorted(SCENES)), st.sampled_from(CHANGES))
def test_a_key_is_new_where_something_that_is_read_is(name, change):
    """Keys of all stages before and after: as different as the values that each reads."""
    base, before = SCENES[name], KEYS[name]
    try:
        changed, _ = load_scene(name, [change])
    except InputError:
        return
    after = stage_keys(stage_reads(), changed)
    assert len(set(before.values())) == len(before)  # no two stages share one
    key, moved = change.partition("=")[0], base != changed
    for stage, entries in stage_reads().items():
        reading = key in keys_read(base, entries) | keys_read(changed, entries)
        new = before[stage] != after[stage]
        # what holds the base is read as it holds it, and other models by the map that they bring
        if reading and "support" not in entries and moved:
            assert new, (stage, change)
        if new:
            assert reading or "models" in entries, (stage, change)
