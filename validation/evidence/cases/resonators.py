"""Piezoelectric resonators and bodies with exact answers: plates, bars, block, cube, strip."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.materials import EPS0, Piezoceramic, PiezoTensors
from tactgen.validation.evidence.boxes import (
    Box,
    Condition,
    Span,
    block,
    even,
    graded,
    harmonic,
    held,
    load,
    natural_frequencies,
    statics,
    together,
)
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.mesh_levels import cached

_IEEE = "IEEE Std 176-1987, in closed form"
_BRICKS = "bricks of the model solid, general supports and electrodes"
_CERAMIC = LIBRARY["PZT-5A"]


def poled(ceramic: Piezoceramic, along: str = "x", *, lossy: bool = False) -> Material:
    """Ceramic poled along an axis of the box, x or z."""
    tensors = ceramic.tensors(lossy=lossy)
    if along == "z":  # exchange x and z: Voigt xx yy zz yz xz xy
        voigt, axes = np.array([2, 1, 0, 5, 4, 3]), np.array([2, 1, 0])
        tensors = PiezoTensors(
            tensors.c[np.ix_(voigt, voigt)], tensors.e[np.ix_(axes, voigt)],
            tensors.eps[np.ix_(axes, axes)],
        )  # fmt: skip
    return Material(tensors.c, ceramic.density, tensors)


def _along_x(
    normal: tuple[float, ...], shear: tuple[float, ...], e: tuple[float, ...],
    eps: tuple[float, ...],
) -> Material:  # fmt: skip
    """PZT-4 poled along x: c (GPa) 11, 12, 22, 23 and 44, 55; e 11, 12, 26; ε/ε0 11, 22."""
    c = np.zeros((6, 6))
    c11, c12, c22, c23 = normal
    c[:3, :3] = np.array([[c11, c12, c12], [c12, c22, c23], [c12, c23, c22]]) * 1e9
    c[3, 3], c[4, 4], c[5, 5] = shear[0] * 1e9, shear[1] * 1e9, shear[1] * 1e9
    coupling = np.zeros((3, 6))
    coupling[0, :3] = e[0], e[1], e[1]
    coupling[1, 5] = coupling[2, 4] = e[2]
    permittivity = np.diag([eps[0], eps[1], eps[1]]) * EPS0
    return Material(c, 7500.0, PiezoTensors(c, coupling, permittivity))


def _resonance(box: Box, grounded: bool, **electrode: Span) -> float:
    """First frequency (Hz) with an electrode at 0 V, or without charge."""
    ends = held("V", 0.0, **electrode) if grounded else together("V", **electrode)
    return float(natural_frequencies(box.under(ends), 1)[0])


# --- plates of infinite extent, bars -----------------------------------------------------------


def _plate(shear: bool, grounded: bool) -> float:
    """First frequency of a column of a 1 mm plate that moves along its normal (x) or along z.

    What does not vary along the plate does not move the other way.  Its halves are mirrored: the
    column reaches from the middle (φ = 0) to one electrode.
    """
    thin = even(1e-4, 1, 1)
    other, moving = ("xy", "z") if shear else ("yz", "x")
    box = block(
        (even(0.5e-3, 1, 9), thin, thin), poled(_CERAMIC, "z" if shear else "x"),
        held(other), held(moving + "V", x=0.0),
    )  # fmt: skip
    return _resonance(box, grounded, x=0.5e-3)


def _plate_coupling(shear: bool) -> float:
    """Coupling factor of a plate driven along its motion, from f_s and f_p."""
    phase = 0.5 * math.pi * _plate(shear, True) / _plate(shear, False)
    return math.sqrt(phase / math.tan(phase))


_PLATES = tuple(
    case(
        name, f"{words} of an endless plate (IEEE 176)",
        f"A PZT-5A plate of 1 mm, electrodes on both faces, {motion}: parallel and series "
        "resonance.",
        [
            Check("The charge-free plate resonates at f_p = √(c^D/ρ)/(2 h).", parallel, "Hz",
                  partial(_plate, shear, False)),
            Check("The short-circuited plate resonates where k² = (π f_s/2 f_p) cot(π f_s/2 f_p).",
                  series, "Hz", partial(_plate, shear, True)),
            Check("Its coupling factor from the two is that of the constants.", coupling, "1",
                  partial(_plate_coupling, shear)),
        ],
        model=_BRICKS + ", one of degree 9 through half the thickness",
        source=_IEEE + ", with the library's PZT-5A", tolerance=1e-8,
        reason="half a cosine by a polynomial of degree 9",
    )
    for name, words, motion, shear, coupling, parallel, series in (
        ("TE", "Thickness extension", "poled along its normal, held sideways", False,
         0.48465880340, 2162019.6726948, 1934044.1700592),
        ("TS", "Thickness shear", "poled in its plane", True,
         0.68465002097, 1130631.5474351, 862133.9657283),
    )
)  # fmt: skip

#: PZT-5A as the published values of the two bars have it.
_BAR_CERAMIC = replace(_CERAMIC, eps_t=np.diag([1730.0, 1730.0, 1700.0]) * EPS0)


def _mirrored(grounded: str) -> tuple[Condition, ...]:
    """Supports of an eighth at its planes of symmetry; the potential is odd at one."""
    odd: dict[str, Span] = {grounded: 0.0}
    return held("x", x=0.0), held("y", y=0.0), held("z", z=0.0), held("V", 0.0, **odd)


def _bar(along: bool, grounded: bool) -> float:
    """First frequency of a 10 mm bar along z, an eighth, driven across (31) or along it (33)."""
    drive = "z" if along else "x"
    side = even(0.05e-3, 1, 2)
    axes = (side, side, even(5e-3, 2, 7))
    box = block(axes, poled(_BAR_CERAMIC, drive), *_mirrored(drive))
    return _resonance(box, grounded, **{drive: 5e-3 if along else 0.05e-3})


_BARS = tuple(
    case(
        name, f"Bar driven {words} its length (IEEE 176)",
        f"A slender bar of PZT-5A, 10 mm, poled and driven {words} its length, ends free.",
        [
            Check("Its series resonance is that of the closed form.", series, "Hz",
                  partial(_bar, along, True)),
            Check("Its parallel resonance is that of the closed form.", parallel, "Hz",
                  partial(_bar, along, False)),
        ],
        model=_BRICKS + ", two of degree 7 along half the bar",
        source=_IEEE + ", with the library's PZT-5A", tolerance=3e-5,
        reason="Rayleigh's correction for a bar 0.1 mm thick: (ν π a/L)²/12 is 1e-5, ceramic's ν = "
        "0.35; six printed digits",
    )
    for name, words, along, series, parallel in (
        ("BAR31", "across", False, 140248.0, 147495.0), ("BAR33", "along", True, 137381.0, 184201.0)
    )
)  # fmt: skip


def _admittance(frequency: float) -> float:
    """Im Y (S) of the whole bar of 10 x 0.2 x 0.05 mm; an eighth has half a volt on its face."""
    axes = (even(0.025e-3, 1, 2), even(0.1e-3, 1, 2), even(5e-3, 2, 6))
    box = block(axes, poled(_BAR_CERAMIC), *_mirrored("x"), held("V", 0.5, x=0.025e-3))
    charge = harmonic(box, frequency).force("V", x=0.025e-3).real
    return 2.0 * math.pi * frequency * 4.0 * charge


_ADMITTANCE = case(
    "YBAR", "Admittance of a bar driven across its length (IEEE 176)",
    "PZT-5A, 10 x 0.2 x 0.05 mm (the same admittance as 10 x 2 x 0.5 mm, but with a hundredth of "
    "the lateral inertia, which goes with (ν width/length)²), electrodes on the largest faces, "
    "ends free, no losses.",
    [
        Check(f"Im Y at {f / 1e3:g} kHz is that of the closed form.", value, "S",
              partial(_admittance, f))
        for f, value in ((100e3, 416.150467e-6), (160e3, 355.686270e-6))
    ],
    model=_BRICKS, tolerance=1e-3,
    source=_IEEE + ": ω ε33 (1 − k31²) b L/h (1 + k31²/(1 − k31²) tan q/q), q = ω L √(ρ s11)/2",
    reason="the width's inertia lowers the resonance by 2e-5, which counts 24 times at 160 kHz",
)  # fmt: skip

# --- a free block, a cube, a strip -------------------------------------------------------------


@cached
def _free_block() -> tuple[float, float]:
    """Stretch (m) along 10 mm and across 1 mm with 1 V across 1 mm."""
    state = statics(block(
        (even(1e-3, 1, 1), even(2e-3, 1, 1), even(10e-3, 1, 1)), poled(_CERAMIC),
        held("V", 1.0, x=0.0), held("V", x=1e-3), held("xyz", x=0.0, y=0.0, z=0.0),
        held("xy", x=0.0, y=0.0, z=10e-3), held("x", x=0.0, y=2e-3, z=0.0),
    ))  # fmt: skip
    along = state.mean("z", z=10e-3) - state.mean("z", z=0.0)
    across = state.mean("x", x=1e-3) - state.mean("x", x=0.0)
    return along.real, across.real


_BLOCK = case(
    "BLOCK", "Free block in a uniform field",
    "PZT-5A, 10 x 2 x 1 mm, poled and driven with 1 V along 1 mm, free: a patch test.",
    [
        Check("It grows along its length by d31 V L/t.", -1.71e-9, "m", nth(_free_block, 0)),
        Check("It grows along the field by d33 V.", 0.374e-9, "m", nth(_free_block, 1)),
    ],
    model=_BRICKS + ", one brick of degree 1", source="d31 V L/t and d33 V", tolerance=1e-10,
    reason="linear functions contain the answer; rounding",
)  # fmt: skip


@cached
def _cube(grounded: bool) -> Floats:
    """Frequencies (Hz) of VM175's cube, an eighth, that are even at all planes of symmetry.

    Some of them are odd under the exchange of y and z: a voltage does not excite those.
    """
    pzt4 = _along_x((115.0, 73.0, 132.0, 71.0), (30.0, 26.0), (14.1, -4.1, 10.5), (659.7, 804.6))
    end = held("V", x=10e-3) if grounded else together("V", x=10e-3)
    return natural_frequencies(block((even(10e-3, 1, 6),) * 3, pzt4, *_mirrored("x"), end), 5)


CUBE = case(
    "VM175", "Piezoelectric cube (ANSYS VM175)",
    "A free cube of PZT-4, 20 mm, electrodes on two faces: frequencies of the two lowest motions "
    "that a voltage excites.",
    [
        Check(f"The cube's {words} frequency is the manual's.", value, "Hz",
              nth(_cube, at, grounded), known=known,
              explained="the targets are those of a mixed finite element-perturbation method of "
              "1981 (Boucher, Lagier, Maerfeld, table 1), not of a converged solution: here all "
              "four fall to these values as the mesh is refined, and from degree 5 to two elements "
              "of degree 6 move by 1e-7 to 2e-5")
        for grounded, words, at, value, known in (
            (True, "first short-circuit", 0, 66560.0, -0.0219),
            (True, "second short-circuit", 3, 88010.0, 0.00144),
            (False, "first open-circuit", 2, 81590.0, -0.0219),
            (False, "second open-circuit", 4, 93410.0, 0.00179),
        )
    ],
    model=_BRICKS + ", an eighth by symmetry, degree 6",
    source="ANSYS Verification Manual, VM175, targets as printed; D. Boucher, M. Lagier, C. "
    "Maerfeld, IEEE Trans. Sonics Ultrason. SU-28 (1981) 318, table 1",
    tolerance=1e-3, reason="four printed digits",
)  # fmt: skip

#: Half length and half height of VM231's strip (m); slope of the stress over the height (N/m³).
STRIP_LENGTH, STRIP_HEIGHT, STRIP_SLOPE = 1e-3, 0.5e-3, -20e9
#: PZT-4 as ANSYS VM231 has it, poled along its height.
STRIP_MATERIAL = _along_x(
    (115.0, 74.3, 139.0, 77.8), (30.6, 25.6), (15.1, -5.2, 12.7), (634.7, 728.5)
)


@cached
def _corner() -> Floats:
    """Displacement along and across half the strip (m) and the potential (V) at its corner."""
    height = graded(np.linspace(-STRIP_HEIGHT, STRIP_HEIGHT, 3), 2)
    state = statics(block(
        (height, even(0.2e-3, 1, 2), even(STRIP_LENGTH, 1, 2)), STRIP_MATERIAL,
        held("z", z=0.0), held("y", y=0.0), held("xV", x=0.0, y=0.0, z=0.0),
        load("z", lambda x, _y, _z: STRIP_SLOPE * x, z=STRIP_LENGTH),
    ))  # fmt: skip
    return np.array([state.mean(c, x=STRIP_HEIGHT, y=0.0, z=STRIP_LENGTH).real for c in "zxV"])


_BENT = case(
    "VM231", "Piezoelectric strip in pure bending (ANSYS VM231)",
    "PZT-4, poled along its height, 2 mm long and 1 mm high, no electrodes; at its ends a stress "
    "along it of −20 GPa/m times the height above its middle; displacements and potential at the "
    "corner, against the middle of the strip.",
    [
        Check(f"The corner {words} as in closed form.", value, unit, nth(_corner, at))
        for at, (words, value, unit) in enumerate((
            ("moves along the strip", -1.0953e-7, "m"), ("moves across it", 1.1493e-7, "m"),
            ("is at the potential", 27.378, "V"),
        ))
    ],
    model="bricks of the model solid, two of degree 2 for half of the strip",
    source="ANSYS Verification Manual, VM231, after Parton, Kudryavtsev and Senik: exact",
    tolerance=5e-5,
    reason="five printed digits, of compliances printed with six; bricks of degree 2 are exact",
)  # fmt: skip

CASES: tuple[Case, ...] = (*_PLATES, *_BARS, _ADMITTANCE, _BLOCK, _BENT)
