"""The phases of a run by where the rod is: held down, rising, pressed up, falling."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tactgen.validation.models.generator.transient import Simulation

#: A rod so close to a stop (m) is on it: far above a contact's approach, far below the stroke.
_NEAR = 2e-6
#: What is shorter (s) belongs to the phase before: a bounce.
_SHORT = 0.15e-3
#: Instants at which an oscillation is fitted within a phase.
_SAMPLES = 500


@dataclass(frozen=True)
class Phase:
    """A stretch of time.

    Attributes
    ----------
    name : {"held", "rising", "pressed", "falling"}
    start, end : float
        s.
    amplitude : float
        Half the way between the outermost positions of the tip in it, laterally (m); what drifts
        counts too.  For the answer to the drive alone see :func:`oscillation`.
    """

    name: str
    start: float
    end: float
    amplitude: float


def phases(found: Simulation) -> tuple[Phase, ...]:
    """Return the phases of a run in order."""
    run, tip = found.answer.run, found.answer.outputs["lateral_tip"]
    lift = found.answer.outputs["rod_lift"]
    state = np.where(lift < -found.stroke + _NEAR, -1, np.where(lift > -_NEAR, 1, 0))
    edges = np.flatnonzero(np.diff(state)) + 1
    bounds = [0, *edges.tolist(), state.size - 1]
    stretches: list[tuple[int, int, int]] = []  # state, first, last
    for first, last in pairwise(bounds):
        if last == first:
            continue
        short = run.time[last] - run.time[first] < _SHORT
        if stretches and (short or stretches[-1][0] == state[first]):
            stretches[-1] = (stretches[-1][0], stretches[-1][1], last)
        else:
            stretches.append((int(state[first]), first, last))
    result = []
    came = 1
    for kind, first, last in stretches:
        if kind:
            came = kind
        name = {1: "pressed", -1: "held", 0: "falling" if came > 0 else "rising"}[kind]
        part = tip[first : last + 1]
        result.append(
            Phase(name, float(run.time[first]), float(run.time[last]), 0.5 * float(np.ptp(part)))
        )
    return tuple(result)


def oscillation(found: Simulation, phase: Phase, frequency: float) -> float | None:
    """Return the tip's lateral amplitude (m) at a frequency (Hz) within a phase.

    That of the sine which, beside a straight line, comes nearest to the tip's motion: where a blow
    has shifted the head, the finger lets the tip follow over milliseconds, which is no oscillation.
    None if the phase is shorter than half a period and holds too little of it.
    """
    run, tip = found.answer.run, found.answer.outputs["lateral_tip"]
    lasts = phase.end - phase.start
    if lasts < 0.5 / frequency:
        return None
    time = np.linspace(phase.start, phase.end, _SAMPLES)
    turn = 2.0 * np.pi * frequency * time
    along = (time - phase.start) / lasts
    columns = np.column_stack([np.sin(turn), np.cos(turn), np.ones_like(time), along])
    fitted = np.linalg.lstsq(columns, np.interp(time, run.time, tip), rcond=None)[0]
    return float(np.hypot(fitted[0], fitted[1]))
