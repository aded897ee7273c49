"""The sections of the report, in order; those of an actuator only if the scene asks for it."""

from __future__ import annotations

from typing import Any

from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.engine.origin import this_origin
from tactgen.validation.engine.plan import asks_display
from tactgen.validation.engine.solve import solve
from tactgen.validation.report.request import model_apart, shown_model
from tactgen.validation.report.second_process import Asked
from tactgen.validation.report.sections import gallery
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.report.study import INVARIANT_TOLERANCE, Apart, Study
from tactgen.validation.scene.scene import Scene

#: What is looked up rather than read.
APPENDIX = ("audit", "parameters", "plan")


def sections(study: Study) -> tuple[Section, ...]:
    """Return the sections of a study; what is not asked for is not even imported."""
    found = [Section("what", "What was studied", _what)]
    after: list[Section] = []
    lateral: tuple[Section, ...] = ()
    if study.lateral:
        from tactgen.validation.report.sections.bimorph import LATERAL, PRINTED_FORMULAS

        lateral, after = LATERAL, [PRINTED_FORMULAS]
    if study.machine:
        story, lateral = _machine(lateral)
        found, after = found + story, []
    found += lateral
    if study.normal:
        from tactgen.validation.report.sections.reluctance import NORMAL

        found += NORMAL
    if asks_display(study.scene.quantities):
        from tactgen.validation.report.sections.display import DISPLAY

        found.append(DISPLAY)
    return (
        *found,
        Section("checks", "Checks of this scene", _checks),
        Section("credibility", "How far this report can be trusted", _credibility),
        *after,
        Section("parameters", "Parameters and assumptions", _parameters),
        Section("plan", "What ran, what was skipped, what it cost", _plan),
    )


#: Sections about the lateral actuator that tell of the machine's response, after its support ...
_RESPONSE = ("response",)
#: ... what ends the story, and what belongs to the report of the lateral actuator alone.
_LIMITS, _APART = ("drive_limits",), ("holding", "length", "voltage", "stress")


#: What stands alone beside a model, in the order in which another process makes it: first what
#: takes the CAD kernel that the model has loaded, and what others need, then what takes longest.
_ALONE = (
    "pictures", "run", "steps", "bridge", "holding", "stress", "material", "length",
    "parameter_uncertainty", "load", "voltage", "drive_limits", "audit",
)  # fmt: skip
#: What the process that puts the report together makes while it waits, in this order.
_MEANWHILE = (
    "moving", "holding", "stress", "material", "length", "parameter_uncertainty", "load",
    "voltage", "drive_limits", "audit",
)  # fmt: skip


def alone(scene: Scene) -> tuple[str, ...]:
    """Return the names of a report's parts that need nothing of the rest."""
    if not any(MODELS[name].actuator == "bimorph" for name in scene.models):
        return ()
    apart = model_apart(scene)
    machine = scene.support.kind == "contact"
    # a mesh of tetrahedra is known to who solves on it
    unused = {
        *(_APART if machine else ("run",)),
        *(("pictures",) if shown_model(scene) == "cad" else ()),
    }
    return (*([apart] if apart else []), *(name for name in _ALONE if name not in unused))


def meanwhile(scene: Scene) -> tuple[str, ...]:
    """Return the names of parts that the report's own process makes while it waits for another."""
    known = {*alone(scene), *(("moving",) if model_apart(scene) else ())}
    return tuple(name for name in _MEANWHILE if name in known)


def made_alone(asked: Asked, name: str) -> Any:
    """Return a part, in the process that makes parts ahead."""
    return part(_study(asked), name)


def part(study: Study, name: str) -> Any:
    """Return what needs nothing of the rest: a model's stages, a section's contents, a value."""
    from tactgen.validation.report.sections.bimorph import LATERAL, PRINTED_FORMULAS

    if name in MODELS:
        return made_apart(study, name)
    found = {section.id: section.context for section in (*LATERAL, PRINTED_FORMULAS)}
    if name == "run":
        from tactgen.validation.report.sections.large_motion import run_in_time

        return run_in_time(study)
    make = (found | {"pictures": gallery.bimorph, "moving": gallery.moving}).get(name)
    return make(study) if make else getattr(study, name)


def made_apart(study: Study, name: str) -> Apart:
    """Return what the rest needs of a model that this process solves alone."""
    quantities = tuple(q for q in study.scene.quantities if gives(name, q))
    solution = solve(study.scene, (name,), quantities, study.announce)
    mesh = gallery.tetrahedra(solution) if name == "cad" else None
    return Apart(solution.quantities, solution.stages.to_travel(), mesh)


#: What the process that makes parts ahead was asked last, and its study: parts share much of it.
_last: list[tuple[Asked, Study]] = []


def _study(asked: Asked) -> Study:
    if not _last or _last[0][0] != asked:
        scene, origins, quick = asked
        _last[:] = [(asked, Study(scene, origins, lambda _: None, quick=quick))]
    return _last[0][1]


def _machine(lateral: tuple[Section, ...]) -> tuple[list[Section], tuple[Section, ...]]:
    """Return the machine's story, and the sections about its bimorph that follow it."""
    from tactgen.validation.report.sections.large_motion import AMPLITUDE, TIME
    from tactgen.validation.report.sections.machine import MOTIONS, POSITIONS, SUPPORT

    by_id = {section.id: section for section in lateral}
    response, limits = ([by_id[name] for name in names] for names in (_RESPONSE, _LIMITS))
    told = {*_RESPONSE, *_LIMITS, *_APART}
    story = [POSITIONS, SUPPORT, *response, MOTIONS, AMPLITUDE, TIME, *limits]
    return story, tuple(section for section in lateral if section.id not in told)


def _what(study: Study) -> Context:
    return {"pictures": gallery.pictures(study)}


def _checks(study: Study) -> Context:
    return {
        "comparison": study.compared,
        "outcomes": study.outcomes,
        "invariants": study.invariants,
        "invariant_tolerance": INVARIANT_TOLERANCE,
    }


def _credibility(study: Study) -> Context:
    from tactgen.validation.report.credibility.evidence import gathered
    from tactgen.validation.report.credibility.factors import factors
    from tactgen.validation.report.credibility.levels import overall

    found = factors(gathered(study))
    return {"factors": found, "overall": overall(found)}


def _parameters(study: Study) -> Context:
    return {"parameters": study.parameters}


def _plan(study: Study) -> Context:
    return {
        "plan": study.plan,
        "stage_seconds": study.seconds,
        "origin": this_origin(),
    }
