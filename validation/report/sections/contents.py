"""The sections of the report, in order; those of an actuator only if the scene asks for it."""

from __future__ import annotations

from tactgen.validation.engine.origin import this_origin
from tactgen.validation.report.sections import gallery
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.report.study import INVARIANT_TOLERANCE, Study


def sections(study: Study) -> tuple[Section, ...]:
    """Return the sections of a study; what is not asked for is not even imported."""
    found = [Section("what", "What was studied", _what)]
    after: list[Section] = []
    if study.lateral:
        from tactgen.validation.report.sections.bimorph import LATERAL, PRINTED_FORMULAS

        found += LATERAL
        after = [PRINTED_FORMULAS]
    if study.normal:
        from tactgen.validation.report.sections.reluctance import NORMAL

        found += NORMAL
    if study.lateral and study.scene.support.kind == "contact":
        from tactgen.validation.report.sections.machine import MACHINE

        found.append(MACHINE)
    return (
        *found,
        Section("checks", "Checks of this scene", _checks),
        *after,
        Section("credibility", "How far this report can be trusted", _credibility),
        Section("parameters", "Parameters and assumptions", _parameters),
        Section("plan", "What ran, what was skipped, what it cost", _plan),
    )


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
    from tactgen.validation.report.credibility.factor import overall
    from tactgen.validation.report.credibility.factors import factors

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
