"""The book's figures: convergence of a case, and scatter of measured about reference."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.validation.book.statistics import Scatter
from tactgen.validation.view.figures import BLUE, DARK, GREY, ORANGE, new_figure, panels, svg

#: Errors below this are rounding, and drawn here.
_ROUNDING = 1e-16


def convergence(sizes: Sequence[int], errors: Sequence[float], tolerance: float) -> str:
    """Return the relative error over the number of unknowns, with the row's tolerance."""
    figure, axis = panels(6.4, 3.4)
    axis.loglog(sizes, np.maximum(np.abs(errors), _ROUNDING), "o-", color=BLUE)
    if tolerance > 0.0:
        axis.axhline(tolerance, color=ORANGE, linestyle="--", linewidth=1.0)
        axis.annotate("tolerance", (sizes[0], tolerance), color=ORANGE, va="bottom", fontsize=9)
    axis.set_xlabel("level" if max(sizes) < 20 else "unknowns")
    axis.set_ylabel("relative error")
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
