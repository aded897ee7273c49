"""What one driven unit of the display moves at the others, over frequency."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.validation.engine.results import Quantity
from tactgen.validation.view.figures import panels, plain_numbers, shades, svg


def crosstalk_plot(found: Sequence[Quantity]) -> str:
    """Plot ratios of tips' motions by the last model that gave them; nothing without any.

    Returns
    -------
    str
        An SVG element.
    """
    shown = [q for q in found if q.model == found[-1].model and np.isfinite(q.value).any()]
    if not shown:
        return ""
    figure, axis = panels(8.0, 4.2)
    for colour, q in zip(shades(len(shown)), shown, strict=True):
        label = f"{q.name.replace('_', ' ')}, {q.model}"
        axis.plot(q.frequency, 100.0 * np.abs(q.value), color=colour, label=label)
    axis.set(xlabel="frequency (Hz)", ylabel="of the driven tip's motion (%)", yscale="log")
    if min(shown[0].frequency or (0.0,)) > 0.0:
        axis.set(xscale="log")
        plain_numbers(axis.xaxis)
    axis.legend(fontsize=8)
    return svg(figure)
