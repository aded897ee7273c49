"""Elastic bodies with known answers: cube, plates, torsion, rods: the solid without a field."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np

from tactgen.fem.bimorph.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Axis
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.validation.checks.case import Answer, Case, Refinement, case, nth
from tactgen.validation.checks.cases.boxes import (
    Box,
    Held,
    Where,
    block,
    even,
    natural_frequencies,
    statics,
)
from tactgen.validation.checks.known import seven_layers
from tactgen.validation.checks.setup.sections import section

_BRICKS = "bricks of the model solid"


def _centred(length: float, intervals: int, degree: int) -> Axis:
    return Axis(np.linspace(-0.5 * length, 0.5 * length, intervals + 1), degree)


def _block(
    axes: tuple[Axis, Axis, Axis], modulus: float, poisson: float, density: float, *held: Held
) -> Box:
    return block(axes, Material(isotropic_stiffness(modulus, poisson), density), *held)


def _unit_cube(degree: int) -> Box:
    return _block((even(1.0, 1, degree),) * 3, 1.0, 0.3, 1.0)


@cache
def _cube(degree: int) -> Floats:
    """Return ω a √(ρ/E) of a free cube's lowest modes, ν = 0.3."""
    return 2.0 * np.pi * natural_frequencies(_unit_cube(degree), 8, loose=6, near=0.1)


def _cube_size(degree: int) -> tuple[int, float]:
    return 3 * (degree + 1) ** 3, float(_cube(degree)[0])


_RUS = case(
    "RUS",
    "Free elastic cube",
    "A free cube of edge a with ν = 0.3: the lowest ω a √(ρ/E), as resonant ultrasound "
    "spectroscopy uses them.  The first two are one pair, the next three one triple.",
    model=_BRICKS + ", one brick of degree 7",
    source="W. M. Visscher et al., J. Acoust. Soc. Am. 90 (1991) 2154: Ritz, powers up to 13",
    tolerance=2e-5,
    reason="six digits of a Ritz series that is 1e-5 above its limit",
    answers=[
        Answer(f"Mode {mode} of the free cube is that of the Ritz series.", value, "1",
               nth(_cube, mode - 1, 7))
        for mode, value in ((1, 1.77126), (2, 1.77126), (3, 2.38518), (5, 2.38518), (6, 2.42566))
        if mode != 5
    ],
    refinement=Refinement((3, 4, 5, 6), _cube_size, "exponential in the degree"),
    setup=section(_unit_cube, 7, unit="a"),
)  # fmt: skip


def _turned_bar(ratio: float) -> Box:
    """Return a bar turned by its ends, which may warp.

    Uniform torsion is linear along it, so its length and degree there do not matter.
    """
    axes = (_centred(ratio, 2, 10), _centred(1.0, 2, 10), even(1.0, 1, 1))
    ends = []
    for z in (0.0, 1.0):
        ends += [
            Held(Where(z=z), ("x",), lambda _x, y, z: -z * y),
            Held(Where(z=z), ("y",), lambda x, _y, z: z * x),
        ]
    corner = Where(x=0.0, y=0.0, z=0.0)
    return _block(axes, 2.0, 0.0, 1.0, *ends, Held(corner, ("z",)))


def _torsion_constant(ratio: float) -> float:
    """Return J/(a b³) of a rectangle: the moment that turns such a bar over G θ."""
    box = _turned_bar(ratio)
    state = statics(box)
    x, y, _ = box.grid
    top = box.nodes(Where(z=1.0))
    fx, fy = (state.forces[..., i] for i in (0, 1))
    return float((x * fy - y * fx)[top].real.sum()) / ratio


_TORSION = case(
    "TOR",
    "Saint-Venant's torsion of rectangles",
    "A bar of rectangular section turned by its ends, which may warp: J/(a b³) for a/b = 1, 2, 5.",
    model=_BRICKS + ", degree 10 across",
    source="Saint-Venant's series (Timoshenko and Goodier, Theory of Elasticity, art. 109)",
    tolerance=2e-6,
    reason="weak singularities in the corners: 1e-7 for the square, 1e-6 where it is long",
    answers=[
        Answer(f"J/(a b³) of a rectangle {ratio:g} : 1 is that of the series.", value, "1",
               partial(_torsion_constant, ratio))
        for ratio, value in ((1.0, 0.140577015), (2.0, 0.228681677), (5.0, 0.291316754))
    ],
    setup=section(_turned_bar, 2.0, unit="b", plane=("x", "y")),
)  # fmt: skip


def _free_rod() -> Box:
    """Return VM61's free rod, lengths in inches."""
    side, length = 1.0, 800.0
    return _block(
        (even(side, 1, 1), even(side, 1, 1), even(length, 2, 8)), 30e6, 0.0, 0.00073,
        Held(Where(), ("x", "y")),
    )  # fmt: skip


@cache
def _rod() -> Floats:
    """Return its lowest axial frequencies (Hz)."""
    return natural_frequencies(_free_rod(), 2, loose=1, near=1.0)


_VM61 = case(
    "VM61",
    "Free rod, axial motion (ANSYS VM61)",
    "800 in long, E = 30e6 psi, ρ = 0.00073 lb s²/in⁴, free at both ends, motion along it only.",
    model=_BRICKS + ", two of degree 8 along the rod",
    source="ANSYS Verification Manual, VM61 (n/(2 L) √(E/ρ) in closed form)",
    tolerance=1e-4,
    reason="five printed digits",
    answers=[
        Answer("The second frequency (the first is 0) is printed as 126.70 Hz.", 126.70, "Hz",
               nth(_rod, 0)),
        Answer("The third is printed as 253.40 Hz.", 253.40, "Hz", nth(_rod, 1)),
    ],
    setup=section(_free_rod, unit="in"),
)  # fmt: skip


def plate(intervals: int, degree: int, *held: Held, poisson: float = 0.3) -> Box:
    """Return NAFEMS' plate: 10 x 10 x 0.05 m, E = 200 GPa, 8000 kg/m³; x is its normal."""
    side = even(10.0, intervals, degree)
    return _block((_centred(0.05, 1, 2), side, side), 200e9, poisson, 8000.0, *held)


def clamped_plate() -> Box:
    """Return the plate clamped at z = 0, graded there and towards the edges that meet it."""
    across = Axis(np.array([0.0, 0.1, 1.0, 5.0, 9.0, 9.9, 10.0]), 5)
    along = Axis(np.array([0.0, 0.1, 0.6, 3.0, 10.0]), 5)
    axes = (_centred(0.05, 1, 2), across, along)
    return _block(axes, 200e9, 0.3, 8000.0, Held(Where(z=0.0), ("x", "y", "z")))


def _supported_plate(degree: int = 6) -> Box:
    edges = [
        edge
        for at in (0.0, 10.0)
        for edge in (Held(Where(y=at), ("x", "z")), Held(Where(z=at), ("x", "y")))
    ]
    return plate(2, degree, *edges)


@cache
def _supported(degree: int = 6) -> Floats:
    return natural_frequencies(_supported_plate(degree), 8)


@cache
def free_plate(degree: int = 6) -> Floats:
    """Return the lowest frequencies (Hz) of the plate without supports."""
    return natural_frequencies(plate(2, degree), 8, loose=6, near=0.3)


def _by_degree(frequencies: Callable[[int], Floats]) -> Refinement:
    """Return the first frequency by degrees along the plate."""
    return Refinement((3, 4, 5, 6), lambda p: (p, float(frequencies(p)[0])), "exponential")


@cache
def cantilever_plate() -> Floats:
    """Return ω a² √(ρh/D) of the plate clamped along one edge."""
    found = natural_frequencies(clamped_plate(), 6)
    rigidity = 200e9 * 0.05**3 / (12.0 * (1.0 - 0.3**2))
    return 2.0 * np.pi * found * 100.0 * math.sqrt(8000.0 * 0.05 / rigidity)


def _kirchhoff(m: int, n: int) -> float:
    """Return the frequency (Hz) of a thin simply supported plate with m and n half waves."""
    rigidity = 200e9 * 0.05**3 / (12.0 * (1.0 - 0.3**2))
    return math.pi / 2.0 * (m**2 + n**2) / 100.0 * math.sqrt(rigidity / (8000.0 * 0.05))


_THIN = (
    "a plate of h/a = 1/200 in three dimensions: shear and rotation take (m² + n²) π² h²/a² · 0.24 "
    "= 1e-4 to 6e-4 from the thin plate's frequency"
)
_PLATES = (
    case(
        "P13H",
        "Thin plate, simply supported (NAFEMS test 13H)",
        "10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, hard simple supports.",
        model=_BRICKS + ", 2 x 2 of degree 6, one of degree 2 through the thickness",
        source="thin-plate theory, as NAFEMS R0016 test 13 prints it (2.377 to 15.468 Hz)",
        tolerance=1.5e-3,
        reason=_THIN,
        answers=[
            Answer(f"Frequency {at} is the thin plate's with {m} and {n} half waves.",
                   _kirchhoff(m, n), "Hz", nth(_supported, at - 1))
            for at, m, n in ((1, 1, 1), (2, 1, 2), (4, 2, 2), (5, 1, 3), (7, 2, 3))
        ],
        refinement=_by_degree(_supported),
        setup=section(_supported_plate, unit="m", plane=("z", "y")),
    ),
    case(
        "FV12",
        "Free thin square plate (NAFEMS FV12)",
        "The same plate without supports.",
        model=_BRICKS + ", 2 x 2 of degree 6, one of degree 2 through the thickness",
        source="NAFEMS FV12",
        tolerance=3e-3,
        reason="four printed digits, and a plate of finite thickness",
        answers=[
            Answer(f"Frequency {at + 7} of the free plate is NAFEMS'.", value, "Hz",
                   nth(free_plate, at))
            for at, value in enumerate(
                (1.622, 2.360, 2.922, 4.190, 4.190, 7.356, 7.356, 7.668)
            )
        ],
        refinement=_by_degree(free_plate),
        setup=section(plate, 2, 6, unit="m", plane=("z", "y")),
    ),
    case(
        "FV16",
        "Cantilevered thin square plate (NAFEMS FV16)",
        "The same plate clamped along one edge: ω a² √(ρh/D).",
        model=_BRICKS + ", 3 x 3 of degree 6, one of degree 2 through the thickness",
        source="converged thin-plate values; NAFEMS' printed targets are up to 1 % higher",
        tolerance=3e-3,
        reason="a plate of h/a = 1/200, and the clamp's singular corners",
        answers=[
            Answer(f"Frequency {at + 1} is the converged thin plate's.", value, "1",
                   nth(cantilever_plate, at))
            for at, value in enumerate((3.47101, 8.50629, 21.28409, 27.19874, 30.95460, 54.18437))
        ],
        setup=section(clamped_plate, unit="m", plane=("z", "y")),
    ),
)  # fmt: skip

CASES: tuple[Case, ...] = (_RUS, _TORSION, _VM61, *_PLATES, *seven_layers.CASES)
