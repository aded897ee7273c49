"""3D magnetic fields by both potentials: slivers, any permeability, any current."""

from __future__ import annotations

import numpy as np

from tactgen.fem.magnetics.problem_3d import MagneticField, MagneticSolid, sample
from tactgen.fem.magnetics.scalar_potential import ScalarPotential
from tactgen.fem.magnetics.vector_potential import VectorPotential
from tactgen.geometry.device.steel_law import TEAM20, MagnetisationCurve, linear
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh, team20_source
from tactgen.validation.checks.cases.magnetics.sphere_in_field import ball_error
from tactgen.validation.checks.stress.answers import REFUSALS, Family
from tactgen.validation.checks.stress.result import Row, answered

#: H = T0 linear in x, y, z, with curl and without divergence: within what the elements can do.
_TURN = np.array([[1.0, 2.0, -0.5], [0.3, -3.0, 1.0], [0.7, 0.2, 2.0]])
#: Newton's tolerance is 1e-7 of the energy norm; the balance is right to about that.
_BALANCE = 1e-6


def sliver_row(quick: bool) -> Row:
    """Solve an exactly representable field by A on boxes as flat as asked for."""
    family = Family()
    for aspect in (1.0, 1e2, 1e4) if quick else (1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6):
        mesh = _slivers(aspect)
        solid = sample(MagneticSolid(mesh, {}, lambda p: p @ _TURN.T, tuple(mesh.faces)))
        try:
            field = VectorPotential(solid).solve(1.0)
        except REFUSALS as error:
            family.refuse(error)
            continue
        miss = np.abs(field.field_strength - solid.source).max() / np.abs(solid.source).max()
        # rounding: of the solver, and of derivatives across a flat box
        family.add(f"flatness {aspect:g}", float(miss), 1e-11 + 1e-14 * aspect)
    what = "uniform curl, linear H, by A; boxes as flat as 1e6"
    return answered("3D slivers: linear field", what, family.points, family.refusals)


def _slivers(aspect: float) -> Mesh:
    even = np.linspace(0.0, 1.0, 4)
    flat = np.cumsum([0.0, 0.4, 0.2 / aspect, 0.4])
    return box_tetrahedra(even, even, flat, np.zeros((3, 3, 3), int), ("air",))


def ball_row(quick: bool) -> Row:
    """Hold a ball of any permeability in a uniform field between both potentials."""
    family = Family()
    for permeability in 10.0 ** np.arange(0.0, 6.5, 3.0 if quick else 1.0):
        low, high = (
            ball_error(potential, 2, permeability=float(permeability))[0]
            for potential in (VectorPotential, ScalarPotential)
        )
        # the exact mean lies between, so neither is farther off than their distance
        bound = max(high - low, 0.0) + 1e-9
        family.add(f"µr {permeability:g}", max(abs(low), abs(high)), bound)
    what = "µr 1 to 1e6, coarse (two intervals per edge); the exact mean B lies between A and φ"
    return answered("3D ball in a uniform field", what, family.points)


def team20_rows(quick: bool) -> list[Row]:
    """Hold a coarse mesh's bracket of the co-energy against a finer mesh's, and iλ = W + W'."""
    bracket, balance = Family(), Family()
    curves = {"µr 1": linear(1.0), "µr 1e6": linear(1e6), "steel": TEAM20}
    currents = (5e3, 1e6) if quick else (1e-6, 1e-3, 1.0, 5e3, 1e5, 1e6)
    for name, curve in curves.items():
        if quick and name == "µr 1":
            continue
        fine, coarse = (_solvers(scale, curve) for scale in (3.0, 4.0))
        for current in currents if name == "steel" else currents[:1]:
            where = f"{name}, {current:g} ampere-turns"
            try:
                found, better = ([p.solve(current) for p in pair] for pair in (coarse, fine))
            except REFUSALS as error:
                bracket.refuse(error)
                continue
            (middle, half), (exact, rest) = _bracket(found), _bracket(better)
            bracket.compare(where, middle, exact, half + rest)
            for field, potential in zip(found, "Aφ", strict=True):
                balance.add(f"{where}, {potential}", _imbalance(field), _BALANCE)
    what = "µr 1 to 1e6 and saturating steel, 1 µA to 1 MA-turns"
    return [
        answered(
            "3D co-energy between A and φ", f"{what}; coarse bracket against a finer mesh's",
            bracket.points, bracket.refusals,
        ),
        answered("3D energy balance", f"{what}; iλ = W + W'", balance.points),
    ]  # fmt: skip


def _solvers(scale: float, curve: MagnetisationCurve) -> tuple[VectorPotential, ScalarPotential]:
    mesh = team20_mesh(Team20Meshing(scale=scale))
    solid = sample(MagneticSolid(mesh, {"pole": curve, "yoke": curve}, team20_source, copies=4))
    return VectorPotential(solid), ScalarPotential(solid)


def _bracket(fields: list[MagneticField]) -> tuple[float, float]:
    """Return the middle and the half width; negative where the bounds have crossed."""
    low, high = (field.coenergy for field in fields)
    return 0.5 * (low + high), 0.5 * (high - low)


def _imbalance(field: MagneticField) -> float:
    supplied = field.current * field.flux_linkage
    return abs(field.energy + field.coenergy - supplied) / supplied
