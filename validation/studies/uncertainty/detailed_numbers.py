"""The headline numbers by the most detailed model of a solution, as far as it gives them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from validation.engine.solve import Solution, solve
from validation.report.comparison import compare
from validation.scene.scene import Scene
from validation.studies.uncertainty.headline_numbers import Target

#: Models that answer at any frequency in milliseconds; others only where they were asked.
_QUICK = ("lumped", "tmm", "beam")


def detailed_numbers(
    scene: Scene, solution: Solution, model: str, targets: Sequence[Target]
) -> dict[str, tuple[float, float]]:
    """Return magnitude and numerical error bar by label; targets without a number are left out.

    Peaks are not searched for, and a model that costs minutes per sweep is not run again.
    """
    scalars = {row.quantity: row.cells[-1] for row in compare(solution)}
    responses = _responses(scene, solution, model, targets)
    found = {}
    for target in targets:
        if target.frequency is not None:
            near = [f for f in responses if np.isclose(f, target.frequency, rtol=1e-9, atol=0.0)]
            if near:
                found[target.label] = responses[near[0]]
        elif target.quantity in scalars:
            cell = scalars[target.quantity]
            found[target.label] = (abs(cell.value), cell.uncertainty)
    return found


def _responses(
    scene: Scene, solution: Solution, model: str, targets: Sequence[Target]
) -> dict[float, tuple[float, float]]:
    """Return the tip displacement's magnitude and error bar by frequency (Hz)."""
    wanted = tuple(sorted({t.frequency for t in targets if t.frequency is not None}))
    if model in _QUICK and wanted:
        at_wanted = scene.model_copy(update={"frequency": wanted})
        solution = solve(at_wanted, (model,), ("tip_displacement",))
    for q in solution.quantities:
        if (q.name, q.model) == ("tip_displacement", model) and q.frequency is not None:
            rows = zip(q.frequency, np.abs(q.value), q.uncertainty, strict=True)
            return {f: (float(size), float(bar)) for f, size, bar in rows}
    return {}
