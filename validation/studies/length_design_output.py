"""A design of the length as text, as JSON and as a picture (the paper's Fig 9 and section 4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.formats import signed
from tactgen.validation.catalogue.detection import ThresholdCurve
from tactgen.validation.scene.conditions import answer_head, conditions
from tactgen.validation.show.figures import (
    BLUE,
    GREEN,
    ORANGE,
    new_figure,
    plain_numbers,
    shades,
    svg,
)
from tactgen.validation.studies.length_design import Dependence, Design, lowest_margin
from tactgen.validation.studies.length_map import LengthMap, actuator

#: Parameters with smaller slopes are named without their number: 10 % of one then moves the
#: length by less than 0.005 %.
_NEGLIGIBLE = 5e-4
#: Most frequencies of a threshold that are named one by one.
_LISTED = 5
#: Lengths that span more than this factor are drawn over a logarithmic axis.
_WIDE = 5.0


def sentences(result: Design) -> tuple[str, ...]:
    """Design in sentences: drive, length, intervals, present length, the known threshold."""

    def end(length: float, at: float | None) -> str:
        limit = "end of the range" if at is None else f"critical frequency {at:.4g} Hz"
        return f"{_mm(length)} ({limit})"

    ranges = "; ".join(
        f"{end(i.shortest, i.at_shortest)} to {end(i.longest, i.at_longest)}"
        for i in result.intervals
    )
    margin, at = result.present
    own, (low, high) = result.scene.bimorph.length, result.aim.lengths
    outside = "" if low <= own <= high else " outside that range,"
    present = f"a minimum |w| / threshold of {margin:.4g}, at {at:.4g} Hz"
    return (
        conditions(result.scene),
        _outcome(result),
        f"Lengths that meet the margin: {ranges}." if ranges else "No length meets the margin.",
        f"The scene's own length, {_mm(own)},{outside} has {present}.",
        _caveat(result),
    )


def _outcome(result: Design) -> str:
    aim = result.aim
    band = f"{aim.band[0]:g} to {aim.band[1]:g} Hz"
    within = f"of {_mm(aim.lengths[0])} to {_mm(aim.lengths[1])}"
    wanted = f"|w| / threshold ≥ {aim.margin:g} over {band}"
    reached = f"the minimum of |w| / threshold is {result.margin:.4g}, at {result.frequency:.4g} Hz"
    if result.limit == "compromise":
        return f"No length {within} meets {wanted}. The closest is {_mm(result.length)}: {reached}."
    if aim.kind == "margin":
        end = (
            " (an end of the range; the margin may grow beyond it)" if result.limit == "end" else ""
        )
        best = f"{_mm(result.length)}{end}"
        return f"The length with the largest margin {within} over {band} is {best}: {reached}."
    if result.limit == "end":
        return (
            f"The shortest length allowed, {_mm(result.length)}, already meets {wanted}: "
            f"{reached}. The range limits the length, not the threshold."
        )
    return (
        f"The shortest length {within} that meets {wanted} is {_mm(result.length)}. "
        f"The critical frequency is {result.frequency:.4g} Hz."
    )


def _caveat(result: Design) -> str:
    """Where the threshold is known."""
    points = [p.frequency for p in result.aim.threshold.points]
    if len(points) > _LISTED:
        listed = f"{len(points)} frequencies from {points[0]:g} to {points[-1]:g} Hz"
    else:
        listed = ", ".join(f"{f:g}" for f in points[:-1]) + f" and {points[-1]:g} Hz"
    between = "" if result.frequency in points else f", as at {result.frequency:.4g} Hz"
    return (
        f"The detection threshold is stated at {listed}; it is interpolated linearly in log-log "
        f"between them{between}."
    )


def _mm(length: float) -> str:
    return f"{1e3 * length:.5g} mm"


def lines(study: LengthMap, result: Design, rows: tuple[Dependence, ...]) -> list[str]:
    """Sentences, a table of lengths, and what the designed ones depend on."""
    found = list(sentences(result))
    found.append(
        f"\n{'length':>10} {'|w| at start':>13} {'minimum':>11} {'at':>9} "
        f"{'|w|/threshold':>14} {'at':>9}"
    )
    for row in _length_rows(study, result):
        dip = row["minimum"]
        lowest = (
            (f"{1e6 * dip.displacement:.4g} µm", f"{dip.frequency:.4g} Hz") if dip else ("none", "")
        )
        found.append(
            f"{1e3 * row['length']:>7.4g} mm {1e6 * row['start']:>10.4g} µm {lowest[0]:>11} "
            f"{lowest[1]:>9} {row['margin']:>14.4g} {row['frequency']:>6.4g} Hz"
        )
    if not result.decided:
        return [*found, "\nThe length is at an end of the range and depends on no parameter."]
    heads = " ".join(f"{1e3 * length:>9.5g} mm" for length, _ in result.decided)
    found += [
        "\npercent by which a length changes per percent of a parameter",
        f"{'parameter':32} {'value':>22} {heads}  source",
    ]
    for line in rows:
        if line.largest >= _NEGLIGIBLE:
            slopes = " ".join(f"{signed(slope, 3):>12}" for slope in line.slopes)
            found.append(f"{line.key:32} {line.text:>22} {slopes}  {line.source}")
    idle = [line.key for line in rows if line.largest < _NEGLIGIBLE]
    return found + ([f"less than {_NEGLIGIBLE:g}: {', '.join(idle)}"] if idle else [])


def as_json(study: LengthMap, result: Design, rows: tuple[Dependence, ...]) -> dict[str, Any]:
    """Design as plain values, SI units."""
    aim, scene = result.aim, result.scene
    return {
        **answer_head(scene),
        "setting": {
            "voltage": scene.drive.voltage, "wiring": scene.bimorph.wiring,
            "load": scene.load.kind,
        },
        "aim": {
            "kind": aim.kind, "margin": aim.margin, "band": aim.band, "lengths": aim.lengths,
            "threshold": aim.threshold.points,
        },
        "length": result.length,
        "margin": result.margin,
        "frequency": result.frequency,
        "limit": result.limit,
        "feasible": [{"lengths": i[:2], "frequencies": i[2:]} for i in result.intervals],
        "present": {
            "length": scene.bimorph.length,
            "margin": result.present[0], "frequency": result.present[1],
        },
        "map": _length_rows(study, result),
        "sensitivity": {
            "lengths": [length for length, _ in result.decided],
            "frequencies": [at for _, at in result.decided],
            "parameters": [
                {"key": row.key, "value": row.text, "source": row.source,
                 "assumed": row.source.startswith("assumed"), "slopes": row.slopes}
                for row in rows
            ],
        },
        "statements": sentences(result),
        "warnings": result.warnings,
    }  # fmt: skip


def _length_rows(study: LengthMap, result: Design) -> list[dict[str, Any]]:
    """One row per length of a map: start, minimum, lowest margin and where that is."""
    margins, at = lowest_margin(actuator(result.scene), result.aim, study.lengths)
    columns = zip(
        study.lengths.tolist(), study.displacement[:, 0].tolist(), study.minima,
        margins.tolist(), at.tolist(), strict=True,
    )  # fmt: skip
    names = ("length", "start", "minimum", "margin", "frequency")
    return [dict(zip(names, row, strict=True)) for row in columns]


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
    for axis in figure.axes:
        axis.grid(visible=True, which="both", alpha=0.25)
        plain_numbers(axis.xaxis, axis.yaxis)
    return svg(figure)


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
