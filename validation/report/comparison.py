"""The models side by side: what the error bars explain, what the bridge does, what is left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from validation.engine.solve import Solution

if TYPE_CHECKING:
    from validation.models.bimorph.bridge import Rung

Verdict = Literal["reference", "agrees", "explained", "model form", "differs"]

#: Quantities compared as single numbers, in the order in which they are shown.
SCALARS = (
    "static_tip_displacement",
    "short_circuit_frequencies",
    "open_circuit_frequencies",
    "coupling_factor",
    "capacitance_free",
    "capacitance_blocked",
)
#: The quantities that the bridge follows, by the rung's attribute.
BRIDGED = {
    "static_tip_displacement": "deflection",
    "short_circuit_frequencies": "first_frequency",
    "capacitance_free": "capacitance",
}
_STATIC = ("static_tip_displacement", "capacitance_free", "capacitance_blocked")
#: A difference is explained if the bridge accounts for all but this fraction of the value:
#: the bridge runs on the coarser mesh of the pair.
UNEXPLAINED = 3e-3
#: Models of one theory must agree to this fraction.
_SAME_THEORY = 1e-8

_ONE_DIMENSIONAL = "one-dimensional: uniform field, no Poisson effect, no d32"
_ON_ROD = "one-dimensional: head rigid around the slot, sections plane where tab and ceramic meet"
_LUMPED = "the inertia is that of the static shapes"


@dataclass(frozen=True)
class Cell:
    """One model's value: number, error bar, difference from the reference, verdict."""

    model: str
    value: float
    uncertainty: float
    difference: float
    verdict: Verdict
    why: str


@dataclass(frozen=True)
class ComparedRow:
    """One quantity by all models; the first bending mode in x stands for a list of modes."""

    quantity: str
    unit: str
    cells: tuple[Cell, ...]

    @property
    def remarks(self) -> list[str]:
        """Why models differ beyond their error bars, each reason once."""
        named: dict[str, list[str]] = {}
        for cell in self.cells:
            if cell.why:
                named.setdefault(cell.why, []).append(cell.model)
        return [f"{', '.join(models)}: {why}" for why, models in named.items()]


def compare(solution: Solution, rungs: Sequence[Rung] | None = None) -> list[ComparedRow]:
    """Compare all scalar quantities with those of the most detailed model.

    Parameters
    ----------
    rungs : sequence of Rung, optional
        The bridge from TMM to the solid, which can explain a difference between them.
    """
    rows = []
    for name in SCALARS:
        if any(q.name == name for q in solution.quantities):
            unit = next(q.unit for q in solution.quantities if q.name == name)
            cells = _cells(solution, name, rungs)
            rows.append(ComparedRow(name, unit, cells))
    return rows


def _cells(solution: Solution, name: str, rungs: Sequence[Rung] | None) -> tuple[Cell, ...]:
    models = tuple(solution.models)
    reference = models[-1]
    found = {model: _first(solution, name, model) for model in models}
    base, base_bar = found[reference]
    cells = []
    for model, (value, bar) in found.items():
        difference = value / base - 1.0 if base != 0.0 else 0.0 if value == base else np.inf
        agrees = abs(value - base) <= bar + base_bar + 1e-12 * abs(base)
        verdict: Verdict = "agrees"
        why = ""
        if model == reference:
            verdict = "reference"
        elif not agrees:
            verdict, why = _judge(solution, name, model, difference, rungs)
        cells.append(Cell(model, value, bar, difference, verdict, why))
    return tuple(cells)


def _judge(
    solution: Solution,
    name: str,
    model: str,
    difference: float,
    rungs: Sequence[Rung] | None,
) -> tuple[Verdict, str]:
    """Return the verdict on a difference that the error bars do not cover, and its reason."""
    if tuple(solution.models)[-1] != "solid":
        if model == "lumped" and name not in _STATIC:
            return "model form", _LUMPED
        return ("agrees", "") if abs(difference) < _SAME_THEORY else ("differs", "not understood")
    reason = _ON_ROD if solution.scene.support.kind == "rod" else _ONE_DIMENSIONAL
    if model == "lumped" and name not in _STATIC:
        reason += f"; {_LUMPED}"
    if rungs is None or name not in BRIDGED:
        return "model form", reason
    first, last = (getattr(rung, BRIDGED[name]) for rung in (rungs[0], rungs[-1]))
    left = (1.0 + difference) * last / first - 1.0
    if abs(left) > UNEXPLAINED + (0.01 if model == "lumped" and name not in _STATIC else 0.0):
        return (
            "differs",
            f"{reason}; the bridge leaves {round(100.0 * left, 2) + 0.0:+.2f} % unexplained",
        )
    return "explained", f"{reason}; the bridge leaves {round(100.0 * left, 2) + 0.0:+.2f} %"


def _first(solution: Solution, name: str, model: str) -> tuple[float, float]:
    """Return a scalar, or the first bending mode in x of a list, with its error bar."""
    q = solution.get(name, model)
    if q.classes is None:
        return float(q.value), float(q.uncertainty)
    if "bending_x" not in q.classes:
        return float("nan"), float("nan")
    at = q.classes.index("bending_x")
    return float(np.asarray(q.value)[at]), float(np.asarray(q.uncertainty)[at])
