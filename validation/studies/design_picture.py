"""The report's section on the length of the actuator (the paper's Fig 9 and section 4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.validation.catalogue.detection import ThresholdCurve
from tactgen.validation.show.figures import (
    BLUE,
    GREEN,
    ORANGE,
    new_figure,
    plain_numbers,
    shades,
    svg,
)
from tactgen.validation.studies.design import Design
from tactgen.validation.studies.length_map import LengthMap

#: Lengths that span more than this factor are drawn over a logarithmic axis.
_WIDE = 5.0


def length_plot(study: LengthMap, found: Design) -> str:
    """Plot deflection over frequency, margin over length, and the minimum over length."""
    layout: list[Any] = [[*6 * ["curves"], *2 * ["key"]], [*4 * ["margin"], *4 * ["minimum"]]]
    figure = new_figure(9.0, 7.4)
    axes = figure.subplot_mosaic(layout, height_ratios=(1.25, 1.0))
    _curves(axes["curves"], study, found.aim.threshold)
    names = axes["curves"].get_legend_handles_labels()
    axes["key"].legend(*names, frameon=False, loc="center left", fontsize=8)
    axes["key"].axis("off")
    _margin(axes["margin"], found)
    _minimum(axes["minimum"], study)
    return drawn(figure)


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


def drawn(figure: Any) -> str:
    """Figure with grids and plain numbers as SVG."""
    for axis in figure.axes:
        axis.grid(visible=True, which="both", alpha=0.25)
        plain_numbers(axis.xaxis, axis.yaxis)
    return svg(figure)
