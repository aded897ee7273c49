"""Smits' bimorph under uniform pressure: the row and the column that the beam models do not have.

By bricks of a body that bends as Bernoulli's beam does: no Poisson's ratio, next to no shear.
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.geometry.device.materials import EPS0, PiezoTensors
from tactgen.validation.checks.case import Answer, Case, case
from tactgen.validation.checks.cases.boxes import (
    Box,
    Held,
    Load,
    State,
    Where,
    even,
    stacked,
    statics,
)
from tactgen.validation.checks.cases.fineness import cached
from tactgen.validation.checks.drawings.sections import section

#: Length, width, thickness of a layer (m); s11 (1/Pa), d31 (C/N) of the ceramic: as in case SMITS.
_L, _W, _H = 20e-3, 2.1e-3, 0.26e-3
_S11, _D31 = 16.4e-12, -171e-12
#: Moduli of shear and squeezing over E: more would add less than 5e-6 to the bending, and lose as
#: much to rounding.
_STIFF = 100.0


def _bimorph(pressure: float, volts: float) -> Box:
    """Return the two layers in series: a pressure (Pa) on the upper face, volts across both."""
    stiffness = np.diag([_STIFF, _STIFF, 1.0, _STIFF, _STIFF, _STIFF]) / _S11
    coupling = np.zeros((3, 6))
    coupling[0, 2] = _D31 / _S11
    parts = tuple(
        (
            Slab(name, (i, i + 1), (0, 1)),
            Material(stiffness, 7750.0, PiezoTensors(stiffness, sign * coupling, EPS0 * np.eye(3))),
        )
        for i, (name, sign) in enumerate((("low", -1.0), ("high", 1.0)))
    )
    return Box(
        x=stacked((_H, _H), 2),
        y=even(_W, 1, 1),
        z=even(_L, 1, 5),
        parts=parts,
        held=(
            Held(Where(), ("phi",), lambda x, _y, _z: volts * x / (2.0 * _H)),
            Held(Where(), ("y",)),
            Held(Where(z=0.0), ("x", "z")),
        ),
        loads=(Load(Where(x=2.0 * _H), "x", pressure),),
    )


@cached
def _state(pressure: float, volts: float) -> State:
    return statics(_bimorph(pressure, volts))


def _deflection() -> float:
    return _state(1.0, 0.0).mean(Where(x=_H, z=_L), "x").real


def _rotation() -> float:
    """Return that of the end face, by its motion along z, which is 0 in the middle."""
    return -_state(1.0, 0.0).mean(Where(x=2.0 * _H, z=_L), "z").real / _H


def _volume(pressure: float, volts: float) -> float:
    """Return the volume (m³) that the bimorph sweeps."""
    return _W * _L * abs(_state(pressure, volts).mean(Where(x=_H), "x"))


CASES: tuple[Case, ...] = (
    case(
        "SMITSP",
        "Series bimorph under pressure (Smits, Dalke and Cooney)",
        "The bimorph of case SMITS, two layers of 0.26 mm in series, 20 x 2.1 mm, clamped, s11 = "
        "16.4e-12 1/Pa, d31 = −171e-12 C/N: what a pressure on one face does, and what volume a "
        "voltage sweeps, without its sign.",
        model="bricks of the model solid, of degree 5 along the bimorph, without Poisson's ratio "
        "and with next to no shear",
        source="J. G. Smits, S. I. Dalke, T. K. Cooney, Sensors and Actuators A 28 (1991) 41; "
        "Bernoulli's beam of E I = 2 w h³/(3 s11)",
        tolerance=1e-5,
        reason="shear of a hundred times E adds 5e-6; polynomials of degree 5 contain the rest",
        answers=[
            Answer("The tip's deflection per pressure is that of the matrix, 3 s11 L⁴/(16 h³).",
                   3.0 * _S11 * _L**4 / (16.0 * _H**3), "m/Pa", _deflection),
            Answer("The tip's rotation per pressure is s11 L³/(4 h³).",
                   _S11 * _L**3 / (4.0 * _H**3), "rad/Pa", _rotation),
            Answer("The volume per pressure is 3 s11 w L⁵/(40 h³).",
                   3.0 * _S11 * _W * _L**5 / (40.0 * _H**3), "m^3/Pa", lambda: _volume(1.0, 0.0)),
            Answer("The volume per volt, and so the charge per pressure, is −d31 w L³/(8 h²).",
                   -_D31 * _W * _L**3 / (8.0 * _H**2), "m^3/V", lambda: _volume(0.0, 1.0)),
        ],
        setup=section(_bimorph, 1.0, 0.0),
    ),
)  # fmt: skip
