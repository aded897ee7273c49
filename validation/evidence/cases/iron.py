"""Bodies of iron with closed-form answers, by the scalar potential on tetrahedra.

A uniform field far away: a hollow ball shields, a spheroid is magnetised evenly.  A slot in one
of two facing iron surfaces takes permeance from the gap between them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import MagneticField
from tactgen.fem.magnetics.axisymmetric_force import virtual_work_force
from tactgen.fem.magnetics.problem_3d import MagneticSolid, ScalarPotential, sample
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.magnetisation import MU0, linear
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.spring_contact_guide import Spring
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, graded_planes
from tactgen.geometry.reluctance.section_grid import Region
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import Samples
from tactgen.tmm.reluctance.switching import Switching, switching
from tactgen.validation.evidence.case import Case, Check, case
from tactgen.validation.evidence.cases import ball
from tactgen.validation.evidence.cases.ball import RADIUS, sphere_mesh
from tactgen.validation.evidence.cases.coils import (
    between_windings,
    mutual_inductance,
    mutual_inductance_slope,
    winding_field,
)
from tactgen.validation.evidence.mesh_levels import cached, counted, intervals, size

_FIELD = "scalar potential, quadratic tetrahedra"
_PERMEABILITY = 1000.0
#: Radius of the outer wall; a body of radius 1 disturbs the field there by the cube of its inverse.
_WALL = 60.0


def _mean_in(mesh: Mesh, iron: str) -> float:
    """Mean of B_z in the ball of an eighth of a body in 1 A/m along z, over µ0 H0."""
    solid = ball.in_uniform_field(mesh, iron, linear(_PERMEABILITY))
    return ball.mean_in(ScalarPotential, solid) / MU0


# --- hollow ball -------------------------------------------------------------------------------

_OUTSIDE = 1.1


def _shell_mesh(n: int) -> Mesh:
    """Air in the ball, iron from radius 1 to 1.1, air beyond."""
    iron = np.linspace(RADIUS, _OUTSIDE, n // 2 + 1)
    beyond = np.geomspace(_OUTSIDE, _WALL, 4 * n + 1)
    mesh = sphere_mesh(n, curved=True, shells=np.concatenate([iron, beyond[1:]]))
    corners = np.linalg.norm(mesh.points[mesh.cells[:, :4]], axis=2)
    hull = (corners.min(axis=1) > RADIUS - 1e-9) & (corners.max(axis=1) < _OUTSIDE + 1e-9)
    region = np.where(hull, len(mesh.regions), mesh.region_of_cell)
    return replace(mesh, region_of_cell=region, regions=(*mesh.regions, "iron"))


_SHELL = case(
    "SHELL", "Hollow ball of iron in a uniform field",
    "Radii 1 and 1.1, µr = 1000, in a field that is uniform far away: B in the hollow over B far "
    "away.",
    [
        Check("The hollow is shielded to 1.78 % of the field.", 0.0178085173, "1",
               lambda: _mean_in(_shell_mesh(intervals(4)), "iron")),
    ],
    model=_FIELD + " on an eighth, curved, to 60 radii",
    source="J. D. Jackson, Classical Electrodynamics, 3rd ed., eq. 5.121", tolerance=1e-3,
    reason="the mesh, by its own refinement: 0.06 %, which 2/3 of the size makes a fifth",
)  # fmt: skip

# --- spheroid ----------------------------------------------------------------------------------


def _factor(ratio: float, finest: int) -> float:
    """N from B = µr H0 µ0 / (1 + N (µr − 1)), on so many intervals along an edge."""
    n = intervals(finest)
    round_mesh = sphere_mesh(n, curved=True, shells=np.geomspace(RADIUS, _WALL, 4 * n + 1))
    mesh = replace(round_mesh, points=round_mesh.points * [1.0, 1.0, ratio])
    inside = _mean_in(mesh, "ball")
    return (_PERMEABILITY / inside - 1.0) / (_PERMEABILITY - 1.0)


_SPHEROID = case(
    "SPHEROID", "Spheroid of iron in a uniform field along its axis",
    "Twice and four times as long as thick, µr = 1000: the demagnetising factor that follows from "
    "B inside.",
    [
        Check(f"The factor is Osborn's at {ratio:g} : 1.", value, "1", partial(_factor, ratio, n),
               heavy=n > 4)
        for ratio, value, n in ((2.0, 0.173564, 4), (4.0, 0.0754072, 6))
    ],
    model=_FIELD + " on an eighth of a stretched ball, curved, to 60 radii",
    source="J. A. Osborn, Demagnetizing factors of the general ellipsoid, Phys. Rev. 67 (1945)",
    tolerance=5e-3,
    reason="the mesh, by its own refinement: 0.2 % at 2 : 1, 0.3 % on the finer one at 4 : 1",
)  # fmt: skip

# --- slot --------------------------------------------------------------------------------------

_DEEP, _WIDE, _IRON = 3.0, 5.0, 1.0
_STEEL = 1e7


def _slot_mesh(ratio: float) -> Mesh:
    """Half a slot of width `ratio` in the upper of two iron faces, a gap of 1 apart."""
    edge = 0.5 * ratio
    finest, coarse, growth = (size(wanted) for wanted in (1e-3, 0.2, 0.5))
    x = graded_planes([(0.0, coarse), (edge, finest), (edge + _WIDE, coarse)], growth=growth)
    top = 1.0 + _DEEP * ratio
    z = graded_planes(
        [(-_IRON, 1.0), (0.0, coarse), (1.0, finest), (top, coarse), (top + _IRON, 1.0)],
        growth=growth,
    )
    mid_x, mid_z = np.meshgrid(0.5 * (x[1:] + x[:-1]), 0.5 * (z[1:] + z[:-1]), indexing="ij")
    slot = (mid_x < edge) & (mid_z > 1.0) & (mid_z < top)
    gap = (mid_z > 0.0) & (mid_z < 1.0)
    region = np.where(gap, 1, np.where(slot, 2, 0))
    return box_tetrahedra(x, np.array([0.0, 0.2]), z, region[:, None], ("iron", "gap", "slot"))


def _across_the_gap(points: Floats) -> Floats:
    """T0: 1 A between the iron faces."""
    field = np.zeros(points.shape)
    field[..., 2] = (points[..., 2] > 0.0) & (points[..., 2] < 1.0)
    return field


def _slot(ratio: float) -> float:
    """Σ from the permeance."""
    potential = ScalarPotential(sample(MagneticSolid(
        _slot_mesh(ratio), {"iron": linear(_STEEL)}, _across_the_gap,
        flux_normal=("z_low", "z_high"),
    )))  # fmt: skip
    counted(potential.size)
    permeance = 2.0 * potential.solve(1.0).coenergy / (MU0 * 0.2)
    return 2.0 * (0.5 * ratio + _WIDE - permeance) / ratio


_CARTER = case(
    "CARTER", "Gap below a slot",
    "Two facing iron faces, in one of them a deep slot 0.5, 1, 2 and 5 times as wide as the gap: "
    "the share of the slot's width by which the gap seems narrower.",
    [
        Check(f"Carter's σ at b/g = {ratio:g}.", value, "1", partial(_slot, ratio))
        for ratio, value in (
            (0.5, 0.0787685949), (1.0, 0.153109638), (2.0, 0.2793644), (5.0, 0.505533176),
        )
    ],
    model=_FIELD + " on a slice, intervals of 1/1000 of the gap at the slot's edge",
    source="F. W. Carter (1901), by conformal mapping", tolerance=5e-4,
    reason="the mesh at the edge, where B has no bound: 0.02 %, ten times that at ten times the "
    "size",
)  # fmt: skip


_TURNS, _AREA, _GAP, _STIFFNESS = 500.0, 4e-6, 0.2e-3, 100.0


@cache
def _snap() -> Switching:
    """When a rod on a spring without preload snaps: W' = µ0 N² A i²/(2 g)."""
    strength = MU0 * _TURNS**2 * _AREA
    current, gap = np.linspace(0.0, 0.03, 9), np.geomspace(0.015e-3, 0.25e-3, 48)
    inductance: Floats = np.tile(strength / gap, (current.size, 1))
    linkage = inductance * current[:, None]
    samples = Samples(
        current, gap, linkage, 0.5 * linkage**2 / strength, 0.5 * current[:, None] * linkage,
        inductance,
    )  # fmt: skip
    spring = Spring(preload=0.0, stiffness=_STIFFNESS, stop_gap=20e-6)
    return switching(Device(spring=spring, gap=_GAP), fit(samples))


_SNAP = case(
    "SNAP", "Rod that snaps across an ideal gap",
    "500 turns, a gap of 0.2 mm and 4 mm², iron without resistance, a spring of 100 N/m without "
    "preload: the current at which it snaps, and how far it had moved.",
    [
        Check("It snaps at 13.734 mA.", 0.0137341938, "A", lambda: _snap().pull_in),
        Check("It had moved by a third of the gap.", _GAP / 3.0, "m",
              lambda: _GAP - _snap().pull_in_gap, 5e-3,
              "the current is at a maximum there: an error ε of the place costs it only ε², so the "
              "place is known to the root of the current's error at best, √(1e-5) = 3e-3"),
    ],
    model="a co-energy map of samples of µ0 N² A i²/(2 g), and the model's switching",
    source="I² = 8 k g³/(27 µ0 N² A) at a third of the gap (the twin of electrostatic pull-in)",
    tolerance=1e-3, reason="the map's cubics over 48 gaps",
)  # fmt: skip


def _ring(height: float) -> Region:
    return Region("ring", (0.19, 0.21), (height - 0.01, height + 0.01), turns=1.0, moves=True)


def _image(function: Callable[[Floats, Floats, Floats], Floats]) -> float:
    """Mutual inductance of ring and image, or its slope, with the image's share."""
    share = (_PERMEABILITY - 1.0) / (_PERMEABILITY + 1.0)
    return share * between_windings(_ring(-0.05), _ring(0.05), function)


@cached
def _above(permeability: float) -> MagneticField:
    """Field of 1 A above a body of this permeability, 1 for none, walls at a hundred radii."""
    walls = 20.0
    below = Region("iron", (0.0, walls), (-walls, 0.0), linear(permeability))
    return winding_field((_ring(0.05), below), (1.0,), walls)


_IMAGE = case(
    "IMAGE", "Ring winding above a half-space of iron",
    "One turn of 1 A on a section of 20 x 20 mm, mean radius 0.2 m, its middle 50 mm above iron of "
    "µr = 1000.",
    [
        Check("The iron adds the image's mutual inductance.", _image(mutual_inductance), "H",
              lambda: float((_above(_PERMEABILITY).flux_linkage - _above(1.0).flux_linkage)[0])),
        Check("The iron pulls as the image does.", _image(mutual_inductance_slope), "N",
              lambda: virtual_work_force(_above(_PERMEABILITY))),
    ],
    model="axisymmetric field, quadrilaterals of order 4 on a graded grid, walls at a hundred "
    "radii",
    source="image current (µr − 1)/(µr + 1) (J. D. Jackson, Classical Electrodynamics, 3rd ed., "
    "ch. 5), by Maxwell's elliptic integrals over both sections",
    tolerance=1e-5, reason="the mesh and walls at a hundred radii, 2e-6 each",
)  # fmt: skip


CASES: tuple[Case, ...] = (_SHELL, _SPHEROID, ball.CASE, _CARTER, _IMAGE, _SNAP)
