"""The quantities of the normal actuator, one row each.

Those of one current and gap are read off a MagneticPoint, those of the stroke off
SwitchingCurrents.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tactgen.validation.catalogue.row import AnswerReadout, QuantityRow


def _at_point(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("magnetic_point", of)


def _of_stroke(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("magnetic_map", of)


ROWS = (
    QuantityRow(
        "magnetic_force", "N", "pull between rod and sleeve at the coil's current and the gap",
        _at_point(lambda point: point.force), label="pull", headline=True,
    ),
    QuantityRow(
        "flux_linkage", "Wb", "flux linkage of the winding, all turns",
        _at_point(lambda point: point.flux_linkage),
    ),
    QuantityRow(
        "coenergy", "J", "magnetic co-energy", _at_point(lambda point: point.coenergy),
        label="co-energy",
    ),
    QuantityRow(
        "inductance", "H", "apparent inductance, flux linkage / current",
        _at_point(lambda point: point.inductance), headline=True,
    ),
    QuantityRow(
        "incremental_inductance", "H", "d flux linkage / d current, gap held",
        _at_point(lambda point: point.incremental_inductance),
    ),
    QuantityRow(
        "pull_in_current", "A", "current that draws the rod to its lower stop",
        _of_stroke(lambda currents: currents.pull_in), label="pull-in current", headline=True,
    ),
    QuantityRow(
        "holding_current", "A", "least current that holds the rod at its lower stop",
        _of_stroke(lambda currents: currents.holding),
    ),
    QuantityRow(
        "drop_out_current", "A", "current below which the rod is back at its upper stop",
        _of_stroke(lambda currents: currents.drop_out), label="drop-out current",
    ),
)  # fmt: skip
