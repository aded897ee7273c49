"""The sections of the report, in order; those of an actuator only if the scene asks for it."""

from __future__ import annotations

from tactgen.validation.engine.origin import this_origin
from tactgen.validation.engine.solve import asks_display
from tactgen.validation.report.report_data import INVARIANT_TOLERANCE, Study
from tactgen.validation.report.sections import gallery
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.report.sections.uncertainty import credibility_section

#: What is looked up rather than read.
APPENDIX = ("audit", "parameters", "plan")


def sections(study: Study) -> tuple[Section, ...]:
    """Sections of a study; only those asked for are imported."""
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
        Section("credibility", "How far this report can be trusted", credibility_section),
        *after,
        Section("parameters", "Parameters and assumptions", _parameters),
        Section("plan", "What ran, what was skipped, what it cost", _plan),
    )


#: Sections about the lateral actuator that tell of the machine's response, after its support ...
_RESPONSE = ("response",)
#: ... what ends the story, and what belongs to the report of the lateral actuator alone.
_LIMITS, _APART = ("drive_limits",), ("holding", "length", "voltage", "stress")


def _machine(lateral: tuple[Section, ...]) -> tuple[list[Section], tuple[Section, ...]]:
    """Machine's story, and the sections about its bimorph that follow it."""
    from tactgen.validation.report.sections.generator import MOTIONS, POSITIONS, SUPPORT
    from tactgen.validation.report.sections.large_motion import AMPLITUDE, TIME

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


def _parameters(study: Study) -> Context:
    return {"parameters": study.parameters}


def _plan(study: Study) -> Context:
    return {"plan": study.plan, "stage_seconds": study.seconds, "origin": this_origin()}
