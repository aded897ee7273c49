"""The report's sections on large amplitudes and on the machine in time.

A quick report leaves the first out, says how to get it, and takes longer steps in time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.supports_and_loads import outside_known_range
from tactgen.validation.catalogue.quantities import TIP_DISPLACEMENT
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import (
    COILS,
    Backbone,
    Curve,
    Peak,
    RockingState,
    in_state,
    rocking_states,
)
from tactgen.validation.report.report_data import Context, Section, Study
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import is_papers_generator
from tactgen.validation.show.figures import BLUE, DARK, panels, plain_numbers, shades, svg
from tactgen.validation.show.page import inline
from tactgen.validation.show.run import fragment


def backbone_plot(found: Backbone) -> str:
    """Plot velocity and displacement per volt over frequency; unstable orbits dotted.

    The curve through the peaks is the backbone.
    """
    figure, axes = panels(10.0, 4.4, ncols=2)
    _family(
        axes[0], found.curves, lambda c: 2e3 * np.pi * c.frequencies * np.abs(c.displacement),
        lambda peak: 1e3 * peak.velocity,
    )  # fmt: skip
    _displacements(axes[1], found.curves)
    for axis, unit in zip(axes, ("velocity (mm/s per V)", "displacement (µm per V)"), strict=True):
        axis.set(xlabel="frequency (Hz)", ylabel=f"tip {unit}", yscale="log")
        plain_numbers(axis.yaxis)
    axes[0].legend(frameon=False)
    return svg(figure)


def _family(
    axis: Any,
    curves: Sequence[Curve],
    values: Callable[[Curve], Floats],
    top: Callable[[Peak], float],
) -> None:
    """Draw curves over their voltages, from dark to light, and their highest peaks' backbone."""
    for curve, colour in zip(curves, shades(len(curves)), strict=True):
        _draw(axis, curve, values(curve) / curve.voltage, colour)
    tops = [(c.peaks[0].frequency, top(c.peaks[0]) / c.voltage) for c in curves if c.peaks]
    if len(tops) > 1:
        axis.plot(*np.array(tops).T, "o-", color=DARK, lw=1.0, ms=4, label="backbone")


def _displacements(axis: Any, curves: Sequence[Curve]) -> None:
    _family(
        axis, curves, lambda c: 1e6 * np.abs(c.displacement), lambda peak: 1e6 * peak.displacement
    )


def _draw(axis: Any, curve: Curve, values: Any, colour: Any) -> None:
    """Draw one curve, where unstable dotted."""
    for shown, style in ((curve.stable, "-"), (~curve.stable, ":")):
        label = f"{curve.voltage:g} V" if style == "-" else None
        near = shown.copy()
        near[1:] |= shown[:-1] if style == ":" else False
        axis.plot(
            curve.frequencies, np.where(near, values, np.nan), style, color=colour, label=label
        )


def states_plot(states: Sequence[RockingState]) -> str:
    """Plot displacement per volt of the free tip at several voltages, one panel for each state."""
    shown = [state for state in states if state.curves]
    figure, axes = panels(10.0, 4.4, ncols=len(shown), sharey=True, squeeze=False)
    for axis, state in zip(axes[0], shown, strict=True):
        _displacements(axis, state.curves)
        axis.set(xlabel="frequency (Hz)", yscale="log", title=state.state)
        plain_numbers(axis.yaxis)
        axis.legend(frameon=False, fontsize=8)
    axes[0, 0].set_ylabel("tip displacement (µm per V)")
    return svg(figure)


def deflection_plot(
    states: Sequence[RockingState], frequencies: Floats, linear: Mapping[str, Floats]
) -> str:
    """Plot the deflection under load over frequency, rocking and linear, in each state.

    The linear ones (n,) in m, by state, are at frequencies (n,) in Hz.
    """
    figure, axes = panels(10.0, 4.4, ncols=len(states), sharey=True, squeeze=False)
    for axis, state in zip(axes[0], states, strict=True):
        found = state.deflection
        assert found is not None
        axis.plot(frequencies, 1e6 * linear[state.state], "--", color=DARK, lw=1.0,
                  label="linear support")  # fmt: skip
        axis.plot(found.frequencies, 1e6 * np.abs(found.displacement), color=BLUE,
                  label="head that may rock")  # fmt: skip
        axis.set(xlabel="frequency (Hz)", xscale="log", yscale="log", title=state.state)
        plain_numbers(axis.xaxis, axis.yaxis)
        axis.legend(frameon=False, fontsize=8, loc="lower left")
    axes[0, 0].set_ylabel("tip displacement (µm)")
    return svg(figure)


#: Voltages of the free tip's curves (V); the last is that of the paper's Fig 14.
VOLTAGES = (0.1, 0.3, 1.0)
#: End of the run in time (s): a whole period of the paper's current and the start of the next.
_UNTIL = 12.5e-3
_ACCURACY, _QUICK_ACCURACY = 0.05, 0.2


def _amplitude(study: Study) -> Context | None:
    """Backbones and deflections of both states; only words if quick."""
    scene = study.scene
    if study.quick or len([f for f in scene.frequency if f > 0.0]) < 2:
        return {"states": ()} if study.quick else None
    study.announce("large amplitudes")
    work = partial(rocking_states, scene, VOLTAGES, study.announce)
    states: tuple[RockingState, ...] = study.begun("amplitude", work)
    band, linear = _linear(study)
    loaded = [state for state in states if state.deflection is not None]
    return {
        "states": states,
        "backbones": states_plot(states) if any(s.curves for s in states) else "",
        "deflections": deflection_plot(loaded, band, linear) if loaded else "",
        "rows": [_row(state, linear[state.state]) for state in loaded],
        "papers": is_papers_generator(scene),
    }


def _linear(study: Study) -> tuple[Floats, dict[str, Floats]]:
    """Frequencies (n,) in Hz and the linear deflection (n,) in m of each state (tmm)."""
    scene = study.scene
    frequencies = np.array([f for f in scene.frequency if f > 0.0])
    found: dict[str, Floats] = {}
    for state in COILS:
        asked = {"frequency": tuple(frequencies.tolist())}
        made = in_state(scene, state).model_copy(update=asked)
        values = solve(made, ("tmm",), (TIP_DISPLACEMENT.name,)).quantities[0].value
        outside = outside_known_range(scene.load, frequencies)
        found[state] = np.where(outside, np.nan, np.abs(values))
    return frequencies, found


def _row(state: RockingState, linear: Floats) -> Context:
    """Deflection under load in one state (m, m/Hz)."""
    found = state.deflection
    assert found is not None
    sizes = np.abs(found.displacement)
    return {
        "state": state.state,
        "least": float(sizes.min()),
        "largest": float(sizes.max()),
        "slope": found.fitted_slope,
        "linear": (float(np.nanmin(linear)), float(np.nanmax(linear))),
        "ended": found.ended,
    }


def _time(study: Study) -> Context:
    """Run of the paper's Fig 16, as a film and as pictures for paper."""
    from tactgen.validation.evidence.cases.motion import SOURCES
    from tactgen.validation.models.transient import phases, run_scene
    from tactgen.validation.show.run import still_of_run
    from tactgen.validation.studies.simulate import film_of, time_plot

    scene = study.scene
    accuracy = _QUICK_ACCURACY if study.quick else _ACCURACY
    study.announce("the run of Fig 16")
    try:
        run = run_scene(
            scene, SOURCES, _UNTIL, coil="current", accuracy=accuracy, announce=study.announce
        )
    except InputError as error:
        return {"run": None, "refused": str(error)}
    found = phases(run)
    by_name = {name: [p for p in found if p.name == name] for name in _TEXT}
    return {
        "run": run,
        "loaded": scene.load.kind != "none",
        "picture": time_plot(run),
        "film": fragment(film_of(run), within=True),
        "still": inline(still_of_run(run)),
        "phases": found,
        "text": _TEXT,
        "order": {name: max(p.amplitude for p in ps) for name, ps in by_name.items() if ps},
        "steady": _steady(scene),
        "pull_in": study.normal.switching[study.normal.pull_model].pull_in
        if study.normal
        else None,
        "drive": SOURCES,
    }


def _steady(scene: Scene) -> dict[str, float]:
    """Tip's steady amplitude (m) in small motions on either stop; {} if it has none."""
    from tactgen.validation.evidence.cases.motion import DRIVE, SQUARE, small_tip

    try:
        return {
            name: DRIVE.amplitude * abs(small_tip(scene, current))
            for name, current in (("held", SQUARE.high), ("pressed", 0.0))
        }
    except InputError:
        return {}


#: What the text on Fig 16 says of each phase: when, and of the lateral amplitude.
_TEXT = {
    "held": ("0 to 3 ms", "almost firm: the largest"),
    "rising": ("3 to 4 ms", "like a free support: significantly less"),
    "pressed": ("4 to 7 ms", "stronger support again, not as firm as held: between"),
    "falling": ("7 to 9 ms", "free but guided: more than rising"),
}

AMPLITUDE = Section("amplitude", "At large amplitude", _amplitude)
TIME = Section("time", "In time", _time)
