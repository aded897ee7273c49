"""Plots of the lateral actuator: responses, the bridge to the solid, what holds the ceramic."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.formats import percent
from tactgen.validation.view.figures import AMBER, BLUE, GREEN, GREY, ORANGE, panels, svg

if TYPE_CHECKING:
    from tactgen.validation.models.bimorph.bridge import Rung

Array = NDArray[Any]

#: One colour and line style per model, used in every plot.
MODEL_STYLE: dict[str, dict[str, Any]] = {
    "lumped": {"color": GREY, "linestyle": ":", "linewidth": 2.2},
    "tmm": {"color": BLUE, "linestyle": "-", "linewidth": 2.0},
    "beam": {"color": AMBER, "linestyle": (0, (4, 4)), "linewidth": 2.0},
    "solid": {"color": ORANGE, "linestyle": "-.", "linewidth": 2.0},
    "cad": {"color": GREEN, "linestyle": (0, (1, 1)), "linewidth": 2.0},
}


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
    figure, axes = panels(10.0, 7.6, nrows=3, ncols=len(curves), sharex=True, squeeze=False)
    first_phase = {
        case: np.rad2deg(np.angle(list(models.values())[-1][0])) for case, models in curves.items()
    }
    for column, (case, models) in enumerate(curves.items()):
        top, bottom, ratio = (axes[row][column] for row in range(3))
        reference = np.abs(models[list(models)[-1]])
        for model, values in models.items():
            top.plot(frequencies, np.abs(values) * 1e6, label=model, **MODEL_STYLE.get(model, {}))
            phase = np.rad2deg(np.unwrap(np.angle(values)))
            # ±180° at the start is a matter of rounding
            phase += 360.0 * np.round((first_phase[case] - phase[0]) / 360.0)
            bottom.plot(frequencies, phase, **MODEL_STYLE.get(model, {}))
            with np.errstate(invalid="ignore"):  # 0/0 where nothing moves
                difference = 100.0 * (np.abs(values) / reference - 1.0)
            ratio.plot(frequencies, difference, **MODEL_STYLE.get(model, {}))
        ratio.set_ylim(-25.0, 25.0)
        if any(np.nanmax(np.abs(v)) > 0.0 for v in models.values()):
            top.set_yscale("log")
        top.set_title(labels[case])
        ratio.set_xlabel("frequency (Hz)")
    axes[2][0].set_ylabel(f"|w| against {list(next(iter(curves.values())))[-1]} (%)")
    axes[0][0].set_ylabel("tip displacement |w| (µm)")
    axes[1][0].set_ylabel("phase (°)")
    axes[0][0].legend(frameon=False)
    if _spans_decades(frequencies):
        axes[0][0].set_xscale("log")
    if len(frequencies) > 1:  # the page tells the values where it is pointed at
        axes[0][0].set_xlim(frequencies[0], frequencies[-1])
    return svg(figure)


def response_values(
    frequencies: Array, curves: dict[str, dict[str, Array]], labels: dict[str, str]
) -> str:
    """Return what the page tells of :func:`response_plot` where it is pointed at, as JSON.

    Where a model has no value (nan), null.
    """

    def told(values: Array) -> dict[str, list[str | None]]:
        there = [(value if np.isfinite(value) else None) for value in values]
        return {
            "size": [v if v is None else f"{1e6 * abs(v):.4g}" for v in there],
            "phase": [v if v is None else f"{np.rad2deg(np.angle(v)):.1f}" for v in there],
        }

    shown = {
        "frequency": [float(f"{f:.6g}") for f in frequencies],
        "log": _spans_decades(frequencies),
        "cases": [
            {"title": labels[case], "models": {name: told(v) for name, v in models.items()}}
            for case, models in curves.items()
        ],
    }
    return json.dumps(shown, separators=(",", ":"))


def bridge_plot(rungs: Sequence[Rung], whole: str) -> str:
    """Plot a bridge as a waterfall per quantity: what each step adds, in percent of the start.

    A mark stands where a closed form says that the step ends, a ring where the beam model
    with the solid's own section does.

    Parameters
    ----------
    rungs : sequence of Rung
        The start and the steps.
    whole : str
        What the sum of all steps is called.
    """
    quantities = {
        "deflection": "static deflection",
        "first_frequency": "first frequency",
        "capacitance": "capacitance",
    }
    figure, axes = panels(11.0, 0.42 * len(rungs) + 1.3, ncols=3, sharey=True, squeeze=False)
    names = [*(rung.name for rung in rungs[1:]), whole]
    for axis, (quantity, title) in zip(axes[0], quantities.items(), strict=True):
        values = np.array([getattr(rung, quantity) for rung in rungs])
        ends = 100.0 * (values / values[0] - 1.0)
        starts, widths = np.append(ends[:-1], 0.0), np.append(np.diff(ends), ends[-1])
        colours = [*np.where(np.diff(ends) > 0.0, ORANGE, BLUE), GREY]
        axis.barh(names, widths, left=starts, color=colours, height=0.62)
        marks = []
        for attribute, marker in (("predicted", "|"), ("section", "o")):
            steps = np.array([getattr(getattr(rung, attribute), quantity) for rung in rungs[1:]])
            at = (100.0 + ends[:-1]) * (1.0 + steps) - 100.0
            axis.plot(at, names[:-1], marker, color="black", fillstyle="none", markersize=9)
            marks += at[np.isfinite(at)].tolist()
        axis.axvline(0.0, color="black", linewidth=0.9)
        low, high = min(0.0, *ends, *marks), max(0.0, *ends, *marks)
        span = max(high - low, 0.1)
        axis.set_xlim(low - 0.25 * span, high + 0.6 * span)
        shown = [*(getattr(rung.step, quantity) for rung in rungs[1:]), 0.01 * ends[-1]]
        for place, value in enumerate(shown):
            text = f"{percent(value, 2)} "
            axis.text(high + 0.6 * span, place, text, ha="right", va="center", fontsize=9)
        axis.set(title=title, xlabel=f"difference from {rungs[0].name} (%)")
    axes[0][0].invert_yaxis()
    return svg(figure)


def support_plot(
    lengths: Array, rotations: Mapping[str, Array], target: float, best: Mapping[str, float]
) -> str:
    """Plot rotation per moment of a support over its tab's free length.

    Parameters
    ----------
    lengths : (n,) array
        Free length of the tab (m).
    rotations : mapping of str to (n,) array
        Rotation per moment (rad/(N m)) by what holds the tab.
    target : float
        The fitted one.
    best : mapping of str to float
        Length (m) at which each reaches it; nan where none does.
    """
    figure, axes = panels(10.0, 3.8, squeeze=False)
    axis = axes[0][0]
    # the first, which the second follows closely, is told on the other side of its line
    left, right = ((-3, 6), "right"), ((3, -14), "left")
    styles = ((GREY, ":", right), (BLUE, "-", left), (ORANGE, "-.", left))
    for (name, values), (colour, line, side) in zip(rotations.items(), styles, strict=False):
        axis.plot(1e3 * lengths, values, color=colour, linestyle=line, linewidth=2.0, label=name)
        if np.isfinite(best[name]):
            axis.plot(1e3 * best[name], target, "o", color=colour)
            axis.annotate(
                f"{1e3 * best[name]:.2f} mm",
                (1e3 * best[name], target),
                xytext=side[0],
                ha=side[1],
                textcoords="offset points",
                color=colour,
            )
    axis.axhline(target, color="black", linewidth=0.9)
    axis.text(0.99e3 * lengths[-1], target, "fitted, 1/c_s", ha="right", va="bottom")
    axis.set(xlabel="free length of the tab (mm)", ylabel="rotation per moment (rad/(N m))")
    axis.set(xlim=(0.0, 1e3 * lengths[-1]), ylim=(0.0, None))
    axis.legend(frameon=False)
    return svg(figure)


def _spans_decades(frequencies: Array) -> bool:
    positive = frequencies[frequencies > 0.0]
    return bool(positive.size and positive.max() / positive.min() > 30.0)
