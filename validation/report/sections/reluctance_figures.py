"""Plots of the normal actuator: force and flux families, switching, the bridge to the field.

The field itself is drawn by :mod:`validation.report.sections.magnetic_field`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.tmm.reluctance.switching import (
    balance_current,
    between_stops,
    equilibria,
    finger_force,
    resting_gaps,
    spring_force,
)
from tactgen.validation.models.reluctance.switching import SwitchingCurrents
from tactgen.validation.show.figures import BLUE, GREY, ORANGE, panels, plain_numbers, shades, svg

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint

#: Line of each model; colours tell currents or gaps.
_LINE: dict[str, Any] = {"network": (0, (4, 2)), "axisymmetric": "-", "magnetic3d": ":"}
_CURVE_POINTS = 160
#: So many that a jump of the rod looks like one.
_LOOP_POINTS = 2001


@dataclass(frozen=True)
class Families:
    """What the families of curves show."""

    device: Device  #: Its spring and stops are drawn
    maps: Mapping[str, CoenergyMap]  #: By model
    #: (c,) One curve each (A, m)
    currents: Floats
    gaps: Floats
    #: Single solutions of the field, drawn as circles
    points: Sequence[FieldPoint] = field(default=())


def force_families(shown: Families) -> str:
    """Plot the pull over the gap at several currents, and over the current at several gaps."""
    figure, (left, right) = panels(10.0, 4.6, ncols=2)
    spring = shown.device.spring
    gaps = np.geomspace(spring.stop_gap, shown.device.gap, _CURVE_POINTS)
    for colour, current in zip(shades(shown.currents.size), shown.currents, strict=True):
        for name, pull in shown.maps.items():
            left.plot(gaps * 1e6, pull.force(current, gaps) * 1e3, color=colour, ls=_LINE[name])
        _circles(left, colour, [(p.gap * 1e6, p.force * 1e3) for p in _at(shown, current=current)])
        left.plot([], [], color=colour, label=f"{current * 1e3:.4g} mA")
    left.plot(gaps * 1e6, spring_force(shown.device, gaps) * 1e3, color="black", label="spring")
    left.set(xlabel="working gap (µm)", ylabel="pull (mN)", yscale="log", title="force over gap")
    _over_current(right, shown, lambda pull, i, g: pull.force(i, g) * 1e3, "pull (mN)")
    _circles_by_gap(right, shown, lambda p: p.force * 1e3)
    right.set(title="force over current", yscale="log")
    low, high = (float(spring_force(shown.device, g)) * 1e3 for g in shown.gaps[[0, -1]])
    right.axhspan(min(low, high), max(low, high), color="black", alpha=0.25, label="spring, range")
    right.set_ylim(bottom=1.0)
    for axis in (left, right):
        plain_numbers(axis.yaxis)
        _legend(axis, shown)
    return svg(figure)


def flux_families(shown: Families) -> str:
    """Plot flux linkage and incremental inductance over the current at several gaps."""
    figure, (left, right) = panels(10.0, 4.2, ncols=2)
    _over_current(left, shown, lambda pull, i, g: pull.flux_linkage(i, g) * 1e3, "λ (mWb)")
    _circles_by_gap(left, shown, lambda p: p.flux_linkage * 1e3)
    left.set_title("flux linkage")
    _over_current(
        right, shown, lambda pull, i, g: pull.incremental_inductance(i, g) * 1e3, "∂λ/∂i (mH)"
    )
    _circles_by_gap(right, shown, lambda p: p.incremental_inductance * 1e3)
    right.set(title="incremental inductance", ylim=(0.0, None))
    _legend(left, shown)
    return svg(figure)


def switching_plot(shown: Families, pull: CoenergyMap, found: SwitchingCurrents) -> str:
    """Plot pull against spring with all places of rest, the loop of positions, the finger's force.

    Parameters
    ----------
    pull : CoenergyMap
        Of the model that is shown.
    found : SwitchingCurrents
        Its switching currents.
    """
    figure, (forces, loop, finger) = panels(10.0, 4.3, ncols=3)
    _forces(forces, shown, pull)
    _loop(loop, shown.device, pull, found)
    current = np.linspace(0.0, pull.current_limit, _CURVE_POINTS)
    spring = shown.device.spring
    for gap, name, colour in (
        (shown.device.gap, "upper stop", BLUE),
        (spring.stop_gap, "lower stop", ORANGE),
    ):
        force = finger_force(shown.device, pull, current, np.full_like(current, gap))
        finger.plot(current * 1e3, force * 1e3, color=colour, label=f"held at the {name}")
    finger.axhline(0.0, color="black", linewidth=0.8)
    # without a spring there is only the pull
    most = float(spring_force(shown.device, spring.stop_gap)) or -float(np.min(force))
    finger.set(
        xlabel="current (mA)",
        ylabel="spring − pull (mN)",
        title="force on the finger",
        ylim=(-1.8e3 * most, 1.25e3 * most),
    )
    finger.legend(frameon=False, fontsize=8)
    return svg(figure)


def _forces(axis: Any, shown: Families, pull: CoenergyMap) -> None:
    device = shown.device
    gaps = np.linspace(device.spring.stop_gap, device.gap, _CURVE_POINTS)
    for colour, current in zip(shades(shown.currents.size), shown.currents, strict=True):
        axis.plot(gaps * 1e6, pull.force(current, gaps) * 1e3, color=colour)
        axis.plot([], [], color=colour, label=f"{current * 1e3:.4g} mA")
        for place in equilibria(device, pull, float(current)):
            held = place.kind != "unstable"
            axis.plot(
                place.gap * 1e6,
                float(spring_force(device, place.gap)) * 1e3,
                "o",
                color=colour,
                markersize=7,
                markerfacecolor=colour if held else "white",
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
            axis.text(x + 0.015 * end, 0.5 * (low + high), f"{names}\n{x:.3g} mA", color=colour)
    axis.set(
        xlabel="current (mA)", ylabel="working gap (µm)", title="where the rod is", xlim=(0.0, end)
    )
    axis.set_ylim(0.0, 1.35 * high)
    axis.legend(frameon=False, fontsize=8, loc="upper right")


def _over_current(axis: Any, shown: Families, read: Any, label: str) -> None:
    """Draw a family over the current, one colour per gap."""
    limit = min(pull.current_limit for pull in shown.maps.values())
    current = np.linspace(0.0, limit, _CURVE_POINTS)
    for colour, gap in zip(shades(shown.gaps.size), shown.gaps, strict=True):
        for name, pull in shown.maps.items():
            axis.plot(current * 1e3, read(pull, current, gap), color=colour, ls=_LINE[name])
        axis.plot([], [], color=colour, label=f"{gap * 1e6:.3g} µm")
    axis.set(xlabel="current (mA)", ylabel=label)


def _at(shown: Families, current: float) -> list[FieldPoint]:
    return [p for p in shown.points if np.isclose(p.current, current, rtol=1e-6)]


def _circles_by_gap(axis: Any, shown: Families, read: Any) -> None:
    for colour, gap in zip(shades(shown.gaps.size), shown.gaps, strict=True):
        at = [p for p in shown.points if np.isclose(p.gap, gap, rtol=1e-6)]
        _circles(axis, colour, [(p.current * 1e3, read(p)) for p in at])


def _circles(axis: Any, colour: Any, places: Sequence[tuple[float, float]]) -> None:
    for x, y in places:
        axis.plot(x, y, "o", color=colour, markersize=5, zorder=3)


def _legend(axis: Any, shown: Families) -> None:
    """Add the models' lines to the legend: black, since colours tell something else."""
    for name in shown.maps:
        axis.plot([], [], color="black", ls=_LINE[name], alpha=0.6, label=name)
    if shown.points:
        axis.plot([], [], "o", color="black", alpha=0.6, markersize=5, label="field, single points")
    axis.legend(frameon=False, fontsize=8, ncols=2)
