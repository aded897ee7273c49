"""Beams with published or closed-form answers, by the transfer-matrix and the lumped model."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.geometry.device.material_library import LIBRARY
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.tmm.beam.lumped import lumped_model
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.sections import Section, segmented
from tactgen.validation.evidence.boxes import Box, Held, Where, graded, statics
from tactgen.validation.evidence.case import Case, Check, case, nth
from tactgen.validation.evidence.cases import special_beams
from tactgen.validation.evidence.cases.resonators import poled
from tactgen.validation.evidence.mesh_levels import cached, segments

#: Stiffness of a "rigid" support over EI/L³, and shear stiffness of a beam without shear over
#: EI/L²: errors of their inverse.
_RIGID, _NO_SHEAR = 1e12, 1e10
_TMM = "transfer-matrix model, exact spans"
#: The layer of a beam without a size, for its drawing.
_BEAM = (("beam", 0.05),)
_CLOSED = "rounding, and 1e-10 from what stands for infinite shear stiffness"


def slender(length: float, *, stiffness: float = 1.0, mass: float = 1.0) -> Section:
    """Euler–Bernoulli beam: no shear, no rotary inertia."""
    return Section(EI=stiffness, GA=_NO_SHEAR * stiffness / length**2, m=mass, rhoI=0.0)


def _wavenumbers(beam: Section, length: float, ends: Ends, count: int) -> Floats:
    """Β L of the lowest modes, β⁴ = ω² m/EI."""
    omega = 2.0 * np.pi * bending_frequencies([(beam, length)], ends, count, open_circuit=False)
    return np.asarray(np.sqrt(omega * length**2 * math.sqrt(beam.m / beam.EI)))


def _pinned(beam: Section, length: float) -> Ends:
    rigid = _RIGID * beam.EI / length**3
    return Ends(Springs(rigid, 0.0), TipLoad(stiffness=rigid))


@cached
def _with_tip_mass(ratio: float) -> Floats:
    return _wavenumbers(slender(1.0), 1.0, Ends(tip=TipLoad(mass=ratio)), 3)


@cached
def _on_root_spring(stiffness: float) -> float:
    base = Springs(_RIGID, stiffness)
    return float(_wavenumbers(slender(1.0), 1.0, Ends(base), 1)[0])


def _vm50() -> float:
    beam = slender(80.0, stiffness=30e6 * 4.0 / 3.0, mass=1.124 / 386.0)
    return float(bending_frequencies([(beam, 80.0)], _pinned(beam, 80.0), 1, open_circuit=False)[0])


_UNIFORM = (
    case(
        "MASS",
        "Cantilever with a mass at its tip",
        "A slender cantilever with a tip mass of 1 and 0.25 times its own: β L of three modes.",
        model=_TMM,
        source="1 + cos x cosh x = μ x (sin x cosh x − cos x sinh x)",
        tolerance=1e-8,
        reason=_CLOSED,
        rows=[
            Check(f"β L of mode {at + 1} with a mass ratio of {ratio:g} is the equation's root.",
                   value, "1", nth(_with_tip_mass, at, ratio))
            for ratio, values in (
                (1.0, (1.24791740961, 4.03113943671, 7.13413224094)),
                (0.25, (1.57375130266, 4.22511285671, 7.28123637341)),
            )
            for at, value in enumerate(values)
        ],
    ),
    case(
        "ROOT",
        "Beam on a rotational spring at its root",
        "A slender beam on a spring k L/EI = 1, 10, 100: β L of the first mode.",
        model=_TMM,
        source="the tip mass's equation with μ = EI/(k L): the two problems are dual",
        tolerance=1e-8,
        reason=_CLOSED,
        rows=[
            Check(f"β L at k L/EI = {k:g} is the equation's root.", value, "1",
                   partial(_on_root_spring, k))
            for k, value in ((1.0, 1.24791740961), (10.0, 1.72274152059), (100.0, 1.85678697696))
        ],
    ),
    case(
        "VM50",
        "Simply supported beam (ANSYS VM50)",
        "80 in, E = 30e6 psi, I = 1.3333 in⁴, 1.124 lb per inch over 386 in/s²: first frequency.",
        model=_TMM,
        source="π/(2 L²) √(EI/m); ANSYS Verification Manual, VM50, prints 28.766 Hz",
        tolerance=1e-7,
        reason=_CLOSED,
        rows=[Check("The first frequency is that of the closed form.", 0.5 * math.pi / 80.0**2
                        * math.sqrt(30e6 * 4.0 / 3.0 / (1.124 / 386.0)), "Hz", _vm50)],
    ),
)  # fmt: skip


# --- NAFEMS FV5 --------------------------------------------------------------------------------


def deep_beam() -> Section:
    """NAFEMS FV5's 2 m x 2 m section, Cowper's shear factor."""
    modulus, poisson, side = 200e9, 0.3, 2.0
    shear = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson)
    inertia, area = side**4 / 12.0, side**2
    return Section(
        EI=modulus * inertia,
        GA=shear * modulus / (2.0 * (1.0 + poisson)) * area,
        m=8000.0 * area,
        rhoI=8000.0 * inertia,
    )


@cached
def _deep(supported: bool, count: int) -> Floats:
    beam = deep_beam()
    ends = _pinned(beam, 10.0) if supported else Ends()
    return bending_frequencies([(beam, 10.0)], ends, count, open_circuit=False)


_FV5 = case(
    "FV5",
    "Deep beam (NAFEMS FV5)",
    "2 x 2 x 10 m, E = 200 GPa, ν = 0.3, 8000 kg/m³: flexural frequencies, simply supported "
    "(FV5) and clamped-free.",
    model=_TMM,
    source="NAFEMS FV5; clamped-free: exact solution of Timoshenko's equations",
    rows=[
        *(
            Check(f"Flexural frequency {at + 1}, simply supported, is NAFEMS'.", value, "Hz",
                   nth(_deep, at, True, 2), tolerance, reason)
            for at, (value, tolerance, reason) in enumerate((
                (42.650, 2e-4, "printed 1.2e-4 above the closed form with Cowper's factor, 42.645"),
                (148.15, 4e-5, "half a unit of the fifth printed digit"),
            ))
        ),
        *(
            Check(f"Frequency {at + 1}, clamped-free, is the exact one.", value, "Hz",
                   nth(_deep, at, False, 3), 1e-8, "nine digits of the reference")
            for at, value in enumerate((15.6727306, 84.5597454, 201.540821))
        ),
    ],
)  # fmt: skip

# --- tapers ------------------------------------------------------------------------------------


def _taper(power: float, end: float) -> Callable[[float], Section]:
    """Slender section whose breadth (power 1) or height (power 3) falls to `end`."""

    def at(share: float) -> Section:
        size = 1.0 - (1.0 - end) * share
        return slender(1.0, stiffness=size**power, mass=size)

    return at


def _to_a_point(share: float) -> float:
    return 1.0 - share


@cached
def _tapered_frequencies(power: float, end: float) -> Floats:
    row = segmented(_taper(power, end), 1.0, segments(64))
    return 2.0 * np.pi * bending_frequencies(row, Ends(), 3, open_circuit=False)


@cached
def _triangular_deflection() -> float:
    """Tip deflection (in) of VM34: width 3 in to nothing, 10 lb on 20 in."""
    root = 30e6 * 3.0 * 0.5**3 / 12.0
    row = segmented(
        lambda share: slender(20.0, stiffness=root * (1.0 - share), mass=1.0), 20.0, segments(16)
    )
    stiffness = lumped_model(row).stiffness.real[2:4, 2:4]
    return float(np.linalg.solve(stiffness, [10.0, 0.0])[0])


def _sharp(power: float, number: int) -> float:
    """Frequency of a taper to a point: extrapolated from ends of 0.1 and 0.05 %."""
    blunt, sharp = (_tapered_frequencies(power, end)[number] for end in (1e-3, 5e-4))
    return float(2.0 * sharp - blunt)


_POINT = "64 segments, and the extrapolation from tips of 1/1000 and 1/2000 to a point"
_TAPERS = (
    case(
        "VM34",
        "Cantilever that tapers to a point (ANSYS VM34)",
        "20 in long, 0.5 in high, 3 in wide at the root and pointed at the tip, E = 30e6 psi, "
        "10 lb at the tip.",
        model="lumped statics of a row of tapered segments",
        source="ANSYS Verification Manual, VM34",
        tolerance=1.2e-5,
        reason="half a unit of the last printed digit",
        rows=[Check("The tip deflects by 0.042667 in.", 0.042667, "in",
                        _triangular_deflection)],
    ),
    case(
        "WEDGE",
        "Kirchhoff's wedge",
        "A slender cantilever of constant breadth whose height falls to zero at the tip: "
        "ω L² √(ρ A0/(E I0)).",
        model=_TMM + " of tapered segments",
        source="G. Kirchhoff, Monatsber. Akad. Berlin 1879; Gesammelte Abhandlungen, 1882, p. "
        "339: roots of J1 I2 + J2 I1 = 0",
        tolerance=6e-4,
        reason=_POINT + ": 4e-4 in the third mode",
        rows=[
            Check(f"Mode {at + 1} of the wedge is Kirchhoff's.", value, "1",
                   partial(_sharp, 3.0, at))
            for at, value in enumerate((5.3150994, 15.2071680, 30.0198091))
        ],
    ),
    case(
        "BREADTH",
        "Breadth that tapers to a point",
        "A slender cantilever of constant height whose breadth falls linearly to zero at the "
        "tip: ω L² √(ρ A0/(E I0)).",
        model=_TMM + " of tapered segments",
        source="roots of the power series of (x w″)″ = λ² x w",
        tolerance=2e-5,
        reason=_POINT + ": 1e-5 in the third mode",
        rows=[
            Check(f"Mode {at + 1} is that of the series.", value, "1", partial(_sharp, 1.0, at))
            for at, value in enumerate((7.15646336, 31.0413039, 75.4866029))
        ],
    ),
)  # fmt: skip

# --- Smits, Dalke and Cooney -------------------------------------------------------------------


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
    "SMITS",
    "Series bimorph (Smits, Dalke and Cooney)",
    "Two PZT-5A layers of 0.26 mm in series, 20 x 2.1 mm, clamped: the constituent matrix.",
    model="lumped model",
    source="J. G. Smits, S. I. Dalke, T. K. Cooney, Sensors and Actuators A 28 (1991) 41, matrix "
    "of the series bimorph with these constants",
    tolerance=1e-8,
    reason=_CLOSED,
    rows=[
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
)  # fmt: skip

CASES: tuple[Case, ...] = (*_UNIFORM, _FV5, *_TAPERS, _SMITS, *special_beams.CASES)


_LOW, _HIGH, _PATCH = 8e-3, 10e-3, (55e-3, 65e-3)


def _beam() -> Box:
    """Half of the beam: x through the layers, z along it."""
    metal = Material(isotropic_stiffness(70e9, 0.33), 2700.0)
    foam = Material(isotropic_stiffness(35.3e6, 0.383), 32.0)
    z = np.array([0, 2, 10, 30, 50, 54, 55, 56, 60, 64, 65, 66, 70, 85, 100]) * 1e-3
    first, last = (int(np.flatnonzero(z == at)[0]) for at in _PATCH)
    all_along = (0, z.size - 1)
    return Box(
        graded([0.0, _LOW, _HIGH, 18e-3], 3),
        graded([0.0, 7.5e-3, 14e-3, 15e-3], 3),
        graded(z, 3),
        (
            (Slab("metal", (0, 1), all_along), metal),
            (Slab("metal", (2, 3), all_along), metal),
            (Slab("foam", (1, 2), (0, first)), foam),
            (Slab("piezo", (1, 2), (first, last)), poled(LIBRARY["PZT-5H"], "z")),
            (Slab("foam", (1, 2), (last, z.size - 1)), foam),
        ),
        (
            Held(Where(z=0.0), ("x", "y", "z")),
            Held(Where(y=0.0), ("y",)),
            Held(Where(x=_LOW, z=_PATCH), ("phi",)),
            Held(Where(x=_HIGH, z=_PATCH), ("phi",), 20.0),
        ),
    )


def _tip() -> float:
    """How far (m) the tip's upper face has moved."""
    return abs(statics(_beam()).mean(Where(x=18e-3, z=0.1), "x"))


SHEAR: tuple[Case, ...] = (
    case(
        "SHEAR",
        "Sandwich with a patch in shear (COMSOL's shear bender)",
        "100 x 30 x 18 mm: aluminium of 8 mm (70 GPa, ν = 0.33) on both sides of a core of 2 mm, "
        "of foam (35.3 MPa, ν = 0.383) but for PZT-5H poled along the beam from 55 to 65 mm; one "
        "end held, 20 V across the patch.",
        model="bricks of the model solid, degree 3, graded towards the patch's ends",
        source="the shear bender of COMSOL's application library, as arXiv 2110.11834 gives it",
        tolerance=5e-3,
        reason="the field is singular at the patch's ends and the published mesh is not stated: "
        "quadratic bricks on this one give 0.5 % more than these cubic ones",
        rows=[Check("The tip moves by 82.965 nm.", 82.965e-9, "m", _tip)],
    ),
)  # fmt: skip
