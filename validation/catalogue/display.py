"""The quantities of the display, one row each.

Read off MechanicalCrosstalk and Spread, on any model of the lateral actuator, and NeighbourField,
on models of the normal one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tactgen.validation.catalogue.row import AnswerReadout, QuantityRow


def _moved(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("crosstalk", of)


def _drawn(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("spread", of)


def _pulled(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("neighbours", of)


CROSSTALK_LARGEST = QuantityRow(
    "crosstalk_largest", "1",
    "largest lateral motion of another tip over the driven one's, through board and skin",
    _moved(lambda display: display.largest()),
)  # fmt: skip

ROWS = (
    QuantityRow(
        "crosstalk_beside", "1",
        "lateral motion of the next tip along x over the driven one's, through board and skin",
        _moved(lambda display: display.beside()),
    ),
    QuantityRow(
        "crosstalk_behind", "1",
        "lateral motion of the next tip along y over the driven one's, through board and skin",
        _moved(lambda display: display.behind()),
    ),
    CROSSTALK_LARGEST,
    QuantityRow(
        "crosstalk_by_board", "1",
        "the same with no skin on the tips: what the upper board alone passes on",
        _moved(lambda display: display.by_board()),
    ),
    QuantityRow(
        "unit_frequencies", "Hz",
        "first natural frequency of each unit as drawn from the scatter, row by row",
        _drawn(lambda units: units.as_drawn()),
    ),
    QuantityRow(
        "frequency_spread", "Hz", "highest less lowest of the units' first natural frequencies",
        _drawn(lambda units: units.apart()),
    ),
    QuantityRow(
        "screw_turns", "1",
        "turns of each unit's grub screw that bring it to the units' median, positive tightens",
        _drawn(lambda units: units.screws()),
    ),
    QuantityRow(
        "tuned_spread", "Hz", "highest less lowest after the screws were turned",
        _drawn(lambda units: units.left_apart()),
    ),
    QuantityRow(
        "tuning_range", "Hz",
        "what a grub screw can do to the nominal unit's first natural frequency, from end to end",
        _drawn(lambda units: units.reach()),
    ),
    QuantityRow(
        "pull_all_driven", "N",
        "pull of a unit in an endless array, every coil at display.coil_current, one polarity",
        _pulled(lambda field: field.same),
    ),
    QuantityRow(
        "pull_alternating", "N",
        "the same with polarities that alternate as on a chessboard",
        _pulled(lambda field: field.alternating),
    ),
    QuantityRow(
        "magnetic_crosstalk", "N/A",
        "change of a unit's pull per ampere in each nearest neighbour, if all four change alike",
        _pulled(lambda field: field.per_neighbour()),
    ),
    QuantityRow(
        "pull_one_driven", "N",
        "pull of a single driven unit among others without current, at display.coil_current",
        _pulled(lambda field: field.single),
    ),
    QuantityRow(
        "passive_pull", "N",
        "pull of an undriven unit beside a single driven one, by the field; below 0: it is lifted",
        _pulled(lambda field: field.passive),
    ),
)  # fmt: skip
