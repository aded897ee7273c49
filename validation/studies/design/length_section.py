"""The report's section on the length of the actuator (the paper's Fig 9 and section 4)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tactgen.geometry.device.parameters import Drive
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.sensitivities import logarithmic_sensitivities
from tactgen.validation.catalogue.bimorph import TIP_DISPLACEMENT
from tactgen.validation.catalogue.detection import ThresholdCurve, threshold_of
from tactgen.validation.scene.papers_device import is_papers_bimorph
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.design import wording
from tactgen.validation.studies.design.aim import Aim, AimKind, stated_band
from tactgen.validation.studies.design.length_dependence import decided_lengths, dependences
from tactgen.validation.studies.design.length_design import Design, design
from tactgen.validation.studies.design.length_map import LengthMap, actuator, length_map
from tactgen.validation.studies.design.length_scan import lowest_margin

#: Lengths of the table and the plot: from 20 to 40 mm in steps of 2.5 mm.
CURVES = 9
#: Lengths (m) that the paper does not show, for comparison.
_SHORTER = (10e-3, 40e-3)
#: Lengths asked about for another device, in terms of its own.
_AROUND = (0.5, 2.0)
_SOUGHT: dict[AimKind, str] = {
    "shortest": "shortest that keeps margin 1",
    "margin": "largest margin",
}
#: Parameters with smaller slopes are named without their number: 10 % of one then moves the
#: length by less than 0.005 %.
NEGLIGIBLE = 5e-4


def section(
    scene: Scene, origins: dict[str, str], announce: Callable[[str], None]
) -> dict[str, Any] | None:
    """Return what the report shows; None for an actuator that does not move.

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
    from tactgen.validation.studies.design.plots import length_plot

    papers = is_papers_bimorph(scene)
    asked, aims = _papers_question(scene) if papers else _own_question(scene)
    study = length_map(asked, np.linspace(*aims[0].lengths, CURVES), aims[0].band)
    found = design(asked, aims[0])
    rows = dependences(found, origins)
    return {
        "papers": papers,
        "own_threshold": scene.threshold.kind == "table",
        "plot": length_plot(study, found),
        "rows": table_rows(asked, study, found.aim),
        "law": study.minimum_law,
        "found": found,
        "changed": wording.changed_setting(scene, asked),
        "loaded": wording.LOADS[asked.load.kind],
        "caveat": wording.caveat(found),
        "statements": (
            wording.statement(found),
            wording.feasible(found),
            wording.present(found),
        ),
        "cases": _cases(asked, aims),
        "decided": decided_lengths(found),
        "dependences": [row for row in rows if row.largest >= NEGLIGIBLE],
        "negligible": [row.key for row in rows if row.largest < NEGLIGIBLE],
        "at_end": _at_band_end(asked),
    }


def table_rows(scene: Scene, study: LengthMap, aim: Aim) -> list[dict[str, Any]]:
    """Return one row per length of a map: start, minimum, lowest margin."""
    margins, at = lowest_margin(actuator(scene), aim, study.lengths)
    return [
        {
            "length": float(length),
            "start": float(curve[0]),
            "minimum": minimum,
            "margin": float(margin),
            "margin_at": float(frequency),
        }
        for length, curve, minimum, margin, frequency in zip(
            study.lengths, study.displacement, study.minima, margins, at, strict=True
        )
    ]


def _papers_question(scene: Scene) -> tuple[Scene, list[Aim]]:
    """Return the scene as the paper drives and loads it, and the aims worth comparing."""
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
    """Return the scene as it is, and aims about lengths around its own."""
    bimorph = scene.bimorph
    bare = 1.5 * (bimorph.bare_below + bimorph.bare_above)
    shortest = max(_AROUND[0] * bimorph.length, bimorph.thickness, bare)
    lengths = shortest, _AROUND[1] * bimorph.length
    band, threshold = _band(scene)
    return scene, [Aim(kind, 1.0, band, lengths, threshold) for kind in _SOUGHT]


def _band(scene: Scene) -> tuple[tuple[float, float], ThresholdCurve]:
    """Return the frequencies (Hz) over which the tip shall be felt, and from where on it is."""
    threshold = threshold_of(scene.threshold)
    return stated_band(threshold), threshold


def _cases(scene: Scene, aims: Sequence[Aim]) -> list[tuple[str, str, Design]]:
    """Return the aims in both wirings: title, what is sought, result."""
    found = []
    for wiring in ("parallel", "series"):
        bimorph = scene.bimorph.model_copy(update={"wiring": wiring})
        wired = scene.model_copy(update={"bimorph": bimorph})
        found += [(wiring, _SOUGHT[aim.kind], design(wired, aim)) for aim in aims]
    return found


def _at_band_end(scene: Scene) -> dict[str, Any]:
    """Return how ill-conditioned the deflection is at the band's end, for the scene's length."""
    at = _band(scene)[0][1]
    slopes = logarithmic_sensitivities(
        actuator(scene), TIP_DISPLACEMENT.port_readout, None, np.array([at])
    )
    strongest = sorted(slopes.items(), key=lambda item: -abs(float(item[1][0])))[:4]
    return {"frequency": at, "slopes": [(key, float(value[0])) for key, value in strongest]}
