"""What a coverage run shows: a table, CSVs of verdicts and of answers, the calibration curve."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

from tactgen.geometry.files import write_text
from tactgen.validation.checks.coverage.result import MULTIPLES, PROMISED, WIDE, calibration
from tactgen.validation.checks.coverage.run import Part
from tactgen.validation.view.figures import GREY, panels, svg


def table(parts: Sequence[Part]) -> str:
    """Return the parts as lines of text."""
    lines = []
    for part in parts:
        lines.append(f"{part.name}: {part.what}; {part.devices} devices, seed {part.seed}")
        lines.append(f"  {'quantity':28} {'devices':>7} {'inside':>12} {'bar/error':>10}  verdict")
        for row in part.rows:
            share = f"{row.inside}/{row.count}"
            lines.append(
                f"  {row.quantity:28} {row.devices:>7} {share:>12} {row.width:>10.2g}"
                f"  {row.verdict}"
            )
            if not row.holds:
                worst = row.worst
                lines.append(f"    worst: {worst.error:.1e} beside a bar of {worst.bar:.1e}")
                lines.append(f"    at {worst.where}")
    if any(row.verdict == "wide" for part in parts for row in part.rows):
        lines.append(f"wide: bars that cover, but of a median bar/error beyond {WIDE:g}")
    return "\n".join(lines)


def write(parts: Sequence[Part], out: Path) -> list[Path]:
    """Write verdicts and all answers as CSV, the calibration curves as SVG; return the files."""
    verdicts: list[Sequence[object]] = [
        ["part", "seed", "quantity", "devices", "inside", "answers", "median bar/error", "verdict"]
    ]
    answers: list[Sequence[object]] = [
        ["part", "seed", "device", "quantity", "relative error", "relative bar"]
    ]
    for part in parts:
        verdicts += [
            [part.name, part.seed, r.quantity, r.devices, r.inside, r.count, r.width, r.verdict]
            for r in part.rows
        ]
        answers += [
            [part.name, part.seed, one.where, one.quantity, float(one.error), float(one.bar)]
            for one in part.answers
        ]
    return [
        write_text(out / "verdicts.csv", _csv(verdicts)),
        write_text(out / "coverage.csv", _csv(answers)),
        write_text(out / "calibration.svg", calibration_plot(parts)),
    ]


def _csv(lines: Sequence[Sequence[object]]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(lines)
    return buffer.getvalue()


def calibration_plot(parts: Sequence[Part]) -> str:
    """Return the share of errors within so many times the bar, a curve for each part."""
    figure, axis = panels(6.4, 4.0)
    for part in parts:
        axis.semilogx(MULTIPLES, 100.0 * calibration(part.answers), label=part.name)
    axis.axhline(100.0 * PROMISED, color=GREY, linestyle="--", linewidth=1.0)
    axis.axvline(1.0, color=GREY, linestyle="--", linewidth=1.0)
    axis.set_xlabel("multiple of the bar")
    axis.set_ylabel("errors within it (%)")
    axis.legend(fontsize=9)
    return svg(figure)
