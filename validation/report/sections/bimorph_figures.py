"""Plots of the lateral actuator: responses and model differences."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.formats import engineering, percent, prefixed
from tactgen.validation.catalogue.quantities import QUANTITIES, QuantityRow
from tactgen.validation.show.figures import AMBER, BLUE, GREEN, GREY, ORANGE, SKY, panels, svg

if TYPE_CHECKING:
    from tactgen.validation.models.difference import Step

Array = NDArray[Any]
#: (n,) complex response by name of the quantity and by model.
Curves = Mapping[str, Mapping[str, Array]]

#: One colour and line style per model, used in every plot.
MODEL_STYLE: dict[str, dict[str, Any]] = {
    "lumped": {"color": GREY, "linestyle": ":", "linewidth": 2.2},
    "tmm": {"color": BLUE, "linestyle": "-", "linewidth": 2.0},
    "beam": {"color": AMBER, "linestyle": (0, (4, 4)), "linewidth": 2.0},
    "calibrated": {"color": SKY, "linestyle": "--", "linewidth": 2.0},
    "solid": {"color": ORANGE, "linestyle": "-.", "linewidth": 2.0},
    "cad": {"color": GREEN, "linestyle": (0, (1, 1)), "linewidth": 2.0},
}


def magnitude_plot(frequencies: Array, curves: Curves) -> str:
    """Plot the magnitude of each response (SI) over frequencies (n,) in Hz, a panel a quantity."""
    figure, axes = panels(10.0, 3.4, ncols=len(curves), squeeze=False)
    for axis, (name, models) in zip(axes[0], curves.items(), strict=True):
        row = QUANTITIES[name]
        factor, unit = prefixed(max(_largest(v) for v in models.values()), row.unit)
        for model, values in models.items():
            axis.plot(frequencies, factor * np.abs(values), label=model, **MODEL_STYLE[model])
        if any(_largest(v) > 0.0 for v in models.values()):
            axis.set_yscale("log")
        axis.set(title=row.label, xlabel="frequency (Hz)", ylabel=f"magnitude ({unit})")
        _along(axis, frequencies)
    axes[0][0].legend(frameon=False)
    return svg(figure)


def difference_plot(frequencies: Array, curves: Curves) -> str:
    """Plot phase, and magnitude against the last model's in percent; see `magnitude_plot`."""
    figure, axes = panels(10.0, 4.6, nrows=2, ncols=len(curves), sharex=True, squeeze=False)
    for (phases, ratio), (name, models) in zip(axes.T, curves.items(), strict=True):
        reference = list(models.values())[-1]
        first = np.rad2deg(np.angle(reference[0]))
        for model, values in models.items():
            phase = np.rad2deg(np.unwrap(np.angle(values)))
            # ±180° at the start is a matter of rounding
            phase += 360.0 * np.round((first - phase[0]) / 360.0)
            phases.plot(frequencies, phase, label=model, **MODEL_STYLE[model])
            with np.errstate(invalid="ignore"):  # 0/0 where nothing moves
                difference = 100.0 * (np.abs(values) / np.abs(reference) - 1.0)
            ratio.plot(frequencies, difference, **MODEL_STYLE[model])
        ratio.set(ylim=(-25.0, 25.0), xlabel="frequency (Hz)")
        phases.set_title(QUANTITIES[name].label)
        _along(ratio, frequencies)
    axes[0][0].set_ylabel("phase (°)")
    axes[1][0].set_ylabel(f"magnitude against {list(next(iter(curves.values())))[-1]} (%)")
    axes[0][0].legend(frameon=False)
    return svg(figure)


def _largest(values: Array) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))


def _along(axis: Any, frequencies: Array) -> None:
    """Scale of the frequency axis; its ends are the band's, which the pointer reads."""
    if _spans_decades(frequencies):
        axis.set_xscale("log")
    if len(frequencies) > 1:
        axis.set_xlim(frequencies[0], frequencies[-1])


def response_values(frequencies: Array, curves: Curves) -> str:
    """Values of :func:`magnitude_plot` for the pointer, as JSON.

    Where a model has no value (nan), null.
    """

    def values(row: QuantityRow, curve: Array) -> dict[str, list[str | None]]:
        there = [(value if np.isfinite(value) else None) for value in curve]
        return {
            "size": [v if v is None else engineering(abs(v), row.unit, 4) for v in there],
            "phase": [v if v is None else f"{np.rad2deg(np.angle(v)):.1f}" for v in there],
        }

    shown = {
        "frequency": [float(f"{f:.6g}") for f in frequencies],
        "log": _spans_decades(frequencies),
        "cases": [
            {"title": row.label, "models": {model: values(row, v) for model, v in models.items()}}
            for row, models in ((QUANTITIES[name], models) for name, models in curves.items())
        ],
    }
    return json.dumps(shown, separators=(",", ":"), ensure_ascii=False)


def breakdown_plot(steps: Sequence[Step], titles: Mapping[str, str], reference: str) -> str:
    """Plot steps between models as a waterfall, in percent of the last one.

    The first bar is the whole difference, each other one a step; a stroke stands where the closed
    form or the simple model says that the step ends.  `titles` are by quantity, `reference` is the
    last step's model.
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


def _spans_decades(frequencies: Array) -> bool:
    positive = frequencies[frequencies > 0.0]
    return bool(positive.size and positive.max() / positive.min() > 30.0)
