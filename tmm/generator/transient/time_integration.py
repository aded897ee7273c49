"""A run: time steps chosen to a tolerance, then halved everywhere to measure the error.

The first pass chooses the steps: the distance from a predictor of second order says how much a
step errs; steps are halved where that is too much (impacts) and doubled where it is little.
Another goes over the same steps in pairs, the last in halves: it is the result, and the distances
between the three give its error.  If that exceeds what was asked, all are repeated with shorter
steps; unless it has grown as large as the motion: then the answer says up to which time it is
certain.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.errors import InputError
from tactgen.tmm.generator.transient.step import Flow, State, Stepper, StepTooLongError
from tactgen.tmm.generator.transient.system import System
from tactgen.tmm.generator.transient.waveform import Sources, between_breaks


@dataclass(frozen=True)
class Run:
    """Results of a run at its times (k,)."""

    time: Floats  #: (k,) s; a time at which a source jumps appears twice
    #: (k, n) Coordinates of the system
    position: Floats
    velocity: Floats
    #: (k,) V; A or V
    voltage: Floats
    coil_source: Floats
    #: (k,) A, Wb, m, N, C
    current: Floats
    flux_linkage: Floats
    gap: Floats
    pull: Floats
    charge: Floats
    #: (k,) Energies: of motion, of the structure, of springs and stops, of constant forces, of the
    #: magnetic field, of the bimorph's capacitance (J)
    kinetic: Floats
    strain: Floats
    springs: Floats
    load: Floats
    magnetic: Floats
    electric: Floats
    #: (k,) Given by the sources since the start (J)
    bimorph_work: Floats
    coil_work: Floats
    #: (k,) Taken by dampers, by springs and stops, by the circuit's resistance since the start (J)
    structure_loss: Floats
    element_loss: Floats
    wire_loss: Floats
    #: (k,) Sum since the start of the sizes of all works, losses and changes of one kind of energy
    #: (J): what the balance is judged by
    throughput: Floats

    @property
    def energy(self) -> Floats:
        """All that is stored (k,), in J."""
        mechanical = self.kinetic + self.strain + self.springs + self.load
        return mechanical + self.magnetic + self.electric

    @property
    def imbalance(self) -> Floats:
        """Stored energy less start, works and losses (k,), in J: rounding only."""
        lost = self.structure_loss + self.element_loss + self.wire_loss
        given = self.bimorph_work + self.coil_work
        return np.asarray(self.energy - self.energy[0] - given + lost)

    @property
    def worst_imbalance(self) -> float:
        """Largest energy imbalance relative to throughput or stored energy.

        What rests exchanges rounding only, of which nothing is a share; 0 without any energy.
        """
        kinds = (self.kinetic, self.strain, self.springs, self.load, self.magnetic, self.electric)
        stored = sum(float(np.abs(kind).max()) for kind in kinds)
        whole = max(float(self.throughput[-1]), stored)
        return float(np.abs(self.imbalance).max()) / whole if whole > 0.0 else 0.0


#: Time (s), state, energies exchanged on the way, what the coil's source says.
Record = list[tuple[float, State, Flow, float]]


def recorded(system: System, record: Record) -> Run:
    """Run of its states; the energies are worked out all at once."""
    s, (times, states, flows, sources) = system, zip(*record, strict=True)
    position, velocity, change, step, voltage, current, gap = (
        np.array([getattr(state, name) for state in states])
        for name in ("position", "velocity", "change", "lasted", "voltage", "current", "gap")
    )
    coenergy, linkage, pull = np.array([state.field[:3] for state in states]).T
    before = np.concatenate([voltage[:1], voltage[:-1]])
    given = change @ s.coupling + s.capacitance * (voltage - before)
    # nothing moves where no time passes
    structure = _squares(change, s.damping) / np.where(step > 0.0, step, 1.0)
    stored = np.zeros(len(record))
    for element in s.elements:
        deformed = position @ np.atleast_2d(element.direction).T + element.offset
        stored += element.law.energy(deformed).sum(axis=1)
    energies = np.array(
        [
            0.5 * _squares(velocity, s.mass),
            0.5 * _squares(position, s.stiffness),
            stored,
            -position @ s.load,
            current * linkage - coenergy,
            0.5 * s.capacitance * voltage**2,
        ]
    )
    coil, elements, wire = np.array(flows).T
    exchanged = np.array([0.5 * (before + voltage) * given, coil, structure, elements, wire])
    moved = np.abs(np.diff(energies, prepend=energies[:, :1])).sum(axis=0)
    sums = np.cumsum(np.vstack([exchanged, moved + np.abs(exchanged).sum(axis=0)]), axis=1)
    return Run(
        np.array(times), position, velocity, voltage, np.array(sources), current, linkage, gap,
        pull, position @ s.coupling + s.capacitance * voltage, *energies, *sums,
    )  # fmt: skip


def _squares(rows: Floats, matrix: Floats) -> Floats:
    """Row · matrix · row for each row (k,)."""
    return np.asarray(np.einsum("ki,ki->k", rows @ matrix, rows))


def output_at(run: Run, row: Floats, at: Floats) -> Floats:
    """Output of a run at other times (s): cubics through its values and rates."""
    value, rate = run.position @ row, run.velocity @ row
    k = np.clip(np.searchsorted(run.time, at, "right") - 1, 0, run.time.size - 2)
    h = run.time[k + 1] - run.time[k]
    s = (at - run.time[k]) / h
    rise = value[k + 1] - value[k]
    bend = s * (1.0 - s)
    start, end = h * rate[k] - rise, rise - h * rate[k + 1]
    return np.asarray(value[k] + s * rise + bend * ((1.0 - s) * start + s * end))


#: Least and largest ratio of the distances that is believed.
_LEAST, _MOST = 0.25, 2.0 / 3.0


def error_bar(larger: Floats, smaller: Floats, safety: float) -> Floats:
    """Error bar (k,) of the finest answers.

    Parameters
    ----------
    larger, smaller : (k,) float
        Distance of the first answers from the second, of the second from the last; 0 or more.
    safety : float
        Factor on the error; the grid convergence index takes 1.25 where the order is observed.
    """
    within = np.clip(smaller, _LEAST * larger, _MOST * larger)
    whole = np.where(larger > 0.0, larger, 1.0)
    ratio = np.where(larger > 0.0, within / whole, _MOST)
    return np.asarray(safety * np.maximum(smaller, _LEAST * larger) * ratio / (1.0 - ratio))


#: Steps between two breaks: a time inside the piece, the start, each step's end and length (s).
#: Equal lengths are equal to the last digit, so that they share their matrices.
Piece = tuple[float, float, list[tuple[float, float]]]


def paired(pieces: list[Piece]) -> tuple[list[Piece], Bools]:
    """Steps with neighbours of equal length joined.

    Also which of the times at which the given steps start or end are kept, (k,).
    """
    found, kept = [], []
    for inside, start, ends in pieces:
        longer: list[tuple[float, float]] = []
        kept.append(True)
        at = 0
        while at < len(ends):
            whole = at + 1 < len(ends) and ends[at][1] == ends[at + 1][1]
            end, h = ends[at + whole]
            longer.append((end, 2.0 * h if whole else h))
            kept += [False, True] if whole else [True]
            at += 1 + whole
        found.append((inside, start, longer))
    return found, np.array(kept)


def spread(values: Floats, ends: Bools) -> Floats:
    """Values at some of the times, those of `ends` (k,), at all: that of the next end."""
    after: Ints = np.cumsum(ends) - ends
    return np.asarray(values[after])


#: Halvings of the longest step that are tried, and those after each break, where nothing is known.
_DEEPEST, _FIRST = 20, 6
#: Share of a circuit's time constant that the first step after a break takes.
_PER_LAG = 0.02
#: How much further the predictor is from the truth than the step.
_PREDICTOR = 6.0
#: A step is doubled where its error is below this share of the tolerance: an eighth, with margin.
_EASY = 0.06
#: Safety factor of the bars: with 1.25, 8 of 200 outputs of random runs with contact lay outside,
#: all but two of them by less than a fifth.
_SAFETY = 1.5
#: Steps after which a run is given up.
MOST_STEPS = 3_000_000


@dataclass(frozen=True)
class Passes:
    """Three runs over the same steps: in pairs, as chosen, in halves.

    `ends` says which times of the first end a step of it; `of_coarse` and `of_fine` which times of
    the other two the run before has as well.
    """

    coarsest: Run
    coarse: Run
    fine: Run
    ends: Bools
    of_coarse: Bools
    of_fine: Bools

    def bar(self, of: Callable[[Run], Floats]) -> Floats:
        """Error over time of a readout of the last run."""
        first, middle, last = (of(run) for run in (self.coarsest, self.coarse, self.fine))
        larger = np.maximum.accumulate(np.abs(middle[self.of_coarse] - first[self.ends]))
        smaller = np.maximum.accumulate(np.abs(last[self.of_fine] - middle))
        bar = error_bar(spread(larger, self.of_coarse), smaller, _SAFETY)
        return spread(np.maximum.accumulate(bar), self.of_fine)


class Marcher:
    """Goes over the pieces between breaks, and records."""

    def __init__(
        self, system: System, sources: Sources, until: float, announce: Callable[[float], None]
    ) -> None:
        self._system, self._sources, self._until = system, sources, until
        self._announce = announce
        self._stepper = Stepper(system)
        outputs = system.outputs.values()
        rows = [o.row / (o.step_scale or o.scale) for o in outputs]
        self._rows = np.array([row for row in rows if row.any()]).reshape(-1, system.mass.shape[0])

    def passes(self, first: State, longest: float, local: float) -> Passes:
        """Three runs over steps whose local errors are below `local`."""
        chosen, coarse = self.choose(first, longest, local)
        longer, of_coarse = paired(chosen)
        coarsest, ends = self.follow(first, longer, parts=1, share=(2 / 7, 3 / 7), rough=True)
        fine, of_fine = self.follow(first, chosen, parts=2, share=(3 / 7, 1.0))
        return Passes(coarsest, coarse, fine, ends, of_coarse, of_fine)

    def choose(self, first: State, longest: float, local: float) -> tuple[list[Piece], Run]:
        """Steps whose local errors are below `local`, and the run with them."""
        record: Record = []
        state, chosen = first, []
        for start, end in between_breaks(self._sources, self._until):
            inside = 0.5 * (start + end)
            state = self._jumped(state, start, inside, record)
            count = max(1, math.ceil((end - start) / longest))
            done, whole = 0, count << _DEEPEST
            level = self._first_level(state, (end - start) / count)
            ends: list[tuple[float, float]] = []
            earlier: list[State] = []
            while done < whole:
                ticks = 1 << (_DEEPEST - level)
                time = start + (end - start) * ((done + ticks) / whole)
                h = (end - start) * (ticks / whole)
                try:
                    new, flow = self._stepped(state, h, time, inside)
                    off = self._local_error(earlier, state, new, h)
                except StepTooLongError:
                    if level == _DEEPEST:
                        raise InputError(_never_settles(time)) from None
                    off = math.inf
                if off > local and level < _DEEPEST:
                    level += 1
                    continue
                self._keep(record, time, new, flow, inside)
                earlier, state = [*earlier[-1:], state], new
                ends.append((time, h))
                done += ticks
                if len(record) > MOST_STEPS:
                    raise InputError(
                        f"more than {MOST_STEPS} steps are needed, and {time * 1e3:.6g} ms were "
                        "reached; ask for a shorter time or a larger accuracy, or make stops and "
                        "circuit less stiff"
                    )
                if level > 0 and off < _EASY * local and done % (2 * ticks) == 0:
                    level -= 1
                self._announce(2.0 / 7.0 * time / self._until)
            chosen.append((inside, start, ends))
        return chosen, recorded(self._system, record)

    def follow(
        self,
        first: State,
        pieces: Sequence[Piece],
        parts: int,
        *,
        share: tuple[float, float] = (0.0, 1.0),
        rough: bool = False,
    ) -> tuple[Run, Bools]:
        """Run with each given step cut in parts, and which times end a given step.

        `share` is what is done of the whole work before and afterwards.  A `rough` run may leave
        what is known of the coil: it only judges another run.
        """
        record: Record = []
        state, shared = first, []
        done, all_done = share
        for inside, start, ends in pieces:
            state = self._jumped(state, start, inside, record)
            shared.append(True)
            for end, whole in ends:
                h = whole / parts
                for part in range(1, parts + 1):
                    time = end if part == parts else end - (parts - part) * h
                    for at, new, flow in self._in_pieces(state, h, time, inside):
                        self._keep(record, at, new, flow, inside, rough=rough)
                        state = new
                        shared.append(part == parts and at == time)
                self._announce(done + (all_done - done) * end / self._until)
        return recorded(self._system, record), np.array(shared)

    def _first_level(self, state: State, longest: float) -> int:
        """Halvings of the longest step after a break, where sources may jump.

        A circuit answers a jump within L/R, which the first step must resolve: the implicit
        midpoint rule does not damp what it steps over.
        """
        coil = self._system.coil
        if coil is None or coil.source != "voltage" or coil.resistance == 0.0:
            return _FIRST
        lag = state.field.inductance / coil.resistance
        level = math.ceil(math.log2(max(longest / (_PER_LAG * lag), 1.0)))
        if level > _DEEPEST:
            raise InputError(
                f"the coil's circuit answers within {lag:.3g} s (its inductance over its "
                "resistance), too short to be followed; prescribe the coil's current instead of "
                "its voltage"
            )
        return max(level, _FIRST)

    def _in_pieces(
        self, state: State, h: float, time: float, inside: float, depth: int = 0
    ) -> Iterator[tuple[float, State, Flow]]:
        """Yield the states of a step, which is halved where it does not settle."""
        try:
            new, flow = self._stepped(state, h, time, inside)
        except StepTooLongError:
            if depth == _DEEPEST:
                raise InputError(_never_settles(time)) from None
            for end in (time - 0.5 * h, time):
                for found in self._in_pieces(state, 0.5 * h, end, inside, depth + 1):
                    state = found[1]
                    yield found
            return
        yield time, new, flow

    def _stepped(self, state: State, h: float, time: float, inside: float) -> tuple[State, Flow]:
        """State at `time`, `h` later."""
        coil = self._sources.coil
        source = coil.value(time - h, inside), coil.value(time, inside)
        return self._stepper.step(state, h, self._sources.bimorph.value(time, inside), source)

    def _jumped(self, state: State, time: float, inside: float, record: Record) -> State:
        """State after the sources' jumps at `time`, recorded."""
        source = self._sources.coil.value(time, inside)
        voltage = self._sources.bimorph.value(time, inside)
        new, flow = self._stepper.jump(state, voltage, source)
        record.append((time, new, flow, source))
        return new

    def _local_error(self, earlier: list[State], state: State, new: State, h: float) -> float:
        """Step's error over the outputs' scales, by its distance from a predictor."""
        if not earlier:
            return 0.0
        ahead = state.position + h * state.velocity + 0.5 * h * h * state.acceleration
        off = float(np.abs(self._rows @ (new.position - ahead)).max(initial=0.0))
        coil = self._system.coil
        if coil is not None and coil.source == "voltage" and len(earlier) == 2:
            scale = self._sources.coil.peak / coil.resistance if coil.resistance else math.inf
            off = max(off, abs(_bend(earlier, state, new, h)) / scale)
        return off / _PREDICTOR

    def _keep(
        self,
        record: Record,
        time: float,
        new: State,
        flow: Flow,
        inside: float,
        *,
        rough: bool = False,
    ) -> None:
        """Record a step, if the coil is still where it is known, or that does not matter."""
        coil = None if rough else self._system.coil
        if coil is not None and abs(new.current) > coil.largest_current:
            raise InputError(
                f"at {time * 1e3:.6g} ms the current is {new.current * 1e3:.6g} mA, beyond the "
                f"{coil.largest_current * 1e3:.6g} mA to which the co-energy map goes; drive the "
                "coil less"
            )
        if coil is not None and not coil.gaps[0] <= new.gap <= coil.gaps[1]:
            low, high = coil.gaps
            raise InputError(
                f"at {time * 1e3:.6g} ms the gap is {new.gap * 1e6:.6g} um, outside the "
                f"{low * 1e6:.6g} to {high * 1e6:.6g} um of the co-energy map; give the stops more "
                "stiffness or drive the coil less"
            )
        record.append((time, new, flow, self._sources.coil.value(time, inside)))


def _bend(earlier: list[State], state: State, new: State, h: float) -> float:
    """Distance of the current from the parabola through the three before it (A)."""
    first, second = earlier
    h1, h2 = state.lasted, second.lasted
    slope1 = (state.current - second.current) / h1
    slope2 = (second.current - first.current) / h2
    curve = (slope1 - slope2) / (h1 + h2)
    return new.current - (state.current + h * (slope1 + curve * (h + h1)))


def _never_settles(time: float) -> str:
    return (
        f"at {time * 1e3:.6g} ms no step, however short, settles; give the stops less stiffness, "
        "or the coil's circuit a longer time constant"
    )


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
    """Run with its errors."""

    run: Run  #: With every chosen step halved
    outputs: dict[str, Floats]  #: The system's outputs over time
    #: Error bar of each output up to each time, in its unit, by the largest distances between the
    #: passes until then
    bars: dict[str, Floats]
    error: float  #: The largest of all bars over its output's scale
    certain_until: float  #: Time (s) up to which no bar exceeds the accuracy
    accuracy: float  #: What was asked for
    rounds: int  #: How often all passes were made

    @property
    def errors(self) -> dict[str, float]:
        """Bar of each output over the whole run, in its unit."""
        return {name: float(bar[-1]) for name, bar in self.bars.items()}


def simulate(
    system: System,
    sources: Sources,
    until: float,
    *,
    position: Floats | float = 0.0,
    velocity: Floats | float = 0.0,
    accuracy: float = 1e-3,
    longest: float = math.inf,
    announce: Callable[[float], None] = lambda _: None,
) -> Answer:
    """Simulation of a system under its sources from 0 to `until` (s).

    Parameters
    ----------
    position, velocity : (n,) float, optional
        At the start.
    accuracy : float
        Error of the outputs, over their scales, that is aimed at.
    longest : float
        Longest step (s), besides a share of the fastest waveform's period.
    announce : callable
        Is told now and then which share of the work is done.

    Raises InputError if a step does not settle however short, the run needs too many, or the coil's
    current or gap leaves what is known of it.
    """
    first = _at_start(system, sources, until, position, velocity)
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
    position: Floats | float = 0.0,
    velocity: Floats | float = 0.0,
) -> Run:
    """Run in equal steps, `steps` between every two breaks of the sources."""
    first = _at_start(system, sources, until, position, velocity)
    pieces: list[Piece] = []
    for a, b in between_breaks(sources, until):
        ends = np.linspace(a, b, steps + 1)[1:].tolist()
        pieces.append((0.5 * (a + b), a, [(t, (b - a) / steps) for t in ends]))
    return Marcher(system, sources, until, lambda _: None).follow(first, pieces, parts=1)[0]


def _at_start(
    system: System,
    sources: Sources,
    until: float,
    position: Floats | float,
    velocity: Floats | float,
) -> State:
    """State with the bimorph's voltage and the coil's current as they are just after the start."""
    by_current = system.coil is not None and system.coil.source == "current"
    inside = 0.5 * next(between_breaks(sources, until))[1]
    current = sources.coil.value(0.0, inside) if by_current else 0.0
    still = np.zeros(system.mass.shape[0])
    voltage = sources.bimorph.value(0.0, inside)
    return Stepper(system).start(still + position, still + velocity, voltage, current)


def _read(row: Floats, run: Run) -> Floats:
    return run.position @ row


def _compared(
    system: System, passes: Passes
) -> tuple[dict[str, Floats], dict[str, Floats], Floats]:
    """Outputs, their bars up to each time, and the largest of these over its scale."""
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
