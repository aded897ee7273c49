"""The normal actuator's models far beyond the device: they converge, or say why not.

Held against exact limits where there are any, else an answer's own error bar against a
finer solution.
"""

from __future__ import annotations

import time

from tactgen.validation.checks.stress import Asked, Families
from tactgen.validation.checks.stress.magnetics_circuit import network_rows, refused_row
from tactgen.validation.checks.stress.magnetics_device import (
    as_built_row,
    device_rows,
    narrow_gap_row,
    solenoid_row,
)
from tactgen.validation.checks.stress.magnetics_solid import ball_row, sliver_row, team20_rows
from tactgen.validation.checks.stress.result import Stress

_FAMILIES: Families = {
    "device, permeability, gap and current": device_rows,
    "device, coarse to fine": as_built_row,
    "narrow gap": narrow_gap_row,
    "long core": solenoid_row,
    "3D slivers": sliver_row,
    "3D ball": ball_row,
    "3D, TEAM problem 20": team20_rows,
    "network": network_rows,
    "no answer exists": refused_row,
}
_STATEMENT = (
    "Each answer is within what was promised of it: its own error bar (with the finer solution's) "
    "or, where the exact answer is known, the bound that follows from the method.  A point counts "
    "as refused if the model says in one sentence why it has no answer: the grid may be too "
    "coarse for one."
)


def run(asked: Asked) -> Stress:
    """Run all families; half a minute if quick, else about two."""
    started = time.perf_counter()
    rows = asked.rows("magnetics", _FAMILIES)
    return Stress("magnetics", _STATEMENT, rows, (), (), time.perf_counter() - started)
