"""Layered bodies with exact answers: cylindrical bending, strips of PVDF."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.geometry.device.material_library import LIBRARY
from tactgen.geometry.device.materials import EPS0, PiezoTensors, isotropic_stiffness
from tactgen.validation.evidence.boxes import (
    Box,
    Held,
    Load,
    State,
    Where,
    even,
    graded,
    natural_frequencies,
    stacked,
    statics,
)
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.cases import beams, strips
from tactgen.validation.evidence.mesh_levels import cached

#: Length of the half wave (m), and the thickness of each layer (m) of three bimorphs.
_LENGTH = 20e-3
_THIN, _MEDIUM, _THICK = 0.385e-3, 1.0e-3, 2.5e-3

_EXACT = "exact state-space solution through the thickness (validation/checks/cases/exact_laminate)"
_SMOOTH = "polynomials of degree 6 along half a sine wave, 4 through each layer"


def bending_bimorph(
    thickness: float,
    *,
    grounded: bool = True,
    volts: float = 0.0,
    degree: int = 6,
    intervals: int = 1,
) -> Box:
    """Half of the half wave of two PZT-5A layers poled towards each other.

    No strain along y; simply supported with φ = 0 at z = 0, mirrored at z = L/2; the lower face
    at 0 V and the upper at `volts` sin(π z/L), or both without charge.
    """
    ceramic = LIBRARY["PZT-5A"].tensors(lossy=False)
    density = LIBRARY["PZT-5A"].density
    turned = replace(ceramic, e=-ceramic.e)
    parts = tuple(
        (Slab(name, (i, i + 1), (0, intervals)), Material(tensors.c, density, tensors))
        for i, (name, tensors) in enumerate((("low", ceramic), ("high", turned)))
    )
    middle = 0.5 * _LENGTH
    held = [Held(Where(), ("y",)), Held(Where(z=0.0), ("x", "phi")), Held(Where(z=middle), ("z",))]
    if grounded:

        def wave(_x: Floats, _y: Floats, z: Floats) -> Floats:
            return np.asarray(volts * np.sin(np.pi * z / _LENGTH))

        held += [Held(Where(x=0.0), ("phi",)), Held(Where(x=2.0 * thickness), ("phi",), wave)]
    return Box(
        x=stacked((thickness, thickness), 4),
        y=even(1e-3, 1, 1),
        z=even(middle, intervals, degree),
        parts=parts,
        held=tuple(held),
    )


def _bending_frequency(thickness: float, grounded: bool) -> float:
    return float(natural_frequencies(bending_bimorph(thickness, grounded=grounded), 1)[0])


@cached
def _driven(thickness: float) -> Floats:
    """W and D_x at the lower face's crest with 1 V sin(π z/L) on the upper one."""
    box = bending_bimorph(thickness, volts=1.0)
    state = statics(box)
    w = state.mean(Where(x=0.0, z=0.5 * _LENGTH), "x").real
    # the charge of the whole lower face, per width; the mean of a sine is 2/π of its crest
    charge = state.force(Where(x=0.0), "phi").real / (1e-3 * 0.5 * _LENGTH)
    return np.array([w, charge * np.pi / 2.0])


_CYLINDRICAL = tuple(
    case(
        f"CYL{number}",
        f"Piezoelectric bimorph in cylindrical bending, L/H = {_LENGTH / (2 * thickness):.3g}",
        f"Two PZT-5A layers of {thickness * 1e3:g} mm poled towards each other, one half wave of "
        "20 mm between simple supports with φ = 0, no strain across the width: first bending "
        "frequency, faces short-circuited or without charge.",
        model="bricks of the model solid, general supports",
        source=_EXACT,
        tolerance=1e-6,
        reason=_SMOOTH,
        rows=[
            Check(
                f"The first frequency with {words} is that of the exact solution.",
                reference, "Hz", partial(_bending_frequency, thickness, grounded),
            )
            for reference, grounded, words in (
                (short, True, "both faces at 0 V"),
                (free, False, "no charge on the faces"),
            )
        ],
    )
    for number, (thickness, short, free) in enumerate(
        (
            (_THIN, 2729.781550839573, 3065.134786141134),
            (_MEDIUM, 6981.984969234867, 7774.313612838951),
            (_THICK, 16075.335034538324, 17250.375637915604),
        ),
        start=1,
    )
)  # fmt: skip


_DRIVEN = tuple(
    case(
        name,
        "Piezoelectric bimorph in cylindrical bending, driven by a wave of voltage, L/H = "
        f"{_LENGTH / (2 * thickness):.3g}",
        f"Two PZT-5A layers of {thickness * 1e3:g} mm poled towards each other, one half wave of "
        "20 mm between simple supports with φ = 0, no strain across the width, at rest: 1 V "
        "sin(π z/L) on the upper face, 0 V on the lower.",
        model="bricks of the model solid, general supports",
        source=_EXACT,
        tolerance=1e-6,
        reason=_SMOOTH,
        rows=[
            Check("The lower face's crest moves as the exact solution does.", motion, "m",
                   nth(_driven, 0, thickness)),
            Check("The electric displacement at that crest is exact.", charge, "C/m^2",
                   nth(_driven, 1, thickness)),
        ],
    )
    for name, thickness, motion, charge in (
        ("CYL4", _THIN, -4.29692165364606e-8, -1.56662847218356e-5),
        ("CYL5", _THICK, -8.42981467454552e-10, -2.14853285936959e-6),
    )
)  # fmt: skip


def ply(along: str) -> Material:
    """Pagano's ply, E_L = 25, E_T = 1, G_LT = 0.5, G_TT = 0.2, ν = 0.25, fibres along."""
    axes = ("x", "y", "z")
    fibre = axes.index(along)
    compliance = np.zeros((6, 6))
    for i in range(3):
        for j in range(3):
            stiffest = 25.0 if fibre in (i, j) else 1.0
            compliance[i, j] = (1.0 if i == j else -0.25) / stiffest
    for at, pair in ((3, (1, 2)), (4, (0, 2)), (5, (0, 1))):
        compliance[at, at] = 1.0 / (0.5 if fibre in pair else 0.2)
    return Material(np.linalg.inv(compliance), 1.0)


def _laminate(slenderness: float) -> Box:
    """Half of a 0/90/0 laminate of height 1 under sin(π z/L), its middle between bricks."""
    h, length = 1.0, slenderness

    def wave(_x: Floats, _y: Floats, z: Floats) -> Floats:
        return np.asarray(np.sin(np.pi * z / length))

    parts = tuple(
        (Slab(f"fibres along {along} {at}", (at, to), (0, 1)), ply(along))
        for along, at, to in (("z", 0, 1), ("y", 1, 3), ("z", 3, 4))
    )
    return Box(
        x=stacked((h / 3, h / 6, h / 6, h / 3), 6),
        y=even(1.0, 1, 1),
        z=even(0.5 * length, 1, 7),
        parts=parts,
        held=(
            Held(Where(), ("y",)),
            Held(Where(z=0.0), ("x",)),
            Held(Where(z=0.5 * length), ("z",)),
        ),
        loads=(Load(Where(x=h), "x", wave),),
    )


def _pagano(slenderness: float) -> float:
    """100 E_T h³ w/(q L⁴) of the middle of the laminate."""
    w = statics(_laminate(slenderness)).mean(Where(x=0.5, z=0.5 * slenderness), "x").real
    return 100.0 * w / slenderness**4


_PAGANO = case(
    "PAG",
    "Pagano's 0/90/0 laminate in cylindrical bending",
    "Three equal plies (E_L/E_T = 25, G_LT/E_T = 0.5, G_TT/E_T = 0.2, ν = 0.25), load q sin(π z/L) "
    "on one face, simple supports: 100 E_T h³ w/(q L⁴) in the middle for L/h = 4, 10, 20 and 50.",
    model="bricks of the model solid, degree 6 through each ply",
    source="N. J. Pagano, J. Compos. Mater. 3 (1969) 398, prints 2.887 and 0.932; digits by "
    + _EXACT,
    tolerance=1e-6,
    reason=_SMOOTH,
    rows=[
        Check(f"The deflection at L/h = {s:g} is Pagano's.", value, "1", partial(_pagano, s))
        for s, value in (
            (4.0, 2.88722515895213),
            (10.0, 0.931642912042631),
            (20.0, 0.617268227453981),
            (50.0, 0.526975657629369),
        )
    ],
)  # fmt: skip


def pvdf(uniform: bool) -> Box:
    """Bimorph of Tzou and of Hwang and Park: 100 x 5 x 1 mm, poled oppositely, 1 V.

    E = 2 GPa, e31 = 0.046 C/m², ε = 12 ε0, no Poisson's ratio; the field linear through the whole
    thickness (`uniform`) or as electrostatics has it.
    """
    c = isotropic_stiffness(2e9, 0.0)
    e = np.zeros((3, 6))
    e[0, 2] = 0.046
    permittivity = 12.0 * EPS0 * np.eye(3)
    parts = tuple(
        (
            Slab(name, (i, i + 1), (0, 5)),
            Material(c, 1800.0, PiezoTensors(c, sign * e, permittivity)),
        )
        for i, (name, sign) in enumerate((("low", 1.0), ("high", -1.0)))
    )
    linear = Held(Where(), ("phi",), lambda x, _y, _z: x / 1e-3)
    faces = (Held(Where(x=0.0), ("phi",)), Held(Where(x=1e-3), ("phi",), 1.0))
    return Box(
        x=stacked((0.5e-3, 0.5e-3), 3),
        y=even(5e-3, 1, 1),
        z=even(100e-3, 5, 3),
        parts=parts,
        held=(
            *((linear,) if uniform else faces),
            Held(Where(), ("y",)),
            Held(Where(z=0.0), ("x", "z")),
        ),
    )


@cached
def pvdf_deflection(position: float, uniform: bool) -> float:
    """Deflection (m) at a position (m) along the bimorph of case HP."""
    state = statics(pvdf(uniform))
    return abs(state.mean(Where(x=0.5e-3, z=position), "x").real)


#: k31² of that PVDF: e31²/(E ε + e31²).
_PVDF_K2 = 0.046**2 / (2e9 * 12.0 * EPS0 + 0.046**2)

_PVDF = case(
    "PVDF",
    "PVDF bimorph: what the field's own variation is worth",
    "The bimorph of case HP, 100 x 5 x 1 mm of two layers of PVDF poled oppositely, E = 2 GPa, ν = "
    "0, e31 = 0.046 C/m², ε = 12 ε0, 1 V across both, with the potential as electrostatics has it, "
    "quadratic through each layer, over that with a linear one: deflection at 60 mm.",
    model="bricks of the model solid",
    source="a layer stiffened by 1/(1 − k²) about its own middle: (1 − k²)/(1 − 3/4 k²)",
    tolerance=1e-5,
    reason="the clamp's zone, h/L of the 0.25 % in question",
    rows=[
        Check("The varying field takes 0.25 % of the deflection, as in closed form.",
               (1.0 - _PVDF_K2) / (1.0 - 0.75 * _PVDF_K2), "1",
               lambda: pvdf_deflection(0.06, False) / pvdf_deflection(0.06, True)),
    ],
)  # fmt: skip

CASES: tuple[Case, ...] = (
    *_CYLINDRICAL,
    *_DRIVEN,
    _PAGANO,
    *strips.CASES,
    _PVDF,
    *beams.SHEAR,
    *strips.SMITS,
)


_LAYERS = (1e-4, 1e-4, 1e-4, 4e-4, 1e-4, 1e-4, 1e-4)
_FIBRES = ("fibres along z", "fibres along y")


def _ply(*, along: bool) -> Material:
    """Ply with its fibres along z or along y; Voigt's order xx, yy, zz, yz, xz, xy.

    E 100, 5, 5 GPa; ν12 0.4, ν13 = ν23 0.3; G12 3, G13 = G23 2 GPa; axis 3 is the thickness, x.
    """
    s = np.zeros((6, 6))
    # in the order 1 (fibre), 2, 3
    first = np.array([[1 / 100, -0.4 / 100, -0.3 / 100], [-0.4 / 100, 1 / 5, -0.3 / 5],
                      [-0.3 / 100, -0.3 / 5, 1 / 5]]) * 1e-9  # fmt: skip
    order = [2, 1, 0] if along else [2, 0, 1]
    s[:3, :3] = first[np.ix_(order, order)]
    s[3, 3], s[4, 4], s[5, 5] = 1 / 3e9, 1 / 2e9, 1 / 2e9
    return Material(np.linalg.inv(s), 1.0)


def _quarter() -> Box:
    """Quarter of the strip, 30 mm between its supports, under 10 N/mm in the middle."""
    parts = tuple(
        (Slab(f"{_FIBRES[i % 2]} {i}", (i, i + 1), (0, 4)), _ply(along=i % 2 == 0))
        for i in range(len(_LAYERS))
    )
    top = sum(_LAYERS)
    return Box(
        x=stacked(_LAYERS, 2),
        y=even(5e-3, 1, 3),
        z=graded([0.0, 1e-3, 4e-3, 15e-3, 25e-3], 4),
        parts=parts,
        held=(
            Held(Where(z=0.0), ("z",)),
            Held(Where(y=0.0), ("y",)),
            Held(Where(x=0.0, z=15e-3), ("x",)),
        ),
        loads=(Load(Where(x=top, z=0.0), "x", -5e3),),
    )


@cached
def _strip() -> State:
    return statics(_quarter())


def _deflection() -> float:
    return float(_strip().mean(Where(x=0.0, y=0.0, z=0.0), "x").real)


SEVEN_LAYERS: tuple[Case, ...] = (
    case(
        "R0031",
        "Seven-layer strip in three-point bending (NAFEMS R0031/1)",
        "0/90/0/90/0/90/0, layers of 0.1 mm, the middle one of 0.4 mm, 10 mm wide, 30 mm between "
        "line supports and 10 mm beyond each, 10 N/mm across the middle; E1 = 100, E2 = E3 = 5 "
        "GPa, ν12 = 0.4, ν13 = ν23 = 0.3, G12 = 3, G13 = G23 = 2 GPa.",
        model="bricks of the model solid, a layer of bricks for each of the strip",
        source="NAFEMS R0031, test 1",
        tolerance=7e-3,
        reason="half a unit of the last printed digit, and lines that load and hold a solid: what "
        "they press in grows without limit on ever finer bricks",
        rows=[
            Check("The lower side moves by −1.06 mm below the load.", -1.06e-3, "m", _deflection)
        ],
    ),
)
