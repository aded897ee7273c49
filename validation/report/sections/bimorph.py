"""The report's sections about the lateral actuator, in order."""

from __future__ import annotations

import numpy as np

from tactgen.validation.catalogue.models import MODELS, ranked
from tactgen.validation.catalogue.quantities import (
    OPEN_CIRCUIT_FREQUENCIES,
    QUANTITIES,
    SHORT_CIRCUIT_FREQUENCIES,
)
from tactgen.validation.engine.comparison import UNEXPLAINED
from tactgen.validation.evidence import stress as stress_output
from tactgen.validation.evidence.cases import audit
from tactgen.validation.models.bimorph.model import LumpedModel
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections import drive_voltage as voltage_section
from tactgen.validation.report.sections import gallery
from tactgen.validation.report.sections import length as length_section
from tactgen.validation.report.sections import uncertainty as uncertainty_section
from tactgen.validation.report.sections.bimorph_figures import response_plot, response_values
from tactgen.validation.report.sections.drive_voltage import drive_limits_section
from tactgen.validation.report.sections.model_differences import (
    bridge_section,
    holding_section,
    material_section,
)
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.report.sections.tip_load import load_section
from tactgen.validation.scene.variation import is_papers_bimorph


def _models(study: Study) -> Context:
    methods = {
        q.model: q.method
        for q in study.solution.quantities
        if MODELS[q.model].theory == "solid" and QUANTITIES[q.name].static
    }
    return {
        "comparison": study.comparison,
        "models": ranked(study.solution.models_of("bimorph")),
        "methods": methods,
        "unexplained": UNEXPLAINED,
        "tet": gallery.beside(study),
    }


def _modes(study: Study) -> Context:
    lumped = study.solution.models.get("lumped")
    circuit = lumped.circuit() if isinstance(lumped, LumpedModel) else None
    short, opened = (
        study.solution.by_model(row.name)
        for row in (SHORT_CIRCUIT_FREQUENCIES, OPEN_CIRCUIT_FREQUENCIES)
    )
    both = {model: (short[model], opened[model]) for model in short if model in opened}
    return {"frequencies": both, "circuit": circuit, **gallery.moving(study)}


def _response(study: Study) -> Context:
    cases = study.cases
    curves = {case.name: {m: case.curve(m) for m in ranked(case.models)} for case in cases}
    titles = {case.name: case.title for case in cases}
    frequency = np.asarray(study.scene.frequency)
    return {
        "cases": cases,
        "response": response_plot(frequency, curves, titles),
        "values": response_values(frequency, curves, titles) if len(frequency) > 1 else "",
    }


def _stress(study: Study) -> Context | None:
    # the same for every scene: tactgen stress drives it over more points than a report can wait for
    return None if study.quick else stress_output.section(study.announce)


def _length(study: Study) -> Context | None:
    return length_section.section(study.scene, study.origins, study.announce)


def _voltage(study: Study) -> Context | None:
    # the voltages stated were felt on the paper's display, from its threshold on
    if study.scene.threshold.kind != "paper" or not is_papers_bimorph(study.scene):
        return None
    return voltage_section.section(study.scene, study.announce)


def _uncertainty(study: Study) -> Context:
    return uncertainty_section.section(study.scene, study.solution, study.parameter_uncertainty)


def _audit(study: Study) -> Context | None:
    if not is_papers_bimorph(study.scene):
        return None
    return audit.section(study.scene, study.announce)


#: Shown before the checks.
LATERAL: tuple[Section, ...] = (
    Section("models", "Models side by side", _models),
    Section("modes", "Natural modes", _modes),
    Section("bridge", "From the beam to the solid", bridge_section),
    Section("holding", "What holds the bimorph", holding_section),
    Section("material", "What the assumed constants are worth", material_section),
    Section("load", "What the tip touches", load_section),
    Section("response", "Frequency response", _response),
    Section("drive_limits", "What it may be driven with", drive_limits_section),
    Section("length", "Length design", _length),
    Section("voltage", "Voltage at the detection threshold", _voltage),
    Section("uncertainty", "Numerical and parameter uncertainty", _uncertainty),
    Section("stress", "Numerical limits of the beam model", _stress),
)
#: Shown after the checks.
PRINTED_FORMULAS = Section("audit", "The printed formulas", _audit)
