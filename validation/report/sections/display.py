"""The report's section about the display: parts, clearances, crosstalk, units that differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.display.bill import bill_of_parts, total_mass, wiring
from tactgen.geometry.display.clearances import clearances
from tactgen.geometry.display.layout import levels
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.results import Quantity
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.report.study import Study
from tactgen.validation.view.page.html import inline

#: Clearances shown, the narrowest first.
_NARROWEST = 10


@dataclass(frozen=True)
class Row:
    """A number by all models that gave it."""

    label: str
    meaning: str
    cells: tuple[Quantity, ...]


def display_section(study: Study) -> Context:
    """Return parts, clearances and leads, and what units do to each other and how they differ."""
    from tactgen.validation.export.display_view import drawn_parts
    from tactgen.validation.report.figures.display import crosstalk_plot
    from tactgen.validation.view.pictures import assembly_picture

    device, display = study.scene.device, study.scene.display
    study.announce("picture of the display")
    parts = drawn_parts(study.scene)
    gaps, lines = clearances(device, display), bill_of_parts(device, display)
    asked = [q for q in study.solution.quantities if QUANTITIES[q.name].actuator == "display"]
    return {
        "pictures": [
            {"caption": "the display", "png": inline(assembly_picture(parts))},
            {
                "caption": "cut along a column",
                "png": inline(assembly_picture(parts, cut=500.0 * display.pitch)),
            },
        ],
        "height": levels(device, display).total,
        "bill": lines,
        "mass": total_mass(lines),
        "gaps": gaps[:_NARROWEST],
        "wider": len(gaps) - _NARROWEST,
        "leads": wiring(device, display),
        "numbers": _numbers(asked),
        "units": _units(asked),
        "crosstalk": crosstalk_plot([q for q in asked if q.frequency is not None]),
    }


def _numbers(asked: list[Quantity]) -> list[Row]:
    """Return the scalars, one row each, of models that know a value."""
    known = [q for q in asked if q.value.ndim == 0 and not np.isnan(q.value)]
    names = dict.fromkeys(q.name for q in known)
    return [
        Row(
            QUANTITIES[name].label,
            QUANTITIES[name].meaning,
            tuple(q for q in known if q.name == name),
        )
        for name in names
    ]


def _units(asked: list[Quantity]) -> dict[str, Any] | None:
    """Return the lists over the units by the last model that gave them, None without."""
    listed = [q for q in asked if q.classes is not None]
    if not listed:
        return None
    model = listed[-1].model
    chosen = [q for q in listed if q.model == model]
    (units,) = {q.classes for q in chosen}
    return {
        "model": model,
        "labels": [(QUANTITIES[q.name].label, q.unit) for q in chosen],
        "rows": [
            (name, [(float(q.value[i]), q.unit) for q in chosen])
            for i, name in enumerate(units or ())
        ],
    }


DISPLAY = Section("display", "The display: parts, neighbours, units that differ", display_section)
