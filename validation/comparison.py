"""The four models side by side: differences, and whether the error bars explain them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from validation.solve import Solution

#: Quantities compared as single numbers, in the order in which they are shown.
SCALARS = (
    "static_tip_displacement",
    "short_circuit_frequencies",
    "open_circuit_frequencies",
    "coupling_factor",
    "capacitance_free",
    "capacitance_blocked",
)
_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
#: What separates a model from the solid, where it does: shown beside a difference that
#: numerical error bars do not explain.
MODEL_FORM = {
    "lumped": "one-dimensional (uniform field, no Poisson effect, no d32), see the bridge",
    "tmm": "one-dimensional (uniform field, no Poisson effect, no d32), see the bridge",
    "beam": "one-dimensional (uniform field, no Poisson effect, no d32), see the bridge",
}
#: The same for a bimorph in the rod.
ROD_FORM = (
    "one-dimensional, the glue rigid and all sections plane where tab, slot and ceramic meet; "
    "the solid's joint is softer"
)
#: What sets the lumped model apart from the exact beam besides.
LUMPED_FORM = "frequencies take the inertia from the static shapes"


@dataclass(frozen=True)
class Cell:
    """One model's value: number, error bar, difference from the reference, verdict."""

    model: str
    value: float
    uncertainty: float
    difference: float
    verdict: str
    why: str


@dataclass(frozen=True)
class ComparedRow:
    """One quantity by all models; the first bending mode stands for a list of modes."""

    quantity: str
    unit: str
    reference_model: str
    cells: tuple[Cell, ...]

    @property
    def remarks(self) -> list[str]:
        """Why models differ beyond their error bars, each reason once."""
        named: dict[str, list[str]] = {}
        for cell in self.cells:
            if cell.verdict == "explained":
                named.setdefault(cell.why, []).append(cell.model)
        return [f"{', '.join(models)}: {why}" for why, models in named.items()]


def compare(solution: Solution) -> list[ComparedRow]:
    """Compare all scalar quantities of a solution with its most detailed model."""
    models = tuple(solution.models)
    reference = models[-1]
    rows = []
    for name in SCALARS:
        if not any(q.name == name for q in solution.quantities):
            continue
        found = {model: _first(solution, name, model) for model in models}
        base, base_bar = found[reference]
        cells = []
        for model, (value, bar) in found.items():
            difference = value / base - 1.0
            agrees = abs(value - base) <= bar + base_bar + 1e-12 * abs(base)
            verdict, why = ("agrees", "within the numerical error bars")
            if model == reference:
                verdict, why = "reference", ""
            elif not agrees:
                on_rod = solution.scene.support.kind == "rod"
                verdict, why = "explained", ROD_FORM if on_rod else MODEL_FORM[model]
                if model == "lumped" and name not in _STATIC:
                    why += f"; {LUMPED_FORM}"
            cells.append(Cell(model, value, bar, difference, verdict, why))
        unit = next(q.unit for q in solution.quantities if q.name == name)
        rows.append(ComparedRow(name, unit, reference, tuple(cells)))
    return rows


def _first(solution: Solution, name: str, model: str) -> tuple[float, float]:
    """Return a scalar, or the first bending mode in x of a list, with its error bar."""
    q = solution.get(name, model)
    if q.classes is None:
        return float(q.value), float(q.uncertainty)
    at = q.classes.index("bending_x")
    return float(np.asarray(q.value)[at]), float(np.asarray(q.uncertainty)[at])
