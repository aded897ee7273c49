"""What a report of each kind of scene is made of, and what its head says, with nothing solved."""

import math
from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest
from approved import described

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.models.bimorph import bridge
from tactgen.validation.models.bimorph.bridge import assumptions, causes, generator
from tactgen.validation.models.comparison import Cell
from tactgen.validation.report import page, study
from tactgen.validation.report.request import check_report, model_apart, prepared, shown_model
from tactgen.validation.report.sections.contents import alone, meanwhile, sections
from tactgen.validation.report.study import Study
from tactgen.validation.scene.scene import load_scene

#: Scenes with their settings, that differ in what they are about.
SCENES = (
    "paper",
    "paper models=tmm,solid,cad load.kind=none",
    "paper models=tmm piezo.d31=0pC/N",
    "paper models=cad,tmm quantities=capacitance_free",
    "prototype frequency=100 accuracy=0.1",
    "paper frequency=10,20 models=lumped",
    "bimorph_on_rod",
    "bimorph_on_rod load.kind=none models=tmm,cad,solid",
    "bimorph_on_rod load.kind=mass load.mass=1mg",
    "generator",
    "generator coil.current=90mA",
    "generator models=tmm",
    "reluctance",
    "reluctance models=network steel.curve=linear",
    "display",
    "display models=tmm",
    "paper models=tmm,network quantities=static_tip_displacement,magnetic_force coil.current=50mA",
)


@pytest.fixture
def asked(monkeypatch):
    """Return what of long calculations is asked for; nothing of it is done."""
    found = []

    def solved(scene, models=None, names=None, announce=None, reuse=None):
        models = tuple(models or scene.models)
        names = tuple(names or scene.quantities)
        if reuse is not None:
            found.append(f"solve {' '.join(models)} at {scene.coil.current:g} A: {' '.join(names)}")
        rows = [SimpleNamespace(name=q, model=m) for m in models for q in names if gives(m, q)]
        return SimpleNamespace(
            scene=scene,
            models=dict.fromkeys(models),
            quantities=rows,
            models_of=lambda a: {m: None for m in models if MODELS[m].actuator == a},
        )

    def stand_in(room, name):
        def called(*given, **options):
            found.append(f"{name} {options}" if options else name)
            return [name]

        monkeypatch.setattr(room, name, called)

    monkeypatch.setattr(study, "solve", solved)
    monkeypatch.setattr(study, "run_check", lambda check: check.id)
    stand_in(bridge, "bridge")
    stand_in(assumptions, "solid_steps")
    stand_in(causes, "on_a_clamp")
    stand_in(causes, "in_the_rod")
    stand_in(generator, "GeneratorChain")
    return found


@pytest.mark.parametrize("number", range(len(SCENES)), ids=[s.replace(".", "_") for s in SCENES])
@pytest.mark.parametrize("quick", [True, False])
def test_what_a_report_is_made_of(number, quick, asked, approved_line):
    """Models, quantities, sections, parts made alone, checks and parameters of each scene."""
    name, *settings = SCENES[number].split()
    scene, origins = load_scene(name, settings)
    try:
        check_report(scene, quick=quick)
    except InputError as error:
        approved_line(f"refused: {error}")
        return
    made = prepared(scene, quick=quick)
    said = []
    one = Study(scene, origins, said.append, quick=quick)
    frequency = np.array(made.frequency)
    told = {
        "models": made.models,
        "quantities": of_each_actuator(made.quantities),
        "accuracy": made.accuracy,
        "frequencies": described(frequency),
        "shown": shown_model(made),
        "apart": model_apart(made),
        "sections": [section.id for section in sections(one)],
        "alone": alone(made),
        "meanwhile": meanwhile(made),
        "checks": one.outcomes,
        "as it stands": one.as_it_stands,
        "machine": one.machine,
        "field": one.asks_field,
        "rungs": one.rungs,
        "causes": one.causes,
        "chain": one.chain,
        "parameters": in_groups(row.key for row in one.parameters),
        "asked": asked,
        "said": said,
    }
    approved_line("; ".join(f"{key} {_short(value)}" for key, value in told.items()))


def of_each_actuator(names):
    """Return how many of each actuator's quantities these are, and which they are not."""
    found = []
    for actuator in dict.fromkeys(row.actuator for row in QUANTITIES.values()):
        own = [name for name, row in QUANTITIES.items() if row.actuator == actuator]
        missing = [name for name in own if name not in names]
        if len(missing) < len(own):
            without = f" (no {', '.join(missing)})" if missing else ""
            found.append(f"{actuator} {len(own) - len(missing)}{without}")
    return found


def in_groups(keys):
    """Return how many parameters of each group these are."""
    return [f"{group} {count}" for group, count in Counter(k.split(".")[0] for k in keys).items()]


def _short(value):
    return " ".join(map(str, value)) if isinstance(value, tuple | list) else str(value)


def outcome(status, *, fitted=False):
    return SimpleNamespace(status=status, check=SimpleNamespace(fitted=fitted))


def row(*cells, quantity="static_tip_displacement"):
    cells = tuple(Cell("m", *c, "reference", "") for c in cells)
    return SimpleNamespace(quantity=quantity, cells=cells)


def made_up(**changed):
    """Return a study of a lateral actuator with checks that ended in each way."""
    headline = SimpleNamespace(target=SimpleNamespace(quantity=SimpleNamespace(headline=True)))
    other = SimpleNamespace(target=SimpleNamespace(quantity=SimpleNamespace(headline=False)))
    compared = [
        row((2.0, 1e-3, 0.2), (-1.0, 5e-3, 0.0)),
        row((math.nan, 1.0, 9.0), (0.0, 1e-3, math.nan)),
        row((1.0, 1e-2, -0.5), (4.0, 4.1e-3, 0.0)),
    ]
    # of two stops models may take either: no difference in size
    rests = row((5.0, 0.5, 7.0), quantity="rod_position")
    normal = SimpleNamespace(comparison=[row((5.0, 0.5, -0.03)), rests])
    parts = {
        "scene": load_scene("paper", ["models=tmm", "accuracy=1e-3"])[0],
        "lateral": True,
        "parameter_uncertainty": [headline, other],
        "shown": {},
        "comparison": compared[:2],
        "compared": compared,
        "normal": normal,
        "invariants": "invariants",
        "rungs": "rungs",
        "parameters": "parameters",
        "asked": 0.25,
        "solution": SimpleNamespace(
            quantities=[SimpleNamespace(name=n, model="tmm") for n in ("a", "b", "a")],
            models_of=lambda _: {"tmm": None},
        ),
        "outcomes": [outcome(s) for s in ("explained", "pass", "fail", "pass")]
        + [outcome("explained", fitted=True), outcome("fail")],
    }
    return SimpleNamespace(**{**parts, **changed})


def test_what_the_head_of_the_page_says(monkeypatch, approved):
    """Counts, the widest bars, what tips the head over, what was left out."""
    monkeypatch.setattr(page, "accuracy_warnings", lambda *_: ["a warning"])
    monkeypatch.setattr(page, "expected_differences", lambda _: {"static_tip_displacement": "band"})
    tipped = {"support": {"moment": {"largest": 2.0, "tipping": 1.0}}}
    held = {"support": {"moment": {"largest": 1.0, "tipping": 1.0}}}
    solid = SimpleNamespace(quantities=[], models_of=lambda _: {"tmm": None, "solid": None})
    for changed in (
        {},
        {"shown": tipped, "solution": solid},
        {"shown": held, "outcomes": []},
        {"lateral": False, "normal": None, "compared": []},
    ):
        part = page.summary(made_up(**changed))
        approved(described(part), f"{len(changed)}{'lateral' in changed}{'outcomes' in changed}")
