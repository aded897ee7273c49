"""Results and plans as plain text tables on stdout."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tactgen.validation.engine.plan import Plan
from tactgen.validation.engine.prospects import Prospect, total
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import Solution
from tactgen.validation.view.formats import engineering, share

#: Arrays over frequency longer than this are shown at a few of their points.
_SHOWN = 12
#: Digits of a value.
_DIGITS = 7


def print_quantities(solution: Solution) -> None:
    """Print every quantity with its error bar; arrays are thinned out."""
    print(f"{'quantity':26} {'model':12} {'at':>10}  {'value':>28}  {'+/-':>9}")
    for q in solution.quantities:
        for label, value, bar in _rows(q):
            print(f"{q.name:26} {q.model:12} {label:>10}  {value:>28}  {bar:>9}")


def print_plan(scene: str, plan: Plan, prospects: dict[str, Prospect]) -> None:
    """Print what runs, with what it cost when it last ran here, and what is skipped, and why."""
    print(f"scene {scene}")
    print("runs:")
    for step in plan.run:
        found = prospects[step.stage]
        cost = "kept" if found.kept else f"{found.seconds:.2g} s" if found.seconds else ""
        print(f"  {step.stage:23} {cost:>7}  {step.reason}  [{step.key}]")
    print(f"  about {total(prospects):.2g} s in all, as far as costs are recorded")
    print("skipped:")
    for skip in plan.skipped:
        print(f"  {skip.stage:23} {skip.reason}")


def format_value(value: Any, unit: str) -> str:
    """Return a real number with its unit, or magnitude and phase of a complex one."""
    if np.iscomplexobj(value):
        phase = math.degrees(math.atan2(value.imag, value.real))
        return f"{engineering(abs(value), unit, _DIGITS)} ∠ {phase:.2f}°"
    if math.isnan(value):
        return "no value"
    return engineering(float(value), unit, _DIGITS)


def _rows(q: Quantity) -> list[tuple[str, str, str]]:
    if q.value.ndim > 1:
        return [("", f"5x5 at {len(q.frequency or ())} frequencies: --json", "")]
    if q.value.ndim == 0:
        return [("", format_value(q.value[()], q.unit), _bar(q, ()))]
    if q.classes is not None:
        labels = [c.replace("bending_", "bend ") for c in q.classes]
    else:
        labels = [engineering(f, "Hz") for f in q.frequency or ()]
    picked = np.unique(np.linspace(0, len(labels) - 1, min(len(labels), _SHOWN)).astype(int))
    return [(labels[i], format_value(q.value[i], q.unit), _bar(q, i)) for i in picked]


def _bar(q: Quantity, at: int | tuple[()]) -> str:
    """Return an error bar as a share of its value, in the value's unit where that is zero."""
    size, bar = float(abs(q.value[at])), float(q.error[at])
    if math.isnan(bar) or math.isnan(size):
        return "-"
    return share(bar / size) if size > 0.0 else engineering(bar, q.unit, 2)
