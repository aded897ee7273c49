"""The main contributors to the parameter uncertainty of each headline number, as inline SVG."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tactgen.validation.studies.uncertainty.propagation import Uncertainty
from tactgen.validation.view.figures import GREY, SKY, panels, svg

#: Contributors shown per number, and panels per row.
_SHOWN, _COLUMNS = 5, 3


def contributors_plot(rows: Sequence[Uncertainty]) -> str:
    """Plot Sobol's total index of the largest contributors, one panel per headline number.

    The thin line is the 95 % confidence interval of the estimate.
    """
    lines = math.ceil(len(rows) / _COLUMNS)
    figure, grid = panels(
        10.0, 1.75 * lines, nrows=lines, ncols=_COLUMNS, squeeze=False, sharex=True
    )
    axes = grid.ravel()
    for axis, row in zip(axes, rows, strict=False):
        largest = row.contributors[:_SHOWN]
        names = [key.replace("_", " ").replace(".", ": ", 1) for key, _, _ in largest]
        axis.barh(
            names,
            [100.0 * index for _, index, _ in largest],
            xerr=[100.0 * bar for _, _, bar in largest],
            color=GREY if row.target.ill_conditioned else SKY,
            error_kw={"elinewidth": 1.0},
        )
        axis.invert_yaxis()
        axis.set_title(row.target.label, loc="right", fontsize=10)  # longer than the panel
        axis.tick_params(labelsize=8)
    for axis in axes[len(rows) :]:
        axis.set_visible(False)
    for axis in axes[max(0, len(rows) - _COLUMNS) : len(rows)]:
        axis.set_xlabel("share of variance (%)")
        axis.tick_params(labelbottom=True)
    axes[0].set_xlim(0.0, 100.0)
    return svg(figure)
