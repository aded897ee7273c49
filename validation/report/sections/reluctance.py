"""The report's sections about the normal actuator, in order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.device.layout import below_head
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.winding import winding
from tactgen.tmm.reluctance.network import largest_rms_current, thermal_statement
from tactgen.tmm.reluctance.switching import Equilibrium, equilibria, finger_force, spring_force
from tactgen.validation.catalogue.quantities import FLUX_LINKAGE, MAGNETIC_FORCE, QUANTITIES
from tactgen.validation.engine.results import Estimate
from tactgen.validation.models.reluctance.field import AxisymmetricModel
from tactgen.validation.models.reluctance.model import NetworkModel
from tactgen.validation.models.reluctance.switching import SwitchingCurrents
from tactgen.validation.report.normal_actuator import NormalActuator
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.studies import reconstruction as stated

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint
    from tactgen.validation.report.study import Study

#: Order and fineness of pictures: many lines for smooth contours.
_PICTURE: dict[str, Any] = {"order": 2, "refinement": 3.0}


def _models(actuator: NormalActuator) -> Context:
    """Models side by side and the bridge between them."""
    from tactgen.validation.models.difference import remaining
    from tactgen.validation.report.sections.bimorph_figures import breakdown_plot

    field = actuator.field_model
    titles = {MAGNETIC_FORCE.name: "magnetic force", FLUX_LINKAGE.name: "flux linkage"}
    reference = "the field" if actuator.has_field else "the full network"
    left = remaining(actuator.steps)
    moved = [{k: b[k] - a[k] for k in b} for a, b in pairwise(left)]
    methods: dict[str, dict[str, list[str]]] = {model: {} for model in actuator.models}
    for q in actuator.quantities:
        judged = methods.setdefault(q.model, {}).setdefault(q.method, [])
        judged.append(QUANTITIES[q.name].label)
    return {
        "actuator": actuator,
        "models": actuator.models,
        "rows": actuator.comparison,
        "methods": methods,
        "routes": field.point() if field else None,
        "steps": list(zip(actuator.steps, left, [left[0], *moved], strict=True)),
        "waterfall": breakdown_plot(actuator.steps, titles, reference),
        "deviations": _deviations(actuator),
    }


def _deviations(actuator: NormalActuator) -> Context | None:
    """Network's force against the field's over the map, if both have one."""
    names = (NetworkModel.name, AxisymmetricModel.name)
    if not set(names) <= set(actuator.maps):
        return None
    network, field = (actuator.maps[name] for name in names)
    currents, gaps = actuator.currents, actuator.gaps
    table = network.force(currents[:, None], gaps) / field.force(currents[:, None], gaps) - 1.0
    return {"currents": currents, "gaps": gaps, "table": table}


def _field(actuator: NormalActuator) -> Context | None:
    """Pictures of the field at both stops, if it was asked for."""
    if actuator.field_model is None:
        return None
    from tactgen.fem.magnetics.axisymmetric import solve_point
    from tactgen.validation.report.sections.magnetic_field import field_plot

    device, current = actuator.device, actuator.current
    stop = device.spring.stop_gap
    actuator.announce("pictures of the field")
    points = {
        f"{name}: {gap * 1e6:.3g} µm, {current * 1e3:.4g} mA": solve_point(
            device, current, gap, **_PICTURE
        )
        for name, gap in (("upper stop", device.gap), ("lower stop", stop))
    }
    return {
        "field_picture": field_plot(device, points),
        "saturated": [p.incremental_inductance < 0.5 * p.inductance for p in points.values()],
        "viewer": _viewer(actuator),
        "shaft": [_shaft_density(point, device.rod.radius) for point in points.values()],
    }


def _viewer(actuator: NormalActuator) -> str:
    """Field at the scene's current and gap, revolved, in a frame of its own."""
    from tactgen.validation.show.fields.magnetic import gather_magnetic
    from tactgen.validation.show.page import fragment
    from tactgen.validation.show.viewer import payload

    actuator.announce("field in the round")
    solution = actuator.solution
    found = gather_magnetic(solution.scene, actuator.announce, reuse=solution)
    return fragment(payload([found]), [], light=True, name="tv-field")


def _shaft_density(point: FieldPoint, radius: float) -> float:
    """Largest mean flux density in the shaft (T): flux 2π r A_φ over its section."""
    assert point.solution is not None
    grid = point.solution.discretisation.grid
    at = int(np.argmin(np.abs(grid.r - radius)))
    flux = 2.0 * np.pi * np.abs(point.solution.flux_function[at]).max()
    return float(flux / (np.pi * radius**2))


@dataclass(frozen=True)
class ElectricalRow:
    """The coil's inductances (H) and time constant (s) at one state."""

    state: str
    current: float
    gap: float
    apparent: Estimate
    incremental: Estimate
    time_constant: float


def _characteristics(actuator: NormalActuator) -> Context:
    """Families, switching, finger force and the coil's electrical and thermal values."""
    from tactgen.validation.report.sections.reluctance_figures import (
        Families,
        flux_families,
        force_families,
        switching_plot,
    )

    device, current = actuator.device, actuator.current
    shown = Families(device, actuator.maps, actuator.currents, actuator.gaps, actuator.points)
    chosen = actuator.switching[actuator.pull_model]
    wound = winding(device.coil)
    heat = {
        "At the scene's current": thermal_statement(device, current),
        "At the paper's direct current for holding": thermal_statement(device, stated.HELD),
    }
    if np.isfinite(chosen.holding.value):
        held = thermal_statement(device, chosen.holding.value)
        heat["At this device's holding current"] = held
    return {
        "actuator": actuator,
        "forces": force_families(shown),
        "fluxes": flux_families(shown),
        "switching_picture": switching_plot(shown, actuator.pull, chosen),
        "switching": actuator.switching,
        "chosen": chosen,
        "finger": _finger(actuator),
        "paper": _beside_the_paper(actuator),
        "winding": wound,
        "power": wound.power(current),
        "current_density": wound.current_density(current),
        "heating_rate": wound.heating_rate(current),
        "electrical_rows": _electrical_rows(actuator, chosen),
        "heat": heat,
        "rms": largest_rms_current(device, actuator.scene.limits),
        "limits": actuator.scene.limits,
        "duties": (1.0, 0.5, 0.1, 0.01),
    }


def _finger(actuator: NormalActuator) -> list[dict[str, Any]]:
    """Spring, pull and what is left for the finger at both stops."""
    device, pull = actuator.device, actuator.pull
    rows = []
    for stop, gap in (("upper stop", device.gap), ("lower stop", device.spring.stop_gap)):
        spring = float(spring_force(device, gap))
        for current in (0.0, *actuator.currents[[0, 1, 3]]):
            left = float(finger_force(device, pull, current, gap))
            rows.append(
                {"stop": stop, "current": current, "spring": spring, "pull": spring - left,
                 "left": left}
            )  # fmt: skip
    return rows


def _electrical_rows(actuator: NormalActuator, found: SwitchingCurrents) -> list[ElectricalRow]:
    device = actuator.device
    resistance = winding(device.coil).resistance
    top, stop = device.gap, device.spring.stop_gap
    states = (
        ("upper stop, no current", 0.0, top),
        ("upper stop", actuator.current, top),
        ("lower stop, holding current", found.holding.value, stop),
        ("lower stop", actuator.current, stop),
    )
    rows = []
    for state, current, gap in states:
        if np.isfinite(current):
            point = actuator.point_by_map_model(current, gap)
            slope = point.incremental_inductance
            rows.append(
                ElectricalRow(
                    state, current, gap, point.inductance, slope, slope.value / resistance
                )
            )
    return rows


def _beside_the_paper(actuator: NormalActuator) -> Context | None:
    """Model's answers to what the paper states, None outside the map."""
    device, pull = actuator.device, actuator.pull
    low, high = pull.gap_limits
    if not low <= stated.GAP <= high or pull.current_limit < stated.PULL_IN:
        return None
    places = equilibria(device, pull, stated.HELD)
    return {
        "force": actuator.point_by_reference(stated.PULL_IN, stated.GAP).force,
        "driven": actuator.point_by_reference(stated.DRIVEN, stated.GAP).force,
        "model": actuator.reference,
        "preload_is_set": device.spring.preload == Device().spring.preload,
        "turns_are_set": actuator.turns_are_set,
        "held": any(place.kind == "lower stop" for place in places),
        "held_up_to": _unstable(places),
        "found": actuator.switching[actuator.pull_model],
        "height_below_tip": stated.TOTAL_HEIGHT - below_head(device),
        "below_head": below_head(device),
        "stated": {
            "gap": stated.GAP,
            "force": stated.FORCE,
            "pull_in": stated.PULL_IN,
            "held": stated.HELD,
            "driven": stated.DRIVEN,
            "height": stated.TOTAL_HEIGHT,
        },
    }


def _unstable(places: Sequence[Equilibrium]) -> float | None:
    """Smallest gap (m) from which the spring takes over, None if there is none."""
    return min((p.gap for p in places if p.kind == "unstable"), default=None)


def _of(show: Callable[[NormalActuator], Context | None]) -> Callable[[Study], Context | None]:
    """Contents of a section by what it shows of the normal actuator, at its current."""

    def context(study: Study) -> Context | None:
        actuator = study.normal
        found = show(actuator) if actuator else None
        return {"scene": actuator.scene, **found} if actuator and found is not None else None

    return context


NORMAL: tuple[Section, ...] = (
    Section("magnetic_models", "Normal actuator: models side by side", _of(_models)),
    Section("magnetic_field", "Normal actuator: the field", _of(_field)),
    Section("characteristics", "Normal actuator: force, switching, coil", _of(_characteristics)),
)
