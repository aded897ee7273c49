"""The suite's own checks run as one job: rows with a verdict, for people and for programs."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal

from tactgen.validation.checks.case import Case
from tactgen.validation.checks.row import Check, run_check

Verdict = Literal["pass", "fail", "explained", "skipped"]

_KNOWN = "tactgen.validation.checks.known."

#: Where the rows or cases of each group are declared; a group is imported when it is asked for.
GROUPS: dict[str, tuple[str, str]] = {
    "beams": (_KNOWN + "beams", "CASES"),
    "laminates": (_KNOWN + "laminates", "CASES"),
    "resonators": (_KNOWN + "resonators", "CASES"),
    "elastic": (_KNOWN + "elastic", "CASES"),
    "coils": (_KNOWN + "coils", "CASES"),
    "orders": (_KNOWN + "orders", "CASES"),
    "bimorph": ("tactgen.validation.checks.bimorph", "CHECKS"),
    "reluctance": ("tactgen.validation.checks.reluctance", "MAGNETIC_CHECKS"),
    "amplitude": ("tactgen.validation.checks.amplitude", "AMPLITUDE_CHECKS"),
    "misprints": (_KNOWN + "misprints", "CASES"),
}


def group_cases(group: str) -> tuple[Case, ...]:
    """Return the cases of a group; rows without one are gathered by the letters of their ids."""
    module, name = GROUPS[group]
    declared: tuple[Case | Check, ...] = getattr(importlib.import_module(module), name)
    gathered: dict[str, Case] = {}
    for entry in declared:
        found = entry if isinstance(entry, Case) else _alone(entry)
        known = gathered.get(found.id)
        if known is not None:
            found = replace(known, rows=known.rows + found.rows)
        gathered[found.id] = found
    return tuple(gathered.values())


def _alone(row: Check) -> Case:
    """Return a case of one row that was declared without a problem of its own."""
    return Case(row.id.rpartition("-")[0], "", "", "", (row,))


def group_rows(group: str) -> tuple[Check, ...]:
    """Return the checks of a group."""
    return tuple(row for found in group_cases(group) for row in found.rows)


def verify(
    groups: Sequence[str], *, heavy: bool, announce: Callable[[str], None]
) -> list[dict[str, Any]]:
    """Run the checks of the groups, and the heavy ones among them if asked to.

    Returns
    -------
    list of dict
        One row a check as plain values: id, group, tier, requirement, unit, measured and
        deviation (null where skipped), reference (a number or [low, high]), source, tolerance,
        reason, verdict, and what explains a known difference.
    """
    rows = []
    for group in groups:
        for check in group_rows(group):
            if check.heavy and not heavy:
                rows.append(_row(group, check, None, None, "skipped"))
                continue
            announce(f"check {check.id}")
            found = run_check(check)
            verdict: Verdict = "explained" if found.status == "differs, explained" else found.status
            rows.append(_row(group, check, found.measured, found.deviation, verdict))
    return rows


def _row(
    group: str, check: Check, measured: float | None, deviation: float | None, verdict: Verdict
) -> dict[str, Any]:
    return {
        "id": check.id,
        "group": group,
        "tier": check.tier,
        "requirement": check.requirement,
        "unit": check.unit,
        "measured": measured,
        "reference": check.reference,
        "deviation": deviation,
        "source": check.source,
        "tolerance": check.tolerance,
        "reason": check.reason,
        "verdict": verdict,
        "explained": check.explained,
    }
