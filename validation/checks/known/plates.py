"""Thin square plates of NAFEMS: free, clamped, simply supported, driven; by three dimensions."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Axis
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.validation.checks.case import Answer, Case, case, nth
from tactgen.validation.checks.cases.boxes import (
    Box,
    Held,
    Load,
    Where,
    block,
    even,
    graded,
    harmonic,
    natural_frequencies,
)
from tactgen.validation.checks.cases.fineness import cached
from tactgen.validation.checks.drawings.sections import section

_BRICKS = "bricks of the model solid"
_MODULUS, _POISSON, _DENSITY, _HEIGHT = 200e9, 0.3, 8000.0, 0.05

#: The thin plate's √(D/(ρ h))/a² (rad/s).
_THIN = math.sqrt(_MODULUS * _HEIGHT**2 / (12.0 * (1.0 - _POISSON**2) * _DENSITY)) / 10.0**2


def _thickness(degree: int) -> Axis:
    return graded([-0.5 * _HEIGHT, 0.5 * _HEIGHT], degree)


def _solid(axes: tuple[Axis, Axis, Axis], *held: Held, loss: float = 0.0) -> Box:
    stiffness = isotropic_stiffness(_MODULUS, _POISSON)
    c = stiffness * (1.0 + 1j * loss) if loss else stiffness
    return block(axes, Material(c, _DENSITY), *held)


def plate(*held: Held, through: int = 2, along: int = 6) -> Box:
    """Return NAFEMS' plate: 10 x 10 x 0.05 m, E = 200 GPa, 8000 kg/m³; x is its normal."""
    side = even(10.0, 2, along)
    return _solid((_thickness(through), side, side), *held)


def clamped_plate() -> Box:
    """Return the plate clamped at z = 0, graded there and towards the edges that meet it."""
    across = graded([0.0, 0.1, 1.0, 5.0, 9.0, 9.9, 10.0], 5)
    along = graded([0.0, 0.1, 0.6, 3.0, 10.0], 5)
    return _solid((_thickness(2), across, along), Held(Where(z=0.0), ("x", "y", "z")))


def _supported_plate() -> Box:
    edges = [
        edge
        for at in (0.0, 10.0)
        for edge in (Held(Where(y=at), ("x", "z")), Held(Where(z=at), ("x", "y")))
    ]
    return plate(*edges, through=3, along=8)


@cached
def _supported() -> Floats:
    return natural_frequencies(_supported_plate(), 8)


@cached
def free_plate() -> Floats:
    """Return the lowest frequencies (Hz) of the plate without supports."""
    return natural_frequencies(plate(), 8, loose=6, near=0.3)


@cached
def cantilever_plate() -> Floats:
    """Return ω a² √(ρh/D) of the plate clamped along one edge."""
    return 2.0 * np.pi * natural_frequencies(clamped_plate(), 6) / _THIN


def _mindlin(m: int, n: int) -> float:
    """Return the frequency (Hz) of the simply supported plate with m and n half waves.

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


def _driven_plate() -> Box:
    """Return a quarter of the plate, its upper face pressed."""
    side = even(5.0, 1, 6)
    quarter = _solid(
        (_thickness(2), side, side),
        Held(Where(y=0.0), ("x", "z")), Held(Where(z=0.0), ("x", "y")),
        Held(Where(y=5.0), ("y",)), Held(Where(z=5.0), ("z",)),
        loss=_LOSS,
    )  # fmt: skip
    return replace(quarter, loads=(Load(Where(x=0.5 * _HEIGHT), "x", _PRESSURE),))


def _peak() -> float:
    """Return the amplitude (m) of the middle."""
    return abs(harmonic(_driven_plate(), _DRIVEN_AT).mean(Where(x=0.0, y=5.0, z=5.0), "x"))


def _thin_peak() -> float:
    """Return the thin plate's: the sum over its modes of odd m and n half waves."""
    omega2, total = (2.0 * math.pi * _DRIVEN_AT) ** 2, 0j
    for m, n in itertools.product(range(1, 60, 2), repeat=2):
        own = (_THIN * math.pi**2 * (m**2 + n**2)) ** 2 * (1.0 + 1j * _LOSS)
        sign = (-1) ** ((m + n) // 2 - 1)
        force = 16.0 * _PRESSURE / (math.pi**2 * m * n * _DENSITY * _HEIGHT)
        total += sign * force / (own - omega2)
    return abs(total)


CASES: tuple[Case, ...] = (
    case(
        "P13H",
        "Thin plate, simply supported (NAFEMS test 13H)",
        "10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, hard simple supports.",
        model=_BRICKS + ", 2 x 2 of degree 8, one of degree 3 through the thickness",
        source="R. D. Mindlin's plate in closed form, κ = 5/(6 − ν); thin-plate theory, as NAFEMS "
        "R0015 test 13 prints it (2.377 to 15.449 Hz), is 9e-5 to 6e-4 higher",
        tolerance=5e-6,
        reason="half waves by polynomials of degree 8, 2e-7; with this κ Mindlin's plate is the "
        "solid one to 1e-8",
        answers=[
            Answer(f"Frequency {at} is Mindlin's with {m} and {n} half waves.",
                   _mindlin(m, n), "Hz", nth(_supported, at - 1))
            for at, m, n in ((1, 1, 1), (2, 1, 2), (4, 2, 2), (5, 1, 3), (7, 2, 3))
        ],
        setup=section(_supported_plate, unit="m", plane=("z", "y")),
    ),
    case(
        "P13HD",
        "Thin plate, simply supported, driven in resonance (NAFEMS test 13H)",
        "The plate of case P13H, 10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, 2 % of "
        "critical damping, 100 Pa on one face at 2.377 Hz: amplitude of its middle.",
        model=_BRICKS + ", a quarter, one of degree 6, of degree 2 through the thickness",
        source="sum over the thin plate's modes; NAFEMS R0016, test 13H, prints 45.42 mm",
        tolerance=5e-4,
        reason="shear and rotation lower the frequency by 9e-5, a peak of 4 % width by less; four "
        "printed digits",
        answers=[Answer("The middle's amplitude is that of the sum.", _thin_peak(), "m", _peak)],
        setup=section(_driven_plate, unit="m", plane=("z", "x")),
    ),
    case(
        "FV12",
        "Free thin square plate (NAFEMS FV12)",
        "A square plate of 10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, without supports.",
        model=_BRICKS + ", 2 x 2 of degree 6, one of degree 2 through the thickness",
        source="converged thin-plate values, ω a² √(ρh/D) = 13.468, 19.596, 24.270, 34.801, "
        "61.093, 63.686; the first three are also NAFEMS R0015, FV12",
        tolerance=1e-3,
        reason="a plate of h/a = 1/200: shear, rotation and the twist of its free edges take 4e-4 "
        "to 8e-4",
        answers=[
            Answer(f"Frequency {at + 7} of the free plate is the thin plate's.",
                   value * _THIN / (2.0 * math.pi), "Hz", nth(free_plate, at))
            for at, value in enumerate(
                (13.4682, 19.5961, 24.2702, 34.8009, 34.8009, 61.0932, 61.0932, 63.6861)
            )
        ],
        setup=section(plate, unit="m", plane=("z", "y")),
    ),
    case(
        "FV16",
        "Cantilevered thin square plate (NAFEMS FV16)",
        "A square plate of 10 x 10 x 0.05 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, clamped along one "
        "edge: ω a² √(ρh/D).",
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
