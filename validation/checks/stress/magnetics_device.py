"""The normal actuator's axisymmetric field, far beyond the device: error bars and exact limits."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from tactgen.fem.magnetics.axisymmetric import (
    FieldErrors,
    FieldPoint,
    solve_map,
    solve_point,
)
from tactgen.fem.magnetics.axisymmetric_field import MagneticField
from tactgen.geometry.device.parameters import Device, Sleeve, Steel
from tactgen.geometry.device.steel_law import MU0, TEAM20, MagnetisationCurve, linear
from tactgen.geometry.formats import engineering
from tactgen.validation.checks.cases.magnetics.infinite_solenoid import (
    INNER,
    OUTER,
    core_tolerance,
    flux_density_in_core,
    infinite_solenoid,
)
from tactgen.validation.checks.stress.answers import REFUSALS, Family, spread
from tactgen.validation.checks.stress.result import Row, answered

#: Steels: linear by their µr, and the saturating one.
_STEELS = {
    f"µr {mu:g}": Steel(curve="linear", relative_permeability=mu) for mu in (1.0, 30.0, 1e3, 1e6)
} | {"steel": Steel(curve="team20")}
#: A collar through which the flange can leave, so that gaps up to 5 mm exist.
_WIDE = Sleeve(collar_radius=0.95e-3)
#: The largest Newton decrement, relative to the energy, at which the field counts as solved.
_BALANCE = 1e-6
_QUANTITIES = {
    "flux_linkage": "flux linkage",
    "coenergy": "co-energy",
    "force": "force by virtual work",
    "force_eggshell": "force by stress",
    "incremental_inductance": "incremental inductance",
}


def device_rows(quick: bool) -> list[Row]:
    """Hold a coarse grid's numbers and bars against a finer one over permeability, gap, current.

    Energy balance and straight iron's proportionality come with the same solutions.
    """
    gaps = (1e-6, 0.3e-3, 5e-3) if quick else (1e-6, 10e-6, 0.1e-3, 0.5e-3, 5e-3)
    currents = (1e-6, 0.13, 1e3) if quick else (1e-6, 1e-2, 0.13, 10.0, 1e3)
    order = 4 if quick else 5
    steels = ("µr 1", "µr 1e+06", "steel") if quick else tuple(_STEELS)
    families = {name: Family() for name in (*_QUANTITIES, "balance", "straight", "no pull")}
    for name, gap in product(steels, gaps):
        device = Device(sleeve=_WIDE, steel=_STEELS[name])
        where = f"{name}, {engineering(gap, 'm', 3)}"
        try:
            finer = solve_map(device, [gap], currents, order=order, refinement=0.75)[0]
        except REFUSALS as error:
            families["coenergy"].refuse(error)
            continue
        coarse = []
        for current, exact in zip(currents, finer, strict=True):
            at = f"{where}, {engineering(current, 'A', 3)}"
            try:
                point = solve_point(device, current, gap, order=3, refinement=0.5)
            except REFUSALS as error:
                families["coenergy"].refuse(error)
                continue
            coarse.append(point)
            _covered(families, at, point, exact, pulls=name != "µr 1")
            families["balance"].add(at, _imbalance(point), _BALANCE)
        if name != "steel" and coarse:
            # one grid at all currents, and Newton's first step is exact: rounding remains
            ratios = spread(p.coenergy / p.current**2 for p in coarse)
            families["straight"].add(where, ratios, 1e-9)
    ranges = "µr 1 to 1e6 and saturating steel, gaps 1 µm to 5 mm, 1 µA to 1 kA"
    rows = [
        answered(
            f"device: {words}", f"{ranges}; coarse (order 3, fineness 0.5) against order {order}",
            families[name].points, families[name].refusals,
        )
        for name, words in _QUANTITIES.items()
    ]  # fmt: skip
    others = (
        ("balance", "device: iλ = W + W'", f"{ranges}; W' integrated apart from W"),
        ("straight", "device: W' ∝ i² in straight iron", "1 µA to 1 kA, relative spread of W'/i²"),
        ("no pull", "device: no iron, no pull", "µr = 1; force times sleeve length over W'"),
    )
    return rows + [answered(words, what, families[name].points) for name, words, what in others]


def _covered(
    families: dict[str, Family], at: str, point: FieldPoint, exact: FieldPoint, *, pulls: bool
) -> None:
    for name in _QUANTITIES:
        bar_of = "force" if name == "force_eggshell" else name
        bar = getattr(point.errors, bar_of) + getattr(exact.errors, bar_of)
        if bar_of != "force":
            families[name].compare(at, getattr(point, name), getattr(exact, name), bar)
            continue
        if name == "force_eggshell":
            # the bar is that of the other route
            bar += abs(point.force - point.force_eggshell)
        size = point.coenergy / _WIDE.length
        if pulls:
            # saturated, the force passes through zero: relative to what is stored, too
            size = max(size, abs(exact.force))
            families[name].add(at, abs(getattr(point, name) - exact.force) / size, bar / size)
        else:
            families["no pull"].add(at, abs(getattr(point, name)) / size, bar / size)


def _imbalance(point: FieldPoint) -> float:
    """Return (W + W' − iλ)/(iλ) with W' integrated from the curves on its own."""
    assert point.solution is not None
    supplied = point.current * point.flux_linkage
    stored = point.solution.energy + _integrated_coenergy(point.solution)
    return abs(stored - supplied) / supplied


def _integrated_coenergy(field: MagneticField) -> float:
    d = field.discretisation
    magnitude = np.linalg.norm(field.flux_density, axis=-1)
    density = magnitude**2 / (2.0 * MU0)
    for index, region in enumerate(d.grid.regions):
        if region.curve is not None:
            cells = d.cell_labels == index
            density[cells] = region.curve.coenergy_density(magnitude[cells])
    return float(np.sum(density * d.volumes))


def as_built_row(quick: bool) -> Row:
    """Go from coarse to fine on the device as it is, closing it and opening it too far."""
    family = Family()
    ways = ((2, 0.25), (2, 1.0), (3, 0.5)) if quick else ((2, 0.25), (2, 2.0), (3, 0.5), (4, 1.0))
    names = tuple(FieldErrors.__dataclass_fields__)
    for gap in (0.0, 2e-6, 0.2e-3, 2.5e-3) if quick else (0.0, 2e-6, 0.2e-3, 2e-3, 2.5e-3):
        try:
            exact = solve_point(Device(), gap=gap, order=5)
        except REFUSALS as error:
            family.refuse(error)
            continue
        for order, fineness in ways:
            try:
                point = solve_point(Device(), gap=gap, order=order, refinement=fineness)
            except REFUSALS as error:
                family.refuse(error)
                continue
            for name in names:
                bar = getattr(point.errors, name) + getattr(exact.errors, name)
                where = f"{name}, {engineering(gap, 'm', 3)}, order {order}, fineness {fineness:g}"
                family.compare(where, getattr(point, name), getattr(exact, name), bar)
    what = "gaps 0 to 2.5 mm, 130 mA; orders 2 to 4, fineness 0.25 to 2, against order 5"
    return answered("device as built: coarse to fine", what, family.points, family.refusals)


def narrow_gap_row(_: bool) -> Row:
    """Close the gap between perfect poles: F = Φ²/(2 µ0 A), Φ the flux into the sleeve's top."""
    device = Device(steel=Steel(curve="linear", relative_permeability=1e6))
    inner, outer = device.sleeve.collar_radius, device.sleeve.outer_radius
    family = Family()
    for gap in (1e-7, 1e-6, 1e-5):
        point = solve_point(device, 1e-4, gap, order=3)
        exact = _top_flux(point, inner, outer) ** 2 / (2.0 * MU0 * math.pi * (outer**2 - inner**2))
        # fringing widens the pole by about one gap at each edge
        bar = 2.0 * gap / (outer - inner) * exact + point.errors.force
        family.compare(engineering(gap, "m", 3), point.force, exact, bar)
    return answered("narrow gap: F = Φ²/(2 µ0 A)", "µr = 1e6, gaps 0.1 to 10 µm", family.points)


def _top_flux(point: FieldPoint, inner: float, outer: float) -> float:
    """Return the flux through the sleeve's top face, z = 0 (Wb)."""
    assert point.solution is not None
    grid = point.solution.discretisation.grid
    at = int(np.abs(grid.z).argmin())
    rings = [int(np.abs(grid.r - radius).argmin()) for radius in (inner, outer)]
    through = 2.0 * math.pi * point.solution.flux_function[rings, at]
    return float(through[1] - through[0])


def solenoid_row(quick: bool) -> Row:
    """Hold a long core against Ampère's law, at any permeability and current density."""
    curves: list[MagnetisationCurve] = [linear(10.0**k) for k in range(0, 7, 3 if quick else 1)]
    family, thickness = Family(), OUTER - INNER
    for curve, density in product([*curves, TEAM20], 10.0 ** np.arange(-3.0, 11.0, 3.0)):
        field = infinite_solenoid(float(density), curve)
        exact = float(curve.flux_density_at(np.array(density * thickness)))
        error = float(np.abs(flux_density_in_core(field) / exact - 1.0).max())
        where = f"{curve.name}, {engineering(float(density), 'A/m²', 3)}"
        family.add(where, error, core_tolerance(curve))
    what = "µr 1 to 1e6 and saturating steel, 1e-3 to 1e9 A/m²; B of the curve at H = J (r2 − r1)"
    return answered("long core in a solenoid", what, family.points)
