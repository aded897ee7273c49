"""Piezoelectric resonators and bodies with exact answers: plates, bars, a block, a cube."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.material_library import LIBRARY
from tactgen.geometry.device.materials import EPS0, Piezoceramic, PiezoTensors
from tactgen.validation.evidence.boxes import (
    Box,
    Component,
    Held,
    Together,
    Where,
    block,
    even,
    harmonic,
    natural_frequencies,
    statics,
)
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.cases.special_beams import BENT
from tactgen.validation.evidence.mesh_levels import cached

_IEEE = "IEEE Std 176-1987, in closed form"
_BRICKS = "bricks of the model solid, general supports and electrodes"
_CERAMIC = LIBRARY["PZT-5A"]
_AXES = (0, 1, 2)


def poled(ceramic: Piezoceramic, poled: Component = "x") -> Material:
    """Ceramic poled along an axis of the box."""
    tensors = ceramic.tensors(lossy=False)
    if poled == "z":  # exchange x and z: Voigt xx yy zz yz xz xy
        voigt, axes = np.array([2, 1, 0, 5, 4, 3]), np.array([2, 1, 0])
        tensors = PiezoTensors(
            tensors.c[np.ix_(voigt, voigt)],
            tensors.e[np.ix_(axes, voigt)],
            tensors.eps[np.ix_(axes, axes)],
        )
    return Material(tensors.c, ceramic.density, tensors)


# --- plates of infinite extent -----------------------------------------------------------------

_THICKNESS = 1e-3


def _plate(shear: bool) -> Box:
    """Column of a 1 mm plate that moves along its normal (x) or in its plane (z).

    What does not vary along the plate does not move the other way.  Its halves are mirrored: the
    column reaches from the middle (φ = 0) to one electrode.
    """
    material = poled(_CERAMIC, "z" if shear else "x")
    box = block((even(0.5 * _THICKNESS, 1, 9), even(1e-4, 1, 1), even(1e-4, 1, 1)), material)
    # all points of a height move alike: one column of nodes, the others tied to it
    other: tuple[Component, ...] = ("x", "y") if shear else ("y", "z")
    moving: Component = "z" if shear else "x"
    ties = tuple(
        Together(Where(x=float(at)), component)
        for at in box.x.nodes[1:-1]
        for component in (moving, "phi")
    )
    outer = float(box.x.nodes[-1])
    held = (Held(Where(), other), Held(Where(x=0.0), (moving, "phi")))
    return replace(box, held=held, together=(*ties, Together(Where(x=outer), moving)))


def _plate_frequency(shear: bool, grounded: bool) -> float:
    box = _plate(shear)
    outer = Where(x=float(box.x.nodes[-1]))
    if grounded:
        box = replace(box, held=(*box.held, Held(outer, ("phi",))))
    else:
        box = replace(box, together=(*box.together, Together(outer, "phi")))
    return float(natural_frequencies(box, 1)[0])


def _plate_answers(coupling: float, parallel: float, series: float, shear: bool) -> list[Check]:
    return [
        Check("The charge-free plate resonates at f_p = √(c^D/ρ)/(2 h).", parallel, "Hz",
               partial(_plate_frequency, shear, False)),
        Check("The short-circuited plate resonates where k² = (π f_s/2 f_p) cot(π f_s/2 f_p).",
               series, "Hz", partial(_plate_frequency, shear, True)),
        Check("Its coupling factor from the two is that of the constants.", coupling, "1",
               lambda: _coupling(_plate_frequency(shear, True), _plate_frequency(shear, False))),
    ]  # fmt: skip


def _coupling(series: float, parallel: float) -> float:
    """Coupling factor of a bar or plate driven along its motion, from f_s and f_p."""
    phase = 0.5 * math.pi * series / parallel
    return math.sqrt(phase / math.tan(phase))


_EXPONENTIAL = "half a cosine by a polynomial of degree 9"
_PLATES = tuple(
    case(
        name,
        f"{words} of an endless plate (IEEE 176)",
        f"A PZT-5A plate of 1 mm, electrodes on both faces, {motion}: parallel and series "
        "resonance.",
        model=_BRICKS + ", one of degree 9 through half the thickness",
        source=_IEEE + ", with the library's PZT-5A",
        tolerance=1e-8,
        reason=_EXPONENTIAL,
        rows=_plate_answers(*values, shear),
    )
    for name, words, motion, shear, values in (
        ("TE", "Thickness extension", "poled along its normal, held sideways", False,
         (0.48465880340, 2162019.6726948, 1934044.1700592)),
        ("TS", "Thickness shear", "poled in its plane", True,
         (0.68465002097, 1130631.5474351, 862133.9657283)),
    )
)  # fmt: skip

# --- bars --------------------------------------------------------------------------------------

_BAR, _SIDE = 10e-3, 0.1e-3
#: PZT-5A as the published values of the two bars have it.
_BAR_CERAMIC = replace(_CERAMIC, eps_t=np.diag([1730.0, 1730.0, 1700.0]) * EPS0)
_SLENDER = "Rayleigh's correction for a bar 0.1 mm thick: (ν π a/L)²/12 is 1e-5, ceramic's ν = 0.35"


def _bar(along: bool) -> Box:
    """Eighth of a 10 mm bar along z, driven across (31) or along its length (33)."""
    material = poled(_BAR_CERAMIC, "z" if along else "x")
    side = even(0.5 * _SIDE, 1, 2)
    box = block((side, side, even(0.5 * _BAR, 2, 7)), material)
    return replace(box, held=_mirrored(grounded="z" if along else "x"))


def _mirrored(grounded: Component) -> tuple[Held, ...]:
    """What holds an eighth at its planes of symmetry; the potential is odd at one."""
    planes = {"x": Where(x=0.0), "y": Where(y=0.0), "z": Where(z=0.0)}
    held = [Held(plane, (axis,)) for axis, plane in planes.items()]  # type: ignore[arg-type]
    return (*held, Held(planes[grounded], ("phi",)))


def _bar_frequency(along: bool, grounded: bool) -> float:
    box = _bar(along)
    end = Where(z=0.5 * _BAR) if along else Where(x=0.5 * _SIDE)
    if grounded:
        box = replace(box, held=(*box.held, Held(end, ("phi",))))
    else:
        box = replace(box, together=(*box.together, Together(end, "phi")))
    return float(natural_frequencies(box, 1)[0])


_BARS = tuple(
    case(
        name,
        f"Bar driven {words} its length (IEEE 176)",
        f"A slender bar of PZT-5A, 10 mm, poled and driven {words} its length, ends free.",
        model=_BRICKS + ", two of degree 7 along half the bar",
        source=_IEEE + ", with the library's PZT-5A",
        tolerance=3e-5,
        reason=_SLENDER + "; six printed digits",
        rows=[
            Check("Its series resonance is that of the closed form.", series, "Hz",
                   partial(_bar_frequency, along, True)),
            Check("Its parallel resonance is that of the closed form.", parallel, "Hz",
                   partial(_bar_frequency, along, False)),
        ],
    )
    for name, words, along, series, parallel in (
        ("BAR31", "across", False, 140248.0, 147495.0),
        ("BAR33", "along", True, 137381.0, 184201.0),
    )
)  # fmt: skip


_FACE = Where(x=0.025e-3)


def _driven_bar() -> Box:
    """Eighth of the 10 x 0.2 x 0.05 mm bar, half a volt on its face."""
    axes = (even(0.025e-3, 1, 2), even(0.1e-3, 1, 2), even(5e-3, 2, 6))
    held = (*_mirrored(grounded="x"), Held(_FACE, ("phi",), 0.5))
    return replace(block(axes, poled(_BAR_CERAMIC)), held=held)


@cached
def _admittance(frequency: float) -> float:
    """Im Y (S) of the whole bar."""
    state = harmonic(_driven_bar(), frequency)
    return 2.0 * math.pi * frequency * 4.0 * state.force(_FACE, "phi").real


_ADMITTANCE = case(
    "YBAR",
    "Admittance of a bar driven across its length (IEEE 176)",
    "PZT-5A, 10 x 0.2 x 0.05 mm (the same admittance as 10 x 2 x 0.5 mm, but with a hundredth of "
    "the lateral inertia, which goes with (ν width/length)²), electrodes on the largest faces, "
    "ends free, no losses.",
    model=_BRICKS,
    source=_IEEE + ": ω ε33 (1 − k31²) b L/h (1 + k31²/(1 − k31²) tan q/q), q = ω L √(ρ s11)/2",
    tolerance=1e-3,
    reason="the width's inertia lowers the resonance by 2e-5, which counts 24 times at 160 kHz",
    rows=[
        Check(f"Im Y at {f / 1e3:g} kHz is that of the closed form.", value, "S",
               partial(_admittance, f))
        for f, value in ((100e3, 416.150467e-6), (160e3, 355.686270e-6))
    ],
)  # fmt: skip

# --- a free block, a cube ----------------------------------------------------------------------


def _held_block() -> Box:
    """Block with 1 V across 1 mm, held against rigid motion alone."""
    box = block((even(1e-3, 1, 1), even(2e-3, 1, 1), even(10e-3, 1, 1)), poled(_CERAMIC))
    held = (
        Held(Where(x=0.0), ("phi",), 1.0),
        Held(Where(x=1e-3), ("phi",)),
        Held(Where(x=0.0, y=0.0, z=0.0), ("x", "y", "z")),
        Held(Where(x=0.0, y=0.0, z=10e-3), ("x", "y")),
        Held(Where(x=0.0, y=2e-3, z=0.0), ("x",)),
    )
    return replace(box, held=held)


@cached
def _free_block() -> tuple[float, float]:
    """Stretch along 10 mm and across 1 mm (m)."""
    state = statics(_held_block())
    along = state.mean(Where(z=10e-3), "z") - state.mean(Where(z=0.0), "z")
    across = state.mean(Where(x=1e-3), "x") - state.mean(Where(x=0.0), "x")
    return along.real, across.real


_BLOCK = case(
    "BLOCK",
    "Free block in a uniform field",
    "PZT-5A, 10 x 2 x 1 mm, poled and driven with 1 V along 1 mm, free: a patch test.",
    model=_BRICKS + ", one brick of degree 1",
    source="d31 V L/t and d33 V",
    tolerance=1e-10,
    reason="linear functions contain the answer; rounding",
    rows=[
        Check("It grows along its length by d31 V L/t.", -1.71e-9, "m", lambda: _free_block()[0]),
        Check("It grows along the field by d33 V.", 0.374e-9, "m", lambda: _free_block()[1]),
    ],
)


def _pzt4() -> Material:
    """PZT-4 as ANSYS VM175 has it, poled along x (c, e and ε at constant strain)."""
    c = np.zeros((6, 6))
    c[:3, :3] = np.array([[115.0, 73.0, 73.0], [73.0, 132.0, 71.0], [73.0, 71.0, 132.0]]) * 1e9
    c[3, 3], c[4, 4], c[5, 5] = 30.0e9, 26.0e9, 26.0e9
    e = np.zeros((3, 6))
    e[0, :3] = 14.1, -4.1, -4.1
    e[1, 5] = e[2, 4] = 10.5
    return Material(c, 7500.0, PiezoTensors(c, e, np.diag([659.7, 804.6, 804.6]) * EPS0))


_PERTURBED = (
    "the targets are those of a mixed finite element-perturbation method of 1981 (Boucher, Lagier, "
    "Maerfeld, table 1), not of a converged solution: here all four fall to these values as the "
    "mesh is refined, and from degree 5 to two elements of degree 6 move by 1e-7 to 2e-5"
)


def _eighth(grounded: bool) -> Box:
    """Eighth of VM175's cube, its electrode at 0 V or without charge."""
    half = 10e-3
    box = block((even(half, 1, 6),) * 3, _pzt4())
    held = _mirrored(grounded="x")
    face = Where(x=half)
    if grounded:
        return replace(box, held=(*held, Held(face, ("phi",))))
    return replace(box, held=held, together=(Together(face, "phi"),))


@cached
def _cube(grounded: bool) -> Floats:
    """Frequencies (Hz) of the cube that are even at all planes of symmetry.

    Some of them are odd under the exchange of y and z: a voltage does not excite those.
    """
    return natural_frequencies(_eighth(grounded), 5)


CUBE = case(
    "VM175",
    "Piezoelectric cube (ANSYS VM175)",
    "A free cube of PZT-4, 20 mm, electrodes on two faces: frequencies of the two lowest motions "
    "that a voltage excites.",
    model=_BRICKS + ", an eighth by symmetry, degree 6",
    source="ANSYS Verification Manual, VM175, targets as printed; D. Boucher, M. Lagier, C. "
    "Maerfeld, IEEE Trans. Sonics Ultrason. SU-28 (1981) 318, table 1",
    tolerance=1e-3,
    reason="four printed digits",
    rows=[
        Check(f"The cube's {words} frequency is the manual's.", value, "Hz",
               nth(_cube, at, grounded), explained=_PERTURBED, known=known)
        for grounded, words, at, value, known in (
            (True, "first short-circuit", 0, 66560.0, -0.0219),
            (True, "second short-circuit", 3, 88010.0, 0.00144),
            (False, "first open-circuit", 2, 81590.0, -0.0219),
            (False, "second open-circuit", 4, 93410.0, 0.00179),
        )
    ],
)  # fmt: skip

CASES: tuple[Case, ...] = (*_PLATES, *_BARS, _ADMITTANCE, _BLOCK, BENT)
