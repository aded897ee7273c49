"""Tolerances and known deviations of all rows are those that were agreed on."""

import json
from pathlib import Path

import numpy as np
from approved import described

from tactgen.validation.checks.verification import GROUPS, group_cases

AGREED = Path(__file__).parents[2] / "data" / "tolerances.json"


def test_no_tolerance_moves_unseen():
    """A row passes as well with a tolerance three times as wide: so each is written down twice.
    So is which are heavy: what is not runs with every change.

    Who adds a row adds it to the file; who changes one says why.
    """
    rows = [row for group in GROUPS for case in group_cases(group) for row in case.rows]
    stated = {
        row.id: [row.tolerance, *([row.known] if row.known else []), *["heavy"][: row.heavy]]
        for row in rows
    }
    assert stated == json.loads(AGREED.read_text(encoding="utf-8"))


def test_what_is_known_to_differ_is_explained_and_nothing_else():
    """By how much, and why: neither without the other."""
    for group in GROUPS:
        for case in group_cases(group):
            for row in case.rows:
                assert bool(row.explained) == (row.known != 0.0), row.id


def test_references_of_all_rows(approved):
    """What each is held against, in its unit, tier and report."""
    lines = [
        f"{row.id} {described(np.array(row.reference))} {row.unit} | {row.tier} | {row.scene}"
        for group in GROUPS
        for case in group_cases(group)
        for row in case.rows
    ]
    approved("\n".join(lines))
