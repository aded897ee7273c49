"""Plots of the whole machine: where its rod rests, and its transfers from voltage and current."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.positions import AxialForces, resting_places
from tactgen.validation.engine.solve import Solution
from tactgen.validation.view.figures import BLUE, GREY, ORANGE, panels, plain_numbers, shades, svg


def position_plot(forces: AxialForces, currents: Floats, current: float) -> str:
    """Plot all resting places over the coil's current (c,) A, and the way there and back.

    Returns
    -------
    str
        An SVG element.
    """
    figure, axis = panels(8.0, 4.2)
    places = [resting_places(forces, float(i)) for i in currents]
    stable = [[place.lift for place in at if place.stable] for at in places]
    floating = [
        (1e3 * i, 1e6 * place.lift)
        for i, at in zip(currents, places, strict=True)
        for place in at
        if not place.stable
    ]
    if floating:
        axis.plot(*zip(*floating, strict=True), ".", ms=3, color=GREY, label="unstable")
    axis.plot(
        1e3 * currents, [1e6 * lifts[0] for lifts in stable], color=ORANGE, label="current rising"
    )
    axis.plot(
        1e3 * currents,
        [1e6 * lifts[-1] for lifts in stable],
        color=BLUE,
        ls="--",
        label="current falling",
    )
    if current:
        axis.axvline(1e3 * current, color="black", lw=0.8, ls=":", label="the scene's current")
    axis.set(xlabel="coil current (mA)", ylabel="rod's position (µm)")
    axis.legend(fontsize=8)
    return svg(figure)


def transfer_plot(solution: Solution, units: Sequence[str]) -> str:
    """Plot the magnitudes of the transfers that a solution holds, one panel for each unit.

    Returns
    -------
    str
        An SVG element.
    """
    figure, axes = panels(10.0, 4.2, ncols=2)
    for axis, unit in zip(axes, units, strict=True):
        shown = [
            q
            for q in solution.quantities
            if q.unit == unit and q.frequency is not None and np.abs(q.value).any()
        ]
        for colour, q in zip(shades(len(shown)), shown, strict=True):
            label = f"{q.name.replace('_', ' ')}, {q.model}"
            axis.plot(q.frequency, np.abs(q.value), color=colour, label=label)
        axis.set(xlabel="frequency (Hz)", ylabel=f"magnitude ({unit})", yscale="log")
        if shown and min(shown[0].frequency or (0.0,)) > 0.0:
            axis.set(xscale="log")
            plain_numbers(axis.xaxis)
        if shown:
            axis.legend(fontsize=7)
    return svg(figure)
