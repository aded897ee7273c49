"""The suite's own checks run as one job: rows with a verdict, for people and for programs."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from typing import Any, Literal

from tactgen.validation.checks.row import Check, run_check

Verdict = Literal["pass", "fail", "explained", "skipped"]

#: Where the rows of each group are declared; a group is imported when it is asked for.
GROUPS: dict[str, tuple[str, str]] = {
    "bimorph": ("tactgen.validation.checks.bimorph", "CHECKS"),
    "reluctance": ("tactgen.validation.checks.reluctance", "MAGNETIC_CHECKS"),
    "amplitude": ("tactgen.validation.checks.amplitude", "AMPLITUDE_CHECKS"),
}


def group_rows(group: str) -> tuple[Check, ...]:
    """Return the checks of a group."""
    module, name = GROUPS[group]
    rows: tuple[Check, ...] = getattr(importlib.import_module(module), name)
    return rows


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
