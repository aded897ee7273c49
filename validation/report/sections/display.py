"""The report's section about the display: parts, clearances, crosstalk, units that differ."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tactgen.geometry.display.bill import bill_of_parts, total_mass, wiring
from tactgen.geometry.display.clearances import clearances
from tactgen.geometry.display.layout import levels
from tactgen.validation.catalogue.quantities import QUANTITIES, QuantityRow
from tactgen.validation.models.model import Quantity
from tactgen.validation.report.report_data import Context, Section, Study
from tactgen.validation.show.figures import panels, plain_numbers, shades, svg
from tactgen.validation.show.page import Still


def crosstalk_plot(found: Sequence[Quantity]) -> str:
    """Plot ratios of tips' motions by the last model that gave them; nothing without any."""
    shown = [q for q in found if q.model == found[-1].model and np.isfinite(q.value).any()]
    if not shown:
        return ""
    figure, axis = panels(8.0, 4.2)
    for colour, q in zip(shades(len(shown)), shown, strict=True):
        label = f"{q.name.replace('_', ' ')}, {q.model}"
        axis.plot(q.frequency, 100.0 * np.abs(q.value), color=colour, label=label)
    axis.set(xlabel="frequency (Hz)", ylabel="of the driven tip's motion (%)", yscale="log")
    if min(shown[0].frequency or (0.0,)) > 0.0:
        axis.set(xscale="log")
        plain_numbers(axis.xaxis)
    axis.legend(fontsize=8)
    return svg(figure)


#: Clearances shown, the narrowest first.
_NARROWEST = 10


def display_section(study: Study) -> Context:
    """Parts, clearances, leads, crosstalk and scatter of the units."""
    from tactgen.validation.show.display import drawn_parts
    from tactgen.validation.show.pictures import assembly_picture

    device, display = study.scene.device, study.scene.display
    study.announce("picture of the display")
    parts = drawn_parts(study.scene)
    gaps, lines = clearances(device, display), bill_of_parts(device, display)
    asked = [q for q in study.solution.quantities if QUANTITIES[q.name].actuator == "display"]
    return {
        "pictures": [
            Still(assembly_picture(parts), "the display"),
            Still(assembly_picture(parts, cut=500.0 * display.pitch), "cut along a column"),
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


def _numbers(asked: list[Quantity]) -> list[tuple[QuantityRow, list[Quantity]]]:
    """Scalars, each with its answers by the models that know a value."""
    known = [q for q in asked if q.value.ndim == 0 and not np.isnan(q.value)]
    names = dict.fromkeys(q.name for q in known)
    return [(QUANTITIES[name], [q for q in known if q.name == name]) for name in names]


def _units(asked: list[Quantity]) -> dict[str, Any] | None:
    """Lists over the units by the last model that gave them, None without."""
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
