"""The picture of the responses at several voltages."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.validation.models.amplitude.backbone import Backbone, Curve
from tactgen.validation.view.figures import DARK, panels, plain_numbers, shades, svg


def backbone_plot(found: Backbone) -> str:
    """Plot velocity and displacement per volt over frequency; unstable orbits dotted.

    The curve through the peaks is the backbone.
    """
    figure, axes = panels(10.0, 4.4, ncols=2)
    colours = shades(len(found.curves))
    for curve, colour in zip(found.curves, colours, strict=True):
        size = np.abs(curve.displacement) / curve.voltage
        speed = 2.0 * np.pi * curve.frequencies * size
        for axis, values in zip(axes, (1e3 * speed, 1e6 * size), strict=True):
            _draw(axis, curve, values, colour)
    tops = [(p.frequency, p.velocity / c.voltage, p.displacement / c.voltage)
            for c in found.curves for p in c.peaks[:1]]  # fmt: skip
    if len(tops) > 1:
        at, speed, size = np.array(tops).T
        for axis, values in zip(axes, (1e3 * speed, 1e6 * size), strict=True):
            axis.plot(at, values, "o-", color=DARK, linewidth=1.0, markersize=4, label="backbone")
    for axis, unit in zip(axes, ("velocity (mm/s per V)", "displacement (µm per V)"), strict=True):
        axis.set(xlabel="frequency (Hz)", ylabel=f"tip {unit}", yscale="log")
        plain_numbers(axis.yaxis)
    axes[0].legend(frameon=False)
    return svg(figure)


def _draw(axis: Any, curve: Curve, values: Any, colour: Any) -> None:
    """Draw one curve, where unstable dotted."""
    for shown, style in ((curve.stable, "-"), (~curve.stable, ":")):
        label = f"{curve.voltage:g} V" if style == "-" else None
        near = shown.copy()
        near[1:] |= shown[:-1] if style == ":" else False
        axis.plot(
            curve.frequencies, np.where(near, values, np.nan), style, color=colour, label=label
        )
