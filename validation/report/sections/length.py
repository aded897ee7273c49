"""The report's section on the length of the actuator (the paper's Fig 9 and section 4)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tactgen.geometry.device.parameters import Drive
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.parametric import parameter_keys
from tactgen.validation.catalogue.detection import ThresholdCurve, threshold_of
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import is_papers_bimorph
from tactgen.validation.show.figures import (
    BLUE,
    GREEN,
    ORANGE,
    new_figure,
    plain_numbers,
    shades,
    svg,
)
from tactgen.validation.studies.design import (
    CURVES,
    Aim,
    AimKind,
    Design,
    design,
    length_rows,
    stated_band,
)
from tactgen.validation.studies.design_statements import (
    LOADS,
    NEGLIGIBLE,
    caveat,
    changed_setting,
    dependences,
    statements,
)
from tactgen.validation.studies.length_map import LengthMap, actuator, length_map, tip_slopes

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


#: Lengths (m) that the paper does not show, for comparison.
_SHORTER = (10e-3, 40e-3)
#: Lengths asked about for another device, in terms of its own.
_AROUND = (0.5, 2.0)
_SOUGHT: dict[AimKind, str] = {
    "shortest": "shortest that keeps margin 1",
    "margin": "largest margin",
}


def section(
    scene: Scene, origins: dict[str, str], announce: Callable[[str], None]
) -> dict[str, Any] | None:
    """Section of the report; None for an actuator that does not move.

    The paper's actuator is asked the paper's question: under the finger, at 50 V, 20 to 40 mm.
    Any other is asked as its scene drives and loads it, about lengths around its own.
    Where the ceramic cannot have other lengths, `found` is None and `why` says so.
    """
    if scene.piezo.d31 == 0.0 or scene.drive.voltage == 0.0:
        return None
    announce("length design")
    try:
        return _found(scene, origins)
    except InputError as reason:
        return {"found": None, "why": str(reason)}


def _found(scene: Scene, origins: dict[str, str]) -> dict[str, Any]:

    papers = is_papers_bimorph(scene)
    asked, aims = _papers_question(scene) if papers else _own_question(scene)
    study = length_map(asked, np.linspace(*aims[0].lengths, CURVES), aims[0].band)
    found = design(asked, aims[0])
    rows = dependences(found, origins)
    return {
        "papers": papers,
        "own_threshold": scene.threshold.kind == "table",
        "plot": length_plot(study, found),
        "rows": length_rows(study, found),
        "law": study.minimum_law,
        "found": found,
        "changed": changed_setting(scene, asked),
        "loaded": LOADS[asked.load.kind],
        "caveat": caveat(found),
        "statements": statements(found),
        "cases": _cases(asked, aims),
        "decided": found.decided,
        "dependences": [row for row in rows if row.largest >= NEGLIGIBLE],
        "negligible": [row.key for row in rows if row.largest < NEGLIGIBLE],
        "at_end": _at_band_end(asked),
    }


def _papers_question(scene: Scene) -> tuple[Scene, list[Aim]]:
    """Scene as the paper drives and loads it, and the aims worth comparing."""
    asked = scene.model_copy(
        update={
            "load": scene.load.model_copy(update={"kind": "finger"}),
            "drive": scene.drive.model_copy(update={"voltage": Drive().voltage}),
        }
    )
    band, threshold = _band(scene)
    aims = [Aim(kind, band=band, threshold=threshold) for kind in _SOUGHT]
    if scene.bimorph.bare_below + scene.bimorph.bare_above < _SHORTER[0]:
        aims.append(Aim("margin", band=band, lengths=_SHORTER, threshold=threshold))
    return asked, aims


def _own_question(scene: Scene) -> tuple[Scene, list[Aim]]:
    """Scene as it is, and aims about lengths around its own."""
    bimorph = scene.bimorph
    bare = 1.5 * (bimorph.bare_below + bimorph.bare_above)
    shortest = max(_AROUND[0] * bimorph.length, bimorph.thickness, bare)
    lengths = shortest, _AROUND[1] * bimorph.length
    band, threshold = _band(scene)
    return scene, [Aim(kind, 1.0, band, lengths, threshold) for kind in _SOUGHT]


def _band(scene: Scene) -> tuple[tuple[float, float], ThresholdCurve]:
    """Frequencies (Hz) over which the tip shall be felt, and from where on it is."""
    threshold = threshold_of(scene.threshold)
    return stated_band(threshold), threshold


def _cases(scene: Scene, aims: Sequence[Aim]) -> list[tuple[str, str, Design]]:
    """Aims in both wirings: title, aim, result."""
    found = []
    for wiring in ("parallel", "series"):
        bimorph = scene.bimorph.model_copy(update={"wiring": wiring})
        wired = scene.model_copy(update={"bimorph": bimorph})
        found += [(wiring, _SOUGHT[aim.kind], design(wired, aim)) for aim in aims]
    return found


def _at_band_end(scene: Scene) -> dict[str, Any]:
    """Conditioning of the deflection at the band's end."""
    at = _band(scene)[0][1]
    device = actuator(scene)
    slopes = tip_slopes(device, parameter_keys(device), at)
    strongest = sorted(slopes.items(), key=lambda item: -abs(item[1]))[:4]
    return {"frequency": at, "slopes": strongest}
