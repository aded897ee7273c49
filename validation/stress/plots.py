"""Plots of a stress run, as inline SVG."""

from __future__ import annotations

from typing import Any

import numpy as np

from geometry.arrays import Floats
from validation.plots import svg
from validation.stress.result import WANTED, Approach, ErrorMap

#: Decades of relative error that the colours span.
_DECADES = (-17.0, 0.0)


def map_plot(table: ErrorMap) -> str:
    """Plot errors over frequency and length, ours beside the naive formulas'.

    Colours are decades of relative error; black is no correct digit, overflow or 0/0.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 3.4), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    panels = ((axes[0], "this model", table.error), (axes[1], "matrix A", table.naive))
    for axis, title, values in panels:
        image = _decades(axis, table, values)
        axis.set_title(f"{title}: {table.title}", fontsize="medium")
        axis.set_xlabel("frequency (Hz)")
    axes[0].set_ylabel("length (m)")
    figure.colorbar(image, ax=axes.tolist(), label="log10 of the relative error", extend="max")
    return svg(figure)


def _decades(axis: Any, table: ErrorMap, values: Floats) -> Any:
    import matplotlib as mpl

    colours = mpl.colormaps["viridis"].with_extremes(over="black", bad="white")
    with np.errstate(divide="ignore"):
        shown = np.log10(np.clip(values, 10.0 ** _DECADES[0], 1e300))
    low, high = _DECADES
    image = axis.imshow(shown, cmap=colours, vmin=low, vmax=high, origin="lower", aspect="auto")
    for ticks, labels, spaced in (
        (axis.set_xticks, axis.set_xticklabels, table.frequencies),
        (axis.set_yticks, axis.set_yticklabels, table.lengths),
    ):
        at = np.unique(np.linspace(0, spaced.size - 1, 7).astype(int))
        ticks(at)
        labels([f"{v:.2g}" for v in spaced[at]])
    return image


def approach_plot(approaches: tuple[Approach, ...]) -> str:
    """Plot error against condition number, with the promised bound."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 3.4), layout="constrained")
    axis = figure.subplots()
    for approach, marker in zip(approaches, "os^v", strict=False):
        axis.loglog(approach.condition, approach.error, marker, label=approach.title)
    condition = np.concatenate([a.condition for a in approaches])
    bounds = np.concatenate([a.bound for a in approaches])
    order = np.argsort(condition)
    axis.loglog(condition[order], bounds[order], "k-", linewidth=1.0, label="promised bound")
    axis.axhline(WANTED, color="#D55E00", linestyle="--", linewidth=1.0, label="wanted")
    axis.set_xlabel("condition number")
    axis.set_ylabel("relative error")
    axis.legend(frameon=False)
    axis.grid(visible=True, alpha=0.25)
    return svg(figure)
