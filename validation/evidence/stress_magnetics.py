"""The normal actuator's models far beyond the device: they converge, or say why not.

Held against exact limits where there are any, else an answer's own error bar against a
finer solution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np

from tactgen.fem.magnetics.axisymmetric import FieldErrors, FieldPoint, solve_map, solve_point
from tactgen.fem.magnetics.problem_3d import MagneticSolid, ScalarPotential, VectorPotential, sample
from tactgen.geometry.device.magnetisation import MU0, TEAM20, MagnetisationCurve, linear
from tactgen.geometry.device.parameters import Device, Sleeve, Steel
from tactgen.geometry.formats import engineering
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh, team20_source
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.evidence.cases.ball import ball_error
from tactgen.validation.evidence.cases.coils import (
    INNER,
    OUTER,
    core_tolerance,
    flux_density_in_core,
    infinite_solenoid,
)
from tactgen.validation.evidence.judgement import Family

_GAPS = (1e-6, 1e-5, 1e-4, 0.4e-3, 1e-3, 5e-3)
_CURRENTS = np.array([1e-6, 1e-3, 0.13, 10.0, 1e3])
_STEELS = {
    f"µr {mu:g}": Steel(curve="linear", relative_permeability=mu) for mu in (1.0, 30.0, 1e3, 1e6)
} | {"steel": Steel(curve="team20")}


def _network_derivative(family: Family, _: bool) -> None:
    """Hold the full network's force against the slope of its own co-energy."""
    for (name, steel), gap in product(_STEELS.items(), _GAPS):
        with family.attempt():
            step = 1e-4 * gap
            gaps = gap + step * np.array([-1.0, 0.0, 1.0])
            found = network_samples(Device(steel=steel), _CURRENTS, gaps)
            assert found.coenergy is not None
            (low, middle, high), force = found.coenergy.T, found.force[:, 1]
            slope = (low - high) / (2.0 * step)
            # a dozen roundings of W' over the step, and the step squared
            bars = 12.0 * np.finfo(float).eps * middle / step + 1e-6 * np.abs(force)
            for current, *numbers in zip(_CURRENTS, slope, force, bars, strict=True):
                at = f"{engineering(gap, 'm', 3)}, {engineering(float(current), 'A', 3)}"
                family.compare(f"{name}, {at}", *numbers)


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


def _device(family: Family, quick: bool) -> None:
    """Hold a coarse grid's numbers and bars against a finer one over permeability, gap, current.

    Energy balance and straight iron's proportionality come with the same solutions.
    """
    gaps = (1e-6, 0.3e-3, 5e-3) if quick else (1e-6, 10e-6, 0.1e-3, 0.5e-3, 5e-3)
    currents = (1e-6, 0.13, 1e3) if quick else (1e-6, 1e-2, 0.13, 10.0, 1e3)
    order = 4 if quick else 5
    steels = ("µr 1", "µr 1e+06", "steel") if quick else tuple(_STEELS)
    for name, gap in product(steels, gaps):
        device = Device(sleeve=_WIDE, steel=_STEELS[name])
        where = f"{name}, {engineering(gap, 'm', 3)}"
        with family.attempt(of="co-energy"):
            finer = solve_map(device, [gap], currents, order=order, refinement=0.75)[0]
            coarse = []
            for current, exact in zip(currents, finer, strict=True):
                at = f"{where}, {engineering(current, 'A', 3)}"
                with family.attempt(of="co-energy"):
                    point = solve_point(device, current, gap, order=3, refinement=0.5)
                    coarse.append(point)
                    _covered(family, at, point, exact, pulls=name != "µr 1")
                    # W' is integrated apart from W
                    family.add(at, _imbalance(point), _BALANCE, of="iλ = W + W'")
            if name != "steel" and coarse:
                # one grid at all currents, and Newton's first step is exact: rounding remains
                ratios = np.array([p.coenergy / p.current**2 for p in coarse])
                spread = np.ptp(ratios) / np.abs(ratios).max()
                family.add(where, spread, 1e-9, of="W' ∝ i² in straight iron, relative spread")


def _covered(family: Family, at: str, point: FieldPoint, exact: FieldPoint, *, pulls: bool) -> None:
    for name, words in _QUANTITIES.items():
        bar_of = "force" if name == "force_eggshell" else name
        bar = getattr(point.errors, bar_of) + getattr(exact.errors, bar_of)
        if bar_of != "force":
            family.compare(at, getattr(point, name), getattr(exact, name), bar, of=words)
            continue
        if name == "force_eggshell":
            # the bar is that of the other route
            bar += abs(point.force - point.force_eggshell)
        size, known = point.coenergy / _WIDE.length, 0.0
        if pulls:
            # saturated, the force passes through zero: relative to what is stored, too
            size, known = max(size, abs(exact.force)), exact.force
        off = abs(getattr(point, name) - known) / size
        family.add(at, off, bar / size, of=words if pulls else "no iron, no pull")


def _imbalance(point: FieldPoint) -> float:
    """(W + W' − iλ)/(iλ) with W' integrated from the curves on its own."""
    assert point.solution is not None
    d = point.solution.discretisation
    magnitude = np.linalg.norm(point.solution.flux_density, axis=-1)
    density = magnitude**2 / (2.0 * MU0)
    for index, region in enumerate(d.grid.regions):
        if region.curve is not None:
            cells = d.cell_labels == index
            density[cells] = region.curve.coenergy_density(magnitude[cells])
    stored = point.solution.energy + float(np.sum(density * d.volumes))
    supplied = point.current * point.flux_linkage
    return abs(stored - supplied) / supplied


def _as_built(family: Family, quick: bool) -> None:
    """Go from coarse to fine on the device as it is, closing it and opening it too far."""
    ways = ((2, 0.25), (2, 1.0), (3, 0.5)) if quick else ((2, 0.25), (2, 2.0), (3, 0.5), (4, 1.0))
    for gap in (0.0, 2e-6, 0.2e-3, 2.5e-3) if quick else (0.0, 2e-6, 0.2e-3, 2e-3, 2.5e-3):
        with family.attempt():
            exact = solve_point(Device(), gap=gap, order=5)
            for order, fineness in ways:
                where = f"{engineering(gap, 'm', 3)}, order {order}, fineness {fineness:g}"
                with family.attempt():
                    point = solve_point(Device(), gap=gap, order=order, refinement=fineness)
                    for name in FieldErrors.__dataclass_fields__:
                        bar = getattr(point.errors, name) + getattr(exact.errors, name)
                        value, right = getattr(point, name), getattr(exact, name)
                        family.compare(f"{name}, {where}", value, right, bar)


def _narrow_gap(family: Family, _: bool) -> None:
    """Close the gap between perfect poles: F = Φ²/(2 µ0 A), Φ the flux into the sleeve's top."""
    device = Device(steel=Steel(curve="linear", relative_permeability=1e6))
    inner, outer = device.sleeve.collar_radius, device.sleeve.outer_radius
    for gap in (1e-7, 1e-6, 1e-5):
        point = solve_point(device, 1e-4, gap, order=3)
        assert point.solution is not None
        grid = point.solution.discretisation.grid
        # through the sleeve's top face, z = 0
        rings = [int(np.abs(grid.r - radius).argmin()) for radius in (inner, outer)]
        through = 2.0 * math.pi * point.solution.flux_function[rings, np.abs(grid.z).argmin()]
        flux = float(np.diff(through)[0])
        exact = flux**2 / (2.0 * MU0 * math.pi * (outer**2 - inner**2))
        # fringing widens the pole by about one gap at each edge
        bar = 2.0 * gap / (outer - inner) * exact + point.errors.force
        family.compare(engineering(gap, "m", 3), point.force, exact, bar)


def _long_core(family: Family, quick: bool) -> None:
    """Hold a long core against Ampère's law, at any permeability and current density."""
    curves: list[MagnetisationCurve] = [linear(10.0**k) for k in range(0, 7, 3 if quick else 2)]
    for curve, density in product([*curves, TEAM20], 10.0 ** np.arange(-3.0, 11.0, 3.0)):
        field = infinite_solenoid(float(density), curve)
        exact = float(curve.flux_density_at(np.array(density * (OUTER - INNER))))
        error = float(np.abs(flux_density_in_core(field) / exact - 1.0).max())
        where = f"{curve.name}, {engineering(float(density), 'A/m²', 3)}"
        family.add(where, error, core_tolerance(curve))


#: H = T0 linear in x, y, z, with curl and without divergence: within what the elements can do.
_TURN = np.array([[1.0, 2.0, -0.5], [0.3, -3.0, 1.0], [0.7, 0.2, 2.0]])
#: Newton's tolerance is 1e-7 of the energy norm; the balance is right to about that.
_SOLID_BALANCE = 1e-6


def _flat_boxes(family: Family, quick: bool) -> None:
    """Solve an exactly representable field by A on boxes as flat as asked for."""
    for aspect in (1.0, 1e2, 1e4) if quick else (1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6):
        even = np.linspace(0.0, 1.0, 4)
        flat = np.cumsum([0.0, 0.4, 0.2 / aspect, 0.4])
        mesh = box_tetrahedra(even, even, flat, np.zeros((3, 3, 3), int), ("air",))
        solid = sample(MagneticSolid(mesh, {}, lambda p: p @ _TURN.T, tuple(mesh.faces)))
        with family.attempt():
            field = VectorPotential(solid).solve(1.0)
            miss = np.abs(field.field_strength - solid.source).max() / np.abs(solid.source).max()
            # rounding: of the solver, and of derivatives across a flat box
            family.add(f"flatness {aspect:g}", float(miss), 1e-11 + 1e-14 * aspect)


def _ball(family: Family, quick: bool) -> None:
    """Hold a ball of any permeability in a uniform field between both potentials."""
    for permeability in 10.0 ** np.arange(0.0, 6.5, 3.0 if quick else 1.0):
        low, high = (
            ball_error(potential, 2, permeability=float(permeability))[0]
            for potential in (VectorPotential, ScalarPotential)
        )
        # the exact mean lies between, so neither is farther off than their distance
        bound = max(high - low, 0.0) + 1e-9
        family.add(f"µr {permeability:g}", max(abs(low), abs(high)), bound)


def _team20(family: Family, quick: bool) -> None:
    """Hold a coarse mesh's bracket of the co-energy against a finer mesh's, and iλ = W + W'."""
    bracket = "co-energy between A and φ"
    curves = {"µr 1": linear(1.0), "µr 1e6": linear(1e6), "steel": TEAM20}
    currents = (5e3, 1e6) if quick else (1e-6, 1e-3, 1.0, 5e3, 1e5, 1e6)
    for name, curve in curves.items():
        if quick and name == "µr 1":
            continue
        fine, coarse = (_solvers(scale, curve) for scale in (3.0, 4.0))
        for current in currents if name == "steel" else currents[:1]:
            where = f"{name}, {current:g} ampere-turns"
            with family.attempt(of=bracket):
                found, better = ([p.solve(current) for p in pair] for pair in (coarse, fine))
                low, high, below, above = (field.coenergy for field in (*found, *better))
                # negative half widths where the bounds have crossed
                bar = 0.5 * (high - low) + 0.5 * (above - below)
                middle, finer = 0.5 * (low + high), 0.5 * (below + above)
                family.compare(where, middle, finer, bar, of=bracket)
                for field, potential in zip(found, "Aφ", strict=True):
                    supplied = field.current * field.flux_linkage
                    off = abs(field.energy + field.coenergy - supplied) / supplied
                    family.add(f"{where}, {potential}", off, _SOLID_BALANCE, of="iλ = W + W'")


def _solvers(scale: float, curve: MagnetisationCurve) -> tuple[VectorPotential, ScalarPotential]:
    mesh = team20_mesh(Team20Meshing(scale=scale))
    solid = sample(MagneticSolid(mesh, {"pole": curve, "yoke": curve}, team20_source, copies=4))
    return VectorPotential(solid), ScalarPotential(solid)


_RANGES = "gaps 1 µm to 5 mm, 1 µA to 1 kA"
#: By title, with the range.
FAMILIES: dict[str, Callable[[Family, bool], None]] = {
    f"device: µr 1 to 1e6 and saturating steel, {_RANGES}; order 3, fineness 0.5, against finer":
        _device,
    "TEAM problem 20 in 3D: µr 1 to 1e6 and saturating steel, 1 µA to 1 MA-turns, coarse against "
    "fine": _team20,
    "device as built: gaps 0 to 2.5 mm, 130 mA; orders 2 to 4, fineness 0.25 to 2, against order 5":
        _as_built,
    "narrow gap: F = Φ²/(2 µ0 A), µr = 1e6, gaps 0.1 to 10 µm": _narrow_gap,
    "long core in a solenoid: µr 1 to 1e6 and saturating steel, 1e-3 to 1e9 A/m²; B of the curve "
    "at H = J (r2 − r1)": _long_core,
    "3D slivers: uniform curl, linear H, by A; boxes as flat as 1e6": _flat_boxes,
    "3D ball in a uniform field: µr 1 to 1e6, coarse (two intervals per edge); the exact mean B "
    "lies between A and φ": _ball,
    f"network, F = −∂W'/∂g: µr 1 to 1e6 and steel, {_RANGES}; central difference":
        _network_derivative,
}  # fmt: skip
