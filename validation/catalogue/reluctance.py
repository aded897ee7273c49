"""The quantities of the normal actuator, one row each.

Those of one current and gap are read off a MagneticPoint, those of the stroke off
SwitchingCurrents, those of the rod between its stops off a RestingState.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tactgen.validation.catalogue.row import AnswerReadout, QuantityRow


def _at_point(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("magnetic_point", of)


def _of_stroke(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("magnetic_map", of)


def _at_rest(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("rest", of)


MAGNETIC_FORCE = QuantityRow(
    "magnetic_force", "N", "pull between rod and sleeve at the coil's current and the gap",
    _at_point(lambda point: point.force), label="pull", headline=True,
)  # fmt: skip
FLUX_LINKAGE = QuantityRow(
    "flux_linkage", "Wb", "flux linkage of the winding, all turns",
    _at_point(lambda point: point.flux_linkage),
)  # fmt: skip
INCREMENTAL_INDUCTANCE = QuantityRow(
    "incremental_inductance", "H", "d flux linkage / d current, gap held",
    _at_point(lambda point: point.incremental_inductance),
)  # fmt: skip
PULL_IN_CURRENT = QuantityRow(
    "pull_in_current", "A", "current that draws the rod to its lower stop",
    _of_stroke(lambda currents: currents.pull_in), label="pull-in current", headline=True,
)  # fmt: skip
DROP_OUT_CURRENT = QuantityRow(
    "drop_out_current", "A", "current below which the rod is back at its upper stop",
    _of_stroke(lambda currents: currents.drop_out), label="drop-out current",
)  # fmt: skip

ROWS = (
    MAGNETIC_FORCE,
    FLUX_LINKAGE,
    QuantityRow(
        "coenergy", "J", "magnetic co-energy", _at_point(lambda point: point.coenergy),
        label="co-energy",
    ),
    QuantityRow(
        "inductance", "H", "apparent inductance, flux linkage / current",
        _at_point(lambda point: point.inductance), headline=True,
    ),
    INCREMENTAL_INDUCTANCE,
    PULL_IN_CURRENT,
    QuantityRow(
        "holding_current", "A", "least current that holds the rod at its lower stop",
        _of_stroke(lambda currents: currents.holding),
    ),
    DROP_OUT_CURRENT,
    QuantityRow(
        "rod_position", "m",
        "where the rod rests at the coil's current and history: 0 at the upper stop, negative down",
        _at_rest(lambda state: state.position), headline=True,
    ),
    QuantityRow(
        "finger_force", "N",
        "force with which the rod there would push a finger: spring less pull, negative if held",
        _at_rest(lambda state: state.finger_force), headline=True,
    ),
    QuantityRow(
        "contact_force", "N", "force that presses the rod's head on its stop there, 0 if it floats",
        _at_rest(lambda state: state.contact_force),
    ),
    QuantityRow(
        "resting_positions", "m",
        "all places where the rod can rest at the coil's current, stable or not, from the top",
        _at_rest(lambda state: state.places),
    ),
)  # fmt: skip
