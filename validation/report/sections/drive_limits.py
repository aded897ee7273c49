"""The report's section on the ceramic's stress and the drive voltages that limits allow."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.beam.ceramic_stress import driven_ceramic
from tactgen.tmm.beam.transfer_matrix import multiport
from tactgen.tmm.ports.excitation_and_circuit import ELECTRICAL, UNIT_VOLTAGE, excitation_of
from tactgen.tmm.ports.multiport import in_series, respond
from tactgen.tmm.ports.supports_and_loads import attach
from tactgen.validation.catalogue.models import ranked
from tactgen.validation.catalogue.quantities import (
    CERAMIC_STRESS,
    REASONS,
    VOLTAGE_LIMIT,
    voltage_limits,
)
from tactgen.validation.engine.answers import representative
from tactgen.validation.report.report_data import Context, Study
from tactgen.validation.report.sections.bimorph_figures import MODEL_STYLE
from tactgen.validation.scene.conditions import driven_in_words
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.figures import BLUE, GREEN, ORANGE, panels, svg

#: Points of the limits' curves: a peak lies between two frequencies of a coarser sweep.
_POINTS = 800


def drive_limits_section(study: Study) -> Context | None:
    """Stress and voltage limits of every model; None where neither has a value."""
    stress, limit = (study.solution.by_model(row.name) for row in (CERAMIC_STRESS, VOLTAGE_LIMIT))
    models = [m for m in ranked(stress) if np.isfinite(stress[m].value).any()]
    if not models or max(study.scene.frequency) <= 0.0:
        return None
    return {
        "rows": [(m, representative(stress[m]), representative(limit[m])) for m in models],
        "picture": _picture(study, models),
        "driven": driven_in_words(study.scene.drive, study.scene.circuit),
        "limits": study.scene.limits,
        "stress_still": study.shown.get("modes", {}).get("stress"),
    }


def _picture(study: Study, models: list[str]) -> str:
    """Plot the stress by all models beside the voltage at which each limit is reached."""
    scene, frequency = study.scene, np.asarray(study.scene.frequency)
    figure, (left, right) = panels(10.0, 3.6, ncols=2)
    for model in models:
        stress = study.known(study.solution.get(CERAMIC_STRESS.name, model))
        left.plot(frequency, 1e-6 * np.abs(stress), label=model, **MODEL_STYLE[model])
    strength = 1e-6 * scene.limits.ceramic_strength
    left.axhline(strength, color="black", linewidth=0.9, linestyle=":", label="strength")
    left.set(yscale="log", xlabel="frequency (Hz)", ylabel="stress in the ceramic (MPa)",
             title=driven_in_words(scene.drive, scene.circuit))  # fmt: skip
    found = _limits(scene)
    if found is not None:
        at, limits = found
        for reason, curve, colour in zip(REASONS, limits, (ORANGE, BLUE, GREEN), strict=True):
            right.plot(at, curve, color=colour, label=reason)
        right.fill_between(at, limits.min(axis=0), color=BLUE, alpha=0.08, linewidth=0.0)
        if source := abs(excitation_of(scene.circuit, scene.drive).source):
            right.axhline(source, color="black", linewidth=0.9, linestyle=":",
                          label="drive voltage")  # fmt: skip
    right.set(yscale="log", xlabel="frequency (Hz)", ylabel="voltage, peak (V)",
              title="voltage at which each limit is reached (tmm)")  # fmt: skip
    for axis in (left, right):
        if min(frequency) > 0.0 and max(frequency) > 30.0 * min(frequency):
            axis.set_xscale("log")
        axis.legend(frameon=False, fontsize=8)
    return svg(figure)


def _limits(scene: Scene) -> tuple[Floats, Floats] | None:
    """Frequencies (n,) and limits (3, n) in V by the transfer matrix; None without a stress."""
    highest = max(scene.frequency)
    lowest = max(min(scene.frequency), 1e-3 * highest)
    if not highest > lowest:
        return None
    frequencies = np.geomspace(lowest, highest, _POINTS)
    port = multiport(scene.device, scene.support, scene.beam, frequencies)
    port = in_series(port) if scene.bimorph.wiring == "series" else port
    response = respond(attach(port, scene.ends), {ELECTRICAL: 1.0})
    driven = driven_ceramic(
        scene.device, scene.beam, scene.ends, frequencies, response, UNIT_VOLTAGE
    )
    return (
        None
        if np.isnan(driven.stress).any()
        else (frequencies, voltage_limits(driven, scene.limits))
    )
