"""Coils in air with closed-form answers, by the axisymmetric field: inductances, force, field.

Sections are small where the closed form is that of a filament or a sheet; a case says what that
costs.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import MagneticField, solve_field
from tactgen.fem.magnetics.axisymmetric_force import virtual_work_force
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.fem.magnetics.force_3d import eggshell_force, harmonic_weight
from tactgen.fem.magnetics.problem_3d import MagneticSolid, sample
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.magnetisation import MU0, MagnetisationCurve
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, graded_planes
from tactgen.geometry.reluctance.section_grid import Grid, Region, graded_grid
from tactgen.validation.evidence.case import Case, Check, case
from tactgen.validation.evidence.cases.ball import Potential
from tactgen.validation.evidence.mesh_levels import cached, counted, degree

LOW = Region("low", (0.04, 0.05), (-0.02, -0.005), turns=100.0)
HIGH = Region("high", (0.03, 0.045), (0.01, 0.02), turns=50.0, moves=True)
#: Currents (A) at which the force is compared.
CURRENTS = (2.0, 3.0)


def mutual_inductance(a: Floats, b: Floats, distance: Floats) -> Floats:
    """M of two coaxial filaments with radii a, b at an axial distance (H)."""
    from scipy.special import ellipe, ellipk

    m = 4.0 * a * b / ((a + b) ** 2 + distance**2)
    k = np.sqrt(m)
    return np.asarray(
        MU0 * np.sqrt(a * b) * ((2.0 / k - k) * ellipk(m) - 2.0 / k * ellipe(m)), dtype=float
    )


def mutual_inductance_slope(a: Floats, b: Floats, distance: Floats) -> Floats:
    """DM/d(distance) of the same (H/m)."""
    from scipy.special import ellipe, ellipk

    m = 4.0 * a * b / ((a + b) ** 2 + distance**2)
    k = np.sqrt(m)
    bracket = ellipk(m) - (2.0 - m) / (2.0 * (1.0 - m)) * ellipe(m)
    return np.asarray(MU0 * distance * k / (2.0 * np.sqrt(a * b)) * bracket, dtype=float)


def between_windings(
    one: Region, other: Region, function: Callable[[Floats, Floats, Floats], Floats]
) -> float:
    """Mean of a filament function over both sections, times the turns."""
    (r1, z1, w1), (r2, z2, w2) = map(_filaments, (one, other))
    values = function(r1[:, None], r2[None, :], z2[None, :] - z1[:, None])
    return one.turns * other.turns * float(w1 @ values @ w2)


def _filaments(winding: Region) -> tuple[Floats, Floats, Floats]:
    x, w = np.polynomial.legendre.leggauss(8)
    (r0, r1), (z0, z1) = winding.radii, winding.heights
    r, z = np.meshgrid((r0 + r1 + (r1 - r0) * x) / 2.0, (z0 + z1 + (z1 - z0) * x) / 2.0)
    return r.ravel(), z.ravel(), np.outer(w, w).ravel() / 4.0


def winding_field(
    regions: tuple[Region, ...], currents: tuple[float, ...], walls: float, order: int = 4
) -> MagneticField:
    """Field of windings in a box of radius `walls` (m)."""
    space = discretise(graded_grid(regions, walls, refinement=2.0), degree(order))
    counted(space.size)
    return solve_field(space, np.array(currents))


@cached
def solved() -> MagneticField:
    """Field of both coils, walls at eighty times their radius."""
    return winding_field((LOW, HIGH), CURRENTS, 4.0)


_FIELD = "axisymmetric field, quadrilaterals of order 4 on a graded grid, walls far away"


# --- two loops ---------------------------------------------------------------------------------

#: Loops of 0.20 and 0.25 m at a distance of 0.10 m, of 1 mm wire.
_LOW, _HIGH = (
    Region(name, (radius - 0.5e-3, radius + 0.5e-3), (at - 0.5e-3, at + 0.5e-3), turns=1.0,
           moves=moves)
    for name, radius, at, moves in (("low", 0.20, -0.05, False), ("high", 0.25, 0.05, True))
)  # fmt: skip


@cached
def _loops() -> MagneticField:
    """Their field with 1 A each."""
    return winding_field((_LOW, _HIGH), (1.0, 1.0), 20.0)


_LOOPS = case(
    "LOOPS", "Two coaxial circular loops",
    "Loops of 0.20 and 0.25 m radius, 0.10 m apart, 1 A in each, of 1 mm wire.",
    [
        Check("Their mutual inductance is Maxwell's.",
               between_windings(_LOW, _HIGH, mutual_inductance), "H",
               lambda: float(_loops().incremental_inductance[0, 1]), 5e-6,
               "walls at eighty radii, 2e-6"),
        Check("They attract each other with Maxwell's force.",
               between_windings(_LOW, _HIGH, mutual_inductance_slope), "N",
               lambda: virtual_work_force(_loops()), 5e-5,
               "the mesh across a wire of 1/200 of its radius"),
    ],
    model=_FIELD,
    source="Maxwell's elliptic integrals, their mean over the wires' square sections; of thin "
    "wires F. W. Grover, Inductance Calculations, example 24",
)  # fmt: skip

# --- thin solenoids ----------------------------------------------------------------------------


def _nagaoka(ratio: float) -> float:
    """L of a thin solenoid of 2R/l = `ratio` over that of an endless one.

    Extrapolated to no thickness from sheets of 0.2 and 0.1 % of the radius, in eight pieces.
    """
    length, factors = 2.0 / ratio, []
    for thickness in (2e-3, 1e-3):
        sheet = _sheet(1.0, length, thickness, 8)
        field = winding_field(sheet, (1.0,) * 8, 100.0 * max(1.0, length))
        factors.append(float(field.flux_linkage.sum()) * length / (MU0 * math.pi))
    return 2.0 * factors[1] - factors[0]


def _sheet(radius: float, length: float, thickness: float, pieces: int) -> tuple[Region, ...]:
    """Thin winding in pieces, so that the grid is as fine along it."""
    ends = np.linspace(-0.5 * length, 0.5 * length, pieces + 1)
    radii = (radius - 0.5 * thickness, radius + 0.5 * thickness)
    return tuple(
        Region(f"sheet{i}", radii, (low, high), turns=1.0 / pieces)
        for i, (low, high) in enumerate(zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True))
    )


_NAGAOKA = case(
    "NAGAOKA", "Inductance of a thin solenoid",
    "L l/(µ0 N² π R²) of a cylindrical current sheet for 2 R/l = 0.2, 0.5, 1, 2 and 5.",
    [
        Check(f"Nagaoka's factor at 2R/l = {ratio:g}.", value, "1", partial(_nagaoka, ratio),
               heavy=ratio in (0.5, 2.0))
        for ratio, value in (
            (0.2, 0.920092671), (0.5, 0.818135752), (1.0, 0.688422607),
            (2.0, 0.525510024), (5.0, 0.319825468),
        )
    ],
    model=_FIELD + "; extrapolated from two thin sheets",
    source="L. Lorenz (1879), H. Nagaoka (1909), by elliptic integrals", tolerance=5e-5,
    reason="the mesh at the sheet's ends 3e-5; (t/R)² log(R/t) = 7e-6 of its thickness",
)  # fmt: skip

# --- a field on the axis -----------------------------------------------------------------------


def _vm168(height: float) -> float:
    """B_z (T) on the axis of VM168's solenoid, at a height (m) above its middle."""
    inch, pieces = 25.4e-3, 16
    sheet = _sheet(0.5 * inch, 5.0 * inch, 1e-4, pieces)
    # an empty ring: a line of the grid where the field is asked for
    mark = Region("mark", (0.1 * inch, 0.2 * inch), (height, height + 2e-3))
    field = winding_field((*sheet, mark), (115.5,) * pieces, 5.0)
    d = field.discretisation
    level = int(np.abs(d.grid.z - height).argmin())
    # on the axis B_z = 2 u; of each cell the first unknown is that of its lower inner corner
    first_column = field.potential[d.cell_dofs[: d.grid.z.size - 1, 0]]
    return float(2.0 * first_column[level])


_VM168 = case(
    "VM168", "Field on the axis of a solenoid (ANSYS VM168)",
    "A thin solenoid, 5 in long, 0.5 in in radius, 115.5 ampere-turns: B_z in the middle and "
    "0.1905 m above.",
    [
        Check(f"B_z at a height of {height:g} m is that of the sheet.", value, "T",
               partial(_vm168, height))
        for height, value in ((0.0, 1.1206537736e-3), (0.1905, 2.1229234256e-6))
    ],
    model=_FIELD,
    source="closed form of a current sheet; ANSYS Verification Manual, VM168, prints 1120e-6 and "
    "2.12e-6 T",
    tolerance=1e-4,
    reason="far from the coil the grid is coarse; the sheet is 0.1 mm thick; walls at 5 m",
)  # fmt: skip

# --- Brooks coil -------------------------------------------------------------------------------


def _brooks() -> float:
    """Inductance (H) of VM207's coil: square section, inner radius its side."""
    coil = Region("coil", (20e-3, 40e-3), (-10e-3, 10e-3), turns=500.0)
    return float(winding_field((coil,), (1.0,), 4.0, order=3).incremental_inductance[0, 0])


_BROOKS = case(
    "VM207", "Brooks coil (ANSYS VM206, VM207)",
    "500 turns on a square of 20 mm, inner radius 20 mm.",
    [
        Check("The inductance is Grover's.", 1.6994e-6 * 1.5 * 20e-3 * 500.0**2, "H", _brooks,
               5e-5, "half a unit of Grover's fifth digit; the mesh 2e-5"),
    ],
    model=_FIELD,
    source="F. W. Grover, Inductance Calculations, Brooks coil: 1.6994e-6 a N²; ANSYS "
    "Verification Manual, VM206 and VM207, prints 12.74 mH",
)  # fmt: skip

CASES: tuple[Case, ...] = (_LOOPS, _NAGAOKA, _VM168, _BROOKS)

# --- what cases of the normal actuator, tests and stress runs use ---------------------------------


#: Radii of the winding and of the core (m).
INNER, OUTER, CORE = 10e-3, 20e-3, 8e-3
_HEIGHT = 5e-3
#: u has a term 1/r² outside the bore.  In the cell where that is worst, 10 to 12.5 mm, its pole
#: lies 9 half widths from the middle: polynomials gain 9 + √80 ≈ 18 per degree, B loses one.
SOLENOID_ERROR = 18.0**-5


def infinite_solenoid(density: float, core: MagnetisationCurve | None = None) -> MagneticField:
    """Field of the winding carrying `density` (A/m²).

    All sides are left open for tangential H = 0: exact outside an infinite solenoid.
    """
    parts = [Region("winding", (INNER, OUTER), (0.0, _HEIGHT), turns=1.0)]
    if core:
        parts.append(Region("core", (0.0, CORE), (0.0, _HEIGHT), core))
    spans = ((0.0, CORE), (CORE, INNER), (INNER, OUTER), (OUTER, 1.5 * OUTER))
    r = np.unique(np.concatenate([np.linspace(a, b, 5) for a, b in spans]))
    grid = Grid(r, np.array([0.0, _HEIGHT]), tuple(parts))
    d = discretise(grid, degree(6), closed=())
    counted(d.size)
    return solve_field(d, np.array([density * (OUTER - INNER) * _HEIGHT]))


def flux_density_in_core(field: MagneticField) -> Floats:
    """B_z (n_e, n_q) in the cells of the core (T)."""
    return np.asarray(field.flux_density[..., 1][field.discretisation.cell_labels == 1])


def core_tolerance(core: MagnetisationCurve) -> float:
    """Relative tolerance of B in the core.

    The flux's error is the square of the field's, weighed by the core's permeability; the
    second term is the tolerance of Newton's method.
    """
    largest = 1.0 / (MU0 * float(core.reluctivity(np.linspace(0.0, 2.0, 200)).min()))
    return 4.0 * largest * SOLENOID_ERROR**2 + 1e-8


CURRENT, APART, TALL, THICK = 24.0, 10e-3, 12e-3, 0.5e-3
_SLICE = 2e-3
_NEAR, _FAR = 0.5 * (APART - THICK), 0.5 * (APART + THICK)


def conductors(potential: Potential, scale: float) -> tuple[float, float]:
    """Force per length (N/m) away from the other bar, by stress and by J x B.

    `scale` is a factor on all cell sizes; 0.7 leaves 0.1 %.
    """
    solid = sample(
        MagneticSolid(_mesh(scale), {}, _conductor_source, flux_normal=("y_low",), copies=2)
    )
    weight = harmonic_weight(solid, ("bar",), ("shell",))
    solver = potential(solid)
    counted(solver.size)
    field = solver.solve(CURRENT)
    cells = solid.problem.mesh.cells_of("bar")
    density = CURRENT / (TALL * THICK)  # along −z here: F_x = −J_z B_y
    flux_density = field.flux_density[cells][..., 1]
    lorentz = 2.0 * float(np.sum(solid.weights[cells] * density * flux_density))
    stress = eggshell_force(field, weight, np.array([1.0, 0.0, 0.0]))
    return stress / _SLICE, lorentz / _SLICE


def _mesh(scale: float) -> Mesh:
    mm = 1e-3 * scale

    def planes(*stops: tuple[float, float]) -> Floats:
        return graded_planes(list(stops), growth=scale)

    far = (1.0, 500.0 * mm)
    x = planes(
        (0.0, 2 * mm), (1.5e-3, 2 * mm), (_NEAR, 0.3 * mm), (_FAR, 0.3 * mm), (13e-3, 6 * mm), far
    )
    y = planes((0.0, 3 * mm), (0.5 * TALL, 0.3 * mm), (14e-3, 6 * mm), far)
    z = np.array([0.0, _SLICE])
    mid = np.meshgrid(*(0.5 * (v[1:] + v[:-1]) for v in (x, y, z)), indexing="ij")
    shell = (mid[0] > 1.5e-3) & (mid[0] < 13e-3) & (mid[1] < 14e-3)
    bar = (mid[0] > _NEAR) & (mid[0] < _FAR) & (mid[1] < 0.5 * TALL)
    region = np.where(bar, 0, np.where(shell, 1, 2))
    return box_tetrahedra(x, y, z, region, ("bar", "shell", "air"))


def _conductor_source(points: Floats) -> Floats:
    """T0 between the bars, falling to 0 across each: ±1 A along z."""
    field = np.zeros(points.shape)
    ramp = np.clip((_FAR - points[..., 0]) / THICK, 0.0, 1.0)
    field[..., 1] = np.where(points[..., 1] < 0.5 * TALL, ramp / TALL, 0.0)
    return field
