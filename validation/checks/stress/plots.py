"""Plots of a stress run, as inline SVG."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.formats import engineering
from tactgen.tmm.beam.span import error_bound
from tactgen.validation.checks.stress.result import WANTED, Approach, ErrorMap
from tactgen.validation.view.figures import ORANGE, new_figure, panels, svg

#: Decades of relative error that the colours span.
_DECADES = (-17.0, 0.0)


def map_plot(table: ErrorMap) -> str:
    """Plot errors over frequency and length, ours beside the naive formulas'.

    Colours are decades of relative error; black is no correct digit, overflow or 0/0.
    """
    figure = new_figure(10.0, 3.4)
    axes = figure.subplots(1, 2, sharey=True)
    sides = ((axes[0], "this model", table.error), (axes[1], "matrix A", table.naive))
    for axis, title, values in sides:
        image = _decades(axis, table, values)
        axis.set_title(f"{title}: {table.title}", fontsize="medium")
        axis.set_xlabel("frequency")
    axes[0].set_ylabel("length")
    figure.colorbar(image, ax=axes.tolist(), label="log10 of the relative error", extend="max")
    return svg(figure)


def _decades(axis: Any, table: ErrorMap, values: Floats) -> Any:
    import matplotlib as mpl

    colours = mpl.colormaps["viridis"].with_extremes(over="black", bad="black")
    with np.errstate(divide="ignore"):
        shown = np.log10(np.clip(values, 10.0 ** _DECADES[0], 1e300))
    low, high = _DECADES
    image = axis.imshow(shown, cmap=colours, vmin=low, vmax=high, origin="lower", aspect="auto")
    axis.set_xticks(*_decade_ticks(table.frequencies, "Hz", every=3))
    axis.set_yticks(*_decade_ticks(table.lengths, "m", every=1))
    return image


def _decade_ticks(spaced: Floats, unit: str, every: int) -> tuple[list[float], list[str]]:
    """Return places between the cells, and names, of decades; a leading 0 keeps its cell."""
    start = int(spaced[0] == 0.0)
    powers = np.log10(spaced[start:])
    cells = np.arange(start, spaced.size)
    first, last = math.ceil(powers[0] - 1e-9), math.floor(powers[-1] + 1e-9)
    decades = [d for d in range(first, last + 1) if d % every == 0]
    places = [float(np.interp(d, powers, cells)) for d in decades]
    names = [engineering(10.0**d, unit, 3) for d in decades]
    return ([0.0, *places], ["0", *names]) if start else (places, names)


def approach_plot(approaches: tuple[Approach, ...]) -> str:
    """Plot error against condition number, with the promised bound."""
    figure, axis = panels(7.0, 3.4)
    for approach, marker in zip(approaches, "os^v", strict=False):
        axis.loglog(approach.condition, approach.error, marker, label=approach.title)
    condition = np.concatenate([a.condition for a in approaches])
    spread = np.geomspace(condition.min(), condition.max(), 200)
    bounds = error_bound(spread)
    axis.loglog(spread, bounds, "k-", linewidth=1.0, label="the method's bound")
    axis.axhline(WANTED, color=ORANGE, linestyle="--", linewidth=1.0, label="wanted")
    axis.set_xlabel("condition number")
    axis.set_ylabel("relative error")
    axis.legend(frameon=False)
    return svg(figure)
