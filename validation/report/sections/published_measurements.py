"""The report's section of the paper's measurements beside their predictions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.validation.report.report_data import Context, Section, Study
from tactgen.validation.show.figures import BLUE, DARK, ORANGE, panels, svg
from tactgen.validation.studies.published_measurements import (
    PRELOADS,
    Comparison,
    Unknown,
    all_compared,
)

#: How far the picture reaches, over the printed value.
_REACH = (-3.0, 15.0)
#: Unknowns named beside a band, and those that a further measurement would have to settle first.
_NAMED, _FIRST = 2, 6


def bands_plot(comparisons: Sequence[Comparison]) -> str:
    """Plot each band over what is printed, which is 1."""
    rows = [p for found in comparisons for p in found.predictions]
    figure, axis = panels(10.0, 0.36 * len(rows) + 1.0)
    for at, row in enumerate(rows):
        low, high, middle = row.published.low, row.published.high, row.published.middle
        ends = np.clip(np.array(row.band) / middle, *_REACH)
        axis.plot(ends, [at, at], color=BLUE, linewidth=7.0, alpha=0.4, solid_capstyle="butt")
        axis.plot(np.clip(row.usual / middle, *_REACH), at, "o", color=DARK, markersize=4)
        axis.plot([low / middle, high / middle], [at, at], color=ORANGE, linewidth=3.0)
    axis.axvline(1.0, color=ORANGE, linewidth=1.0)
    axis.set_xscale("symlog", linthresh=1.0)
    ticks = [-2.0, -1.0, 0.0, 1.0, 2.0, 5.0, 10.0]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_yticks(range(len(rows)), [row.published.words for row in rows])
    axis.set(xlim=_REACH, xlabel="predicted over printed")
    axis.invert_yaxis()
    return svg(figure)


def _open(comparisons: Sequence[Comparison]) -> list[tuple[Unknown, str, float]]:
    """Unknowns that decide most: each with the number that it is worth most to, and how much."""
    found: dict[str, tuple[Unknown, str, float]] = {}
    for comparison in comparisons:
        for unknown in comparison.figure.unknowns:
            for row in comparison.predictions:
                share = row.shares[unknown.name]
                if share > found.get(unknown.name, (unknown, "", 0.0))[2]:
                    found[unknown.name] = unknown, row.published.words, share
    return sorted(found.values(), key=lambda entry: -entry[2])


def _measurements(study: Study) -> Context:
    if study.quick:
        return {"comparisons": ()}
    study.announce("the paper's measurements beside their predictions")
    comparisons: list[Comparison] = study.begun("measurements", all_compared)
    unknowns = {u.name: u for found in comparisons for u in found.figure.unknowns}
    return {
        "comparisons": comparisons,
        "picture": bands_plot(comparisons),
        "unknowns": list(unknowns.values()),
        "decide": _open(comparisons)[:_FIRST],
        "preloads": PRELOADS,
        "named": _NAMED,
    }


MEASUREMENTS = Section("measurements", "Beside the measurements", _measurements)
