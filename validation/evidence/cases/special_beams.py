"""Beams whose answer rests on a taper, on shear alone, on unequal layers, or on damping."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device.materials import EPS0, PiezoTensors, isotropic_stiffness
from tactgen.tmm.beam.lumped import lumped_model
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.sections import Section, segmented
from tactgen.validation.evidence.boxes import (
    Box,
    Component,
    Held,
    Load,
    Where,
    block,
    even,
    harmonic,
    natural_frequencies,
    statics,
)
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.mesh_levels import cached, segments

#: Shear stiffness of a beam without shear over EI/L²; bending stiffness of one without bending
#: over GA L².
_NO_SHEAR, _NO_BENDING = 1e10, 1e3


@cached
def _parabolic() -> float:
    """Tip deflection (in) of VM148: 1000 lb at the tip, height 2 √(x/L) in."""
    root, length = 30e6 * 0.2 * 2.0**3 / 12.0, 4.0

    def at(share: float) -> Section:
        stiffness = root * (1.0 - share) ** 1.5
        return Section(stiffness, _NO_SHEAR * root / length**2, m=1.0, rhoI=0.0)

    stiffness = lumped_model(segmented(at, length, segments(32))).stiffness.real[2:4, 2:4]
    return float(np.linalg.solve(stiffness, [1000.0, 0.0])[0])


@cached
def _shear_beam() -> Floats:
    """Two frequencies (Hz) of VM202's tube, which shears and does not bend."""
    length, side, wall, poisson = 30.0, 10.0, 0.1, 0.27
    area, modulus = 4.0 * side * wall, 200e9 / (2.0 * (1.0 + poisson))
    # Cowper's factor of a thin square tube
    factor = 20.0 * (1.0 + poisson) / (48.0 + 39.0 * poisson)
    shear = factor * modulus * area
    beam = Section(_NO_BENDING * shear * length**2, shear, m=7860.0 * area, rhoI=0.0)
    return bending_frequencies([(beam, length)], Ends(), 2, open_circuit=False)


#: Share of critical damping of NAFEMS' test 5H, and the structural loss that is as large.
_DAMPING = 0.02
_PEAK = 42.65


@cached
def _deep_beam() -> Box:
    """NAFEMS' beam of 2 x 2 x 10 m with its load of 1 MN/m, bent along x.

    The load is spread over the height as Simpson's rule does, which is even for what varies at
    most as its cube: the faces bend less than the axis, so a load on one of them does less work.
    """
    c = (1.0 + 2j * _DAMPING) * isotropic_stiffness(200e9, 0.3)
    axes = (even(2.0, 2, 3), even(2.0, 2, 3), even(10.0, 2, 6))
    held = [Held(Where(z=at), ("x", "y")) for at in (0.0, 10.0)]
    box = block(axes, Material(c, 8000.0), *held, Held(Where(z=5.0), ("z",)))
    loads = (
        Load(Where(x=x), "x", 5e5 * share)
        for x, share in ((0.0, 1 / 6), (1.0, 2 / 3), (2.0, 1 / 6))
    )
    return replace(box, loads=tuple(loads))


@cached
def _deep_beam_at(frequency: float) -> float:
    """Amplitude (m) of the beam's middle."""
    return abs(harmonic(_deep_beam(), frequency).mean(Where(x=1.0, y=1.0, z=5.0), "x"))


def _deep_beam_peak() -> float:
    """Where (Hz) a parabola through three squared inverse amplitudes has its least.

    Of one mode the inverse amplitude squared is a parabola in ω², which over 1 % of it is one in ω.
    """
    at = _PEAK + np.array([-0.25, 0.0, 0.25])
    inverse = [_deep_beam_at(float(f)) ** -2 for f in at]
    a, b, _ = np.polyfit(at - _PEAK, inverse, 2)
    return float(_PEAK - 0.5 * b / a)


@cached
def _turned_or_stretched(turned: bool) -> float:
    """First frequency (Hz) of the beam in torsion or along, by its symmetries."""
    along: tuple[tuple[Component, ...], ...] = (("y", "z"), ("x", "z"), ("x", "y"))
    across: tuple[tuple[Component, ...], ...] = (("x",), ("y",), ("z",))
    on_x, on_y, at_root = along if turned else across
    held = (Held(Where(x=0.0), on_x), Held(Where(y=0.0), on_y), Held(Where(z=0.0), at_root))
    side = even(1.0, 1, 4)
    axes = (side, side, even(10.0, 2, 5))
    material = Material(isotropic_stiffness(200e9, 0.3), 8000.0)
    return float(natural_frequencies(block(axes, material, *held), 1)[0])


#: What the inertia of becoming thinner takes off FV5's first frequency along, by Rayleigh.
_THINNER = (0.3 * math.pi / (2.0 * 10.0)) ** 2 * (2.0 * 2.0**4 / 12.0) / (2.0 * 2.0**2)

CASES: tuple[Case, ...] = (
    case(
        "FV5S",
        "Deep beam in torsion and along (NAFEMS FV5)",
        "The beam of case FV5 as a solid, 2 x 2 x 10 m, E = 200 GPa, ν = 0.3, 8000 kg/m³: one end "
        "does not turn, or does not move along; it may warp and become thinner.",
        model="a quarter in bricks of the model solid, 4 x 4 x 5 degrees, two along the beam",
        source="NAFEMS FV5: 1/(4 L) √(G J/(ρ I_p)) and 1/(4 L) √(E/ρ), printed as 125.0; "
        "Rayleigh's correction (ν π/2L)² I_p/(2 A) = 7.4e-4",
        rows=[
            Check("Torsion is at 71.20 Hz.", 71.20, "Hz", partial(_turned_or_stretched, True),
                   1e-4, "half a unit of the fourth printed digit"),
            Check("Motion along the beam is at 125.0 Hz less what the inertia of becoming thinner "
                   "takes.", 125.0 * (1.0 - _THINNER), "Hz", partial(_turned_or_stretched, False),
                   1e-5, "Rayleigh's correction is the first of a series"),
        ],
    ),
    case(
        "VM148",
        "Cantilever of parabolic height (ANSYS VM148)",
        "4 in long, 0.2 in wide, 2 √(x/L) in high at x from its tip, E = 30e6 psi, 1000 lb at the "
        "tip; no shear.",
        model="lumped statics of a row of tapered segments",
        source="ANSYS Verification Manual, VM148 (Timoshenko, Strength of Materials I): "
        "8 F L³/(E b h³), printed as 0.01067 in",
        tolerance=1e-4,
        reason="32 segments, by the square of their length",
        rows=[
            Check("The tip deflects as the closed form has it.",
                   8.0 * 1000.0 * 4.0**3 / (30e6 * 0.2 * 2.0**3), "in", _parabolic)
        ],
    ),
    case(
        "VM202",
        "Tube that shears and does not bend (ANSYS VM202)",
        "A square tube, side 10 m, wall 0.1 m, 30 m long, E = 200 GPa, ν = 0.27, 7860 kg/m³, held "
        "at one end, its sections kept flat: two frequencies.",
        model="transfer-matrix model with EI = 1000 GA L²",
        source="ANSYS Verification Manual, VM202 (Blevins): (2i − 1)/(4L) √(κG/ρ), Cowper's κ",
        tolerance=2e-4,
        reason="the bending that is left with EI = 1000 GA L² takes 1e-4; stiffer rows cannot be "
        "counted",
        rows=[
            Check("The first frequency is 17.375 Hz.", 17.375, "Hz", nth(_shear_beam, 0)),
            Check("The second is three times as high.", 3.0 * 17.375, "Hz", nth(_shear_beam, 1)),
            Check(
                "The second is printed as 52.176 Hz.", 52.176, "Hz", nth(_shear_beam, 1),
                explained="a shear beam's frequencies are as 1 to 3, and so are not 17.375 and "
                "52.176 Hz: the printed target is 0.1 % too high",
                known=-1.04e-3,
            ),
        ],
    ),
    case(
        "P5H",
        "Deep beam driven in resonance (NAFEMS test 5H)",
        "NAFEMS' beam of FV5, 2 x 2 x 10 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, its ends simply "
        "supported, with 1 MN/m all along it, spread evenly over the section, and 2 % of critical "
        "damping (a loss factor of 4 %): the peak in the middle.",
        model="two bricks of the model solid along each edge, 3 x 3 x 6 degrees",
        source="NAFEMS R0016, test 5H",
        rows=[
            Check("The middle moves by 13.45 mm.", 13.45e-3, "m", lambda: _deep_beam_at(_PEAK),
                   4e-3,
                   "the solid's peak is at 42.69 Hz, not 42.65 (1.3e-3 of the amplitude); the sum "
                   "over a Timoshenko beam's modes is 13.486 mm"),
            Check("The peak is at 42.65 Hz.", 42.65, "Hz", _deep_beam_peak, 2e-3,
                   "the solid's shear against that of NAFEMS' beam", heavy=True),
        ],
    ),
)  # fmt: skip


#: Half length, half height and width (m); slope of the stress over the height (N/m³).
LENGTH, HEIGHT, _WIDTH = 1e-3, 0.5e-3, 0.2e-3
SLOPE = -20e9


def strip_material() -> Material:
    """PZT-4 as ANSYS VM231 has it, poled along x (c, e and ε at constant strain)."""
    c = np.zeros((6, 6))
    c[:3, :3] = np.array([[115.0, 74.3, 74.3], [74.3, 139.0, 77.8], [74.3, 77.8, 139.0]]) * 1e9
    c[3, 3], c[4, 4], c[5, 5] = 30.6e9, 25.6e9, 25.6e9
    e = np.zeros((3, 6))
    e[0, :3] = 15.1, -5.2, -5.2
    e[1, 5] = e[2, 4] = 12.7
    return Material(c, 7500.0, PiezoTensors(c, e, np.diag([634.7, 728.5, 728.5]) * EPS0))


def _strip() -> Box:
    """Half the strip, poled along its height x, bent about y, free but for rigid motion."""
    height = even(2.0 * HEIGHT, 2, 2)
    axes = (replace(height, breaks=height.breaks - HEIGHT), even(_WIDTH, 1, 2), even(LENGTH, 1, 2))
    box = block(axes, strip_material())
    held = (
        Held(Where(z=0.0), ("z",)),
        Held(Where(y=0.0), ("y",)),
        Held(Where(x=0.0, y=0.0, z=0.0), ("x", "phi")),
    )
    return replace(box, held=held, loads=(Load(Where(z=LENGTH), "z", lambda x, _y, _z: SLOPE * x),))


@cached
def _corner() -> Floats:
    """Displacement along and across the strip (m) and the potential (V) at its corner."""
    state = statics(_strip())
    at = Where(x=HEIGHT, y=0.0, z=LENGTH)
    return np.array([state.mean(at, component).real for component in _COMPONENTS])


_COMPONENTS: tuple[Component, ...] = ("z", "x", "phi")
_WORDS = ("moves along the strip", "moves across it", "is at the potential")
BENT = case(
    "VM231",
    "Piezoelectric strip in pure bending (ANSYS VM231)",
    "PZT-4, poled along its height, 2 mm long and 1 mm high, no electrodes; at its ends a stress "
    "along it of −20 GPa/m times the height above its middle; displacements and potential at the "
    "corner, against the middle of the strip.",
    model="bricks of the model solid, two of degree 2 for half of the strip",
    source="ANSYS Verification Manual, VM231, after Parton, Kudryavtsev and Senik: exact",
    tolerance=5e-5,
    reason="five printed digits, of compliances printed with six; bricks of degree 2 are exact",
    rows=[
        Check(f"The corner {words} as in closed form.", value, unit, nth(_corner, at))
        for at, (words, value, unit) in enumerate(
            zip(_WORDS, (-1.0953e-7, 1.1493e-7, 27.378), ("m", "m", "V"), strict=True)
        )
    ],
)
