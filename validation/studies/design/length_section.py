"""The report's section on the length of the actuator (the paper's Fig 9 and section 4)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.sensitivities import logarithmic_sensitivities
from tactgen.validation.catalogue.bimorph import TIP_DISPLACEMENT
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.design import wording
from tactgen.validation.studies.design.aim import PAPER_LENGTHS, Aim
from tactgen.validation.studies.design.length_dependence import decided_lengths, dependences
from tactgen.validation.studies.design.length_design import Design, design
from tactgen.validation.studies.design.length_map import LengthMap, actuator, length_map
from tactgen.validation.studies.design.length_scan import lowest_margin

#: Lengths of the table and the plot: from 20 to 40 mm in steps of 2.5 mm.
CURVES = 9
#: Lengths (m) that the paper does not show, for comparison.
_SHORTER = (10e-3, 40e-3)
_SOUGHT = {"shortest": "shortest that keeps margin 1", "margin": "largest margin"}
#: Parameters with smaller slopes are named without their number: 10 % of one then moves the
#: length by less than 0.005 %.
NEGLIGIBLE = 5e-4


def section(
    scene: Scene, origins: dict[str, str], announce: Callable[[str], None]
) -> dict[str, Any] | None:
    """Return what the report shows; None for an actuator that does not move.

    The scene's bimorph and support in the paper's own question: under the finger, at 50 V.
    Where the ceramic cannot have other lengths, `found` is None and `why` says so.
    """
    if scene.piezo.d31 == 0.0:
        return None
    announce("length design")
    try:
        return _found(scene, origins)
    except InputError as reason:
        return {"found": None, "why": str(reason)}


def _found(scene: Scene, origins: dict[str, str]) -> dict[str, Any]:
    from tactgen.validation.studies.design.plots import length_plot

    asked = scene.model_copy(
        update={
            "load": scene.load.model_copy(update={"kind": "finger"}),
            "drive": scene.drive.model_copy(update={"voltage": 50.0}),
        }
    )
    study = length_map(asked, np.linspace(*PAPER_LENGTHS, CURVES), Aim().band)
    found = design(asked, Aim())
    rows = dependences(found, origins)
    return {
        "plot": length_plot(study, found),
        "rows": table_rows(asked, study, found.aim),
        "law": study.minimum_law,
        "found": found,
        "changed": wording.changed_setting(scene, asked),
        "caveat": wording.caveat(found),
        "statements": (
            wording.statement(found),
            wording.feasible(found),
            wording.present(found),
        ),
        "signed": wording.signed,
        "cases": _cases(asked),
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


def _cases(scene: Scene) -> list[tuple[str, str, Design]]:
    """Return the aims worth comparing: title, what is sought, result."""
    aims = [Aim(), Aim(kind="margin")]
    if scene.bimorph.bare_below + scene.bimorph.bare_above < _SHORTER[0]:
        aims.append(Aim(kind="margin", lengths=_SHORTER))
    found = []
    for wiring in ("parallel", "series"):
        bimorph = scene.bimorph.model_copy(update={"wiring": wiring})
        wired = scene.model_copy(update={"bimorph": bimorph})
        found += [(wiring, _SOUGHT[aim.kind], design(wired, aim)) for aim in aims]
    return found


def _at_band_end(scene: Scene) -> dict[str, Any]:
    """Return how ill-conditioned the deflection is at the band's end, for the scene's length."""
    at = Aim().band[1]
    slopes = logarithmic_sensitivities(
        actuator(scene), TIP_DISPLACEMENT.port_readout, None, np.array([at])
    )
    strongest = sorted(slopes.items(), key=lambda item: -abs(float(item[1][0])))[:4]
    return {"frequency": at, "slopes": [(key, float(value[0])) for key, value in strongest]}
