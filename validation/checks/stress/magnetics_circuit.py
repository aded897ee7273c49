"""The reluctance network far beyond the device, and input that no model of it may answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np

from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.fem.magnetics.axisymmetric_field import solve_field
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.fem.magnetics.problem_3d import MagneticSolid
from tactgen.geometry.device.parameters import Device, Steel
from tactgen.geometry.device.steel_law import MagnetisationCurve, linear
from tactgen.geometry.formats import engineering
from tactgen.geometry.reluctance.section_grid import Region, graded_grid
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh, team20_source
from tactgen.tmm.reluctance.circuit import ONE_GAP
from tactgen.tmm.reluctance.network import network_samples, textbook_force
from tactgen.validation.checks.cases.magnetics.collared_actuator import COLLARED, collared
from tactgen.validation.checks.stress.answers import REFUSALS, Family
from tactgen.validation.checks.stress.result import Row, answered

_GAPS = (1e-6, 1e-5, 1e-4, 0.4e-3, 1e-3, 5e-3)
_CURRENTS = np.array([1e-6, 1e-3, 0.13, 10.0, 1e3])
_STEELS = {
    f"µr {mu:g}": Steel(curve="linear", relative_permeability=mu) for mu in (1.0, 1e3, 1e6)
} | {"steel": Steel()}


def network_rows(_: bool) -> list[Row]:
    """Hold the bare network against the formula and the full one against its own co-energy."""
    formula, derivative = Family(), Family()
    for gap in _GAPS:
        try:
            bare = network_samples(Device(), _CURRENTS, np.array([gap]), ONE_GAP).force[:, 0]
        except REFUSALS as error:
            formula.refuse(error)
            continue
        for current, force in zip(_CURRENTS, bare, strict=True):
            where = f"{engineering(gap, 'm', 3)}, {engineering(float(current), 'A', 3)}"
            formula.compare(where, force, (f := textbook_force(Device(), current, gap)), 1e-12 * f)
    for (name, steel), gap in product(_STEELS.items(), _GAPS):
        try:
            _difference_quotient(derivative, name, Device(steel=steel), gap)
        except REFUSALS as error:
            derivative.refuse(error)
    ranges = "gaps 1 µm to 5 mm, 1 µA to 1 kA"
    return [
        answered(
            "network: one gap", f"{ranges}; F = µ0 N² i² A/(2 g²)",
            formula.points, formula.refusals,
        ),
        answered(
            "network: F = −∂W'/∂g", f"µr 1 to 1e6 and steel, {ranges}; central difference",
            derivative.points, derivative.refusals,
        ),
    ]  # fmt: skip


def _difference_quotient(family: Family, name: str, device: Device, gap: float) -> None:
    step = 1e-4 * gap
    found = network_samples(device, _CURRENTS, gap + step * np.array([-1.0, 0.0, 1.0]))
    assert found.coenergy is not None
    low, middle, high = found.coenergy.T
    slope = (low - high) / (2.0 * step)
    # a dozen roundings of W' over the step, and the step squared
    bars = 12.0 * np.finfo(float).eps * middle / step + 1e-6 * np.abs(found.force[:, 1])
    for current, force, quotient, bar in zip(
        _CURRENTS, found.force[:, 1], slope, bars, strict=True
    ):
        where = f"{name}, {engineering(gap, 'm', 3)}, {engineering(float(current), 'A', 3)}"
        family.compare(where, quotient, force, bar)


def refused_row(_: bool) -> Row:
    """Ask for what has no answer; a number in return is a failure."""
    family = Family()
    for what, ask in _IMPOSSIBLE.items():
        try:
            ask()
        except REFUSALS as error:
            family.refuse(error)
        else:
            family.add(f"{what} was answered", np.inf, 0.0)
    return answered("no answer exists", ", ".join(_IMPOSSIBLE), family.points, family.refusals)


def _upside_down() -> None:
    curve = MagnetisationCurve(np.array([0.0, 1.0]), np.array([0.0, -1e6]), -1e6)
    parts = (
        Region("core", (0.0, 2e-3), (0.0, 5e-3), curve),
        Region("coil", (2.5e-3, 4e-3), (1e-3, 4e-3), turns=100.0),
    )
    solve_field(discretise(graded_grid(parts, 0.1), 2), np.ones(1))


def _hexahedra() -> None:
    mesh = replace(team20_mesh(Team20Meshing(scale=4.0)), kind="hexahedron")
    MagneticSolid(mesh, {}, team20_source)


_IMPOSSIBLE: dict[str, Callable[[], object]] = {
    "a closed gap": lambda: solve_point(Device(), gap=0.0),
    "a negative gap": lambda: solve_point(Device(), gap=-1e-4),
    "flange against collar": lambda: solve_point(COLLARED, gap=2.4e-3),
    "flange in collar": lambda: solve_point(COLLARED, gap=2.5e-3),
    "flange beyond collar": lambda: solve_point(COLLARED, gap=5e-3),
    "coil in head": lambda: solve_point(collared(coil={"position": -1e-3})),
    "coil in collar": lambda: solve_point(collared(coil={"outer_radius": 0.93e-3}), gap=0.4e-3),
    "order 1 with an error bar": lambda: solve_point(Device(), order=1),
    "µr below 1": lambda: linear(0.5),
    "µr nan": lambda: linear(float("nan")),
    "H falling with B": _upside_down,
    "hexahedra": _hexahedra,
}
