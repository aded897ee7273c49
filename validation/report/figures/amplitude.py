"""Pictures of responses at several voltages, and of the deflection under load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.models.amplitude.backbone import Backbone, Curve
from tactgen.validation.models.amplitude.states import RockingState
from tactgen.validation.view.figures import (
    BLUE,
    DARK,
    ORANGE,
    panels,
    plain_numbers,
    shades,
    svg,
)


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


def states_plot(states: Sequence[RockingState]) -> str:
    """Plot displacement per volt of the free tip at several voltages, one panel for each state."""
    shown = [state for state in states if state.curves]
    figure, axes = panels(10.0, 4.4, ncols=len(shown), sharey=True, squeeze=False)
    for axis, state in zip(axes[0], shown, strict=True):
        colours = shades(len(state.curves))
        for curve, colour in zip(state.curves, colours, strict=True):
            _draw(axis, curve, 1e6 * np.abs(curve.displacement) / curve.voltage, colour)
        tops = [(c.peaks[0].frequency, 1e6 * c.peaks[0].displacement / c.voltage)
                for c in state.curves if c.peaks]  # fmt: skip
        if len(tops) > 1:
            axis.plot(*np.array(tops).T, "o-", color=DARK, lw=1.0, ms=4, label="backbone")
        axis.set(xlabel="frequency (Hz)", yscale="log", title=state.state)
        plain_numbers(axis.yaxis)
        axis.legend(frameon=False, fontsize=8)
    axes[0, 0].set_ylabel("tip displacement (µm per V)")
    return svg(figure)


def deflection_plot(
    states: Sequence[RockingState],
    frequencies: Floats,
    linear: Mapping[str, Floats],
    measured: Mapping[str, tuple[float, float]],
) -> str:
    """Plot the deflection under load over frequency, rocking and linear, in each state.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    linear : mapping of str to (n,) array
        By state (m).
    measured : mapping of str to (float, float)
        What a measurement spans (m), by state: a band.
    """
    figure, axes = panels(10.0, 4.4, ncols=len(states), sharey=True, squeeze=False)
    for axis, state in zip(axes[0], states, strict=True):
        found = state.deflection
        assert found is not None
        if state.state in measured:
            low, high = measured[state.state]
            axis.axhspan(1e6 * low, 1e6 * high, color=ORANGE, alpha=0.15, lw=0,
                         label="measured, Fig 15 (other load)")  # fmt: skip
        axis.plot(frequencies, 1e6 * linear[state.state], "--", color=DARK, lw=1.0,
                  label="linear support")  # fmt: skip
        axis.plot(found.frequencies, 1e6 * np.abs(found.displacement), color=BLUE,
                  label="head that may rock")  # fmt: skip
        axis.set(xlabel="frequency (Hz)", xscale="log", yscale="log", title=state.state)
        plain_numbers(axis.xaxis, axis.yaxis)
        axis.legend(frameon=False, fontsize=8, loc="lower left")
    axes[0, 0].set_ylabel("tip displacement (µm)")
    return svg(figure)
