"""Results and plans as plain text tables on stdout."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tactgen.validation.engine.plan import Plan
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import Solution

#: Arrays over frequency longer than this are shown at a few of their points.
_SHOWN = 12


def print_quantities(solution: Solution) -> None:
    """Print every quantity with its error bar; arrays are thinned out."""
    print(f"{'quantity':26} {'model':12} {'at':>10}  {'value':>28}  {'+/-':>9}  unit")
    for q in solution.quantities:
        for label, value, bar in _rows(q):
            print(f"{q.name:26} {q.model:12} {label:>10}  {value:>28}  {bar:>9}  {q.unit}")


def print_plan(scene: str, plan: Plan) -> None:
    """Print what runs and what is skipped, each with its reason."""
    print(f"scene {scene}")
    print("runs:")
    for step in plan.run:
        print(f"  {step.stage:23} {step.reason}  [{step.key}]")
    print("skipped:")
    for skip in plan.skipped:
        print(f"  {skip.stage:23} {skip.reason}")


def format_value(value: Any) -> str:
    """Return a real number, or magnitude and phase in degrees of a complex one."""
    if np.iscomplexobj(value):
        return f"{abs(value):.6g} ∠ {math.degrees(math.atan2(value.imag, value.real)):.2f}°"
    if math.isnan(value):
        return "no value"
    return f"{float(value):.8g}"


def _rows(q: Quantity) -> list[tuple[str, str, str]]:
    if q.value.ndim > 1:
        return [("", f"5x5 at {len(q.frequency or ())} frequencies: --json", "")]
    if q.value.ndim == 0:
        bar = "-" if np.isnan(q.uncertainty) else f"{float(q.uncertainty):.1e}"
        return [("", format_value(q.value[()]), bar)]
    if q.classes is not None:
        labels = [c.replace("bending_", "bend ") for c in q.classes]
    else:
        labels = [f"{f:g} Hz" for f in q.frequency or ()]
    picked = np.unique(np.linspace(0, len(labels) - 1, min(len(labels), _SHOWN)).astype(int))
    bars = ("-" if math.isnan(bar) else f"{bar:.1e}" for bar in q.uncertainty[picked])
    return [(labels[i], format_value(q.value[i]), bar) for i, bar in zip(picked, bars, strict=True)]
