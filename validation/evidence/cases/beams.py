"""Beams with published or closed-form answers: transfer matrices, the lumped model, two solids."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.tmm.beam.lumped import lumped_model
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.sections import Section, segmented
from tactgen.validation.evidence.boxes import (
    Box,
    block,
    even,
    harmonic,
    held,
    load,
    natural_frequencies,
)
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.mesh_levels import cached, segments

#: Stiffness of a "rigid" support over EI/L³, shear stiffness of a beam without shear over EI/L²:
#: errors of their inverse.  Bending stiffness of one without bending over GA L².
_RIGID, _NO_SHEAR, _NO_BENDING = 1e12, 1e10, 1e3
_TMM = "transfer-matrix model, exact spans"
_CLOSED = "rounding, and 1e-10 from what stands for infinite shear stiffness"


def slender(length: float, *, stiffness: float = 1.0, mass: float = 1.0) -> Section:
    """Euler–Bernoulli beam: no shear, no rotary inertia."""
    return Section(EI=stiffness, GA=_NO_SHEAR * stiffness / length**2, m=mass, rhoI=0.0)


@cached
def _frequencies(beam: Section, length: float, ends: Ends, count: int) -> Floats:
    return bending_frequencies([(beam, length)], ends, count, open_circuit=False)


def _wavenumber(ends: Ends, number: int) -> float:
    """Β L of a mode of a slender beam, β⁴ = ω² m/EI."""
    return math.sqrt(2.0 * math.pi * _frequencies(slender(1.0), 1.0, ends, 3)[number])


def _pinned(beam: Section, length: float) -> Ends:
    rigid = _RIGID * beam.EI / length**3
    return Ends(Springs(rigid, 0.0), TipLoad(stiffness=rigid))


_VM50 = slender(80.0, stiffness=30e6 * 4.0 / 3.0, mass=1.124 / 386.0)
_UNIFORM = (
    case(
        "MASS", "Cantilever with a mass at its tip",
        "A slender cantilever with a tip mass of 1 and 0.25 times its own: β L of three modes.",
        [
            Check(f"β L of mode {at + 1} with a mass ratio of {ratio:g} is the equation's root.",
                  value, "1", partial(_wavenumber, Ends(tip=TipLoad(mass=ratio)), at))
            for ratio, values in (
                (1.0, (1.24791740961, 4.03113943671, 7.13413224094)),
                (0.25, (1.57375130266, 4.22511285671, 7.28123637341)),
            )
            for at, value in enumerate(values)
        ],
        model=_TMM, source="1 + cos x cosh x = μ x (sin x cosh x − cos x sinh x)", tolerance=1e-8,
        reason=_CLOSED,
    ),
    case(
        "ROOT", "Beam on a rotational spring at its root",
        "A slender beam on a spring k L/EI = 1, 10, 100: β L of the first mode.",
        [
            Check(f"β L at k L/EI = {k:g} is the equation's root.", value, "1",
                  partial(_wavenumber, Ends(Springs(_RIGID, k)), 0))
            for k, value in ((1.0, 1.24791740961), (10.0, 1.72274152059), (100.0, 1.85678697696))
        ],
        model=_TMM, source="the tip mass's equation with μ = EI/(k L): the two problems are dual",
        tolerance=1e-8, reason=_CLOSED,
    ),
    case(
        "VM50", "Simply supported beam (ANSYS VM50)",
        "80 in, E = 30e6 psi, I = 1.3333 in⁴, 1.124 lb per inch over 386 in/s²: first frequency.",
        [Check("The first frequency is that of the closed form.",
               0.5 * math.pi / 80.0**2 * math.sqrt(30e6 * 4.0 / 3.0 / (1.124 / 386.0)), "Hz",
               nth(_frequencies, 0, _VM50, 80.0, _pinned(_VM50, 80.0), 1))],
        model=_TMM, source="π/(2 L²) √(EI/m); ANSYS Verification Manual, VM50, prints 28.766 Hz",
        tolerance=1e-7, reason=_CLOSED,
    ),
)  # fmt: skip


#: NAFEMS FV5's 2 m x 2 m section, Cowper's shear factor.
_DEEP = Section(
    EI=200e9 * 2.0**4 / 12.0, GA=13.0 / 15.3 * 200e9 / 2.6 * 2.0**2,
    m=8000.0 * 2.0**2, rhoI=8000.0 * 2.0**4 / 12.0,
)  # fmt: skip
_FV5 = case(
    "FV5", "Deep beam (NAFEMS FV5)",
    "2 x 2 x 10 m, E = 200 GPa, ν = 0.3, 8000 kg/m³: flexural frequencies, simply supported (FV5) "
    "and clamped-free.",
    [
        *(
            Check(f"Flexural frequency {at + 1}, simply supported, is NAFEMS'.", value, "Hz",
                  nth(_frequencies, at, _DEEP, 10.0, _pinned(_DEEP, 10.0), 2), tolerance, reason)
            for at, (value, tolerance, reason) in enumerate((
                (42.650, 2e-4, "printed 1.2e-4 above the closed form with Cowper's factor, 42.645"),
                (148.15, 4e-5, "half a unit of the fifth printed digit"),
            ))
        ),
        *(
            Check(f"Frequency {at + 1}, clamped-free, is the exact one.", value, "Hz",
                  nth(_frequencies, at, _DEEP, 10.0, Ends(), 3), 1e-8,
                  "nine digits of the reference")
            for at, value in enumerate((15.6727306, 84.5597454, 201.540821))
        ),
    ],
    model=_TMM, source="NAFEMS FV5; clamped-free: exact solution of Timoshenko's equations",
)  # fmt: skip

# --- tapers ------------------------------------------------------------------------------------


@cached
def _tapered_frequencies(power: float, end: float) -> Floats:
    """Of a slender cantilever whose breadth (power 1) or height (power 3) falls to `end`."""

    def at(share: float) -> Section:
        size = 1.0 - (1.0 - end) * share
        return slender(1.0, stiffness=size**power, mass=size)

    row = segmented(at, 1.0, segments(64))
    return 2.0 * np.pi * bending_frequencies(row, Ends(), 3, open_circuit=False)


def _sharp(power: float, number: int) -> float:
    """Frequency of a taper to a point: extrapolated from ends of 0.1 and 0.05 %."""
    blunt, sharp = (_tapered_frequencies(power, end)[number] for end in (1e-3, 5e-4))
    return float(2.0 * sharp - blunt)


def _tip_deflection(
    taper: Callable[[float], Section], length: float, force: float, pieces: int
) -> float:
    """Tip deflection of a cantilever whose section is known by its share of the length."""
    row = segmented(taper, length, segments(pieces))
    stiffness = lumped_model(row).stiffness.real[2:4, 2:4]
    return float(np.linalg.solve(stiffness, [force, 0.0])[0])


_POINT = "64 segments, and the extrapolation from tips of 1/1000 and 1/2000 to a point"
_SEGMENTS = "lumped statics of a row of tapered segments"
_TAPERS = (
    case(
        "VM34", "Cantilever that tapers to a point (ANSYS VM34)",
        "20 in long, 0.5 in high, 3 in wide at the root and pointed at the tip, E = 30e6 psi, 10 "
        "lb at the tip.",
        [Check("The tip deflects by 0.042667 in.", 0.042667, "in", lambda: _tip_deflection(
            lambda share: slender(20.0, stiffness=30e6 * 3.0 * 0.5**3 / 12.0 * (1.0 - share)),
            20.0, 10.0, 16))],
        model=_SEGMENTS, source="ANSYS Verification Manual, VM34", tolerance=1.2e-5,
        reason="half a unit of the last printed digit",
    ),
    case(
        "WEDGE", "Kirchhoff's wedge",
        "A slender cantilever of constant breadth whose height falls to zero at the tip: ω L² √(ρ "
        "A0/(E I0)).",
        [
            Check(f"Mode {at + 1} of the wedge is Kirchhoff's.", value, "1",
                  partial(_sharp, 3.0, at))
            for at, value in enumerate((5.3150994, 15.2071680, 30.0198091))
        ],
        model=_TMM + " of tapered segments", tolerance=6e-4,
        source="G. Kirchhoff, Monatsber. Akad. Berlin 1879; Gesammelte Abhandlungen, 1882, p. 339: "
        "roots of J1 I2 + J2 I1 = 0",
        reason=_POINT + ": 4e-4 in the third mode",
    ),
    case(
        "BREADTH", "Breadth that tapers to a point",
        "A slender cantilever of constant height whose breadth falls linearly to zero at the tip: "
        "ω L² √(ρ A0/(E I0)).",
        [
            Check(f"Mode {at + 1} is that of the series.", value, "1", partial(_sharp, 1.0, at))
            for at, value in enumerate((7.15646336, 31.0413039, 75.4866029))
        ],
        model=_TMM + " of tapered segments", tolerance=2e-5,
        source="roots of the power series of (x w″)″ = λ² x w",
        reason=_POINT + ": 1e-5 in the third mode",
    ),
)  # fmt: skip


@cached
def _smits() -> Floats:
    """Matrix' entries without pressure, in the order of the rows.

    Two PZT-5A layers of 0.26 mm in series: the lumped model's voltage is that of one layer.
    """
    length, width, layer = 20e-3, 2.1e-3, 0.26e-3
    s11, d31, permittivity = 16.4e-12, -171e-12, 1700 * 8.8541878128e-12
    stiffness = width * (2.0 * layer) ** 3 / (12.0 * s11)
    beam = Section(
        EI=stiffness, GA=_NO_SHEAR * stiffness / length**2, m=1.0, rhoI=0.0,
        K=width * d31 / s11 * layer,
        C=2.0 * width / layer * (permittivity - d31**2 / s11),
    )  # fmt: skip
    model = lumped_model([(beam, length)])
    compliance = np.linalg.inv(model.stiffness.real[2:4, 2:4])
    coupling = -model.stiffness.real[2:4, 4]
    capacitance = model.stiffness.real[4, 4] + coupling @ compliance @ coupling
    per_volt = compliance @ coupling / 2.0
    return np.array([
        per_volt[0], compliance[0, 0], compliance[1, 1], capacitance / 4.0, -compliance[1, 0],
        -per_volt[1], -compliance[0, 1],
    ])  # fmt: skip


_SMITS = case(
    "SMITS", "Series bimorph (Smits, Dalke and Cooney)",
    "Two PZT-5A layers of 0.26 mm in series, 20 x 2.1 mm, clamped: the constituent matrix.",
    [
        Check(f"{what} is that of the matrix.", value, unit, nth(_smits, at))
        for at, (what, value, unit) in enumerate((
            ("The tip's deflection per volt (its sign is the poling's)", 3.7943787e-7, "m/V"),
            ("The tip's deflection per newton", 1.7773154e-3, "m/N"),
            ("The tip's rotation per moment", 13.3298654, "rad/(N m)"),
            ("The free capacitance", 1.17974546e-9, "F"),
            ("The tip's rotation per newton", 0.133298654, "rad/N"),
            ("The tip's rotation per volt", 3.7943787e-5, "rad/V"),
            ("The tip's deflection per moment", 0.133298654, "m/(N m)"),
        ))
    ],
    model="lumped model", tolerance=1e-8, reason=_CLOSED,
    source="J. G. Smits, S. I. Dalke, T. K. Cooney, Sensors and Actuators A 28 (1991) 41, matrix "
    "of the series bimorph with these constants",
)  # fmt: skip

# --- solids, shear, damping --------------------------------------------------------------------

_STEEL = isotropic_stiffness(200e9, 0.3)
#: What the inertia of becoming thinner takes off FV5's first frequency along, by Rayleigh.
_THINNER = (0.3 * math.pi / (2.0 * 10.0)) ** 2 * (2.0 * 2.0**4 / 12.0) / (2.0 * 2.0**2)


def _turned_or_stretched(on_x: str, on_y: str, at_root: str) -> float:
    """First frequency (Hz) of a quarter of the beam in torsion or along, by its symmetries."""
    side = even(1.0, 1, 4)
    conditions = held(on_x, x=0.0), held(on_y, y=0.0), held(at_root, z=0.0)
    box = block((side, side, even(10.0, 2, 5)), Material(_STEEL, 8000.0), *conditions)
    return float(natural_frequencies(box, 1)[0])


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


def _deep_beam(damping: float) -> Box:
    """NAFEMS' beam of 2 x 2 x 10 m with its load of 1 MN/m, bent along x.

    Damping is a share of the critical one, half of the structural loss.

    The load is spread over the height as Simpson's rule does, which is even for what varies at
    most as its cube: the faces bend less than the axis, so a load on one of them does less work.
    """
    return block(
        (even(2.0, 2, 3), even(2.0, 2, 3), even(10.0, 2, 6)),
        Material((1.0 + 2j * damping) * _STEEL if damping else _STEEL, 8000.0),
        held("xy", z=0.0), held("xy", z=10.0), held("z", z=5.0),
        load("x", 5e5 / 6, x=0.0), load("x", 1e6 / 3, x=1.0), load("x", 5e5 / 6, x=2.0),
    )  # fmt: skip


def _deep_beam_peak() -> float:
    """Amplitude (m) of the beam's middle at 42.65 Hz."""
    return abs(harmonic(_deep_beam(0.02), 42.65).mean("x", x=1.0, y=1.0, z=5.0))


_SPECIAL = (
    case(
        "FV5S", "Deep beam in torsion and along (NAFEMS FV5)",
        "The beam of case FV5 as a solid, 2 x 2 x 10 m, E = 200 GPa, ν = 0.3, 8000 kg/m³: one end "
        "does not turn, or does not move along; it may warp and become thinner.",
        [
            Check("Torsion is at 71.20 Hz.", 71.20, "Hz",
                  partial(_turned_or_stretched, "yz", "xz", "xy"), 1e-4,
                  "half a unit of the fourth printed digit"),
            Check("Motion along the beam is at 125.0 Hz less what the inertia of becoming thinner "
                  "takes.", 125.0 * (1.0 - _THINNER), "Hz",
                  partial(_turned_or_stretched, "x", "y", "z"), 1e-5,
                  "Rayleigh's correction is the first of a series"),
        ],
        model="a quarter in bricks of the model solid, 4 x 4 x 5 degrees, two along the beam",
        source="NAFEMS FV5: 1/(4 L) √(G J/(ρ I_p)) and 1/(4 L) √(E/ρ), printed as 125.0; "
        "Rayleigh's correction (ν π/2L)² I_p/(2 A) = 7.4e-4",
    ),
    case(
        "VM148", "Cantilever of parabolic height (ANSYS VM148)",
        "4 in long, 0.2 in wide, 2 √(x/L) in high at x from its tip, E = 30e6 psi, 1000 lb at the "
        "tip; no shear.",
        [Check("The tip deflects as the closed form has it.",
               8.0 * 1000.0 * 4.0**3 / (30e6 * 0.2 * 2.0**3), "in",
               lambda: _tip_deflection(
                   lambda share: slender(4.0, stiffness=30e6 * 0.2 * 2.0**3 / 12.0
                                         * (1.0 - share) ** 1.5), 4.0, 1000.0, 32))],
        model=_SEGMENTS, tolerance=1e-4, reason="32 segments, by the square of their length",
        source="ANSYS Verification Manual, VM148 (Timoshenko, Strength of Materials I): "
        "8 F L³/(E b h³), printed as 0.01067 in",
    ),
    case(
        "VM202", "Tube that shears and does not bend (ANSYS VM202)",
        "A square tube, side 10 m, wall 0.1 m, 30 m long, E = 200 GPa, ν = 0.27, 7860 kg/m³, held "
        "at one end, its sections kept flat: two frequencies.",
        [
            Check("The first frequency is 17.375 Hz.", 17.375, "Hz", nth(_shear_beam, 0)),
            Check("The second is three times as high.", 3.0 * 17.375, "Hz", nth(_shear_beam, 1)),
            Check("The second is printed as 52.176 Hz.", 52.176, "Hz", nth(_shear_beam, 1),
                  explained="a shear beam's frequencies are as 1 to 3, and so are not 17.375 and "
                  "52.176 Hz: the printed target is 0.1 % too high", known=-1.04e-3),
        ],
        model="transfer-matrix model with EI = 1000 GA L²", tolerance=2e-4,
        source="ANSYS Verification Manual, VM202 (Blevins): (2i − 1)/(4L) √(κG/ρ), Cowper's κ",
        reason="the bending that is left with EI = 1000 GA L² takes 1e-4; stiffer rows cannot be "
        "counted",
    ),
    case(
        "P5H", "Deep beam driven in resonance (NAFEMS test 5H)",
        "NAFEMS' beam of FV5, 2 x 2 x 10 m, E = 200 GPa, ν = 0.3, 8000 kg/m³, its ends simply "
        "supported, with 1 MN/m all along it, spread evenly over the section, and 2 % of critical "
        "damping (a loss factor of 4 %): the peak in the middle.",
        [
            Check("The middle moves by 13.45 mm.", 13.45e-3, "m", _deep_beam_peak,
                  4e-3, "the solid's peak is at 42.69 Hz, not 42.65 (1.3e-3 of the amplitude); the "
                  "sum over a Timoshenko beam's modes is 13.486 mm"),
            Check("The peak, which a structural loss leaves at the natural frequency, is at 42.65 "
                  "Hz.", 42.65, "Hz", lambda: float(natural_frequencies(_deep_beam(0.0), 1)[0]),
                  2e-3, "the solid's shear against that of NAFEMS' beam", heavy=True),
        ],
        model="two bricks of the model solid along each edge, 3 x 3 x 6 degrees",
        source="NAFEMS R0016, test 5H",
    ),
)  # fmt: skip

CASES: tuple[Case, ...] = (*_UNIFORM, _FV5, *_TAPERS, _SMITS, *_SPECIAL)
