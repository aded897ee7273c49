"""The headline numbers by the most detailed model of a solution, as far as it gives them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.models.comparison import compare
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.uncertainty.headline_numbers import Target


def detailed_numbers(
    scene: Scene, solution: Solution, model: str, targets: Sequence[Target]
) -> dict[str, tuple[float, float]]:
    """Return magnitude and numerical error bar by label; targets without a number are left out.

    Peaks are not searched for, and a model that takes long is not run again.
    """
    scalars = {
        row.quantity: row.cells[-1] for row in compare(scene, solution.quantities, "bimorph")
    }
    responses = _responses(scene, solution, model, targets)
    found = {}
    for target in targets:
        name = target.quantity.name
        if target.frequency is not None:
            near = [
                number
                for f, number in responses.get(name, {}).items()
                if np.isclose(f, target.frequency, rtol=1e-9, atol=0.0)
            ]
            if near:
                found[target.label] = near[0]
        elif name in scalars and not target.peak:
            cell = scalars[name]
            found[target.label] = (abs(cell.value), cell.error)
    return found


def _responses(
    scene: Scene, solution: Solution, model: str, targets: Sequence[Target]
) -> dict[str, dict[float, tuple[float, float]]]:
    """Return each response's magnitude and error bar by frequency (Hz)."""
    wanted = tuple(sorted({t.frequency for t in targets if t.frequency is not None}))
    names = dict.fromkeys(t.quantity.name for t in targets if t.frequency is not None)
    given = [name for name in names if gives(model, name)]
    if MODELS[model].quick and given:
        at_wanted = scene.model_copy(update={"frequency": wanted})
        solution = solve(at_wanted, (model,), given)
    found = {}
    for q in solution.quantities:
        if q.model == model and q.name in given and q.frequency is not None:
            rows = zip(q.frequency, np.abs(q.value), q.error, strict=True)
            found[q.name] = {f: (float(size), float(bar)) for f, size, bar in rows}
    return found
