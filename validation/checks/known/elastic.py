"""Elastic bodies with known answers: cube, torsion, rods, membrane: the solid without a field."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.fem.piezo.tetrahedra import SkfemBody
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Axis
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.validation.checks.case import Answer, Case, case, nth
from tactgen.validation.checks.cases.boxes import (
    Box,
    Held,
    Where,
    block,
    even,
    graded,
    lowest_frequencies,
    natural_frequencies,
    statics,
)
from tactgen.validation.checks.cases.cube_cells import hexahedra
from tactgen.validation.checks.cases.fineness import cached, counted, intervals
from tactgen.validation.checks.drawings.sections import section
from tactgen.validation.checks.drawings.strips import tapered
from tactgen.validation.checks.known import plates, seven_layers

_BRICKS = "bricks of the model solid"


def _centred(length: float, intervals: int, degree: int) -> Axis:
    return graded(np.linspace(-0.5 * length, 0.5 * length, intervals + 1), degree)


def _block(
    axes: tuple[Axis, Axis, Axis], modulus: float, poisson: float, density: float, *held: Held
) -> Box:
    return block(axes, Material(isotropic_stiffness(modulus, poisson), density), *held)


def _unit_cube() -> Box:
    return _block((even(1.0, 1, 7),) * 3, 1.0, 0.3, 1.0)


@cached
def _cube() -> Floats:
    """Return ω a √(ρ/E) of a free cube's lowest modes, ν = 0.3."""
    # more than are read: the copies of a multiple frequency are found one after the other
    return 2.0 * np.pi * natural_frequencies(_unit_cube(), 12, loose=6, near=0.1)


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
               nth(_cube, mode - 1))
        for mode, value in ((1, 1.77126), (2, 1.77126), (3, 2.38518), (5, 2.38518), (6, 2.42566))
    ],
    setup=section(_unit_cube, unit="a"),
)  # fmt: skip

_LAME = case(
    "LAME",
    "Lamé modes of a free cube",
    "A free cube of edge a with ν = 0.3: three modes in which all sections across an edge move "
    "alike in their own plane, without change of volume; ω a √(ρ/E).",
    model=_BRICKS + ", one brick of degree 7",
    source="G. Lamé, Leçons sur la théorie mathématique de l'élasticité (1852): ω a = √2 π c_s of "
    "shear waves, whatever ν",
    tolerance=5e-8,
    reason="half a cosine by a polynomial of degree 7",
    answers=[
        Answer(f"Mode {mode} of the free cube is Lamé's.", math.pi / math.sqrt(1.3), "1",
               nth(_cube, mode - 1))
        for mode in (9, 10, 11)
    ],
    setup=section(_unit_cube, unit="a"),
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


@cached
def _rod() -> Floats:
    """Return its lowest axial frequencies (Hz)."""
    return natural_frequencies(_free_rod(), 2, loose=1, near=1.0)


_VM61 = case(
    "VM61",
    "Free rod, axial motion (ANSYS VM61)",
    "800 in long, E = 30e6 psi, ρ = 0.00073 lb s²/in⁴, free at both ends, motion along it only.",
    model=_BRICKS + ", two of degree 8 along the rod",
    source="ANSYS Verification Manual, VM61 prints 126.70 and 253.40 Hz; n/(2 L) √(E/ρ)",
    tolerance=1e-6,
    reason="two half waves of a cosine by two polynomials of degree 8",
    answers=[
        Answer(f"The {words} is that of the closed form.",
               number * math.sqrt(30e6 / 0.00073) / 1600.0, "Hz", nth(_rod, number - 1))
        for number, words in ((1, "second frequency (the first is 0)"), (2, "third"))
    ],
    setup=section(_free_rod, unit="in"),
)  # fmt: skip


# --- a membrane -------------------------------------------------------------------------------

#: Length, height of the root and of the tip, thickness (m).
_LONG, _ROOT, _TIP, _THICK = 10.0, 5.0, 1.0, 0.05


def _height(share: float) -> float:
    """Return the height at a share of the length, over the root's."""
    return 1.0 - (1.0 - _TIP / _ROOT) * share


@cached
def _membrane() -> Floats:
    """Return the lowest frequencies (Hz): half the thickness, which is free to become thinner."""
    n = intervals(16)
    planes = (
        np.linspace(0.0, _LONG, n + 1),
        np.linspace(-0.5 * _ROOT, 0.5 * _ROOT, n + 1),
        np.array([0.0, 0.5 * _THICK]),
    )
    box = hexahedra(planes)
    points = box.points.copy()
    points[:, 1] *= [_height(share) for share in points[:, 0] / _LONG]
    material = Material(isotropic_stiffness(200e9, 0.3), 8000.0)
    body = SkfemBody(replace(box, points=points), {"all": material}, 1.0, None)
    nodes = body.basis.doflocs.T
    root, middle = (np.abs(nodes[:, axis]) < 1e-9 * _LONG for axis in (0, 2))
    free = np.stack([~root, ~root, ~middle, np.zeros_like(root)], axis=-1).ravel()
    counted(int(free.sum()))
    stiffness, mass = (m[free][:, free].tocsr() for m in body.matrices)
    return lowest_frequencies(stiffness, mass, 6)


_FV32 = case(
    "FV32",
    "Tapered membrane (NAFEMS FV32)",
    "10 m long, 5 m high at its root and 1 m at its tip, 0.05 m thick, E = 200 GPa, ν = 0.3, "
    "8000 kg/m³; its root does not move in its plane, nor its middle plane out of it: plane "
    "stress.",
    model="hexahedra of twenty nodes: 16 along it, 16 across, one through half the thickness",
    source="NAFEMS FV32",
    tolerance=5e-4,
    reason="the root's two corners, where the stress has no bound: on two thirds of the size "
    "the fifth frequency is 4e-4 lower, and the targets are those of a mesh as well",
    answers=[
        Answer(f"Frequency {at + 1} of the membrane is NAFEMS'.", value, "Hz",
               nth(_membrane, at))
        for at, value in enumerate((44.623, 130.03, 162.70, 246.05, 379.90, 391.44))
    ],
    setup=partial(tapered, _LONG, _ROOT, _height, unit="m", body="membrane"),
)  # fmt: skip

CASES: tuple[Case, ...] = (_RUS, _LAME, _TORSION, _VM61, *plates.CASES, _FV32, *seven_layers.CASES)
