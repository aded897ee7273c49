"""Report sections on beam against solid, support and material."""

from __future__ import annotations

from tactgen.geometry.device.parameters import Piezo
from tactgen.validation.models.difference import CAPACITANCE, DEFLECTION, FIRST_FREQUENCY
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.bimorph_figures import breakdown_plot
from tactgen.validation.report.sections.section import Context
from tactgen.validation.scene.scene import Scene

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
    first, last = steps[0].values, steps[-1].values
    return {
        "bridge": steps,
        "plot": breakdown_plot(steps, {key: title for key, title, _, _ in COLUMNS}, "the solid"),
        "off": [first[key] / last[key] - 1.0 for key, _, _, _ in COLUMNS],
        "columns": COLUMNS,
        # in series each layer has half the voltage, and the terminals half the charge
        "layers": 2.0 if study.scene.bimorph.wiring == "series" else 1.0,
        "replaced": replaced_constants(study.scene),
    }


def replaced_constants(scene: Scene) -> list[str]:
    """Keys of the ceramic's constants that are not the library's."""
    library = Piezo(material=scene.piezo.material)
    changed = (
        n for n in type(library).model_fields if getattr(scene.piezo, n) != getattr(library, n)
    )
    return [f"piezo.{name}" for name in changed]
