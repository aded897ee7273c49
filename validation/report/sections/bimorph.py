"""The report's sections about the lateral actuator, in order."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Complex
from tactgen.geometry.device.parameters import Piezo
from tactgen.validation.catalogue.models import MODELS, ranked
from tactgen.validation.catalogue.quantities import (
    ADMITTANCE,
    OF_CIRCUIT,
    OPEN_CIRCUIT_FREQUENCIES,
    QUANTITIES,
    SHORT_CIRCUIT_FREQUENCIES,
    TIP_DISPLACEMENT,
)
from tactgen.validation.engine.answers import representative
from tactgen.validation.models.bimorph.model import LumpedModel
from tactgen.validation.models.difference import CAPACITANCE, DEFLECTION, FIRST_FREQUENCY
from tactgen.validation.models.model import Quantity
from tactgen.validation.report.report_data import Context, Section, Study
from tactgen.validation.report.sections import gallery
from tactgen.validation.report.sections.bimorph_figures import breakdown_plot, difference_plot
from tactgen.validation.report.sections.drive_limits import drive_limits_section
from tactgen.validation.report.sections.uncertainty import uncertainty_section
from tactgen.validation.scene.conditions import driven_in_words


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
        "meshes": [] if study.machine else gallery.meshes(study),
    }


def _modes(study: Study) -> Context:
    lumped = study.solution.models.get("lumped")
    circuit = lumped.circuit() if isinstance(lumped, LumpedModel) else None
    short, opened = (
        study.solution.by_model(row.name)
        for row in (SHORT_CIRCUIT_FREQUENCIES, OPEN_CIRCUIT_FREQUENCIES)
    )
    both = {model: (short[model], opened[model]) for model in short if model in opened}
    layers = 2.0 if study.scene.bimorph.wiring == "series" else 1.0  # that share the voltage
    return {"frequencies": both, "circuit": circuit, "layers": layers, **gallery.moving(study)}


def _responses(study: Study) -> dict[str, dict[str, Quantity]]:
    """Displacement, and admittance or what the circuit is there for, by name and model."""
    circuit = OF_CIRCUIT.get(study.scene.circuit.kind, (ADMITTANCE.name,))
    found = {n: study.solution.by_model(n) for n in (TIP_DISPLACEMENT.name, *circuit)}
    return {name: {m: of[m] for m in ranked(of)} for name, of in found.items() if of}


def response_curves(study: Study) -> dict[str, dict[str, Complex]]:
    """Responses (n,) of the first page and of its section, by name and model."""
    return {
        name: {model: study.known(q) for model, q in of.items()}
        for name, of in _responses(study).items()
    }


def _response(study: Study) -> Context:
    found, curves = _responses(study), response_curves(study)
    with_phase = {n: of for n, of in curves.items() if any(map(np.iscomplexobj, of.values()))}
    models = next(iter(found.values()))
    return {
        "driven": driven_in_words(study.scene.drive, study.scene.circuit),
        "responses": [QUANTITIES[name].label for name in found],
        "peaks": [(m, [representative(of[m]) for of in found.values()]) for m in models],
        "response": difference_plot(np.asarray(study.scene.frequency), with_phase),
    }


#: Headline quantities in tables and figures: title, unit,
#: and the power of the number of layers in series by which the terminals see less.
COLUMNS = (
    (DEFLECTION, "static deflection per volt", "m", 1),
    (FIRST_FREQUENCY, "first frequency", "Hz", 0),
    (CAPACITANCE, "free capacitance", "F", 2),
)


def bridge_section(study: Study) -> Context | None:
    """Steps from beam to solid; None where no solid was asked for."""
    steps = study.steps
    if not steps:
        return None if not study.asks_field else {"bridge": None}
    piezo = study.scene.piezo
    library = Piezo(material=piezo.material)
    first, last = steps[0].values, steps[-1].values
    return {
        "bridge": steps,
        "plot": breakdown_plot(steps, {key: title for key, title, _, _ in COLUMNS}, "the solid"),
        "off": [first[key] / last[key] - 1.0 for key, _, _, _ in COLUMNS],
        "columns": COLUMNS,
        # in series each layer has half the voltage, and the terminals half the charge
        "layers": 2.0 if study.scene.bimorph.wiring == "series" else 1.0,
        "replaced": [
            f"piezo.{name}"
            for name in Piezo.model_fields
            if getattr(piezo, name) != getattr(library, name)
        ],
    }


LATERAL: tuple[Section, ...] = (
    Section("models", "Models side by side", _models),
    Section("modes", "Natural modes", _modes),
    Section("response", "Frequency response", _response),
    Section("drive_limits", "Stress and voltage limits", drive_limits_section),
    Section("bridge", "From the beam to the solid", bridge_section),
    Section("uncertainty", "Uncertainty of the parameters", uncertainty_section),
)
