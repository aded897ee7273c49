"""Layered bodies with exact answers: cylindrical bending, bimetal strips, PVDF, a shear bender."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.materials import EPS0, PiezoTensors, isotropic_stiffness
from tactgen.validation.evidence.boxes import (
    Box,
    State,
    even,
    graded,
    held,
    layered,
    load,
    natural_frequencies,
    statics,
)
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.cases.resonators import poled
from tactgen.validation.evidence.mesh_levels import cached

_BRICKS = "bricks of the model solid"
_EXACT = "exact state-space solution through the thickness (tests/exact_laminate)"
_SMOOTH = "polynomials of degree 6 along half a sine wave, 4 through each layer"


def _wave(size: float, length: float) -> Callable[[Floats, Floats, Floats], Floats]:
    return lambda _x, _y, z: np.asarray(size * np.sin(np.pi * z / length))


def _opposed(c: Numbers, density: float, e: Numbers, eps: Numbers) -> list[Material]:
    """Two layers of a ceramic, the upper one poled the other way."""
    return [Material(c, density, PiezoTensors(c, sign * e, eps)) for sign in (1.0, -1.0)]


# --- cylindrical bending -----------------------------------------------------------------------

#: Length of the half wave (m), and the thickness of each layer (m) of three bimorphs.
_LENGTH = 20e-3
_THIN, _MEDIUM, _THICK = 0.385e-3, 1.0e-3, 2.5e-3


def bending_bimorph(
    thickness: float, *, grounded: bool = True, volts: float = 0.0, degree: int = 6,
    intervals: int = 1,
) -> Box:  # fmt: skip
    """Half of the half wave of two PZT-5A layers poled towards each other.

    No strain along y; simply supported with φ = 0 at z = 0, mirrored at z = L/2; the lower face
    at 0 V and the upper at `volts` sin(π z/L), or both without charge.
    """
    of = LIBRARY["PZT-5A"].tensors(lossy=False)
    box = layered(
        (thickness, thickness), _opposed(of.c, LIBRARY["PZT-5A"].density, of.e, of.eps),
        even(1e-3, 1, 1), even(0.5 * _LENGTH, intervals, degree), 4,
        held("y"), held("xV", z=0.0), held("z", z=0.5 * _LENGTH),
    )  # fmt: skip
    if not grounded:
        return box
    return box.under(held("V", x=0.0), held("V", _wave(volts, _LENGTH), x=2.0 * thickness))


def _bending_frequency(thickness: float, grounded: bool) -> float:
    return float(natural_frequencies(bending_bimorph(thickness, grounded=grounded), 1)[0])


@cached
def _driven(thickness: float) -> Floats:
    """W and D_x at the lower face's crest with 1 V sin(π z/L) on the upper one."""
    state = statics(bending_bimorph(thickness, volts=1.0))
    w = state.mean("x", x=0.0, z=0.5 * _LENGTH).real
    # the charge of the whole lower face, per width; the mean of a sine is 2/π of its crest
    charge = state.force("V", x=0.0).real / (1e-3 * 0.5 * _LENGTH)
    return np.array([w, charge * np.pi / 2.0])


def _cylindrical(
    name: str, thickness: float, first: float, second: float, *, driven: bool = False
) -> Case:
    """Bimorph's two frequencies, or driven at rest its motion and charge, with their references."""
    if driven:
        title = "driven by a wave of voltage, "
        asked = ", at rest: 1 V sin(π z/L) on the upper face, 0 V on the lower."
        rows = [
            Check("The lower face's crest moves as the exact solution does.", first, "m",
                  nth(_driven, 0, thickness)),
            Check("The electric displacement at that crest is exact.", second, "C/m^2",
                  nth(_driven, 1, thickness)),
        ]  # fmt: skip
    else:
        title, asked = "", ": first bending frequency, faces short-circuited or without charge."
        rows = [
            Check(f"The first frequency with {faces} is that of the exact solution.", value, "Hz",
                  partial(_bending_frequency, thickness, grounded))
            for faces, value, grounded in (
                ("both faces at 0 V", first, True), ("no charge on the faces", second, False),
            )
        ]  # fmt: skip
    return case(
        name, f"Piezoelectric bimorph in cylindrical bending, {title}L/H = "
        f"{_LENGTH / (2 * thickness):.3g}",
        f"Two PZT-5A layers of {thickness * 1e3:g} mm poled towards each other, one half wave of "
        f"20 mm between simple supports with φ = 0, no strain across the width{asked}",
        rows, model=_BRICKS + ", general supports", source=_EXACT, tolerance=1e-6, reason=_SMOOTH,
    )  # fmt: skip


_CYLINDRICAL = (
    _cylindrical("CYL1", _THIN, 2729.781550839573, 3065.134786141134),
    _cylindrical("CYL2", _MEDIUM, 6981.984969234867, 7774.313612838951),
    _cylindrical("CYL3", _THICK, 16075.335034538324, 17250.375637915604),
    _cylindrical("CYL4", _THIN, -4.29692165364606e-8, -1.56662847218356e-5, driven=True),
    _cylindrical("CYL5", _THICK, -8.42981467454552e-10, -2.14853285936959e-6, driven=True),
)


def _orthotropic(
    axes: str, moduli: tuple[float, ...], poisson: tuple[float, ...], shear: tuple[float, ...]
) -> Material:
    """Ply whose axes 1, 2, 3 lie along, say, "zyx"; E of each, ν and G of the pairs 12, 13, 23."""
    at, s = ["xyz".index(axis) for axis in axes], np.zeros((6, 6))
    s[at, at] = 1.0 / np.array(moduli)
    for (i, j), ratio, modulus in zip(((0, 1), (0, 2), (1, 2)), poisson, shear, strict=True):
        a, b = at[i], at[j]
        s[a, b] = s[b, a] = -ratio / moduli[i]
        s[6 - a - b, 6 - a - b] = 1.0 / modulus  # Voigt xx yy zz yz xz xy
    return Material(np.linalg.inv(s), 1.0)


def ply(along: str) -> Material:
    """Pagano's ply, E_L = 25, E_T = 1, G_LT = 0.5, G_TT = 0.2, ν = 0.25, fibres along an axis."""
    axes = along + "xyz".replace(along, "")
    return _orthotropic(axes, (25.0, 1.0, 1.0), (0.25,) * 3, (0.5, 0.5, 0.2))


def _pagano(slenderness: float) -> float:
    """100 E_T h³ w/(q L⁴) of the middle of half a 0/90/0 laminate of height 1."""
    box = layered(
        (1 / 3, 1 / 6, 1 / 6, 1 / 3), [ply(along) for along in "zyyz"], even(1.0, 1, 1),
        even(0.5 * slenderness, 1, 7), 6, held("y"), held("x", z=0.0),
        held("z", z=0.5 * slenderness), load("x", _wave(1.0, slenderness), x=1.0),
    )  # fmt: skip
    return 100.0 * statics(box).mean("x", x=0.5, z=0.5 * slenderness).real / slenderness**4


_PAGANO = case(
    "PAG", "Pagano's 0/90/0 laminate in cylindrical bending",
    "Three equal plies (E_L/E_T = 25, G_LT/E_T = 0.5, G_TT/E_T = 0.2, ν = 0.25), load q sin(π z/L) "
    "on one face, simple supports: 100 E_T h³ w/(q L⁴) in the middle for L/h = 4, 10, 20 and 50.",
    [
        Check(f"The deflection at L/h = {s:g} is Pagano's.", value, "1", partial(_pagano, s))
        for s, value in (
            (4.0, 2.88722515895213), (10.0, 0.931642912042631), (20.0, 0.617268227453981),
            (50.0, 0.526975657629369),
        )
    ],
    model=_BRICKS + ", degree 6 through each ply", tolerance=1e-6, reason=_SMOOTH,
    source="N. J. Pagano, J. Compos. Mater. 3 (1969) 398, prints 2.887 and 0.932; digits by "
    + _EXACT,
)  # fmt: skip

# --- bimetal strips: the free strain is driven by a field ---------------------------------------

#: Layers as (thickness, modulus, free strain), from below.
_Layers = tuple[tuple[float, float, float], ...]


def _expanding(modulus: float, strain: float) -> Material:
    """Isotropic layer (ν = 0) that expands by `strain` along z.

    An expansion is what a field of 1 V/m along x does to a material with e = c · strain: so a
    potential of −x makes the twin of a change of temperature.
    """
    c = isotropic_stiffness(modulus, 0.0)
    e = np.zeros((3, 6))
    e[0] = c @ np.array([0.0, 0.0, strain, 0.0, 0.0, 0.0])
    return Material(c, 1.0, PiezoTensors(c, e, np.eye(3)))


def _strip_theory(layers: _Layers, moment: float = 0.0) -> tuple[float, float]:
    """Strain at the lower face and curvature of a long strip: force 0, moment as given."""
    edges = np.concatenate([[0.0], np.cumsum([layer[0] for layer in layers])])
    moduli, free = (np.array([layer[i] for layer in layers]) for i in (1, 2))
    a, b, d = (float(moduli @ np.diff(edges**n)) / n for n in (1, 2, 3))
    push, turn = (float(moduli * free @ np.diff(edges**n)) / n for n in (1, 2))
    strain, curvature = np.linalg.solve([[a, b], [b, d]], [push, turn + moment])
    return float(strain), float(curvature)


@cached
def _bimetal(layers: _Layers, length: float, moment: float = 0.0) -> Floats:
    """Deflection and stretch of the tip, and the stress along z at the lower and upper face.

    Clamped at z = 0.  A moment (per width) pulls the upper side of the free end, on which the
    strip's own stress acts: without it the thermal stress, whose force and moment are 0, would
    have to fade there.
    """
    edges = np.concatenate([[0.0], np.cumsum([layer[0] for layer in layers])])
    bottom, curvature = _strip_theory(layers, moment)

    def traction(modulus: float, free: float, x: Floats, _y: Floats, _z: Floats) -> Floats:
        return np.asarray(modulus * (bottom + curvature * x - free))

    box = layered(
        [layer[0] for layer in layers], [_expanding(*layer[1:]) for layer in layers],
        even(1.0, 1, 1), even(length, 1, 2), 2,
        held("V", lambda x, _y, _z: -x), held("z", z=0.0), held("x", x=0.0, z=0.0),
        held("y", x=0.0, y=0.0, z=0.0), held("y", x=0.0, y=0.0, z=length),
        *(
            load("z", partial(traction, modulus, free), x=(float(low), float(high)), z=length)
            for low, high, (_, modulus, free) in zip(edges[:-1], edges[1:], layers, strict=True)
        ),
    )  # fmt: skip
    state = statics(box)
    low, high = (state.mean("z", x=float(at), z=length).real for at in edges[[0, -1]])
    # no stress across and no Poisson's ratio: the strain is linear in x
    stresses = [
        layer[1] * (end / length - layer[2])
        for layer, end in ((layers[0], low), (layers[-1], high))
    ]
    return np.array([state.mean("x", x=0.0, z=length).real, 0.5 * (low + high), *stresses])


_VM144 = ((0.2, 1.2e6, 1.8e-2), (0.1, 0.4e6, 0.6e-2))
_VM35 = ((0.05, 30e6, 2e-3), (0.05, 30e6, 1e-3))
_STRAIN, _CURVATURE = _strip_theory(_VM144, 20.0)
_TWIN = (
    "the traction on the free end is the strip's own stress, so quadratic functions contain the "
    "answer"
)
_STRIPS = (
    case(
        "VM35", "Bimetal strip of two equal layers (ANSYS VM35)",
        "10 in long, two layers of 0.05 in, E = 30e6 psi, expansions 2e-5 and 1e-5 per degree, 100 "
        "degrees warmer, one end clamped.",
        [
            Check("The tip deflects by 0.75 in.", 0.75, "in", nth(_bimetal, 0, _VM35, 10.0)),
            Check("The strip grows by 0.015 in.", 0.015, "in", nth(_bimetal, 1, _VM35, 10.0)),
            Check("The outer fibre of the layer that expands more is stressed to 7500 psi.",
                  7500.0, "psi", nth(_bimetal, 2, _VM35, 10.0)),
        ],
        model=_BRICKS + "; the expansion is driven by the field", tolerance=1e-6,
        source="ANSYS Verification Manual, VM35 (Timoshenko's bimetal in closed form)",
        reason=_TWIN + "; rounding, which a strip of 100 thicknesses magnifies to 1e-7",
    ),
    case(
        "VM144", "Strip of two unequal layers, warmed and bent (ANSYS VM144)",
        "8 in long, 0.2 in with E = 1.2e6 psi under 0.1 in with 0.4e6 psi, expansions 1.8e-4 and "
        "0.6e-4 per degree, 100 degrees warmer, one end clamped, 20 in lb per inch of width at the "
        "other, where it pulls the thinner layer.",
        [
            Check("The tip deflects towards the thinner layer as strip theory has it.",
                  -0.5 * _CURVATURE * 8.0**2, "in", nth(_bimetal, 0, _VM144, 8.0, 20.0)),
            Check("So is the thinner layer's outer fibre stressed.",
                  0.4e6 * (_STRAIN + 0.3 * _CURVATURE - 0.6e-2), "psi",
                  nth(_bimetal, 3, _VM144, 8.0, 20.0)),
            Check("So is the thicker layer's.", 1.2e6 * (_STRAIN - 1.8e-2), "psi",
                  nth(_bimetal, 2, _VM144, 8.0, 20.0)),
        ],
        model=_BRICKS + "; the expansion is driven by the field", tolerance=1e-8,
        source="strip theory; ANSYS Verification Manual, VM144 (Roark, 5th edition), prints 0.832 "
        "in, 2258 psi and 1731 psi", reason=_TWIN + "; rounding",
    ),
)  # fmt: skip

# --- bimorphs without Poisson's ratio -----------------------------------------------------------


@cached
def _pvdf(uniform: bool) -> State:
    """Bimorph of Tzou and of Hwang and Park: 100 x 5 x 1 mm, poled oppositely, 1 V.

    E = 2 GPa, e31 = 0.046 C/m², ε = 12 ε0, no Poisson's ratio; the field linear through the whole
    thickness (`uniform`) or as electrostatics has it.
    """
    e = np.zeros((3, 6))
    e[0, 2] = 0.046
    layers = _opposed(isotropic_stiffness(2e9, 0.0), 1800.0, e, 12.0 * EPS0 * np.eye(3))
    linear = (held("V", lambda x, _y, _z: x / 1e-3),)
    faces = held("V", x=0.0), held("V", 1.0, x=1e-3)
    return statics(layered(
        (0.5e-3, 0.5e-3), layers, even(5e-3, 1, 1), even(100e-3, 5, 3), 3,
        *(linear if uniform else faces), held("y"), held("xz", z=0.0),
    ))  # fmt: skip


def pvdf_deflection(position: float, uniform: bool) -> float:
    """Deflection (m) at a position (m) along the bimorph of case HP."""
    return abs(_pvdf(uniform).mean("x", x=0.5e-3, z=position).real)


#: k31² of that PVDF: e31²/(E ε + e31²).
_K2 = 0.046**2 / (2e9 * 12.0 * EPS0 + 0.046**2)
_PVDF = case(
    "PVDF", "PVDF bimorph: what the field's own variation is worth",
    "The bimorph of case HP, 100 x 5 x 1 mm of two layers of PVDF poled oppositely, E = 2 GPa, ν = "
    "0, e31 = 0.046 C/m², ε = 12 ε0, 1 V across both, with the potential as electrostatics has it, "
    "quadratic through each layer, over that with a linear one: deflection at 60 mm.",
    [Check("The varying field takes 0.25 % of the deflection, as in closed form.",
           (1.0 - _K2) / (1.0 - 0.75 * _K2), "1",
           lambda: pvdf_deflection(0.06, False) / pvdf_deflection(0.06, True))],
    model=_BRICKS, source="a layer stiffened by 1/(1 − k²) about its own middle: (1 − k²)/(1 − 3/4 "
    "k²)", tolerance=1e-5, reason="the clamp's zone, h/L of the 0.25 % in question",
)  # fmt: skip

#: Length, width, thickness of a layer (m); s11 (1/Pa), d31 (C/N) of the ceramic: as in case SMITS.
_L, _W, _H = 20e-3, 2.1e-3, 0.26e-3
_S11, _D31 = 16.4e-12, -171e-12
#: Moduli of shear and squeezing over E: more would add less than 5e-6 to the bending, and lose as
#: much to rounding.
_STIFF = 100.0


@cached
def _smits(pressure: float, volts: float) -> Floats:
    """Tip's deflection (m) and rotation, and volume (m³) of two layers in series.

    A pressure (Pa) on the upper face, volts across both; the rotation is that of the end face, by
    its motion along z, which is 0 in the middle.
    """
    stiffness = np.diag([_STIFF, _STIFF, 1.0, _STIFF, _STIFF, _STIFF]) / _S11
    e = np.zeros((3, 6))
    e[0, 2] = -_D31 / _S11
    state = statics(layered(
        (_H, _H), _opposed(stiffness, 7750.0, e, EPS0 * np.eye(3)),
        even(_W, 1, 1), even(_L, 1, 5), 2,
        held("V", lambda x, _y, _z: volts * x / (2.0 * _H)), held("y"), held("xz", z=0.0),
        load("x", pressure, x=2.0 * _H),
    ))  # fmt: skip
    return np.array([
        state.mean("x", x=_H, z=_L).real, -state.mean("z", x=2.0 * _H, z=_L).real / _H,
        _W * _L * abs(state.mean("x", x=_H)),
    ])  # fmt: skip


_SMITS = case(
    "SMITSP", "Series bimorph under pressure (Smits, Dalke and Cooney)",
    "The bimorph of case SMITS, two layers of 0.26 mm in series, 20 x 2.1 mm, clamped, s11 = "
    "16.4e-12 1/Pa, d31 = −171e-12 C/N: what a pressure on one face does, and what volume a "
    "voltage sweeps, without its sign.",
    [
        Check("The tip's deflection per pressure is that of the matrix, 3 s11 L⁴/(16 h³).",
              3.0 * _S11 * _L**4 / (16.0 * _H**3), "m/Pa", nth(_smits, 0, 1.0, 0.0)),
        Check("The tip's rotation per pressure is s11 L³/(4 h³).",
              _S11 * _L**3 / (4.0 * _H**3), "rad/Pa", nth(_smits, 1, 1.0, 0.0)),
        Check("The volume per pressure is 3 s11 w L⁵/(40 h³).",
              3.0 * _S11 * _W * _L**5 / (40.0 * _H**3), "m^3/Pa", nth(_smits, 2, 1.0, 0.0)),
        Check("The volume per volt, and so the charge per pressure, is −d31 w L³/(8 h²).",
              -_D31 * _W * _L**3 / (8.0 * _H**2), "m^3/V", nth(_smits, 2, 0.0, 1.0)),
    ],
    model=_BRICKS + ", of degree 5 along the bimorph, without Poisson's ratio and with next to no "
    "shear", source="J. G. Smits, S. I. Dalke, T. K. Cooney, Sensors and Actuators A 28 (1991) 41; "
    "Bernoulli's beam of E I = 2 w h³/(3 s11)", tolerance=1e-5,
    reason="shear of a hundred times E adds 5e-6; polynomials of degree 5 contain the rest",
)  # fmt: skip

# --- COMSOL's shear bender, NAFEMS' seven layers ------------------------------------------------


def _shear_bender() -> float:
    """How far (m) the tip's upper face has moved; half of the beam, x through the layers."""
    metal = Material(isotropic_stiffness(70e9, 0.33), 2700.0)
    foam = Material(isotropic_stiffness(35.3e6, 0.383), 32.0)
    z = np.array([0, 2, 10, 30, 50, 54, 55, 56, 60, 64, 65, 66, 70, 85, 100]) * 1e-3
    low, high, patch = 8e-3, 10e-3, (55e-3, 65e-3)
    first, last = (int(np.flatnonzero(z == at)[0]) for at in patch)
    y, wide, whole = [0.0, 7.5e-3, 14e-3, 15e-3], (0, 3), (0, z.size - 1)
    box = Box(
        graded([0.0, low, high, 18e-3], 3), graded(y, 3), graded(z, 3),
        (
            (Slab("metal", (0, 1), wide, whole), metal),
            (Slab("metal", (2, 3), wide, whole), metal),
            (Slab("foam", (1, 2), wide, (0, first)), foam),
            (Slab("piezo", (1, 2), wide, (first, last)), poled(LIBRARY["PZT-5H"], "z")),
            (Slab("foam", (1, 2), wide, (last, whole[1])), foam),
        ),
        (held("xyz", z=0.0), held("y", y=0.0), held("V", x=low, z=patch),
         held("V", 20.0, x=high, z=patch)),
    )  # fmt: skip
    return abs(statics(box).mean("x", x=18e-3, z=0.1))


_SHEAR = case(
    "SHEAR", "Sandwich with a patch in shear (COMSOL's shear bender)",
    "100 x 30 x 18 mm: aluminium of 8 mm (70 GPa, ν = 0.33) on both sides of a core of 2 mm, of "
    "foam (35.3 MPa, ν = 0.383) but for PZT-5H poled along the beam from 55 to 65 mm; one end "
    "held, 20 V across the patch.",
    [Check("The tip moves by 82.965 nm.", 82.965e-9, "m", _shear_bender)],
    model=_BRICKS + ", degree 3, graded towards the patch's ends", tolerance=5e-3,
    source="the shear bender of COMSOL's application library, as arXiv 2110.11834 gives it",
    reason="the field is singular at the patch's ends and the published mesh is not stated: "
    "quadratic bricks on this one give 0.5 % more than these cubic ones",
)  # fmt: skip


def _three_points() -> float:
    """Deflection (m) of a quarter of the strip, 30 mm between supports, under 10 N/mm."""
    thicknesses = (1e-4, 1e-4, 1e-4, 4e-4, 1e-4, 1e-4, 1e-4)
    along, across = (
        _orthotropic(axes, (100e9, 5e9, 5e9), (0.4, 0.3, 0.3), (3e9, 2e9, 2e9))
        for axes in ("zyx", "yzx")
    )
    box = layered(
        thicknesses, [along, across, along, across, along, across, along], even(5e-3, 1, 3),
        graded([0.0, 1e-3, 4e-3, 15e-3, 25e-3], 4), 2,
        held("z", z=0.0), held("y", y=0.0), held("x", x=0.0, z=15e-3),
        load("x", -5e3, x=sum(thicknesses), z=0.0),
    )  # fmt: skip
    return float(statics(box).mean("x", x=0.0, y=0.0, z=0.0).real)


SEVEN_LAYERS = case(
    "R0031", "Seven-layer strip in three-point bending (NAFEMS R0031/1)",
    "0/90/0/90/0/90/0, layers of 0.1 mm, the middle one of 0.4 mm, 10 mm wide, 30 mm between line "
    "supports and 10 mm beyond each, 10 N/mm across the middle; E1 = 100, E2 = E3 = 5 GPa, ν12 = "
    "0.4, ν13 = ν23 = 0.3, G12 = 3, G13 = G23 = 2 GPa.",
    [Check("The lower side moves by −1.06 mm below the load.", -1.06e-3, "m", _three_points)],
    model=_BRICKS + ", a layer of bricks for each of the strip", source="NAFEMS R0031, test 1",
    tolerance=7e-3, reason="half a unit of the last printed digit, and lines that load and hold a "
    "solid: what they press in grows without limit on ever finer bricks",
)  # fmt: skip

CASES: tuple[Case, ...] = (*_CYLINDRICAL, _PAGANO, *_STRIPS, _PVDF, _SHEAR, _SMITS)
