"""The quantities of the whole machine in small motions about where its rod rests, one row each.

Those of frequency are read off SmallSignal, the poles off MeasuredPoles.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tactgen.geometry.units import Unit
from tactgen.validation.catalogue.row import AnswerReadout, QuantityRow


def _in_motion(of: Callable[[Any], Any]) -> AnswerReadout:
    return AnswerReadout("small_signal", of)


ROWS = (
    QuantityRow(
        "lateral_tip_per_voltage", "m/V",
        "lateral motion of the tip per volt at the bimorph, the coil at its supply",
        _in_motion(lambda machine: machine.by_voltage("w_tip")),
    ),
    QuantityRow(
        "axial_tip_per_voltage", "m/V",
        "axial motion of the tip per volt at the bimorph: 0 while the head stands upright",
        _in_motion(lambda machine: machine.by_voltage("u")),
    ),
    QuantityRow(
        "axial_tip_per_current", "m/A",
        "axial motion of the tip per ampere added in the coil, the bimorph's voltage held",
        _in_motion(lambda machine: machine.by_current("u")),
    ),
    QuantityRow(
        "lateral_tip_per_current", "m/A",
        "lateral motion of the tip per ampere added to the coil's current: 0 on an upright head",
        _in_motion(lambda machine: machine.by_current("w_tip")),
    ),
    QuantityRow(
        "axial_tip_per_coil_voltage", "m/V",
        "axial motion of the tip per volt added at the coil, through its resistance and inductance",
        _in_motion(lambda machine: machine.by_coil_voltage("u")),
    ),
    QuantityRow(
        "coil_impedance", "ohm",
        "voltage per current of the coil with its supply's resistance, what the motion induces too",
        _in_motion(lambda machine: machine.impedance()),
        curve=Unit("ohm", "impedance", "12.3 ohm", limits=(1e-9, 1e12)),
    ),
    QuantityRow(
        "axial_poles", "rad/s",
        "poles of axial motion and coil with its supply, the head not rocking",
        AnswerReadout("machine_poles", lambda poles: poles.listed),
    ),
)  # fmt: skip
