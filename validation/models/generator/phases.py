"""The phases of a run by where the rod is: held down, rising, pressed up, falling."""

from __future__ import annotations

from collections.abc import Sequence
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
        counts too.  For the answer to the drive alone see :func:`common_oscillation`.
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


def common_oscillation(
    seen: Sequence[tuple[Simulation, Phase, float]], frequency: float
) -> complex:
    """Return the complex amplitude (m) at a frequency (Hz) that phases of several runs share.

    The tip moves as its real part times e^{j(2π f t + angle)}, and in each phase beside a straight
    line of that phase's own: where a blow has shifted the head, the finger lets the tip follow over
    milliseconds, which is no oscillation.  Of runs whose drives are a quarter of a period apart
    half a period is enough: what resembles a line in one of them does not in the other.

    Parameters
    ----------
    seen : sequence of (Simulation, Phase, float)
        Each with the angle of its drive (rad).
    """
    rows, values = [], []
    for number, (found, phase, angle) in enumerate(seen):
        time = np.linspace(phase.start, phase.end, _SAMPLES)
        turn = 2.0 * np.pi * frequency * time + angle
        lines = np.zeros((_SAMPLES, 2 * len(seen)))
        lines[:, 2 * number] = 1.0
        lines[:, 2 * number + 1] = (time - phase.start) / (phase.end - phase.start)
        rows.append(np.column_stack([np.cos(turn), -np.sin(turn), lines]))
        run, tip = found.answer.run, found.answer.outputs["lateral_tip"]
        values.append(np.interp(time, run.time, tip))
    fitted = np.linalg.lstsq(np.vstack(rows), np.concatenate(values), rcond=None)[0]
    return complex(fitted[0], fitted[1])
