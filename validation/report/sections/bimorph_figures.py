"""Plots of the lateral actuator: responses, model differences, stress."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.formats import percent
from tactgen.validation.show.figures import AMBER, BLUE, GREEN, GREY, ORANGE, panels, svg

if TYPE_CHECKING:
    from tactgen.validation.models.difference import Step

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
    """Values of :func:`response_plot` for the pointer, as JSON.

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


def breakdown_plot(steps: Sequence[Step], titles: Mapping[str, str], reference: str) -> str:
    """Plot steps between models as a waterfall, in percent of the last one.

    The first bar is the whole difference, each other one a step; a stroke stands where the closed
    form or the simple model says that the step ends.

    Parameters
    ----------
    titles : mapping
        Title of each quantity to be shown.
    reference : str
        Name of the last step's model.
    """
    from tactgen.validation.models.difference import remaining

    figure, axes = panels(
        11.0, 0.42 * len(steps) + 1.3, ncols=len(titles), sharey=True, squeeze=False
    )
    names, left = [step.name for step in steps], remaining(steps)
    for axis, (quantity, title) in zip(axes[0], titles.items(), strict=True):
        ends = 100.0 * np.array([one[quantity] for one in left])
        starts = np.append(0.0, ends[:-1])
        colours = [GREY, *np.where(np.diff(ends) > 0.0, ORANGE, BLUE)]
        axis.barh(names, ends - starts, left=starts, color=colours, height=0.62)
        predicted = np.array([step.predicted[quantity] for step in steps[1:]])
        marks = (100.0 + ends[:-1]) * (1.0 + predicted) - 100.0
        axis.plot(marks, names[1:], "|", color="black", markersize=9)
        axis.axvline(0.0, color="black", linewidth=0.9)
        reach = [0.0, *ends, *marks[np.isfinite(marks)]]
        low, high = min(reach), max(reach)
        span = max(high - low, 0.1)
        axis.set_xlim(low - 0.25 * span, high + 0.6 * span)
        for place, value in enumerate(ends - starts):
            text = f"{percent(0.01 * value, 2)} "
            axis.text(high + 0.6 * span, place, text, ha="right", va="center", fontsize=9)
        axis.set(title=title, xlabel=f"difference from {reference} (%)")
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
