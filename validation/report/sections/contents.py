"""The sections of the report, in order; those of an actuator only if the scene asks for it."""

from __future__ import annotations

import math

from tactgen.validation.engine.origin import this_origin
from tactgen.validation.engine.solve import asks_display
from tactgen.validation.report.report_data import INVARIANT_TOLERANCE, Study
from tactgen.validation.report.sections.section import Context, Section


def sections(study: Study) -> tuple[Section, ...]:
    """Sections of a study; only those asked for are imported."""
    found: list[Section] = []
    if study.lateral:
        from tactgen.validation.report.sections.bimorph import LATERAL

        found += _machine(LATERAL) if study.machine else LATERAL
    if study.normal and not study.machine:
        from tactgen.validation.report.sections.reluctance import NORMAL

        found += [s for s in NORMAL if not (study.lateral and s.id == "magnetic_field")]
    if study.lateral:
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


def _machine(lateral: tuple[Section, ...]) -> list[Section]:
    """Machine's own sections, then those about its bimorph.

    The reports of each actuator alone have the rest.
    """
    from tactgen.validation.report.sections.generator import MOTIONS, POSITIONS, SUPPORT
    from tactgen.validation.report.sections.large_motion import AMPLITUDE, TIME

    own = [section for section in lateral if section.id != "bridge"]
    return [POSITIONS, SUPPORT, MOTIONS, AMPLITUDE, TIME, *own]


def _checks(study: Study) -> Context:
    cells = [row.most_detailed for row in study.compared]
    cells = [cell for cell in cells if math.isfinite(cell.value)]
    return {
        "bars": len(cells),
        "widest": max((c.error / abs(c.value) for c in cells if c.value), default=0.0),
        "outcomes": study.outcomes,
        "invariants": study.invariants,
        "invariant_tolerance": INVARIANT_TOLERANCE,
    }


def _parameters(study: Study) -> Context:
    ranges = study.shown.get("uncertainty", {}).get("uncertain_parameters", ())
    return {
        "parameters": study.parameters,
        "ranges": {row.key: row for row in ranges},
        "origin": this_origin(),
    }
