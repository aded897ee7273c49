"""The report's sections on large amplitudes and on the machine in time.

A quick report leaves the first out, says how to get it, and takes longer steps in time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.elements import outside_known_range
from tactgen.validation.catalogue.quantities import TIP_DISPLACEMENT
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.amplitude.held_head import COILS, in_state
from tactgen.validation.models.amplitude.states import RockingState, rocking_states
from tactgen.validation.report.sections.section import Context, Section
from tactgen.validation.report.study import Study
from tactgen.validation.scene.nearby import is_papers_bimorph
from tactgen.validation.scene.scene import Scene
from tactgen.validation.view.page.html import inline
from tactgen.validation.view.run.page import fragment

if TYPE_CHECKING:
    from tactgen.validation.models.generator.transient import Simulation

#: Voltages of the free tip's curves (V); the last is that of the paper's Fig 14.
_VOLTAGES = (0.1, 0.3, 1.0)
#: What the paper's Fig 15 spans at 50 V, 20 mm, under skin imitation and 50 g (m).
_FIG_15 = {"not activated": (3.1e-6, 24.8e-6), "held": (13.6e-6, 72.4e-6)}
#: Its voltage (V), the length of its bimorph (m), and the slopes of the fitted lines (m/Hz).
_AT, _LENGTH = 50.0, 20e-3
_SLOPES = {"not activated": 1.164e-8, "held": 3.441e-8}
#: End of the run in time (s): a whole period of the paper's current and the start of the next.
_UNTIL = 12.5e-3
_ACCURACY, _QUICK_ACCURACY = 0.05, 0.2


@dataclass(frozen=True)
class DeflectionRow:
    """The deflection under load in one state, beside the paper's (m, m/Hz); nan where unknown."""

    state: str
    least: float
    largest: float
    slope: float
    linear: tuple[float, float]
    ended: str
    paper: tuple[float, float] | None
    paper_slope: float


def _amplitude(study: Study) -> Context | None:
    """Return backbones and deflections of both states; only words if quick."""
    from tactgen.validation.report.figures.amplitude import deflection_plot, states_plot

    scene = study.scene
    if study.quick or len([f for f in scene.frequency if f > 0.0]) < 2:
        return {"states": ()} if study.quick else None
    states = rocking_states(scene, _VOLTAGES, study.announce)
    band, linear = _linear(study)
    papers = is_papers_bimorph(scene) and scene.bimorph.length == _LENGTH
    beside = papers and scene.load.kind != "none" and abs(scene.drive.voltage) == _AT
    ranges = _FIG_15 if beside else {}
    loaded = [state for state in states if state.deflection is not None]
    return {
        "states": states,
        "backbones": states_plot(states) if any(s.curves for s in states) else "",
        "deflections": deflection_plot(loaded, band, linear, ranges) if loaded else "",
        "rows": [_row(state, linear[state.state], beside=beside) for state in loaded],
        "beside": beside,
        "free": papers,
    }


def _linear(study: Study) -> tuple[Floats, dict[str, Floats]]:
    """Return frequencies (n,) in Hz and the linear deflection (n,) in m of each state (tmm)."""
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


def _row(state: RockingState, linear: Floats, *, beside: bool) -> DeflectionRow:
    found = state.deflection
    assert found is not None
    sizes = np.abs(found.displacement)
    return DeflectionRow(
        state=state.state,
        least=float(sizes.min()),
        largest=float(sizes.max()),
        slope=found.fitted_slope,
        linear=(float(np.nanmin(linear)), float(np.nanmax(linear))),
        ended=found.ended,
        paper=_FIG_15[state.state] if beside else None,
        paper_slope=_SLOPES[state.state] if beside else float("nan"),
    )


def run_in_time(study: Study) -> Simulation | str:
    """Return the run of the paper's Fig 16, or why there is none."""
    from tactgen.validation.checks.motion_measurements import SOURCES
    from tactgen.validation.models.generator.transient import run_scene

    study.announce("the run of Fig 16")
    try:
        return run_scene(
            study.scene,
            SOURCES,
            _UNTIL,
            coil="current",
            accuracy=_QUICK_ACCURACY if study.quick else _ACCURACY,
            announce=study.announce,
        )
    except InputError as error:
        return str(error)


def _time(study: Study) -> Context:
    """Return the run of the paper's Fig 16, as a film and as pictures for paper."""
    from tactgen.validation.checks.motion_measurements import SOURCES
    from tactgen.validation.export.run_motion import still_of_run
    from tactgen.validation.models.generator.phases import phases
    from tactgen.validation.studies.transient.film import film_of
    from tactgen.validation.studies.transient.plot import time_plot

    scene = study.scene
    run = study.alone("run", lambda: run_in_time(study))
    if isinstance(run, str):
        return {"run": None, "refused": run}
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
    """Return the tip's steady amplitude (m) in small motions on either stop; {} if it has none."""
    from tactgen.validation.checks.motion_measurements import DRIVE, SQUARE, small_tip

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
