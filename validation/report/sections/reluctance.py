"""The report's sections about the normal actuator, in order."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.parts import below_head
from tactgen.geometry.device.winding import winding
from tactgen.geometry.formats import engineering
from tactgen.tmm.generator.equilibrium import axial_forces, resting_places
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.tmm.reluctance.network import largest_rms_current, thermal_statement
from tactgen.tmm.reluctance.switching import (
    balance_current,
    between_stops,
    finger_force,
    resting_gaps,
    spring_force,
)
from tactgen.validation.catalogue.quantities import FLUX_LINKAGE, MAGNETIC_FORCE, QUANTITIES
from tactgen.validation.models.reluctance.field import AxisymmetricModel
from tactgen.validation.models.reluctance.model import NetworkModel
from tactgen.validation.models.reluctance.switching import MagneticPoint, SwitchingCurrents
from tactgen.validation.report.reluctance_data import NormalActuator
from tactgen.validation.report.report_data import Context, Section
from tactgen.validation.show.figures import BLUE, GREY, ORANGE, panels, plain_numbers, shades, svg
from tactgen.validation.studies import published_measurements as stated

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint
    from tactgen.validation.report.report_data import Study


#: Line of each model; colours tell currents or gaps.
_LINE: dict[str, Any] = {"network": (0, (4, 2)), "axisymmetric": "-", "magnetic3d": ":"}
#: Single solutions of the field.
_CIRCLES: dict[str, Any] = {"marker": "o", "ls": "", "markersize": 5, "zorder": 3}
_CURVE_POINTS = 160
#: So many that a jump of the rod looks like one.
_LOOP_POINTS = 2001


def force_families(actuator: NormalActuator) -> str:
    """Plot the pull over the gap at several currents, and over the current at several gaps."""
    figure, (left, right) = panels(10.0, 4.6, ncols=2)
    spring = actuator.device.spring
    gaps = np.geomspace(spring.stop_gap, actuator.device.gap, _CURVE_POINTS)
    for colour, current in zip(shades(actuator.currents.size), actuator.currents, strict=True):
        for name, pull in actuator.maps.items():
            left.plot(gaps * 1e6, pull.force(current, gaps) * 1e3, color=colour, ls=_LINE[name])
        at = [p for p in actuator.points if np.isclose(p.current, current, rtol=1e-6)]
        left.plot([p.gap * 1e6 for p in at], [p.force * 1e3 for p in at], color=colour, **_CIRCLES)
        left.plot([], [], color=colour, label=engineering(current, "A", 4))
    left.plot(gaps * 1e6, spring_force(actuator.device, gaps) * 1e3, color="black", label="spring")
    left.set(xlabel="working gap (µm)", ylabel="pull (mN)", yscale="log", title="force over gap")
    _over_current(right, actuator, "force", "pull (mN)")
    right.set(title="force over current", yscale="log")
    low, high = (float(spring_force(actuator.device, g)) * 1e3 for g in actuator.gaps[[0, -1]])
    right.axhspan(min(low, high), max(low, high), color="black", alpha=0.25, label="spring, range")
    right.set_ylim(bottom=1.0)
    for axis in (left, right):
        plain_numbers(axis.yaxis)
        _legend(axis, actuator)
    return svg(figure)


def flux_families(actuator: NormalActuator) -> str:
    """Plot flux linkage and incremental inductance over the current at several gaps."""
    figure, (left, right) = panels(10.0, 4.2, ncols=2)
    _over_current(left, actuator, "flux_linkage", "λ (mWb)")
    left.set_title("flux linkage")
    _over_current(right, actuator, "incremental_inductance", "∂λ/∂i (mH)")
    right.set(title="incremental inductance", ylim=(0.0, None))
    _legend(left, actuator)
    return svg(figure)


def switching_plot(actuator: NormalActuator) -> str:
    """Plot pull against spring with all places of rest, the loop of positions, the finger's force.

    All by one model: its map and its switching currents.
    """
    pull, found = actuator.pull, actuator.switching[actuator.pull_model]
    figure, (forces, loop, finger) = panels(10.0, 4.3, ncols=3)
    _forces(forces, actuator, pull)
    _loop(loop, actuator.device, pull, found)
    current = np.linspace(0.0, pull.current_limit, _CURVE_POINTS)
    spring = actuator.device.spring
    for gap, name, colour in (
        (actuator.device.gap, "upper stop", BLUE),
        (spring.stop_gap, "lower stop", ORANGE),
    ):
        force = finger_force(actuator.device, pull, current, np.full_like(current, gap))
        finger.plot(current * 1e3, force * 1e3, color=colour, label=f"held at the {name}")
    finger.axhline(0.0, color="black", linewidth=0.8)
    # without a spring there is only the pull
    most = float(spring_force(actuator.device, spring.stop_gap)) or -float(np.min(force))
    finger.set(
        xlabel="current (mA)",
        ylabel="spring − pull (mN)",
        title="force on the finger",
        ylim=(-1.8e3 * most, 1.25e3 * most),
    )
    finger.legend(frameon=False, fontsize=8)
    return svg(figure)


def _forces(axis: Any, actuator: NormalActuator, pull: CoenergyMap) -> None:
    device = actuator.device
    gaps = np.linspace(device.spring.stop_gap, device.gap, _CURVE_POINTS)
    for colour, current in zip(shades(actuator.currents.size), actuator.currents, strict=True):
        axis.plot(gaps * 1e6, pull.force(current, gaps) * 1e3, color=colour)
        axis.plot([], [], color=colour, label=engineering(current, "A", 4))
        for place in resting_places(axial_forces(device, pull), float(current)):
            gap = device.gap + place.lift
            axis.plot(
                gap * 1e6,
                float(spring_force(device, gap)) * 1e3,
                "o",
                color=colour,
                markersize=7,
                markerfacecolor=colour if place.stable else "white",
                zorder=3,
                clip_on=False,
            )
    axis.plot(gaps * 1e6, spring_force(device, gaps) * 1e3, color="black", label="spring")
    axis.set(
        xlabel="working gap (µm)",
        ylabel="force (mN)",
        title="pull against spring",
        ylim=(0.0, 3.0e3 * float(spring_force(device, device.spring.stop_gap)) or None),
    )
    axis.legend(frameon=False, fontsize=8)


def _loop(axis: Any, device: Device, pull: CoenergyMap, found: SwitchingCurrents) -> None:
    """Draw where the rod is while the current rises and falls slowly."""
    low, high = device.spring.stop_gap * 1e6, device.gap * 1e6
    up, down = found.pull_in.value * 1e3, found.drop_out.value * 1e3
    limit = pull.current_limit * 1e3
    end = min(limit, 2.0 * up) if up > 0.0 else limit  # all of it if the rod does not pull in
    gaps = between_stops(device, _CURVE_POINTS)
    balance = balance_current(device, pull, gaps) * 1e3
    axis.plot(balance, gaps * 1e6, ":", color=GREY, label="balance of forces")
    current = np.linspace(0.0, end, _LOOP_POINTS)
    for rising, name, colour, line in (
        (True, "rising current", BLUE, "-"),
        (False, "falling current", ORANGE, "--"),
    ):
        at = resting_gaps(device, pull, current * 1e-3, rising=rising) * 1e6
        axis.plot(current, at, color=colour, linestyle=line, label=name)
    for x, colour, names in ((up, BLUE, "pull-in"), (down, ORANGE, "drop-out")):
        if np.isfinite(x):
            axis.text(
                x + 0.015 * end,
                0.5 * (low + high),
                f"{names}\n{engineering(1e-3 * x, 'A', 3)}",
                color=colour,
            )
    axis.set(
        xlabel="current (mA)", ylabel="working gap (µm)", title="where the rod is", xlim=(0.0, end)
    )
    axis.set_ylim(0.0, 1.35 * high)
    axis.legend(frameon=False, fontsize=8, loc="upper right")


def _over_current(axis: Any, actuator: NormalActuator, name: str, label: str) -> None:
    """Draw maps' values (1e-3 of SI) over the current, one colour per gap, and single points."""
    limit = min(pull.current_limit for pull in actuator.maps.values())
    current = np.linspace(0.0, limit, _CURVE_POINTS)
    for colour, gap in zip(shades(actuator.gaps.size), actuator.gaps, strict=True):
        for model, pull in actuator.maps.items():
            values = getattr(pull, name)(current, gap) * 1e3
            axis.plot(current * 1e3, values, color=colour, ls=_LINE[model])
        axis.plot([], [], color=colour, label=engineering(gap, "m", 3))
        at = [p for p in actuator.points if np.isclose(p.gap, gap, rtol=1e-6)]
        values = [getattr(p, name) * 1e3 for p in at]
        axis.plot([p.current * 1e3 for p in at], values, color=colour, **_CIRCLES)
    axis.set(xlabel="current (mA)", ylabel=label)


def _legend(axis: Any, actuator: NormalActuator) -> None:
    """Add the models' lines to the legend: black, since colours tell something else."""
    for name in actuator.maps:
        axis.plot([], [], color="black", ls=_LINE[name], alpha=0.6, label=name)
    if actuator.points:
        axis.plot([], [], "o", color="black", alpha=0.6, markersize=5, label="field, single points")
    axis.legend(frameon=False, fontsize=8, ncols=2)


#: Order and fineness of pictures: many lines for smooth contours, and no number that needs a bar.
_PICTURE: dict[str, Any] = {"order": 2, "refinement": 3.0, "any_grid": True}


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
        f"{name}: {engineering(gap, 'm', 3)}, {engineering(current, 'A', 4)}": solve_point(
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
    from tactgen.validation.show.magnetic import gather_magnetic
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


def _characteristics(actuator: NormalActuator) -> Context:
    """Families, switching, finger force and the coil's electrical and thermal values."""
    device, current = actuator.device, actuator.current
    chosen = actuator.switching[actuator.pull_model]
    heat = {"At the scene's current": thermal_statement(device, current)}
    if actuator.is_papers:
        paper = thermal_statement(device, stated.HELD)
        heat["At the paper's direct current for holding"] = paper
    if np.isfinite(chosen.holding.value):
        held = thermal_statement(device, chosen.holding.value)
        heat["At this device's holding current"] = held
    return {
        "actuator": actuator,
        "forces": force_families(actuator),
        "fluxes": flux_families(actuator),
        "switching_picture": switching_plot(actuator),
        "switching": actuator.switching,
        "chosen": chosen,
        "finger": _finger(actuator),
        "paper": _beside_the_paper(actuator),
        "winding": winding(device.coil),
        "electrical_rows": _electrical_rows(actuator, chosen.holding.value),
        "heat": heat,
        "rms": largest_rms_current(device, actuator.scene.limits),
        "duties": (1.0, 0.5, 0.1, 0.01),
    }


def _finger(actuator: NormalActuator) -> list[tuple[str, float, float, float]]:
    """Stop, current (A), spring's force and what is left of it on the finger (N)."""
    device = actuator.device
    return [
        (stop, current, float(spring_force(device, gap)),
         float(finger_force(device, actuator.pull, current, gap)))
        for stop, gap in (("upper stop", device.gap), ("lower stop", device.spring.stop_gap))
        for current in (0.0, *actuator.currents[[0, 1, 3]])
    ]  # fmt: skip


def _electrical_rows(
    actuator: NormalActuator, holding: float
) -> list[tuple[str, float, float, MagneticPoint]]:
    """States of the coil, each with its current (A) and gap (m), and what the map's model says."""
    top, stop = actuator.device.gap, actuator.device.spring.stop_gap
    states = (
        ("upper stop, no current", 0.0, top),
        ("upper stop", actuator.current, top),
        ("lower stop, holding current", holding, stop),
        ("lower stop", actuator.current, stop),
    )
    return [
        (state, current, gap, actuator.point(current, gap, mapped=True))
        for state, current, gap in states
        if np.isfinite(current)
    ]


def _beside_the_paper(actuator: NormalActuator) -> Context | None:
    """Model's answers to the paper's statements, None outside the map or of another actuator."""
    device, pull = actuator.device, actuator.pull
    low, high = pull.gap_limits
    inside = low <= stated.GAP <= high and pull.current_limit >= stated.PULL_IN
    if not (actuator.is_papers and inside):
        return None
    places = resting_places(axial_forces(device, pull), stated.HELD)
    return {
        "force": actuator.point(stated.PULL_IN, stated.GAP).force,
        "driven": actuator.point(stated.DRIVEN, stated.GAP).force,
        "model": actuator.reference,
        "preload_is_set": device.spring.preload == Device().spring.preload,
        "turns_are_set": actuator.turns_are_set,
        "held": any(place.kind == "lower stop" for place in places),
        # smallest gap (m) from which the spring takes over
        "held_up_to": min((device.gap + p.lift for p in places if not p.stable), default=None),
        "found": actuator.switching[actuator.pull_model],
        "height_below_tip": stated.TOTAL_HEIGHT - below_head(device),
        "below_head": below_head(device),
        "stated": stated,
    }


def _of(show: Callable[[NormalActuator], Context | None]) -> Callable[[Study], Context | None]:
    """Contents of a section on the normal actuator, at its current."""

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
