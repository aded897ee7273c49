"""Report section on the uncertainty of the headline numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tactgen.validation.catalogue.models import MODELS, gives, ranked
from tactgen.validation.engine.comparison import compare
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.report.report_data import Context, Study
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.figures import GREY, SKY, panels, svg
from tactgen.validation.studies.parameter_uncertainty import (
    Target,
    Uncertainty,
    affordable,
    base_samples,
    left_out,
    range_text,
    uncertain_parameters,
)

#: Contributors shown per number, and panels per row.
_SHOWN, _COLUMNS = 5, 3


def contributors_plot(rows: Sequence[Uncertainty]) -> str:
    """Plot Sobol's total index of the largest contributors, one panel per headline number.

    The thin line is the 95 % confidence interval of the estimate.
    """
    lines = math.ceil(len(rows) / _COLUMNS)
    figure, grid = panels(
        10.0, 1.75 * lines, nrows=lines, ncols=_COLUMNS, squeeze=False, sharex=True
    )
    axes = grid.ravel()
    for axis, row in zip(axes, rows, strict=False):
        largest = row.contributors[:_SHOWN]
        names = [key.replace("_", " ").replace(".", ": ", 1) for key, _, _ in largest]
        axis.barh(
            names,
            [100.0 * index for _, index, _ in largest],
            xerr=[100.0 * bar for _, _, bar in largest],
            color=GREY if row.target.ill_conditioned else SKY,
            error_kw={"elinewidth": 1.0},
        )
        axis.invert_yaxis()
        axis.set_title(row.target.label, loc="right", fontsize=10)  # longer than the panel
        axis.tick_params(labelsize=8)
    for axis in axes[len(rows) :]:
        axis.set_visible(False)
    for axis in axes[max(0, len(rows) - _COLUMNS) : len(rows)]:
        axis.set_xlabel("share of variance (%)")
        axis.tick_params(labelbottom=True)
    axes[0].set_xlim(0.0, 100.0)
    return svg(figure)


def detailed_numbers(
    scene: Scene, solution: Solution, model: str, targets: Sequence[Target]
) -> dict[str, tuple[float, float]]:
    """Magnitude and numerical error bar by label; targets without a number are left out.

    A model that takes long is not run again; its peaks are those of the scene's band.
    """
    scalars = {
        row.quantity: row.cells[-1] for row in compare(scene, solution.quantities, "bimorph")
    }
    frequencies = {t.frequency for t in targets if t.frequency is not None}
    names = dict.fromkeys(t.name for t in targets if t.frequency is not None)
    given = [name for name in names if gives(model, name)]
    if MODELS[model].quick and given:
        at_wanted = scene.model_copy(update={"frequency": tuple(sorted(frequencies))})
        solution = solve(at_wanted, (model,), given)
    found = {}
    for target in targets:
        name = target.name
        if target.frequency is not None:
            for q in (q for q in solution.quantities if (q.name, q.model) == (name, model)):
                near = np.isclose(q.frequency or (), target.frequency, rtol=1e-9, atol=0.0)
                for at in np.flatnonzero(near):
                    found[target.label] = float(abs(q.value[at])), float(q.error[at])
        elif target.peak == "height":
            for q in (q for q in solution.quantities if (q.name, q.model) == (name, model)):
                if q.extreme and not q.extreme_at_end:
                    found[target.label] = q.extreme.value, q.extreme.error
        elif name in scalars and not target.peak:
            cell = scalars[name]
            found[target.label] = (abs(cell.value), cell.error)
    return found


def uncertainty_section(study: Study) -> Context:
    """Section on the headline numbers and their uncertainty."""
    scene, solution, rows = study.scene, study.solution, study.parameter_uncertainty
    parameters = uncertain_parameters(scene)
    detailed = ranked(solution.models_of("bimorph"))[-1]
    omitted = left_out(scene)
    return {
        "uncertainties": rows,
        "uncertain_parameters": parameters,
        "range_texts": {key: range_text(key, spread) for key, spread in parameters.items()},
        "contributors_plot": contributors_plot(rows),
        "evaluations": base_samples(len(parameters), affordable(scene)) * (len(parameters) + 2),
        "detailed_model": detailed if detailed != "tmm" else None,
        "detailed": detailed_numbers(scene, solution, detailed, [row.target for row in rows]),
        "left_out": f"{omitted[0].upper()}{omitted[1:]}." if omitted else "",
    }
