"""Line plots of the report, as inline SVG (matplotlib, no display, no global state)."""

from __future__ import annotations

import io
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from validation.bridge import Rung

Array = NDArray[Any]

#: One colour and line style per model, used in every plot (Okabe-Ito palette).
MODEL_STYLE: dict[str, dict[str, Any]] = {
    "lumped": {"color": "#999999", "linestyle": ":", "linewidth": 2.2},
    "tmm": {"color": "#0072B2", "linestyle": "-", "linewidth": 2.0},
    "beam": {"color": "#E69F00", "linestyle": (0, (4, 4)), "linewidth": 2.0},
    "solid": {"color": "#D55E00", "linestyle": "-.", "linewidth": 2.0},
}


def svg(figure: Figure) -> str:
    """Return a figure as an SVG element that can stand inside a page."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", bbox_inches="tight", metadata={"Date": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def _figure(width: float, height: float, **grid: Any) -> tuple[Figure, Any]:
    import matplotlib as mpl
    from matplotlib.figure import Figure as NewFigure

    mpl.rcParams["svg.hashsalt"] = "tactgen"  # the same picture has the same ids every time
    figure = NewFigure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(**grid)


def response_plot(
    frequencies: Array, curves: dict[str, dict[str, Array]], labels: dict[str, str]
) -> str:
    """Plot tip displacement per model, one column per load case.

    Magnitude, phase, and the magnitude's difference from the last model's in percent.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    curves : dict of str to dict of str to (n,) complex array
        Load case to model to tip displacement (m).
    labels : dict
        Title of each load case.
    """
    figure, axes = _figure(10.0, 7.6, nrows=3, ncols=len(curves), sharex=True, squeeze=False)
    for column, (case, models) in enumerate(curves.items()):
        top, bottom, ratio = (axes[row][column] for row in range(3))
        reference = np.abs(models[list(models)[-1]])
        for model, values in models.items():
            top.plot(frequencies, np.abs(values) * 1e6, label=model, **MODEL_STYLE[model])
            phase = np.rad2deg(np.unwrap(np.angle(values)))
            bottom.plot(frequencies, phase, **MODEL_STYLE[model])
            with np.errstate(invalid="ignore"):  # 0/0 where nothing moves
                difference = 100.0 * (np.abs(values) / reference - 1.0)
            ratio.plot(frequencies, difference, **MODEL_STYLE[model])
        ratio.set_ylim(-25.0, 25.0)
        if any(np.nanmax(np.abs(v)) > 0.0 for v in models.values()):
            top.set_yscale("log")
        top.set_title(labels[case])
        ratio.set_xlabel("frequency (Hz)")
    axes[2][0].set_ylabel(f"|w| against {list(next(iter(curves.values())))[-1]} (%)")
    axes[0][0].set_ylabel("tip displacement |w| (µm)")
    axes[1][0].set_ylabel("phase (°)")
    axes[0][0].legend(frameon=False)
    _finish(axes, log_x=_spans_decades(frequencies))
    return svg(figure)


def bridge_plot(rungs: Sequence[Rung]) -> str:
    """Plot the bridge from TMM to the solid: change in percent per rung and quantity."""
    quantities = {
        "deflection": "static deflection",
        "first_frequency": "first frequency",
        "capacitance": "capacitance",
    }
    figure, axes = _figure(9.0, 2.6, nrows=1, ncols=3, sharey=True, squeeze=False)
    names = [f"{a.name} → {b.name}" for a, b in pairwise(rungs)]
    for axis, (attribute, title) in zip(axes[0], quantities.items(), strict=True):
        values = np.array([getattr(rung, attribute) for rung in rungs])
        change = 100.0 * np.diff(values) / values[:-1]
        bars = axis.barh(names, change, color=["#56B4E9", "#D55E00"][: len(names)])
        axis.bar_label(bars, fmt="%+.2f %%", padding=3)
        axis.axvline(0.0, color="black", linewidth=0.8)
        axis.set_title(title)
        reach = max(1.0, 2.4 * float(np.abs(change).max()))
        axis.set_xlim(-reach, reach)
        axis.set_xlabel("step (%)")
    axes[0][0].invert_yaxis()
    for axis in axes[0]:
        axis.grid(visible=True, axis="x", alpha=0.3)
    return svg(figure)


def _spans_decades(frequencies: Array) -> bool:
    positive = frequencies[frequencies > 0.0]
    return bool(positive.size and positive.max() / positive.min() > 30.0)


def _finish(axes: Any, *, log_x: bool) -> None:
    for axis in np.ravel(axes):
        if log_x:
            axis.set_xscale("log")
        axis.grid(visible=True, which="both", alpha=0.25)
