"""The book's figures: convergence of a case, and scatter of measured about reference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tactgen.validation.book.statistics import Scatter
from tactgen.validation.view.figures import BLUE, DARK, GREY, ORANGE, new_figure, panels, svg

#: Errors below this are rounding, and drawn here.
_ROUNDING = 1e-16
#: Lines of errors, and of changes from level to level.
_STYLES = (("o-", BLUE), ("s--", GREY))


class Curve(NamedTuple):
    """Relative errors or changes over sizes."""

    name: str
    sizes: Sequence[int]
    errors: Sequence[float]


def convergence(curves: Sequence[Curve], measure: str, tolerance: float) -> str:
    """Return relative errors over a measure of fineness, with the row's tolerance."""
    figure, axis = panels(6.4, 3.4)
    for curve, (mark, color) in zip(curves, _STYLES[: len(curves)], strict=True):
        axis.plot(
            curve.sizes, np.maximum(np.abs(curve.errors), _ROUNDING), mark, color=color,
            label=curve.name,
        )  # fmt: skip
    axis.set_yscale("log")
    if tolerance > 0.0:
        axis.axhline(tolerance, color=ORANGE, linestyle=":", linewidth=1.0, label="tolerance")
    sizes = sorted({size for curve in curves for size in curve.sizes})
    if sizes[0] > 0:
        axis.set_xscale("log")
    axis.set_xticks(sizes, [f"{size:,}".replace(",", " ") for size in sizes])
    axis.minorticks_off()
    axis.set_xlabel(measure)
    axis.set_ylabel("relative")
    axis.legend(fontsize=8, labelcolor=DARK)
    return svg(figure)


def scattered(groups: dict[str, Scatter]) -> str:
    """Return all groups' values over their references, on one logarithmic square."""
    figure = new_figure(6.4, 5.6)
    axis = figure.add_subplot()
    low = min(float(s.reference.min()) for s in groups.values())
    high = max(float(s.reference.max()) for s in groups.values())
    axis.loglog([low, high], [low, high], color=GREY, linewidth=1.0)
    marks = "os^Dv<>Pp*hX"
    for mark, (name, found) in zip(marks, groups.items(), strict=False):
        axis.loglog(
            found.reference, found.measured, mark, label=name, markersize=5,
            markerfacecolor="none",
        )  # fmt: skip
    axis.set_xlabel("reference (SI or the case's own units)")
    axis.set_ylabel("computed")
    axis.grid(visible=True, alpha=0.25)
    axis.legend(fontsize=8, labelcolor=DARK)
    return svg(figure)
