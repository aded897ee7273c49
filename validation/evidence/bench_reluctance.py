"""Run time against error of the normal actuator's fields: orders, fineness, formulations.

In the half section, flux linkage and force by two routes at the paper's point, against a
much finer solution of the same run.  In 3D, force and co-energy of TEAM problem 20 by
both potentials.
"""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from tactgen.fem.magnetics.axisymmetric import FieldPoint, solve_map, solve_point
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.validation.evidence.bench import Bench, Target, Timing
from tactgen.validation.evidence.bench_timing import least_time, on_one_core
from tactgen.validation.evidence.cases.ball import potential_of
from tactgen.validation.evidence.cases.team20 import pole_states

#: Errors asked for, relative.
_FORCE, _LINKAGE = 1e-3, 5e-4
_DEVICE = Device()
#: Order at which maps of the device are sampled.
_MAP_ORDER = 3
#: Ampere-turns of TEAM problem 20.
_SATURATED = 5000.0
_LINKAGE_CASE, _WORK, _STRESS = "flux linkage", "force by virtual work", "force by stress"
_TEAM_FORCE, _TEAM_COENERGY = "TEAM 20: force", "TEAM 20: co-energy"


def timing_of(
    path: str, level: str, case: str, at: Mapping[str, float], value: float, unit: str,
    error: float, wanted: float = math.nan,
) -> Timing:  # fmt: skip
    """Timing of one result (in `unit`) of one field solution."""
    values: dict[str, str | float] = {
        "way": path, "fineness": level, "result": case, "unknowns": int(at["unknowns"]),
        "seconds": at["seconds"], "value": value, "unit": unit, "error": error,
    }  # fmt: skip
    return Timing(path, case, at["seconds"], error, values, wanted)


def run(quick: bool, announce: Callable[[str], None]) -> Bench:
    """Measure everything on one core; some three minutes, or under one if `quick`."""
    started = time.perf_counter()
    announce("magnetics: reference")
    reference = on_one_core(__name__, "point_of", *((6, 1.5, 1) if quick else (6, 2.0, 1)))
    finest = 1.4 if quick else 0.8
    forces = [at["force"] for at in _team20(finest, announce).values()]
    middle, half = 0.5 * sum(forces), 0.5 * abs(forces[0] - forces[1])
    timings = [*_half_section(quick, reference, announce), *_solid(quick, middle, announce)]
    announce("magnetics: map of 10 gaps by 10 currents")
    map_time = on_one_core(__name__, "map_seconds", 10, 10)
    conditions = _conditions(reference, finest, half / middle)
    targets = _targets(timings, reference, map_time)
    return Bench("magnetics", conditions, tuple(timings), targets, time.perf_counter() - started)


def _conditions(reference: dict[str, Any], finest: float, apart: float) -> str:
    return (
        "Reconstructed device at 130 mA and 0.2 mm, error bars included in the time; reference: "
        f"order {reference['order']}, fineness {reference['refinement']:g}, "
        f"{reference['unknowns']:,} unknowns, itself within {reference['force_bar']:.0e} in force "
        f"and {reference['flux_linkage_bar']:.0e} in flux linkage.  TEAM problem 20 at "
        f"{_SATURATED:g} ampere-turns: force against the mean of both potentials with cells "
        f"{finest:g} times as large as the default's, each {apart:.0e} from that; co-energy by "
        "half the distance of its two bounds.  One process with one thread per row, processor "
        "time, best of three in the half section of the full run; "
        f"numpy {np.__version__}, {platform.machine()}"
    )


def _half_section(
    quick: bool, reference: dict[str, Any], announce: Callable[[str], None]
) -> Iterator[Timing]:
    for order in (2, 3, 4):
        for fineness in (0.75, 1.0) if quick else (0.5, 0.75, 1.0, 1.5, 2.0):
            announce(f"magnetics: order {order}, fineness {fineness:g}")
            found = on_one_core(__name__, "point_of", order, fineness, 1 if quick else 3)
            for case, name, exact, unit, wanted in (
                (_LINKAGE_CASE, "flux_linkage", "flux_linkage", "Wb", _LINKAGE),
                (_WORK, "force", "force", "N", _FORCE),
                (_STRESS, "force_eggshell", "force", "N", _FORCE),
            ):
                error = abs(found[name] / reference[exact] - 1.0)
                yield timing_of(
                    f"order {order}", f"{fineness:g}", case, found, found[name], unit, error, wanted
                )


def _team20(scale: float, announce: Callable[[str], None]) -> dict[str, dict[str, float]]:
    """TEAM problem 20 by both potentials on one mesh."""
    found = {}
    for name in ("A", "φ"):
        announce(f"magnetics: TEAM problem 20 by {name}, cells {scale:g} times as large")
        found[name] = on_one_core(__name__, "solid_of", name, scale)
    return found


def _solid(quick: bool, exact: float, announce: Callable[[str], None]) -> Iterator[Timing]:
    for scale in (3.0, 2.0) if quick else (3.0, 2.0, 1.4, 1.0):
        found = _team20(scale, announce)
        low, high = (found[name]["coenergy"] for name in ("A", "φ"))
        for name, at in found.items():
            for case, value, unit, error in (
                (_TEAM_FORCE, at["force"], "N", abs(at["force"] / exact - 1.0)),
                (_TEAM_COENERGY, at["coenergy"], "J", (high - low) / (high + low)),
            ):
                yield timing_of(name, f"1/{scale:g}", case, at, value, unit, error)


def _targets(
    timings: list[Timing], reference: dict[str, Any], map_time: float
) -> tuple[Target, ...]:
    """Judge the cheapest grid within both errors, the reference's own bar added."""
    good: dict[tuple[str, str | float], list[Timing]] = {}
    bars = {_LINKAGE_CASE: reference["flux_linkage_bar"], _WORK: reference["force_bar"]}
    for timing in timings:
        if timing.case in bars and timing.error + bars[timing.case] <= timing.wanted:
            good.setdefault((timing.path, timing.values["fineness"]), []).append(timing)
    both = [rows[0] for rows in good.values() if len(rows) == len(bars)]
    best = min(both, key=lambda row: row.cost, default=None)
    way = (
        f"{best.path}, fineness {best.values['fineness']}"
        if best
        else "no grid of this run is near enough"
    )
    return (
        Target(
            "force within 0.1 % and flux linkage within 0.05 % of converged", 2.0,
            best.cost if best else math.inf, "s", True, way,
        ),
        Target(
            "map of 10 gaps by 10 currents", 60.0, map_time, "s", True,
            f"tactgen.fem.magnetics.axisymmetric.solve_map, order {_MAP_ORDER}",
        ),
    )  # fmt: skip


def point_of(order: int, refinement: float, repeats: int) -> dict[str, float]:
    """Device's point and the least of several processor times (s)."""
    seconds, point = least_time(
        lambda: solve_point(_DEVICE, order=order, refinement=refinement, any_grid=True), repeats
    )
    assert isinstance(point, FieldPoint)
    return {
        "order": order,
        "refinement": refinement,
        "seconds": seconds,
        "unknowns": point.unknowns,
        "flux_linkage": point.flux_linkage,
        "force": point.force,
        "force_eggshell": point.force_eggshell,
        "flux_linkage_bar": point.errors.flux_linkage / point.flux_linkage,
        "force_bar": point.errors.force / point.force,
    }


def map_seconds(gaps: int, currents: int) -> float:
    """Processor time (s) of the samples of a map over the device's stroke."""
    i, g = map_grid(_DEVICE, currents, gaps)
    return least_time(lambda: solve_map(_DEVICE, g.tolist(), i.tolist(), order=_MAP_ORDER))[0]


def solid_of(name: str, scale: float) -> dict[str, float]:
    """TEAM problem 20 by one potential, and the processor time (s) from mesh to force."""
    potential = potential_of(name)
    seconds, (found, _) = least_time(lambda: next(pole_states(potential, scale, (_SATURATED,))))
    return {
        "seconds": seconds,
        "unknowns": found.unknowns,
        "force": found.force,
        "coenergy": found.coenergy,
    }
