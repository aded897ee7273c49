"""The response over frequency at several voltages, and the backbone through its peaks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.values import storable
from tactgen.tmm.generator.small_signal import RockingHead
from tactgen.tmm.harmonic_balance.balance import NoConvergence, Orbit
from tactgen.tmm.harmonic_balance.continuation import (
    Branch,
    SpecialPoint,
    folds,
    follow,
    peaks,
    steady_orbit,
)
from tactgen.tmm.harmonic_balance.steady import Resolution, resolved, unstable_exponents

#: Harmonics are added until those left out would move less than this share.
RESOLUTION = Resolution(missing=1e-3, least=5, most=60)
#: Every so many points the unstable exponents are counted; where two counts differ, at all between.
_STRIDE = 6
#: Instants of a period at which the contact is looked at.
_INSTANTS = 256
#: Points of the finer branch by which a peak is judged, and how far it begins before the peak.
_JUDGED_POINTS, _BEFORE = 40, 2


@storable
@dataclass(frozen=True)
class Peak:
    """Where the tip's velocity is largest, in its first harmonic."""

    #: Hz; the bar is the change with twice the harmonics and a tenth of what was missing
    frequency: float
    frequency_bar: float
    #: m/s
    velocity: float
    velocity_bar: float
    displacement: float  #: m
    #: Largest moment on the contact over that at which the head stands on its edge
    moment_share: float


@storable
@dataclass(frozen=True)
class Curve:
    """The response at one voltage, in the order in which it was met."""

    voltage: float  #: Amplitude (V)
    frequencies: Floats  #: (n,) Hz
    displacement: Complex  #: (n,) complex First harmonic of the tip (m)
    stable: Bools  #: (n,) Whether the orbit is stable
    peaks: tuple[Peak, ...]  #: All peaks of the velocity, the largest first
    #: Frequencies at which the curve turns back (Hz), in the order in which they are met
    folds: tuple[float, ...]
    harmonics: int  #: Most harmonics taken
    missing: float  #: Largest share of a motion that they left out
    ended: str  #: Why the curve ends inside the range; empty if it does not


@dataclass(frozen=True)
class Backbone:
    """Curves by growing voltage, and what they are of."""

    head: RockingHead
    curves: tuple[Curve, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the reader of the curves must be told."""
        found = []
        for curve in self.curves:
            if curve.ended:
                found.append(f"at {curve.voltage:g} V {curve.ended}")
            if curve.missing > RESOLUTION.missing:
                found.append(
                    f"at {curve.voltage:g} V {curve.harmonics} harmonics leave out up to "
                    f"{100.0 * curve.missing:.2g} % of the motion"
                )
        return tuple(found)


def backbone(
    head: RockingHead,
    voltages: Sequence[float],
    band: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
) -> Backbone:
    """Response over a band of frequencies (Hz) at each voltage (V).

    Raises InputError if no steady oscillation is found at the band's lower end.
    """
    return Backbone(head, tuple(response_curve(head, u, band, announce) for u in sorted(voltages)))


def response_curve(
    head: RockingHead,
    voltage: float,
    band: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
) -> Curve:
    """Response over a band of frequencies (Hz) at one voltage (V); refusals as above."""
    branch = response_branch(head, voltage, band, announce)
    turns = folds(head.oscillator, branch)
    announce(f"backbone: {voltage:g} V, stability")
    found = [_peak(head, branch, at) for at in peaks(head.oscillator, branch, speed(head))]
    orbits = branch.orbits
    return Curve(
        voltage=voltage,
        frequencies=np.array([o.frequency for o in orbits]),
        displacement=np.array([head.response(o).motion["w_tip"][1] for o in orbits]),
        stable=_stable(head, branch),
        peaks=tuple(sorted(found, key=lambda p: -p.velocity)),
        folds=tuple(at.orbit.frequency for at in turns),
        harmonics=max(o.harmonics for o in orbits),
        missing=branch.missing,
        ended=branch.ended,
    )


def response_branch(
    head: RockingHead,
    voltage: float,
    band: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
) -> Branch:
    """Orbits over a band of frequencies (Hz) at one voltage (V); refusals as above."""
    announce(f"backbone: {voltage:g} V")
    low, high = (2.0 * np.pi * f for f in band)

    def shown(orbit: Orbit) -> None:
        announce(f"backbone: {voltage:g} V, {orbit.frequency:.4g} Hz, {orbit.harmonics} harmonics")

    try:
        start = steady_orbit(head.oscillator, low, voltage, resolution=RESOLUTION)
    except NoConvergence as error:
        raise InputError(
            f"at --voltage {voltage:g} V no response was found to begin with: {error}; begin at "
            "another --frequency, or with less voltage"
        ) from None
    return follow(head.oscillator, start, "omega", low, high, resolution=RESOLUTION, announce=shown)


def speed(head: RockingHead) -> Callable[[Orbit], complex]:
    """What reads the first harmonic of the tip's velocity (m/s) off an orbit."""
    return lambda o: 1j * o.omega * complex(head.response(o).motion["w_tip"][1])


def moment_share(head: RockingHead, orbit: Orbit) -> float:
    """Largest moment on the contact over that at which the head stands on its edge."""
    _, moment = head.contact(orbit, _INSTANTS)
    return float(np.abs(moment).max() / head.stops.upper.tipping_moment(head.place.contact_force))


def _peak(head: RockingHead, branch: Branch, at: SpecialPoint) -> Peak:
    orbit, judge = at.orbit, _judge(head, branch, at)
    size, nan = abs(speed(head)(orbit)), float("nan")
    return Peak(
        frequency=orbit.frequency,
        frequency_bar=abs(judge.frequency - orbit.frequency) if judge else nan,
        velocity=size,
        velocity_bar=abs(abs(speed(head)(judge)) - size) if judge else nan,
        displacement=size / orbit.omega,
        moment_share=moment_share(head, orbit),
    )


def _judge(head: RockingHead, branch: Branch, at: SpecialPoint) -> Orbit | None:
    """Peak again, met on a finer branch; None if that misses it."""
    begin = branch.steps[max(0, at.after - _BEFORE)]
    fine = Resolution(0.1 * RESOLUTION.missing, 2 * at.orbit.harmonics, 2 * RESOLUTION.most)
    try:
        start = resolved(head.oscillator, begin.orbit, fine)
        again = follow(
            head.oscillator, start, "omega", begin.course.low, begin.course.high,
            direction=1 if begin.tangent[-1] > 0.0 else -1, resolution=fine, most=_JUDGED_POINTS,
        )  # fmt: skip
        found = peaks(head.oscillator, again, speed(head))
    except NoConvergence:
        return None
    return found[0].orbit if found else None


def _stable(head: RockingHead, branch: Branch) -> Bools:
    """Which orbits are stable; between two alike that are near, all are taken for alike."""
    orbits = branch.orbits
    counts: dict[int, int | None] = {}

    def count(i: int) -> int | None:
        if i not in counts:
            counts[i] = unstable_exponents(head.oscillator, orbits[i])
        return counts[i]

    stable = np.empty(len(orbits), dtype=bool)
    marks = [*range(0, len(orbits) - 1, _STRIDE), len(orbits) - 1]
    for first, last in zip(marks, [*marks[1:], marks[-1]], strict=True):
        alike = count(first) == count(last)
        for i in range(first, last + 1):
            stable[i] = (count(first) if alike else count(i)) == 0
    return stable
