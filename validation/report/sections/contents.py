"""The sections of the report, in order; those of an actuator only if the scene asks for it."""

from __future__ import annotations

from operator import itemgetter
from typing import Any

from tactgen.validation.catalogue.models import models_of
from tactgen.validation.engine.origin import this_origin
from tactgen.validation.engine.solve import asks_display
from tactgen.validation.report.report_data import INVARIANT_TOLERANCE, Context, Section, Study
from tactgen.validation.scene.variation import is_papers_generator


def sections(study: Study) -> tuple[Section, ...]:
    """Sections of a study; only those asked for are imported."""
    found: list[Section] = []
    if study.lateral:
        from tactgen.validation.report.sections.bimorph import LATERAL

        found += LATERAL
    if study.machine:  # its own sections first; the reports of each actuator alone have the rest
        from tactgen.validation.report.sections import generator, large_motion

        found = [
            generator.POSITIONS, generator.SUPPORT, generator.MOTIONS, large_motion.AMPLITUDE,
            large_motion.TIME, *(section for section in found if section.id != "bridge"),
        ]  # fmt: skip
    if study.normal and not study.machine:
        from tactgen.validation.report.sections.reluctance import NORMAL

        found += [s for s in NORMAL if not (study.lateral and s.id == "magnetic_field")]
    if study.lateral and is_papers_generator(study.scene):
        from tactgen.validation.report.sections.published_measurements import MEASUREMENTS

        found.append(MEASUREMENTS)
    if asks_display(study.scene.quantities):
        from tactgen.validation.report.sections.display import DISPLAY

        found.append(DISPLAY)
    return (
        *found,
        Section("checks", "Checks of this scene", _checks),
        Section("parameters", "Parameters and assumptions", _parameters),
    )


def work_ahead(study: Study) -> dict[str, tuple[Any, ...]]:
    """What sections show that follows from the scene alone, by their ids.

    Each is a function of a module and what it is given, so that another process may do it.
    """
    scene, found = study.scene, dict[str, tuple[Any, ...]]()
    if study.quick or not set(scene.models) & set(models_of("bimorph")):
        return found
    if scene.support.kind == "contact":
        from tactgen.validation.models.backbone import rocking_states
        from tactgen.validation.report.sections.large_motion import VOLTAGES

        found["amplitude"] = rocking_states, scene, VOLTAGES
    elif study.has_steps:
        from tactgen.validation.models.difference import beam_to_solid

        found["bridge"] = beam_to_solid, scene
    if study.asks_field:  # without solids this process is done before the other has started
        from tactgen.validation.studies.parameter_uncertainty import parameter_uncertainty

        found["uncertainty"] = parameter_uncertainty, scene
    if is_papers_generator(scene):
        from tactgen.validation.studies.published_measurements import all_compared

        found["measurements"] = (all_compared,)
    return found


def _checks(study: Study) -> Context:
    errors = study.relative_errors
    return {
        "bars": len(errors),
        "widest": max(errors.items(), key=itemgetter(1), default=("", 0.0)),
        "outcomes": study.outcomes,
        "invariants": study.invariants,
        "invariant_tolerance": INVARIANT_TOLERANCE,
    }


def _parameters(study: Study) -> Context:
    uncertainty = study.shown.get("uncertainty", {})
    return {
        "parameters": study.parameters,
        "ranges": uncertainty.get("uncertain_parameters", {}),
        "range_texts": uncertainty.get("range_texts", {}),
        "origin": this_origin(),
    }
