"""Request of a report: quantities, models, frequencies."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.solve import check_models, check_request
from tactgen.validation.report.reluctance_data import is_of_rest, needs_map
from tactgen.validation.scene.scene import Scene

#: Points of the frequency response in the report.
_PLOT_POINTS = 400
#: Accuracy that the quick version is content with.
_QUICK_ACCURACY = 1e-2


def shown_model(scene: Scene) -> str | None:
    """Field model to be shown, if the scene asks for one: bricks before tetrahedra."""
    return next((name for name in ("solid", "cad") if name in scene.models), None)


def check_report(scene: Scene, *, quick: bool) -> None:
    """Refuse scenes that cannot be reported on, before any computation.

    Raises InputError with the remedy.
    """
    asked = prepared(scene, quick=quick)
    magnetic = any(QUANTITIES[name].actuator == "reluctance" for name in asked.quantities)
    if magnetic and not scene.coil.current and scene.support.kind != "contact":
        raise InputError(
            "coil.current = 0 mA leaves nothing of the normal actuator to report; set the current "
            "of interest, such as coil.current=130mA, or leave its models out"
        )
    check_request(asked, asked.models, asked.quantities)


def prepared(scene: Scene, *, quick: bool) -> Scene:
    """Scene with all quantities, a sweep dense enough to plot, coarser if quick.

    An actuator of which the scene asks for no quantity, or no model, is left alone.

    Raises InputError if the scene asks for a quantity that none of its models can compute.
    """
    check_models(scene.models, scene.quantities)
    about = {QUANTITIES[name].actuator for name in scene.quantities}
    joined = about & {"generator", "display"}
    if joined:
        about.add("bimorph")
    models = tuple(
        name
        for name in scene.models
        if MODELS[name].actuator in about
        or any(gives(name, q) for q in scene.quantities if QUANTITIES[q].actuator in joined)
    )
    named = (name for name in scene.quantities if QUANTITIES[name].by_name)
    quantities = (*quantities_of(models, about, quick=quick), *named)
    if scene.circuit.kind != "source":  # nothing is felt
        quantities = tuple(name for name in quantities if not QUANTITIES[name].has_level)
    if scene.support.kind == "contact" and not scene.coil.current:
        # without current a pull, an inductance say nothing: see Study.normal
        own = (n for n in quantities if QUANTITIES[n].actuator != "reluctance" or is_of_rest(n))
        quantities = tuple(own)
    changes: dict[str, Any] = {"models": models, "quantities": quantities}
    low, high = min(scene.frequency), max(scene.frequency)
    if low < high and len(scene.frequency) < _PLOT_POINTS:
        spaced = np.geomspace if 0.0 < 30.0 * low < high else np.linspace
        changes["frequency"] = (low, *spaced(low, high, _PLOT_POINTS)[1:-1].tolist(), high)
    if quick:
        changes["accuracy"] = max(scene.accuracy, _QUICK_ACCURACY)
    return scene.model_copy(update=changes)


def quantities_of(models: Sequence[str], about: Collection[str], *, quick: bool) -> tuple[str, ...]:
    """Quantities of some actuators that models give unasked; if quick, none by slow maps."""
    found = tuple(
        name
        for name, row in QUANTITIES.items()
        if row.actuator in about and not row.by_name and any(gives(m, name) for m in models)
    )
    slow = any(
        needs_map(name) and gives(model, name) and not MODELS[model].quick
        for name in found
        for model in models
    )
    return tuple(name for name in found if not (quick and slow and needs_map(name)))
