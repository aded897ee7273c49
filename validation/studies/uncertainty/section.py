"""The report's section on what the ranges of the parameters do to the headline numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tactgen.validation.catalogue.models import ranked
from tactgen.validation.engine.solve import Solution
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.uncertainty.detailed_numbers import detailed_numbers
from tactgen.validation.studies.uncertainty.headline_numbers import actuator
from tactgen.validation.studies.uncertainty.propagation import (
    Uncertainty,
    affordable,
    base_samples,
    uncertain_parameters,
)
from tactgen.validation.studies.uncertainty.varied_keys import left_out


def section(scene: Scene, solution: Solution, rows: Sequence[Uncertainty]) -> dict[str, Any]:
    """Return what the report shows of the headline numbers and their uncertainty."""
    from tactgen.validation.studies.uncertainty.plot import contributors_plot

    parameters = uncertain_parameters(scene)
    detailed = ranked(solution.models_of("bimorph"))[-1]
    omitted = left_out(scene, actuator(scene))
    return {
        "uncertainties": rows,
        "uncertain_parameters": parameters,
        "contributors_plot": contributors_plot(rows),
        "evaluations": base_samples(len(parameters), affordable(scene)) * (len(parameters) + 2),
        "detailed_model": detailed if detailed != "tmm" else None,
        "detailed": detailed_numbers(scene, solution, detailed, [row.target for row in rows]),
        "left_out": f"{omitted[0].upper()}{omitted[1:]}." if omitted else "",
    }
