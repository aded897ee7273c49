"""``tactgen verify``: the suite's own checks against known answers."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from tactgen.validation.command_line.commands.common import Commands


def add(commands: Commands) -> None:
    """Declare the command."""
    from tactgen.validation.checks.verification import GROUPS

    parser = commands.add_parser("verify", help="the suite's own checks against known answers")
    only = f"{', '.join(GROUPS)}; may be repeated, all by default"
    parser.add_argument("--only", action="append", metavar="GROUP", help=only)
    parser.add_argument("--heavy", action="store_true", help="also what takes minutes")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a check fails."""
    from tactgen.validation.checks.verification import GROUPS, verify
    from tactgen.validation.command_line.plain_values import plain
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.scene.wording import choices

    groups = choices(",".join(options.only or GROUPS), tuple(GROUPS), "group", "--only")
    with announcer() as announce:
        rows = verify(groups, heavy=options.heavy, announce=announce)
    if options.json:
        json.dump({"rows": plain(rows)}, sys.stdout)
        print()
    else:
        _print(rows)
    return int(any(row["verdict"] == "fail" for row in rows))


def _print(rows: list[dict[str, Any]]) -> None:
    from tactgen.validation.view.formats import engineering, percent

    print(f"{'id':9} {'verdict':10} {'measured':>14} {'deviation':>12}  requirement")
    for row in rows:
        known = row["measured"] is not None
        measured = engineering(row["measured"], row["unit"]) if known else "-"
        deviation = percent(row["deviation"]) if known else "-"
        print(
            f"{row['id']:9} {row['verdict']:10} {measured:>14} {deviation:>12}  "
            f"{row['requirement']}"
        )
        if row["verdict"] == "explained":
            print(f"{'':20} {row['explained']}")
    verdicts = [row["verdict"] for row in rows]
    counts = (f"{verdicts.count(v)} {v}" for v in ("pass", "explained", "fail", "skipped"))
    print(", ".join(counts))
