"""Waveforms: steps and constants, sines, squares, chirps, sampled curves.

A waveform is smooth between its breaks.  At a break it may jump, so a value is asked for with a
time inside the piece that is meant.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from tactgen.geometry.errors import InputError

_TURN = 2.0 * math.pi
#: Switching times of a run beyond which it is refused.
_MOST = 1_000_000


class Waveform(ABC):
    """A value over time."""

    def breaks(self, until: float) -> tuple[float, ...]:
        """Times (s) in (0, until) at which the value jumps or has a kink."""
        return ()

    @abstractmethod
    def value(self, time: float, inside: float) -> float:
        """Value at `time` as the limit from the piece in which `inside` lies."""

    @property
    @abstractmethod
    def peak(self) -> float:
        """Largest size that the value reaches."""

    @property
    def shortest(self) -> float:
        """The shortest time (s) over which it changes smoothly; inf if it does not."""
        return math.inf


@dataclass(frozen=True)
class Step(Waveform):
    """0 before `start`, then `level`, after `stop` 0 again; by default the same at all times."""

    level: float
    start: float = 0.0
    stop: float = math.inf

    def breaks(self, until: float) -> tuple[float, ...]:
        """Start and stop."""
        return tuple(t for t in (self.start, self.stop) if 0.0 < t < until)

    def value(self, time: float, inside: float) -> float:
        """Level between start and stop."""
        return self.level if self.start <= inside < self.stop else 0.0

    @property
    def peak(self) -> float:
        """Size of the level."""
        return abs(self.level)


@dataclass(frozen=True)
class Sine(Waveform):
    """amplitude · sin(2π f (t − start) + phase) from `start` on, 0 before (s, Hz, rad)."""

    amplitude: float
    frequency: float
    phase: float = 0.0
    start: float = 0.0

    def breaks(self, until: float) -> tuple[float, ...]:
        """Start."""
        return (self.start,) if 0.0 < self.start < until else ()

    def value(self, time: float, inside: float) -> float:
        """Sine, 0 before the start."""
        if inside < self.start:
            return 0.0
        return self.amplitude * math.sin(_TURN * self.frequency * (time - self.start) + self.phase)

    @property
    def peak(self) -> float:
        """The amplitude's size."""
        return abs(self.amplitude)

    @property
    def shortest(self) -> float:
        """One period."""
        return 1.0 / self.frequency


@dataclass(frozen=True)
class Square(Waveform):
    """`high` for the first `duty` of each period from `start` on, then `low`; `low` before."""

    high: float
    frequency: float
    low: float = 0.0
    duty: float = 0.5
    start: float = 0.0

    def breaks(self, until: float) -> tuple[float, ...]:
        """All switching times.

        Raises InputError if they are more than a run can have steps.
        """
        period = 1.0 / self.frequency
        count = max(0, math.ceil((until - self.start) / period))
        if 2 * count > _MOST:
            raise InputError(
                f"a square of {self.frequency:g} Hz switches {2 * count} times in {until:g} s, "
                f"more than {_MOST}; ask for a shorter time or a lower frequency"
            )
        edges = (
            self.start + (k + share) * period for k in range(count) for share in (0.0, self.duty)
        )
        return tuple(t for t in edges if 0.0 < t < until)

    def value(self, time: float, inside: float) -> float:
        """One of the two levels."""
        turns = (inside - self.start) * self.frequency
        return self.high if inside >= self.start and turns % 1.0 < self.duty else self.low

    @property
    def peak(self) -> float:
        """The larger level's size."""
        return max(abs(self.high), abs(self.low))


@dataclass(frozen=True)
class Chirp(Waveform):
    """A sine whose frequency runs evenly from `first` to `last` within `duration`, and stays."""

    amplitude: float
    first: float
    last: float
    duration: float

    def breaks(self, until: float) -> tuple[float, ...]:
        """End of the run."""
        return (self.duration,) if self.duration < until else ()

    def value(self, time: float, inside: float) -> float:
        """Sine of the phase run through so far."""
        t = min(time, self.duration)
        turns = self.first * t + 0.5 * (self.last - self.first) * t * t / self.duration
        turns += self.last * (time - t)
        return self.amplitude * math.sin(_TURN * turns)

    @property
    def peak(self) -> float:
        """The amplitude's size."""
        return abs(self.amplitude)

    @property
    def shortest(self) -> float:
        """One period of the higher frequency."""
        return 1.0 / max(self.first, self.last)


@dataclass(frozen=True)
class Sampled(Waveform):
    """Straight between samples (s, value), held at the ends; two at one time are a jump."""

    times: tuple[float, ...]
    values: tuple[float, ...]

    def breaks(self, until: float) -> tuple[float, ...]:
        """Times of the samples."""
        return tuple(sorted({t for t in self.times if 0.0 < t < until}))

    def value(self, time: float, inside: float) -> float:
        """Straight line of the piece."""
        after = bisect_right(self.times, inside)
        if after == 0:
            return self.values[0]
        if after == len(self.times):
            return self.values[-1]
        low, high = self.times[after - 1], self.times[after]
        share = (time - low) / (high - low)
        return (1.0 - share) * self.values[after - 1] + share * self.values[after]

    @property
    def peak(self) -> float:
        """The largest sample's size."""
        return max(map(abs, self.values))


@dataclass(frozen=True)
class Sources:
    """Sources: volts across the bimorph, amperes or volts in the coil."""

    bimorph: Waveform = Step(0.0)
    coil: Waveform = Step(0.0)


def between_breaks(sources: Sources, until: float) -> Iterator[tuple[float, float]]:
    """Yield the pieces from 0 to `until` (s) in which all sources are smooth."""
    breaks = {*sources.bimorph.breaks(until), *sources.coil.breaks(until)}
    yield from pairwise(sorted({0.0, until, *breaks}))
