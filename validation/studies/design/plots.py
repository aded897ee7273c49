"""Plots of the design questions: length (the paper's Fig 9) and excitation voltage (Fig 17)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.catalogue.detection import (
    DISPLAY_THRESHOLD,
    HIGHEST_SUBJECT,
    LITERATURE_BOUND,
    STATED_VOLTAGES,
    ThresholdCurve,
)
from tactgen.validation.view.figures import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    new_figure,
    plain_numbers,
    shades,
    svg,
)

if TYPE_CHECKING:
    from tactgen.validation.studies.design.excitation_voltage import Case
    from tactgen.validation.studies.design.length_design import Design
    from tactgen.validation.studies.design.length_map import LengthMap

#: One style per wiring and load, in every plot of voltages.
VOLTAGE_STYLE: dict[Case, dict[str, Any]] = {
    ("parallel", "loaded"): {"color": BLUE, "linestyle": "-"},
    ("parallel", "free"): {"color": BLUE, "linestyle": "--"},
    ("series", "loaded"): {"color": ORANGE, "linestyle": "-"},
    ("series", "free"): {"color": ORANGE, "linestyle": "--"},
}


#: Lengths that span more than this factor are drawn over a logarithmic axis.
_WIDE = 5.0


def length_plot(study: LengthMap, found: Design) -> str:
    """Plot deflection over frequency, margin over length, and the minimum over length.

    Parameters
    ----------
    study : LengthMap
        Curves of the upper plot and minima of the lower right one.
    found : Design
        Threshold and margin asked for.
    """
    layout: list[Any] = [[*6 * ["curves"], *2 * ["key"]], [*4 * ["margin"], *4 * ["minimum"]]]
    figure = new_figure(9.0, 7.4)
    axes = figure.subplot_mosaic(layout, height_ratios=(1.25, 1.0))
    _curves(axes["curves"], study, found.aim.threshold)
    names = axes["curves"].get_legend_handles_labels()
    axes["key"].legend(*names, frameon=False, loc="center left", fontsize=8)
    axes["key"].axis("off")
    _margin(axes["margin"], found)
    _minimum(axes["minimum"], study)
    return _drawn(figure)


def _curves(axis: Any, study: LengthMap, threshold: ThresholdCurve) -> None:
    rows = zip(
        shades(study.lengths.size), study.lengths, study.displacement, study.minima, strict=True
    )
    for colour, length, values, minimum in rows:
        axis.plot(study.frequencies, values * 1e6, color=colour, label=f"{length * 1e3:.4g} mm")
        if minimum is not None:
            axis.plot(minimum.frequency, minimum.displacement * 1e6, "o", color=colour, ms=3.5)
    level = threshold.at(study.frequencies)
    axis.plot(study.frequencies, level * 1e6, "k--", lw=1.4, label="threshold, interpolated")
    at = np.array([(p.frequency, p.amplitude) for p in threshold.points]).T
    axis.plot(at[0], at[1] * 1e6, "k^", label="threshold in the text", clip_on=False)
    axis.set(xscale="log", yscale="log", xlim=(study.frequencies[0], study.frequencies[-1]))
    axis.set_title("Deflection of each length; dots: its minimum", loc="left")
    axis.set_xlabel("frequency (Hz)")
    axis.set_ylabel("tip displacement |w| (µm)")


def _margin(axis: Any, found: Design) -> None:
    millimetres = 1e3 * found.lengths
    axis.plot(millimetres, found.margins, color=BLUE, lw=1.8)
    axis.axhline(found.aim.margin, color="black", lw=0.9, ls=":")
    for interval in found.intervals:
        axis.axvspan(1e3 * interval.shortest, 1e3 * interval.longest, color=GREEN, alpha=0.15)
    axis.plot(1e3 * found.length, found.margin, "o", color=ORANGE, clip_on=False, label="found")
    own = 1e3 * found.scene.bimorph.length
    if millimetres[0] <= own <= millimetres[-1]:
        axis.plot(own, found.present[0], "ko", mfc="white", clip_on=False, label="the scene's")
    axis.legend(frameon=False)
    axis.set(yscale="log", xlim=(millimetres[0], millimetres[-1]))
    if millimetres[-1] > _WIDE * millimetres[0]:
        axis.set_xscale("log")
    axis.set_title("Lowest margin; green: kept", loc="left")
    axis.set_xlabel("length (mm)")
    axis.set_ylabel("lowest |w| / threshold")


def _minimum(axis: Any, study: LengthMap) -> None:
    pairs = [(l, m.frequency) for l, m in zip(study.lengths, study.minima, strict=True) if m]
    if pairs:
        lengths, frequencies = np.array(pairs).T
        axis.plot(1e3 * lengths, frequencies, "o", color=BLUE)
        law = study.minimum_law
        if law is not None:
            exponent = law[0]
            relative = np.log(lengths) - np.mean(np.log(lengths))
            line = np.exp(np.mean(np.log(frequencies)) + exponent * relative)
            axis.plot(1e3 * lengths, line, "k-", lw=0.9, label=f"∝ length$^{{{exponent:.2f}}}$")
            axis.legend(frameon=False)
    if study.lengths[-1] > _WIDE * study.lengths[0]:
        axis.set(xscale="log", yscale="log")
    axis.set_title("Frequency of the deepest minimum", loc="left")
    axis.set_xlabel("length (mm)")
    axis.set_ylabel("frequency (Hz)")


def voltage_plot(
    frequencies: Floats, voltages: Mapping[Case, Floats], loads: Mapping[str, str]
) -> str:
    """Plot the voltage at the detection threshold beside what the text states.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    voltages : dict of (wiring, "loaded" or "free") to (n,) array
        V.
    loads : dict
        Title of each load.
    """
    figure = new_figure(9.0, 6.4)
    axes = figure.subplot_mosaic([["voltage"], ["threshold"]], height_ratios=(1.7, 1.0))
    axis = axes["voltage"]
    for case, values in voltages.items():
        wiring, load = case
        axis.plot(frequencies, values, lw=1.8, label=f"{wiring}, {loads[load]}",
                  **VOLTAGE_STYLE[case])  # fmt: skip
    for stated in STATED_VOLTAGES:
        low, high = stated.frequencies
        if low == high:
            axis.plot(low, stated.voltages[0], "ks", clip_on=False)
        else:
            axis.fill_between([low, high], *stated.voltages, color="black", alpha=0.15)
    axis.plot([], [], "ks", label="paper, mean of subjects (grey: its range)")
    axis.plot(HIGHEST_SUBJECT.frequencies[0], HIGHEST_SUBJECT.voltages[0], "k+", ms=9,
              label="paper, highest of all subjects")  # fmt: skip
    axis.set(xscale="log", yscale="log", xlim=(frequencies[0], frequencies[-1]))
    axis.set_ylabel("voltage amplitude (V)")
    axis.legend(frameon=False, fontsize=8, ncols=2, loc="lower center")
    _threshold(axes["threshold"], frequencies)
    return _drawn(figure)


def _threshold(axis: Any, frequencies: Floats) -> None:
    axis.plot(frequencies, 1e6 * DISPLAY_THRESHOLD.at(frequencies), "k--", lw=1.4,
              label="interpolated")  # fmt: skip
    points = np.array([(p.frequency, p.amplitude) for p in DISPLAY_THRESHOLD.points]).T
    axis.plot(points[0], 1e6 * points[1], "k^", clip_on=False, label="in the text (display, 50 g)")
    bound = LITERATURE_BOUND
    axis.hlines(1e6 * bound.amplitude, bound.frequency, frequencies[-1], color=GREY,
                label="literature: below this above 100 Hz")  # fmt: skip
    axis.set(xscale="log", yscale="log", xlim=(frequencies[0], frequencies[-1]))
    axis.set_xlabel("frequency (Hz)")
    axis.set_ylabel("threshold (µm)")
    axis.legend(frameon=False, fontsize=8)


def _drawn(figure: Any) -> str:
    for axis in figure.axes:
        axis.grid(visible=True, which="both", alpha=0.25)
        plain_numbers(axis.xaxis, axis.yaxis)
    return svg(figure)
