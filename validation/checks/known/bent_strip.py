"""A piezoelectric strip in pure bending: quadratic functions contain the answer (ANSYS VM231)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.materials import EPS0, PiezoTensors
from tactgen.validation.checks.case import Answer, case, nth
from tactgen.validation.checks.cases.boxes import (
    Box,
    Component,
    Held,
    Load,
    Where,
    block,
    even,
    statics,
)
from tactgen.validation.checks.cases.fineness import cached
from tactgen.validation.checks.drawings.sections import section

#: Half length, half height and width (m); slope of the stress over the height (N/m³).
LENGTH, HEIGHT, _WIDTH = 1e-3, 0.5e-3, 0.2e-3
SLOPE = -20e9


def strip_material() -> Material:
    """Return PZT-4 as ANSYS VM231 has it, poled along x (c, e and ε at constant strain)."""
    c = np.zeros((6, 6))
    c[:3, :3] = np.array([[115.0, 74.3, 74.3], [74.3, 139.0, 77.8], [74.3, 77.8, 139.0]]) * 1e9
    c[3, 3], c[4, 4], c[5, 5] = 30.6e9, 25.6e9, 25.6e9
    e = np.zeros((3, 6))
    e[0, :3] = 15.1, -5.2, -5.2
    e[1, 5] = e[2, 4] = 12.7
    return Material(c, 7500.0, PiezoTensors(c, e, np.diag([634.7, 728.5, 728.5]) * EPS0))


def _strip() -> Box:
    """Return half the strip, poled along its height x, bent about y, free but for rigid motion."""
    height = even(2.0 * HEIGHT, 2, 2)
    axes = (replace(height, breaks=height.breaks - HEIGHT), even(_WIDTH, 1, 2), even(LENGTH, 1, 2))
    box = block(axes, strip_material())
    held = (
        Held(Where(z=0.0), ("z",)),
        Held(Where(y=0.0), ("y",)),
        Held(Where(x=0.0, y=0.0, z=0.0), ("x", "phi")),
    )
    return replace(box, held=held, loads=(Load(Where(z=LENGTH), "z", lambda x, _y, _z: SLOPE * x),))


@cached
def _corner() -> Floats:
    """Return displacement along and across the strip (m) and the potential (V) at its corner."""
    state = statics(_strip())
    at = Where(x=HEIGHT, y=0.0, z=LENGTH)
    return np.array([state.mean(at, component).real for component in _COMPONENTS])


_COMPONENTS: tuple[Component, ...] = ("z", "x", "phi")
_WORDS = ("moves along the strip", "moves across it", "is at the potential")
BENT = case(
    "VM231",
    "Piezoelectric strip in pure bending (ANSYS VM231)",
    "PZT-4, poled along its height, 2 mm long and 1 mm high, no electrodes; at its ends a stress "
    "along it of −20 GPa/m times the height above its middle; displacements and potential at the "
    "corner, against the middle of the strip.",
    model="bricks of the model solid, two of degree 2 for half of the strip",
    source="ANSYS Verification Manual, VM231, after Parton, Kudryavtsev and Senik: exact",
    tolerance=5e-5,
    reason="five printed digits, of compliances printed with six; bricks of degree 2 are exact",
    answers=[
        Answer(f"The corner {words} as in closed form.", value, unit, nth(_corner, at))
        for at, (words, value, unit) in enumerate(
            zip(_WORDS, (-1.0953e-7, 1.1493e-7, 27.378), ("m", "m", "V"), strict=True)
        )
    ],
    setup=section(_strip),
)
