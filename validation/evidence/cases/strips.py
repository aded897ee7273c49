"""Bimetal strips, whose free strains are driven by a field: published closed forms."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.geometry.device.materials import EPS0, PiezoTensors, isotropic_stiffness
from tactgen.validation.evidence.boxes import Box, Held, Load, State, Where, even, stacked, statics
from tactgen.validation.evidence.case import Case, Check, case
from tactgen.validation.evidence.mesh_levels import cached


def expanding(modulus: float, strain: float) -> Material:
    """Isotropic layer (ν = 0) that expands by `strain` along z.

    An expansion is what a field of 1 V/m along x does to a material with e = c · strain: so a
    potential of −x makes the twin of a change of temperature.
    """
    c = isotropic_stiffness(modulus, 0.0)
    e = np.zeros((3, 6))
    e[0] = c @ np.array([0.0, 0.0, strain, 0.0, 0.0, 0.0])
    return Material(c, 1.0, PiezoTensors(c, e, np.eye(3)))


@cached
def _bimetal(
    layers: tuple[tuple[float, float, float], ...], length: float, moment: float = 0.0
) -> tuple[float, float, Callable[[float], float]]:
    """Deflection and stretch of the tip, and the stress along z at a depth x.

    Layers are (thickness, modulus, free strain), from below; clamped at z = 0.  A moment (per
    width) pulls the upper side of the free end, where the stress is that of a long strip.
    """
    thicknesses = tuple(layer[0] for layer in layers)
    parts = tuple(
        (Slab(f"layer{i}", (i, i + 1), (0, 1)), expanding(modulus, strain))
        for i, (_, modulus, strain) in enumerate(layers)
    )
    box = Box(
        x=stacked(thicknesses, 2),
        y=even(1.0, 1, 1),
        z=even(length, 1, 2),
        parts=parts,
        held=(
            Held(Where(), ("phi",), lambda x, _y, _z: -x),
            Held(Where(z=0.0), ("z",)),
            Held(Where(x=0.0, z=0.0), ("x",)),
            Held(Where(x=0.0, y=0.0, z=0.0), ("y",)),
            Held(Where(x=0.0, y=0.0, z=length), ("y",)),
        ),
        loads=_end_stress(layers, length, moment),
    )
    state = statics(box)
    total = sum(thicknesses)
    middle = 0.5 * (
        state.mean(Where(x=0.0, z=length), "z") + state.mean(Where(x=total, z=length), "z")
    )

    def stress(x: float) -> float:
        # no stress across and no Poisson's ratio: the strain is linear in x
        low, high = (state.mean(Where(x=at, z=length), "z").real for at in (0.0, total))
        strain = (low + (high - low) * x / total) / length
        edges = np.cumsum(thicknesses)
        _, modulus, free = layers[int(np.searchsorted(edges, x - 1e-9 * total))]
        return modulus * (strain - free)

    return state.mean(Where(x=0.0, z=length), "x").real, middle.real, stress


def _strip_theory(
    layers: tuple[tuple[float, float, float], ...], moment: float = 0.0
) -> tuple[float, float]:
    """Strain at the lower face and curvature of a long strip: force 0, moment as given."""
    edges = np.concatenate([[0.0], np.cumsum([layer[0] for layer in layers])])
    moduli, free = (np.array([layer[i] for layer in layers]) for i in (1, 2))
    a, b, d = (float(moduli @ np.diff(edges**n)) / n for n in (1, 2, 3))
    push, turn = (float(moduli * free @ np.diff(edges**n)) / n for n in (1, 2))
    strain, curvature = np.linalg.solve([[a, b], [b, d]], [push, turn + moment])
    return float(strain), float(curvature)


def _end_stress(
    layers: tuple[tuple[float, float, float], ...], length: float, moment: float
) -> tuple[Load, ...]:
    """Tractions on the free end that it has the stress of the strip far from it.

    Without them the thermal stress, whose force and moment are 0, would have to fade there.
    """
    strain, curvature = _strip_theory(layers, moment)
    edges = np.concatenate([[0.0], np.cumsum([layer[0] for layer in layers])])

    def traction(modulus: float, free: float, x: Floats, _y: Floats, _z: Floats) -> Floats:
        return np.asarray(modulus * (strain + curvature * x - free))

    return tuple(
        Load(Where(x=(float(low), float(high)), z=length), "z", partial(traction, modulus, free))
        for low, high, (_, modulus, free) in zip(edges[:-1], edges[1:], layers, strict=True)
    )


_VM144 = ((0.2, 1.2e6, 1.8e-2), (0.1, 0.4e6, 0.6e-2))
_VM35 = ((0.05, 30e6, 2e-3), (0.05, 30e6, 1e-3))
_STRAIN, _CURVATURE = _strip_theory(_VM144, 20.0)
_TWIN = (
    "the traction on the free end is the strip's own stress, so quadratic functions contain the "
    "answer"
)

CASES: tuple[Case, ...] = (
    case(
        "VM35",
        "Bimetal strip of two equal layers (ANSYS VM35)",
        "10 in long, two layers of 0.05 in, E = 30e6 psi, expansions 2e-5 and 1e-5 per degree, "
        "100 degrees warmer, one end clamped.",
        model="bricks of the model solid; the expansion is driven by the field",
        source="ANSYS Verification Manual, VM35 (Timoshenko's bimetal in closed form)",
        tolerance=1e-6,
        reason=_TWIN + "; rounding, which a strip of 100 thicknesses magnifies to 1e-7",
        rows=[
            Check("The tip deflects by 0.75 in.", 0.75, "in", lambda: _bimetal(_VM35, 10.0)[0]),
            Check("The strip grows by 0.015 in.", 0.015, "in", lambda: _bimetal(_VM35, 10.0)[1]),
            Check("The outer fibre of the layer that expands more is stressed to 7500 psi.",
                   7500.0, "psi", lambda: _bimetal(_VM35, 10.0)[2](0.0)),
        ],
    ),
    case(
        "VM144",
        "Strip of two unequal layers, warmed and bent (ANSYS VM144)",
        "8 in long, 0.2 in with E = 1.2e6 psi under 0.1 in with 0.4e6 psi, expansions 1.8e-4 and "
        "0.6e-4 per degree, 100 degrees warmer, one end clamped, 20 in lb per inch of width at the "
        "other, where it pulls the thinner layer.",
        model="bricks of the model solid; the expansion is driven by the field",
        source="strip theory; ANSYS Verification Manual, VM144 (Roark, 5th edition), prints "
        "0.832 in, 2258 psi and 1731 psi",
        tolerance=1e-8,
        reason=_TWIN + "; rounding",
        rows=[
            Check("The tip deflects towards the thinner layer as strip theory has it.",
                   -0.5 * _CURVATURE * 8.0**2, "in", lambda: _bimetal(_VM144, 8.0, 20.0)[0]),
            Check("So is the thinner layer's outer fibre stressed.",
                   0.4e6 * (_STRAIN + 0.3 * _CURVATURE - 0.6e-2), "psi",
                   lambda: _bimetal(_VM144, 8.0, 20.0)[2](0.3)),
            Check("So is the thicker layer's.", 1.2e6 * (_STRAIN - 1.8e-2), "psi",
                   lambda: _bimetal(_VM144, 8.0, 20.0)[2](0.0)),
        ],
    ),
)  # fmt: skip


#: Length, width, thickness of a layer (m); s11 (1/Pa), d31 (C/N) of the ceramic: as in case SMITS.
_L, _W, _H = 20e-3, 2.1e-3, 0.26e-3
_S11, _D31 = 16.4e-12, -171e-12
#: Moduli of shear and squeezing over E: more would add less than 5e-6 to the bending, and lose as
#: much to rounding.
_STIFF = 100.0


def _bimorph(pressure: float, volts: float) -> Box:
    """Two layers in series: a pressure (Pa) on the upper face, volts across both."""
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
    """That of the end face, by its motion along z, which is 0 in the middle."""
    return -_state(1.0, 0.0).mean(Where(x=2.0 * _H, z=_L), "z").real / _H


def _volume(pressure: float, volts: float) -> float:
    """Volume (m³) that the bimorph sweeps."""
    return _W * _L * abs(_state(pressure, volts).mean(Where(x=_H), "x"))


SMITS: tuple[Case, ...] = (
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
        rows=[
            Check("The tip's deflection per pressure is that of the matrix, 3 s11 L⁴/(16 h³).",
                   3.0 * _S11 * _L**4 / (16.0 * _H**3), "m/Pa", _deflection),
            Check("The tip's rotation per pressure is s11 L³/(4 h³).",
                   _S11 * _L**3 / (4.0 * _H**3), "rad/Pa", _rotation),
            Check("The volume per pressure is 3 s11 w L⁵/(40 h³).",
                   3.0 * _S11 * _W * _L**5 / (40.0 * _H**3), "m^3/Pa", lambda: _volume(1.0, 0.0)),
            Check("The volume per volt, and so the charge per pressure, is −d31 w L³/(8 h²).",
                   -_D31 * _W * _L**3 / (8.0 * _H**2), "m^3/V", lambda: _volume(0.0, 1.0)),
        ],
    ),
)  # fmt: skip
