"""Plots of the whole machine: where its rod rests, and its transfers from voltage and current."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.positions import RestingPlace
from tactgen.validation.engine.solve import Solution
from tactgen.validation.models.generator.rod_loop import RodLoop
from tactgen.validation.view.figures import BLUE, GREY, ORANGE, panels, plain_numbers, shades, svg

#: Line of each further model.
_LINES = ("-", (0, (4, 2)), ":")


def position_plot(loops: Sequence[RodLoop], current: float) -> str:
    """Plot all resting places over the coil's current, and the way there and back, by model.

    Arrows stand where the rod moves from stop to stop.

    Returns
    -------
    str
        An SVG element.
    """
    figure, axis = panels(8.0, 4.2)
    for found, line in zip(loops, _LINES, strict=False):
        of = f", {found.model}" if len(loops) > 1 else ""
        currents = 1e3 * found.loop.currents
        for way, colour, name in (
            (found.loop.rising, ORANGE, "current rising"),
            (found.loop.falling, BLUE, "current falling"),
        ):
            axis.plot(*_in_pieces(currents, way), color=colour, ls=line, label=name + of)
        unstable = found.loop.unstable
        if unstable.size:
            axis.plot(*(unstable * [1e3, 1e6]).T, ".", ms=3, color=GREY,
                      label=None if of and line != _LINES[0] else "unstable")  # fmt: skip
    _mark_switching(axis, loops[0])
    if current:
        axis.axvline(1e3 * current, color="black", lw=0.8, ls=":", label="the scene's current")
    axis.set(xlabel="coil current (mA)", ylabel="rod's position (µm)")
    axis.legend(fontsize=8)
    return svg(figure)


def _in_pieces(currents: Floats, way: Sequence[RestingPlace]) -> tuple[Floats, Floats]:
    """Return currents and lifts (µm), with a gap where the rod goes from stop to stop."""
    lifts = np.array([1e6 * place.lift for place in way])
    kinds = [place.kind for place in way]
    ends = {"upper stop", "lower stop"}
    jumps = [k for k in range(1, len(way)) if {kinds[k - 1], kinds[k]} == ends]
    return np.insert(currents, jumps, np.nan), np.insert(lifts, jumps, np.nan)


def _mark_switching(axis: Any, found: RodLoop) -> None:
    """Write pull-in and drop-out at the currents at which the rod moves from stop to stop."""
    if found.switching is None:
        return
    lowest = min(place.lift for place in found.loop.falling)
    for name, measured, colour, low in (
        ("pull-in", found.switching.pull_in, ORANGE, True),
        ("drop-out", found.switching.drop_out, BLUE, False),
    ):
        at = 1e3 * measured.value
        if not 0.0 < at <= 1e3 * found.loop.currents[-1]:
            continue
        top, bottom = 0.0, 1e6 * lowest
        way = (bottom, top) if low else (top, bottom)
        axis.annotate(
            "", xy=(at, way[0]), xytext=(at, way[1]),
            arrowprops={"arrowstyle": "->", "color": colour, "lw": 1.2},
        )  # fmt: skip
        axis.annotate(
            f"{name}\n{at:.4g} mA", xy=(at, 0.5 * bottom), xytext=(6, 0),
            textcoords="offset points", fontsize=8, va="center",
        )  # fmt: skip


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
            low, high = axis.get_ylim()
            if high < 10.0 * low:  # what hardly varies is not drawn as if it did
                middle = np.sqrt(low * high)
                axis.set_ylim(middle / 5.0, middle * 5.0)
            axis.legend(fontsize=7)
    return svg(figure)
