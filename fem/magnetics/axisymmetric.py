"""The reconstructed normal actuator by the axisymmetric field: flux, coenergy, force, error bars.

A point is one current at one gap; a map shares one grid between gaps and starts each
point from the last.  Field theory is in :mod:`fem.magnetics.axisymmetric_field`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import MagneticField, truncation_error
from tactgen.fem.magnetics.axisymmetric_force import eggshell_force, stress_size, virtual_work_force
from tactgen.fem.magnetics.axisymmetric_space import share_beyond_table
from tactgen.fem.magnetics.error_estimate import (
    Pair,
    Start,
    TwoOrders,
    fitted,
    from_neighbour,
    solve_pair,
    two_orders,
)
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import CoarseGridError, InputError
from tactgen.geometry.reluctance.section_grid import actuator_regions

#: Polynomial order that gives the accuracy wanted in the least time on this device.
ORDER = 4
#: Relative truncation of the force over that of the coenergy: up to 6 was measured on this
#: device, most at narrow gaps in saturation (flux linkage: never above 1, 2 is taken).
_FORCE_TRUNCATION = 8.0
#: Force's error over its change from the lower order: up to 1.2 was seen (orders 3 to 5 at 2 µm),
#: where the gap's corners are narrower than any cell and the order alone must resolve them.  A
#: corner of iron leaves the order p an error of p^(-8/3): the change at order 5 is 0.8 of it.
_FORCE_CHANGE = 1.25
#: Co-energy's error bar, relative, above which the next order would change everything: neither
#: the values nor their bars mean anything then.  The program's grids stay below 2e-2.
_TOO_COARSE = 0.2
#: dH/dB has corners at the curve's points and a jump at its end, which quadrature points meet by
#: chance, at both orders alike.  In saturation up to 1.2 % of scatter in the incremental
#: inductance was seen over grids and the map; 2 % is taken, less where the steel is linear.
_INDUCTANCE_SCATTER = 0.02


@dataclass(frozen=True)
class FieldErrors:
    """Numerical error bars, each in the unit of its quantity."""

    flux_linkage: float
    coenergy: float
    force: float
    incremental_inductance: float


@dataclass(frozen=True)
class FieldPoint:
    """The actuator at one current and gap."""

    current: float  #: A
    gap: float  #: m
    flux_linkage: float  #: λ (Wb)
    coenergy: float  #: W' = iλ − W (J)
    #: Pull −∂W'/∂g (N); positive closes the gap.  By virtual work, which converges fastest and is
    #: the derivative of `coenergy`
    force: float
    force_eggshell: float  #: The same from the stress in the air (N)
    incremental_inductance: float  #: ∂λ/∂i (H)
    errors: FieldErrors  #: How far the values may be from the exact field of the same model
    iterations: int  #: Newton steps at the final order
    unknowns: int
    beyond_table: float  #: Share of the iron's volume beyond a magnetisation curve that ends early
    #: The values by the lower order
    coarser: dict[str, float] = field(default_factory=dict, repr=False, compare=False)
    #: The field itself; None in a map
    solution: MagneticField | None = field(default=None, repr=False, compare=False)

    @property
    def inductance(self) -> float:
        """Apparent inductance λ/i (H), its limit at zero current."""
        return self.flux_linkage / self.current if self.current else self.incremental_inductance


def solve_point(
    device: Device,
    current: float | None = None,
    gap: float | None = None,
    *,
    order: int = ORDER,
    refinement: float = 1.0,
    outer_radius: float | None = None,
    any_grid: bool = False,
) -> FieldPoint:
    """Solve the actuator's field at one current (A) and gap (m), by default those of the device.

    `order` is the polynomials', at least 2; `refinement` is the fineness of the grid, see
    :func:`geometry.reluctance.section_grid.graded_grid`, `outer_radius` (m) the radius and half
    height of the air, see :func:`geometry.reluctance.section_grid.air_radius`.  With `any_grid` a
    grid too coarse for error bars gives an answer, too: to see how the error falls.

    Raises InputError if the parts do not fit at this gap, or the grid is too coarse for any answer,
    SolverError if the field does not converge.
    """
    current = device.coil.current if current is None else current
    gap = device.gap if gap is None else gap
    model = two_orders(device, gap, order, refinement, outer_radius)
    return field_point(model, solve_pair(model, current), keep=True, any_grid=any_grid)


def solve_map(
    device: Device,
    gaps: Sequence[float],
    currents: Sequence[float],
    *,
    order: int = ORDER,
    refinement: float = 1.0,
    any_grid: bool = False,
) -> tuple[tuple[FieldPoint, ...], ...]:
    """Solve the actuator's field for all gaps (m) and currents (A); rows are gaps, as given.

    The grid made for the widest gap moves with the rod until an edge would pass another
    or a cell would become too high.  Parameters and errors as in :func:`solve_point`.
    """
    for gap in gaps:
        actuator_regions(device, gap)  # refuses before anything is solved
    rows: dict[float, tuple[FieldPoint, ...]] = {}
    home: TwoOrders | None = None
    last: Pair | None = None
    for gap in sorted(set(gaps), reverse=True):
        model = home and fitted(home, device, gap)
        if model is None:
            model = home = two_orders(device, gap, order, refinement)
            last = None
        found, first = {}, None
        for current in sorted(set(currents), key=abs):
            start = from_neighbour(last, current) if last else None
            last = solve_pair(model, current, start)
            found[current] = field_point(model, last, any_grid=any_grid)
            first = first or last
        last = first
        rows[gap] = tuple(found[current] for current in currents)
    return tuple(rows[gap] for gap in gaps)


def field_point(
    model: TwoOrders, pair: Pair, *, keep: bool = False, any_grid: bool = False
) -> FieldPoint:
    """Field values at a point with errors; `keep` keeps the field itself.

    Raises CoarseGridError if the grid is too coarse for error bars, unless `any_grid`.
    """
    fine, d = pair.fine, model.fine
    values, lower = _values(model, fine), _values(model, pair.coarse)
    errors = _errors(fine, values, lower, stress_size(fine, model.weight))
    if errors.coenergy > _TOO_COARSE * abs(values["coenergy"]) and not any_grid:
        raise CoarseGridError(
            f"the field's grid is too coarse at gap = {model.gap * 1e3:g} mm and coil.current = "
            f"{float(fine.currents[0]) * 1e3:g} mA: the co-energy's error bar is "
            f"{100.0 * errors.coenergy / abs(values['coenergy']):.0f} % of it; widen the "
            "narrowest clearance: gap, spring.stop_gap, or what the sleeve's bore leaves around "
            "rod.flange_radius"
        )
    return FieldPoint(
        current=float(fine.currents[0]),
        gap=model.gap,
        **values,
        errors=errors,
        iterations=fine.iterations,
        unknowns=d.free.size,
        beyond_table=share_beyond_table(d.iron, fine.flux_density, d.volumes),
        coarser=lower,
        solution=fine if keep else None,
    )


def _errors(
    fine: MagneticField, values: dict[str, float], lower: dict[str, float], stress: float
) -> FieldErrors:
    """Error bars: the change from the lower order, never less than the coenergy's.

    The coenergy rises with the order towards its exact value, so its change cannot vanish
    by accident, as that of a force can.  The force counts with no less than what its two routes
    differ by, which has the same cause; its shares are of the `stress` (N) that adds up to it,
    since a force may cancel to nothing.  Truncation is added, and to the incremental inductance the
    scatter of dH/dB.
    """
    total = values["coenergy"]
    rise = abs(total - lower["coenergy"]) / total if total else 0.0
    missing = truncation_error(fine) / total if total else 0.0

    def bar(name: str, truncation: float) -> float:
        size = abs(values[name])
        return max(abs(values[name] - lower[name]), rise * size) + truncation * missing * size

    change = _FORCE_CHANGE * abs(values["force"] - lower["force"])
    routes = abs(values["force"] - values["force_eggshell"])
    linear = values["incremental_inductance"] * float(fine.currents[0])
    saturation = abs(values["flux_linkage"] - linear) / abs(linear) if linear else 0.0
    scatter = _INDUCTANCE_SCATTER * min(1.0, saturation) * values["incremental_inductance"]

    return FieldErrors(
        flux_linkage=bar("flux_linkage", 2.0),
        coenergy=bar("coenergy", 1.0),
        force=max(change, rise * stress, routes) + _FORCE_TRUNCATION * missing * stress,
        incremental_inductance=bar("incremental_inductance", 2.0) + scatter,
    )


def _values(model: TwoOrders, solution: MagneticField) -> dict[str, float]:
    return {
        "flux_linkage": float(solution.flux_linkage[0]),
        "coenergy": solution.coenergy,
        # the moving parts are above the gap: a pull that closes it points down
        "force": -virtual_work_force(solution),
        "force_eggshell": -eggshell_force(solution, model.weight),
        "incremental_inductance": float(solution.incremental_inductance[0, 0]),
    }


#: Solved fields that a start is made of, and the largest degree of the polynomial through them.
_NEAR, _DEGREE = 6, 4
#: Fields that are held for it, of half a megabyte each; a table's are all.
_HELD = 150
#: A polynomial whose weights add up to more in size is no start: its fields lie to one side.
_LARGEST_WEIGHTS = 4.0


class FieldPath:
    """Points that differ in a few numbers, on the grid of one device at a gap (m).

    Raises InputError as :func:`solve_point`.
    """

    def __init__(
        self, device: Device, gap: float, *, order: int = ORDER, refinement: float
    ) -> None:
        self._home = two_orders(device, gap, order, refinement)
        self._places: list[Floats] = []
        self._solved: list[Start] = []  # potentials alone: the tables of a field are large

    def solved(
        self, device: Device, current: float, gap: float, place: Floats
    ) -> FieldPoint | None:
        """Field point at a current (A) and gap (m); None if the grid does not reach.

        `place` (k,) is what varies, each about from −1 to 1: fields nearby in it make the start.

        Raises CoarseGridError if the grid is too coarse, SolverError where nothing converges.
        """
        model = fitted(self._home, device, gap)
        if model is None:
            return None
        pair = solve_pair(model, current, self._start(place))
        del self._places[:-_HELD], self._solved[:-_HELD]
        self._places.append(np.asarray(place, dtype=float))
        self._solved.append(Start(pair.coarse.potential, pair.fine.potential))
        return field_point(model, pair)

    def _start(self, place: Floats) -> Start | None:
        if not self._solved:
            return None
        places = np.array(self._places)
        near = np.argsort(np.linalg.norm(places - place, axis=1))[:_NEAR]
        weights = _weights(places[near], place)
        solved = [self._solved[n] for n in near]
        return Start(
            weights @ np.array([each.coarse for each in solved]),
            weights @ np.array([each.fine for each in solved]),
        )


def _weights(places: Floats, place: Floats) -> Floats:
    """Weights (n,) of values at places (n, k) that give polynomials at `place` exactly.

    Of the highest degree that n places, nearest first, determine.
    """
    varies = (places != place).any(axis=0)
    places, place = places[:, varies], place[varies]
    count, axes = places.shape
    for degree in range(_DEGREE, 0, -1):
        if math.comb(axes + degree, degree) > count:
            continue
        powers = [p for p in itertools.product(range(degree + 1), repeat=axes) if sum(p) <= degree]
        away = np.array([np.prod((places - place) ** p, axis=1) for p in powers])
        there = np.array([float(not any(p)) for p in powers])
        weights = np.linalg.lstsq(away, there, rcond=None)[0]
        exact = np.abs(away @ weights - there).max() < 1e-6
        if exact and np.abs(weights).sum() < _LARGEST_WEIGHTS:
            return np.asarray(weights)
    return np.asarray(np.eye(count)[0])


#: Grids of one fineness that are held, with their factors of some 100 MB; the oldest goes.
_MOST = 3


class FieldContinuation:
    """Points of devices, currents and gaps that differ little from one to the next.

    `refinements` are those of the grids that may be taken, coarsest first; where the force's bar
    over the force is above `accuracy` the next finer grid is taken, if there is one.
    """

    def __init__(self, refinements: Sequence[float], accuracy: float) -> None:
        self._refinements, self._accuracy = tuple(refinements), accuracy
        self._paths: list[list[FieldPath]] = [[] for _ in self._refinements]
        self._places: list[Floats] = []
        self._enough: list[int] = []

    def at(self, device: Device, current: float, gap: float, place: Floats) -> FieldPoint:
        """Point of a device at a current (A) and gap (m).

        The first grid tried is the one that was fine enough at the nearest place.  `place` (k,) is
        what varies, each of the order of 1 over the walk: it says which fields are near.

        Raises InputError if the parts do not fit at this gap, SolverError if the field does not
        converge.
        """
        place = np.asarray(place, dtype=float)
        finest = len(self._refinements) - 1
        for level in range(self._first(place), finest):
            with suppress(CoarseGridError):
                found = self._solved(level, device, current, gap, place)
                if found.errors.force <= self._accuracy * abs(found.force):
                    break
        else:
            level = finest
            found = self._solved(level, device, current, gap, place)
        self._places.append(place)
        self._enough.append(level)
        return found

    def _first(self, place: Floats) -> int:
        if not self._places:
            return 0
        away = np.linalg.norm(np.array(self._places) - place, axis=1)
        return self._enough[int(np.argmin(away))]

    def _solved(
        self, level: int, device: Device, current: float, gap: float, place: Floats
    ) -> FieldPoint:
        """Solve on the latest grid of a fineness that reaches there, a new one if none does."""
        paths = self._paths[level]
        for path in reversed(paths):
            found = path.solved(device, current, gap, place)
            if found is not None:
                return found
        del paths[: -_MOST + 1]
        paths.append(FieldPath(device, gap, refinement=self._refinements[level]))
        found = paths[-1].solved(device, current, gap, place)
        if found is None:
            raise InputError(
                f"the grid made for gap = {gap * 1e3:g} mm does not fit its own sizes: two of rod, "
                "coil and sleeve differ by less than 0.1 nm somewhere; make them equal, or move "
                "them apart"
            )
        return found
