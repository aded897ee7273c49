"""A run: time steps chosen to a tolerance, then halved everywhere to measure the error.

The first pass chooses the steps: the distance from a predictor of second order says how much a
step errs; steps are halved where that is too much (impacts) and doubled where it is little.
Another goes over the same steps in pairs, the last in halves: it is the result, and the distances
between the three give its error bar (tmm.generator.observed_order).  If that exceeds what was
asked, all are repeated with shorter steps; unless it has grown as large as the motion: then the
answer says up to which time it is certain.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.passes import MOST_STEPS, Marcher, Passes
from tactgen.tmm.generator.transient.record import Run
from tactgen.tmm.generator.transient.step import Stepper
from tactgen.tmm.generator.transient.system import System
from tactgen.tmm.generator.transient.waveform import Sources, between_breaks

#: Longest step as a share of the fastest waveform's period, and of the whole time.
_PER_PERIOD, _PER_RUN = 1.0 / 64.0, 0.01
#: Local tolerance of the first round over the accuracy asked for.
_LOCAL = 0.01
#: Rounds of all passes, the share of the accuracy that the next round aims at, and the most by
#: which it lowers the local tolerance: an impact's first error says little about the next.
_ROUNDS, _AIM, _LOWERED = 4, 0.5, 0.1
#: Error of a round, over the outputs' scales, beyond which no other is made: bounces amplify small
#: differences until they are as large as the motion, and shorter steps only move the time of that.
_HOPELESS = 1.0


@dataclass(frozen=True)
class Answer:
    """A run with what it is worth.

    Attributes
    ----------
    run : Run
        With every chosen step halved.
    outputs : dict of str to (k,) float
        The system's outputs over time.
    bars : dict of str to (k,) float
        Error bar of each output up to each time, in its unit, by the largest distances between
        the passes until then.
    error : float
        The largest of all bars over its output's scale.
    certain_until : float
        Time (s) up to which no bar exceeds the accuracy.
    accuracy : float
        What was asked for.
    rounds : int
        How often all passes were made.
    """

    run: Run
    outputs: dict[str, Floats]
    bars: dict[str, Floats]
    error: float
    certain_until: float
    accuracy: float
    rounds: int

    @property
    def errors(self) -> dict[str, float]:
        """Bar of each output over the whole run, in its unit."""
        return {name: float(bar[-1]) for name, bar in self.bars.items()}


def simulate(
    system: System,
    sources: Sources,
    until: float,
    *,
    position: Floats | None = None,
    velocity: Floats | None = None,
    accuracy: float = 1e-3,
    longest: float = math.inf,
    announce: Callable[[float], None] = lambda _: None,
) -> Answer:
    """Return what a system does under its sources from 0 to `until` (s).

    Parameters
    ----------
    position, velocity : (n,) float, optional
        At the start; 0 by default.
    accuracy : float
        Error of the outputs, over their scales, that is aimed at.
    longest : float
        Longest step (s), besides a share of the fastest waveform's period.
    announce : callable
        Is told now and then which share of the work is done.

    Raises
    ------
    InputError
        If a step does not settle however short, the run needs too many, or the coil's current or
        gap leaves what is known of it.
    """
    n = system.mass.shape[0]
    first = Stepper(system).start(
        np.zeros(n) if position is None else position,
        np.zeros(n) if velocity is None else velocity,
        *_at_start(system, sources, until),
    )
    fastest = min(sources.bimorph.shortest, sources.coil.shortest)
    longest = min(longest, _PER_PERIOD * fastest, _PER_RUN * until)
    if until > MOST_STEPS * longest:
        raise InputError(
            f"{until:g} s of a waveform that changes within {fastest:g} s need more than "
            f"{MOST_STEPS} steps; ask for a shorter time or a lower frequency"
        )
    local = _LOCAL * accuracy
    rounds = 0
    while True:
        rounds += 1
        marcher = Marcher(system, sources, until, announce)
        passes = marcher.passes(first, longest, local)
        outputs, bars, relative = _compared(system, passes)
        error = float(relative[-1])
        if error <= accuracy or error > _HOPELESS or rounds == _ROUNDS:
            break
        # the error of a run goes as the square of its steps, that of a step as the cube
        local *= max((_AIM * accuracy / error) ** 1.5, _LOWERED)
    run = passes.fine
    certain = run.time[max(int(np.searchsorted(relative, accuracy, "right")) - 1, 0)]
    return Answer(run, outputs, bars, error, float(certain), accuracy, rounds)


def simulate_steps(
    system: System,
    sources: Sources,
    until: float,
    steps: int,
    *,
    position: Floats | None = None,
    velocity: Floats | None = None,
) -> Run:
    """Return a run in equal steps, `steps` between every two breaks of the sources."""
    n = system.mass.shape[0]
    first = Stepper(system).start(
        np.zeros(n) if position is None else position,
        np.zeros(n) if velocity is None else velocity,
        *_at_start(system, sources, until),
    )
    pieces = [
        (
            0.5 * (a + b),
            a,
            [(t, (b - a) / steps) for t in np.linspace(a, b, steps + 1)[1:].tolist()],
        )
        for a, b in between_breaks(sources, until)
    ]
    return Marcher(system, sources, until, lambda _: None).follow(first, pieces, parts=1)[0]


def _at_start(system: System, sources: Sources, until: float) -> tuple[float, float]:
    """Return the voltage across the bimorph and the current just before the start."""
    by_current = system.coil is not None and system.coil.source == "current"
    inside = 0.5 * next(between_breaks(sources, until))[1]
    current = sources.coil.value(0.0, inside) if by_current else 0.0
    return sources.bimorph.value(0.0, inside), current


def _read(row: Floats, run: Run) -> Floats:
    return run.position @ row


def _compared(
    system: System, passes: Passes
) -> tuple[dict[str, Floats], dict[str, Floats], Floats]:
    """Return the outputs, their bars up to each time, and the largest of these over its scale."""
    fine = passes.fine
    outputs: dict[str, Floats] = {}
    bars: dict[str, Floats] = {}
    relative = np.zeros(fine.time.size)
    for name, output in system.outputs.items():
        outputs[name] = fine.position @ output.row
        bars[name] = passes.bar(partial(_read, output.row))
        relative = np.maximum(relative, bars[name] / output.scale)
    if system.coil is not None and system.coil.source == "voltage":
        outputs["current"] = fine.current
        bars["current"] = passes.bar(lambda run: run.current)
        largest = float(np.abs(fine.current).max())
        relative = np.maximum(relative, bars["current"] / largest) if largest else relative
    return outputs, bars, relative
