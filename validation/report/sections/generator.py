"""The report's sections about the machine at rest and in small motions.

Where the rod rests by every model of the normal actuator that has a map; what that holds, and how
it moves, by the map of the model that knows most of those asked for and by the beam models.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.generator.contact import contact_of, moving_rod, stops_of
from tactgen.tmm.generator.equilibrium import (
    RestingPlace,
    axial_forces,
    resting_places,
    resting_tilt,
)
from tactgen.validation.catalogue.models import MODELS, ranked
from tactgen.validation.catalogue.quantities import (
    PULL_IN_CURRENT,
    QUANTITIES,
    SHORT_CIRCUIT_FREQUENCIES,
)
from tactgen.validation.engine.base_moment import base_moment
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.model import Estimate
from tactgen.validation.models.reluctance.model import NetworkModel, RodLoop, rod_loop
from tactgen.validation.models.small_signal import machine_of, measured_poles, of_rod
from tactgen.validation.report.report_data import Context, Section, Study
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import is_papers_actuator
from tactgen.validation.show.figures import BLUE, GREY, ORANGE, panels, plain_numbers, shades, svg

#: Line of each further model.
_LINES = ("-", (0, (4, 2)), ":")


def position_plot(loops: Sequence[RodLoop], current: float) -> str:
    """Plot all resting places over the coil's current, and the way there and back, by model.

    Arrows stand where the rod moves from stop to stop.
    """
    figure, axis = panels(8.0, 4.2)
    for found, line in zip(loops, _LINES, strict=False):
        of = f", {found.model}" if len(loops) > 1 else ""
        currents = 1e3 * found.loop.currents
        for way, colour, name in (
            (found.loop.rising, ORANGE, "current rising"),
            (found.loop.falling, BLUE, "current falling"),
        ):
            axis.plot(*_in_pieces(currents, way), color=colour, ls=line, label=name + of)
        unstable = found.loop.unstable
        if unstable.size:
            axis.plot(*(unstable * [1e3, 1e6]).T, ".", ms=3, color=GREY,
                      label=None if of and line != _LINES[0] else "unstable")  # fmt: skip
    _mark_switching(axis, loops[0])
    if current:
        axis.axvline(1e3 * current, color="black", lw=0.8, ls=":", label="the scene's current")
    axis.set(xlabel="coil current (mA)", ylabel="rod's position (µm)")
    axis.legend(fontsize=8)
    return svg(figure)


def _in_pieces(currents: Floats, way: Sequence[RestingPlace]) -> tuple[Floats, Floats]:
    """Currents and lifts (µm), with a gap where the rod goes from stop to stop."""
    lifts = np.array([1e6 * place.lift for place in way])
    kinds = [place.kind for place in way]
    ends = {"upper stop", "lower stop"}
    jumps = [k for k in range(1, len(way)) if {kinds[k - 1], kinds[k]} == ends]
    return np.insert(currents, jumps, np.nan), np.insert(lifts, jumps, np.nan)


def _mark_switching(axis: Any, found: RodLoop) -> None:
    """Write pull-in and drop-out at the currents at which the rod moves from stop to stop."""
    if found.switching is None:
        return
    lowest = min(place.lift for place in found.loop.falling)
    for name, measured, colour, low in (
        ("pull-in", found.switching.pull_in, ORANGE, True),
        ("drop-out", found.switching.drop_out, BLUE, False),
    ):
        at = 1e3 * measured.value
        if not 0.0 < at <= 1e3 * found.loop.currents[-1]:
            continue
        top, bottom = 0.0, 1e6 * lowest
        way = (bottom, top) if low else (top, bottom)
        axis.annotate(
            "", xy=(at, way[0]), xytext=(at, way[1]),
            arrowprops={"arrowstyle": "->", "color": colour, "lw": 1.2},
        )  # fmt: skip
        axis.annotate(
            f"{name}\n{at:.4g} mA", xy=(at, 0.5 * bottom), xytext=(6, 0),
            textcoords="offset points", fontsize=8, va="center",
        )  # fmt: skip


def transfer_plot(solution: Solution, units: Sequence[str]) -> str:
    """Plot the magnitudes of the transfers that a solution holds, one panel for each unit."""
    figure, axes = panels(10.0, 4.2, ncols=2)
    for axis, unit in zip(axes, units, strict=True):
        shown = [
            q
            for q in solution.quantities
            if q.unit == unit and q.frequency is not None and np.abs(q.value).any()
        ]
        for colour, q in zip(shades(len(shown)), shown, strict=True):
            label = f"{q.name.replace('_', ' ')}, {q.model}"
            axis.plot(q.frequency, np.abs(q.value), color=colour, label=label)
        axis.set(xlabel="frequency (Hz)", ylabel=f"magnitude ({unit})", yscale="log")
        if shown and min(shown[0].frequency or (0.0,)) > 0.0:
            axis.set(xscale="log")
            plain_numbers(axis.xaxis)
        if shown:
            low, high = axis.get_ylim()
            if high < 10.0 * low:  # what hardly varies is not drawn as if it did
                middle = np.sqrt(low * high)
                axis.set_ylim(middle / 5.0, middle * 5.0)
            axis.legend(fontsize=7)
    return svg(figure)


#: Direct current with which the paper holds the rod down (A), section 6.
_HELD = 50e-3
#: Units of the transfers from voltage and current to the tip.
TRANSFERS = ("m/V", "m/A")
#: Preloads shown beside the scene's, as shares of it: what a grub screw may do.
_PRELOADS = (0.5, 1.0, 2.0)


def _positions(study: Study) -> Context | None:
    """Where the rod rests over the current; None where nothing magnetic is asked for."""
    scene = study.scene
    loops = _loops(study)
    if not loops:
        return None

    current = abs(scene.coil.current)
    papers = is_papers_actuator(scene)
    currents = {current, _HELD} if papers else {current}
    forces = axial_forces(scene.device, map_of(scene), scene.load.normal_force)
    return {
        "loops": loops,
        "loop": position_plot(loops, current),
        "places": [(i, resting_places(forces, i)) for i in sorted(currents)],
        "papers": papers,
        "reference": forces.stops.upper.reference_load,
        "resting": study.resting,
        "models": ranked({cell.model for row in study.resting for cell in row.cells}),
    }


def _support(study: Study) -> Context:
    """Contact as a support in several states, with its loads."""
    scene = study.scene
    return {
        "rows": [_row(*state) for state in _states(scene, _is_magnetic(study))],
        "moment": base_moment(scene),
        "law": contact_of(scene.device, "upper"),
        "below": contact_of(scene.device, "lower"),
        "rod": moving_rod(scene.device),
        "rated": Device().spring.preload,
    }


def _motions(study: Study) -> Context | None:
    """Rod and coil in small motions: at the scene's current, or held if it has none."""
    if not _is_magnetic(study):
        return None

    scene, solution = study.scene, study.solution
    if not scene.coil.current:
        scene = _with(scene, current=_HELD, history="falling")
        names = [name for name, row in QUANTITIES.items() if row.unit in TRANSFERS]
        solution = solve(scene, ("tmm",), names)
    linear = machine_of(scene, map_of(scene))
    shown = any(q.unit in TRANSFERS for q in solution.quantities)
    return {
        "of": scene,
        "linear": linear.fine,
        "tilt": resting_tilt(scene.device, scene.rest[0]) if scene.rest else 0.0,
        "compared": [_on_map(scene, name) for name in _maps_asked(scene)],
        "poles": {
            supply: measured_poles(_with(scene, supply=supply), linear).listed
            for supply in ("current", "voltage")
        },
        "transfers": transfer_plot(solution, TRANSFERS) if shown else "",
    }


def _maps_asked(scene: Scene) -> list[str]:
    """Models of the normal actuator asked for, if there are some to compare."""
    asked = [name for name in ranked(scene.models) if MODELS[name].actuator == "reluctance"]
    return asked if len(asked) > 1 else []


def _on_map(scene: Scene, model: str) -> Context:
    """Rod in small motions by one model's map, the supply holding the current (SI, with bars)."""
    made = scene.asking((model,))
    rod = machine_of(made, map_of(made))
    poles = measured_poles(_with(made, supply="current"), rod).listed
    first = int(np.argmax(poles.value.imag))
    return {
        "model": model,
        "axial_stiffness": of_rod(rod, lambda r: float(r.stiffness[2, 2])),
        "rocking_stiffness": of_rod(rod, lambda r: float(r.stiffness[1, 1])),
        "motional": of_rod(rod, lambda r: -r.motional),
        "incremental_inductance": of_rod(rod, lambda r: r.inductance),
        "frequency": Estimate(
            float(abs(poles.value[first])) / (2.0 * np.pi),
            float(poles.error[first]) / (2.0 * np.pi),
        ),
    }


def _is_magnetic(study: Study) -> bool:
    return study.normal is not None or study.scene.coil.current != 0.0


def _loops(study: Study) -> Sequence[RodLoop]:
    if study.normal is not None:
        return study.normal.loops
    if not study.scene.coil.current:
        return ()
    found = solve(study.scene, (NetworkModel.name,), (PULL_IN_CURRENT.name,), study.announce)
    model = found.models[NetworkModel.name]
    assert isinstance(model, NetworkModel)
    return (rod_loop(model),)


def _states(scene: Scene, magnetic: bool) -> list[tuple[str, Scene]]:
    """Scene in the states whose supports are compared."""
    found = []
    for share in _PRELOADS:
        preload = share * scene.spring.preload
        spring = scene.spring.model_copy(update={"preload": preload})
        alone = _with(scene, current=0.0).model_copy(update={"spring": spring})
        found.append((f"spring alone, preload {1e3 * preload:.3g} mN", alone))
    if magnetic:
        for current in sorted({_HELD, abs(scene.coil.current)} - {0.0}):
            for history in ("rising", "falling"):
                state = f"{1e3 * current:.3g} mA, {history}"
                found.append((state, _with(scene, current=current, history=history)))
    return found


def _with(scene: Scene, **coil: Any) -> Scene:
    return scene.model_copy(update={"coil": scene.coil.model_copy(update=coil)})


def _row(state: str, made: Scene) -> Context:
    """Support in one state, by its contact (SI)."""
    answer = solve(made, ["tmm"], [SHORT_CIRCUIT_FREQUENCIES.name]).quantities[0]
    assert made.rest is not None
    place, springs = made.rest
    law = stops_of(made.device).holding(place.lift)
    return {
        "state": state,
        "place": place,
        "springs": springs,
        "first_frequency": float(answer.value[0]),
        "uplift_moment": float(law.uplift_moment(place.contact_force)),
        "tipping_moment": float(law.tipping_moment(place.contact_force)),
    }


#: In the report's order; a section of which there is nothing to say is left out.
POSITIONS = Section("positions", "Where the rod rests", _positions)
SUPPORT = Section("support", "The support that follows", _support)
MOTIONS = Section("motions", "Rod and coil in small motions", _motions)
