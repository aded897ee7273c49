"""The sections of the report, in order; those of an actuator only if the scene asks for it."""

from __future__ import annotations

from typing import Any

from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.origin import this_origin
from tactgen.validation.engine.plan import asks_display
from tactgen.validation.report.second_process import Asked
from tactgen.validation.report.sections import gallery
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.report.study import INVARIANT_TOLERANCE, Study
from tactgen.validation.scene.scene import Scene


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
        *after,
        Section("credibility", "How far this report can be trusted", _credibility),
        Section("parameters", "Parameters and assumptions", _parameters),
        Section("plan", "What ran, what was skipped, what it cost", _plan),
    )


#: Sections about the lateral actuator that tell of the machine's response, after its support ...
_RESPONSE = ("response",)
#: ... what ends the story, and what belongs to the report of the lateral actuator alone.
_LIMITS, _APART = ("drive_limits",), ("holding", "length", "voltage", "stress")


#: What needs no solution, in the order in which another process makes it: first what others need,
#: then what takes longest.
_ALONE = (
    "rungs", "stress", "holding", "material", "bridge", "length", "load",
    "voltage", "drive_limits", "audit",
)  # fmt: skip


def alone(scene: Scene) -> tuple[str, ...]:
    """Return the names of a report's parts that need no solution."""
    if not any(MODELS[name].actuator == "bimorph" for name in scene.models):
        return ()
    unused = _APART if scene.support.kind == "contact" else ()
    return tuple(name for name in _ALONE if name not in unused)


def made_alone(asked: Asked, name: str) -> Any:
    """Return a part that needs no solution: a section's contents, or a value of the study."""
    from tactgen.validation.report.sections.bimorph import LATERAL, PRINTED_FORMULAS

    study = _study(asked)
    found = {section.id: section for section in (*LATERAL, PRINTED_FORMULAS)}.get(name)
    return found.context(study) if found else getattr(study, name)


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
