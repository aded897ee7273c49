"""Elastic bodies with known answers: cube, torsion, rods, membrane: the solid without a field."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.fem.piezo.tetrahedra import SkfemBody
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Axis
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.validation.evidence.boxes import (
    Box,
    Condition,
    block,
    even,
    graded,
    harmonic,
    held,
    load,
    lowest_frequencies,
    natural_frequencies,
    statics,
)
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.cases import laminates
from tactgen.validation.evidence.cases.manufactured import hexahedra
from tactgen.validation.evidence.mesh_levels import cached, counted, intervals

_BRICKS = "bricks of the model solid"


def _centred(length: float, intervals: int, degree: int) -> Axis:
    return graded(np.linspace(-0.5 * length, 0.5 * length, intervals + 1), degree)


@cached
def _cube() -> Floats:
    """Ω a √(ρ/E) of a free cube's lowest modes, ν = 0.3."""
    box = block((even(1.0, 1, 7),) * 3, Material(isotropic_stiffness(1.0, 0.3), 1.0))
    # more than are read: the copies of a multiple frequency are found one after the other
    return 2.0 * np.pi * natural_frequencies(box, 12, loose=6, near=0.1)


_RUS = case(
    "RUS", "Free elastic cube",
    "A free cube of edge a with ν = 0.3: the lowest ω a √(ρ/E), as resonant ultrasound "
    "spectroscopy uses them.  The first two are one pair, the next three one triple.",
    [
        Check(f"Mode {mode} of the free cube is that of the Ritz series.", value, "1",
               nth(_cube, mode - 1))
        for mode, value in ((1, 1.77126), (2, 1.77126), (3, 2.38518), (5, 2.38518), (6, 2.42566))
    ],
    model=_BRICKS + ", one brick of degree 7",
    source="W. M. Visscher et al., J. Acoust. Soc. Am. 90 (1991) 2154: Ritz, powers up to 13",
    tolerance=2e-5, reason="six digits of a Ritz series that is 1e-5 above its limit",
)  # fmt: skip

_LAME = case(
    "LAME", "Lamé modes of a free cube",
    "A free cube of edge a with ν = 0.3: three modes in which all sections across an edge move "
    "alike in their own plane, without change of volume; ω a √(ρ/E).",
    [
        Check(f"Mode {mode} of the free cube is Lamé's.", math.pi / math.sqrt(1.3), "1",
               nth(_cube, mode - 1))
        for mode in (9, 10, 11)
    ],
    model=_BRICKS + ", one brick of degree 7",
    source="G. Lamé, Leçons sur la théorie mathématique de l'élasticité (1852): ω a = √2 π c_s of "
    "shear waves, whatever ν",
    tolerance=5e-8, reason="half a cosine by a polynomial of degree 7",
)  # fmt: skip


def _torsion_constant(ratio: float) -> float:
    """J/(a b³) of a rectangle: the moment that turns a bar, whose ends may warp, over G θ.

    Uniform torsion is linear along it, so its length and degree there do not matter.
    """
    box = block(
        (_centred(ratio, 2, 10), _centred(1.0, 2, 10), even(1.0, 1, 1)),
        Material(isotropic_stiffness(2.0, 0.0), 1.0),
        held("z", x=0.0, y=0.0, z=0.0),
        *(held("x", lambda _x, y, z: -z * y, z=z) for z in (0.0, 1.0)),
        *(held("y", lambda x, _y, z: z * x, z=z) for z in (0.0, 1.0)),
    )  # fmt: skip
    state = statics(box)
    x, y, _ = box.grid
    fx, fy = (state.forces[..., i] for i in (0, 1))
    return float((x * fy - y * fx)[box.nodes(z=1.0)].real.sum()) / ratio


_TORSION = case(
    "TOR", "Saint-Venant's torsion of rectangles",
    "A bar of rectangular section turned by its ends, which may warp: J/(a b³) for a/b = 1, 2, 5.",
    [
        Check(f"J/(a b³) of a rectangle {ratio:g} : 1 is that of the series.", value, "1",
               partial(_torsion_constant, ratio))
        for ratio, value in ((1.0, 0.140577015), (2.0, 0.228681677), (5.0, 0.291316754))
    ],
    model=_BRICKS + ", degree 10 across",
    source="Saint-Venant's series (Timoshenko and Goodier, Theory of Elasticity, art. 109)",
    tolerance=2e-6,
    reason="weak singularities in the corners: 1e-7 for the square, 1e-6 where it is long",
)  # fmt: skip


@cached
def _rod() -> Floats:
    """Lowest axial frequencies (Hz) of VM61's free rod, lengths in inches."""
    axes = even(1.0, 1, 1), even(1.0, 1, 1), even(800.0, 2, 8)
    box = block(axes, Material(isotropic_stiffness(30e6, 0.0), 0.00073), held("xy"))
    return natural_frequencies(box, 2, loose=1, near=1.0)


_VM61 = case(
    "VM61", "Free rod, axial motion (ANSYS VM61)",
    "800 in long, E = 30e6 psi, ρ = 0.00073 lb s²/in⁴, free at both ends, motion along it only.",
    [
        Check(f"The {words} is that of the closed form.",
               number * math.sqrt(30e6 / 0.00073) / 1600.0, "Hz", nth(_rod, number - 1))
        for number, words in ((1, "second frequency (the first is 0)"), (2, "third"))
    ],
    model=_BRICKS + ", two of degree 8 along the rod",
    source="ANSYS Verification Manual, VM61 prints 126.70 and 253.40 Hz; n/(2 L) √(E/ρ)",
    tolerance=1e-6, reason="two half waves of a cosine by two polynomials of degree 8",
)  # fmt: skip


# --- a membrane -------------------------------------------------------------------------------

#: Length, height of the root and of the tip, thickness (m).
_LONG, _ROOT, _TIP, _THICK = 10.0, 5.0, 1.0, 0.05


@cached
def _membrane() -> Floats:
    """Lowest frequencies (Hz): half the thickness, which is free to become thinner."""
    n = intervals(16)
    box = hexahedra((
        np.linspace(0.0, _LONG, n + 1), np.linspace(-0.5 * _ROOT, 0.5 * _ROOT, n + 1),
        np.array([0.0, 0.5 * _THICK]),
    ))  # fmt: skip
    points = box.points.copy()
    points[:, 1] *= 1.0 - (1.0 - _TIP / _ROOT) * (points[:, 0] / _LONG)
    material = Material(isotropic_stiffness(200e9, 0.3), 8000.0)
    body = SkfemBody(replace(box, points=points), {"all": material}, 1.0)
    nodes = body.basis.doflocs.T
    root, middle = (np.abs(nodes[:, axis]) < 1e-9 * _LONG for axis in (0, 2))
    free = np.stack([~root, ~root, ~middle, np.zeros_like(root)], axis=-1).ravel()
    counted(int(free.sum()))
    stiffness, mass = (m[free][:, free].tocsr() for m in body.matrices)
    return lowest_frequencies(stiffness, mass, 6)


_FV32 = case(
    "FV32", "Tapered membrane (NAFEMS FV32)",
    "10 m long, 5 m high at its root and 1 m at its tip, 0.05 m thick, E = 200 GPa, ν = 0.3, 8000 "
    "kg/m³; its root does not move in its plane, nor its middle plane out of it: plane stress.",
    [
        Check(f"Frequency {at + 1} of the membrane is NAFEMS'.", value, "Hz",
               nth(_membrane, at))
        for at, value in enumerate((44.623, 130.03, 162.70, 246.05, 379.90, 391.44))
    ],
    model="hexahedra of twenty nodes: 16 along it, 16 across, one through half the thickness",
    source="NAFEMS FV32", tolerance=5e-4,
    reason="the root's two corners, where the stress has no bound: on two thirds of the size the "
    "fifth frequency is 4e-4 lower, and the targets are those of a mesh as well",
)  # fmt: skip


# --- NAFEMS' plate: 10 x 10 x 0.05 m, x is its normal ---------------------------------------------

_MODULUS, _POISSON, _DENSITY, _HEIGHT = 200e9, 0.3, 8000.0, 0.05
#: The thin plate's √(D/(ρ h))/a² (rad/s).
THIN = math.sqrt(_MODULUS * _HEIGHT**2 / (12.0 * (1.0 - _POISSON**2) * _DENSITY)) / 10.0**2


def _plate(through: int, y: Axis, z: Axis, *conditions: Condition, loss: float = 0.0) -> Box:
    c = isotropic_stiffness(_MODULUS, _POISSON)
    material = Material(c * (1.0 + 1j * loss) if loss else c, _DENSITY)
    return block((_centred(_HEIGHT, 1, through), y, z), material, *conditions)


@cached
def _supported() -> Floats:
    """Lowest frequencies (Hz) of the plate on hard simple supports."""
    side = even(10.0, 2, 8)
    edges = [edge for at in (0.0, 10.0) for edge in (held("xz", y=at), held("xy", z=at))]
    return natural_frequencies(_plate(3, side, side, *edges), 8)


@cached
def free_plate() -> Floats:
    """Lowest frequencies (Hz) of the plate without supports."""
    side = even(10.0, 2, 6)
    return natural_frequencies(_plate(2, side, side), 8, loose=6, near=0.3)


@cached
def cantilever_plate() -> Floats:
    """Ω a² √(ρh/D) of the plate clamped along one edge, graded there and towards its corners."""
    across = graded([0.0, 0.1, 1.0, 5.0, 9.0, 9.9, 10.0], 5)
    along = graded([0.0, 0.1, 0.6, 3.0, 10.0], 5)
    box = _plate(2, across, along, held("xyz", z=0.0))
    return 2.0 * np.pi * natural_frequencies(box, 6) / THIN


def _mindlin(m: int, n: int) -> float:
    """Frequency (Hz) of the simply supported plate with m and n half waves.

    The lower root of (S k² − M ω²)(D k² + S − J ω²) = (S k)², κ = 5/(6 − ν) in the shear stiffness.
    """
    h, nu, square = 0.05, 0.3, (m**2 + n**2) * (math.pi / 10.0) ** 2
    bending = 200e9 * h**3 / (12.0 * (1.0 - nu**2))
    shear = 5.0 / (6.0 - nu) * 200e9 / (2.0 * (1.0 + nu)) * h
    mass, turning = 8000.0 * h, 8000.0 * h**3 / 12.0
    b = shear * square * turning + mass * (bending * square + shear)
    c = shear * bending * square**2
    omega = math.sqrt(2.0 * c / (b + math.sqrt(b**2 - 4.0 * mass * turning * c)))
    return omega / (2.0 * math.pi)


#: Pressure (Pa), loss factor and frequency (Hz) of test 13H.
_PRESSURE, _LOSS, _DRIVEN_AT = 100.0, 0.04, 2.377


def _peak() -> float:
    """Amplitude (m) of the middle; a quarter of the plate, its upper face pressed."""
    side = even(5.0, 1, 6)
    quarter = _plate(
        2, side, side, held("xz", y=0.0), held("xy", z=0.0), held("y", y=5.0), held("z", z=5.0),
        load("x", _PRESSURE, x=0.5 * _HEIGHT), loss=_LOSS,
    )  # fmt: skip
    return abs(harmonic(quarter, _DRIVEN_AT).mean("x", x=0.0, y=5.0, z=5.0))


def _thin_peak() -> float:
    """Thin plate's: the sum over its modes of odd m and n half waves."""
    omega2, total = (2.0 * math.pi * _DRIVEN_AT) ** 2, 0j
    for m, n in itertools.product(range(1, 60, 2), repeat=2):
        own = (THIN * math.pi**2 * (m**2 + n**2)) ** 2 * (1.0 + 1j * _LOSS)
        sign = (-1) ** ((m + n) // 2 - 1)
        force = 16.0 * _PRESSURE / (math.pi**2 * m * n * _DENSITY * _HEIGHT)
        total += sign * force / (own - omega2)
    return abs(total)


PLATES: tuple[Case, ...] = (
    case(
        "P13H", "Thin plate, simply supported (NAFEMS test 13H)",
        "10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, hard simple supports.",
        [
            Check(f"Frequency {at} is Mindlin's with {m} and {n} half waves.",
                   _mindlin(m, n), "Hz", nth(_supported, at - 1))
            for at, m, n in ((1, 1, 1), (2, 1, 2), (4, 2, 2), (5, 1, 3), (7, 2, 3))
        ],
        model=_BRICKS + ", 2 x 2 of degree 8, one of degree 3 through the thickness",
        source="R. D. Mindlin's plate in closed form, κ = 5/(6 − ν); thin-plate theory, as NAFEMS "
        "R0015 test 13 prints it (2.377 to 15.449 Hz), is 9e-5 to 6e-4 higher",
        tolerance=5e-6,
        reason="half waves by polynomials of degree 8, 2e-7; with this κ Mindlin's plate is the "
        "solid one to 1e-8",
    ),
    case(
        "P13HD", "Thin plate, simply supported, driven in resonance (NAFEMS test 13H)",
        "The plate of case P13H, 10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, 2 % of "
        "critical damping, 100 Pa on one face at 2.377 Hz: amplitude of its middle.",
        [Check("The middle's amplitude is that of the sum.", _thin_peak(), "m", _peak)],
        model=_BRICKS + ", a quarter, one of degree 6, of degree 2 through the thickness",
        source="sum over the thin plate's modes; NAFEMS R0016, test 13H, prints 45.42 mm",
        tolerance=5e-4,
        reason="shear and rotation lower the frequency by 9e-5, a peak of 4 % width by less; four "
        "printed digits",
    ),
    case(
        "FV12", "Free thin square plate (NAFEMS FV12)",
        "A square plate of 10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, without supports.",
        [
            Check(f"Frequency {at + 7} of the free plate is the thin plate's.",
                   value * THIN / (2.0 * math.pi), "Hz", nth(free_plate, at))
            for at, value in enumerate(
                (13.4682, 19.5961, 24.2702, 34.8009, 34.8009, 61.0932, 61.0932, 63.6861)
            )
        ],
        model=_BRICKS + ", 2 x 2 of degree 6, one of degree 2 through the thickness",
        source="converged thin-plate values, ω a² √(ρh/D) = 13.468, 19.596, 24.270, 34.801, "
        "61.093, 63.686; the first three are also NAFEMS R0015, FV12",
        tolerance=1e-3,
        reason="a plate of h/a = 1/200: shear, rotation and the twist of its free edges take 4e-4 "
        "to 8e-4",
    ),
    case(
        "FV16", "Cantilevered thin square plate (NAFEMS FV16)",
        "A square plate of 10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, clamped along one "
        "edge: ω a² √(ρh/D).",
        [
            Check(f"Frequency {at + 1} is the converged thin plate's.", value, "1",
                   nth(cantilever_plate, at))
            for at, value in enumerate((3.47101, 8.50629, 21.28409, 27.19874, 30.95460, 54.18437))
        ],
        model=_BRICKS + ", 3 x 3 of degree 6, one of degree 2 through the thickness",
        source="converged thin-plate values; NAFEMS' printed targets are up to 1 % higher",
        tolerance=3e-3, reason="a plate of h/a = 1/200, and the clamp's singular corners",
    ),
)  # fmt: skip


CASES: tuple[Case, ...] = (_RUS, _LAME, _TORSION, _VM61, *PLATES, _FV32, laminates.SEVEN_LAYERS)
