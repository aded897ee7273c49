"""Deflection under load where the head may rock, and the voltage for a deflection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.values import storable
from tactgen.tmm.generator.rocking import RockingHead
from tactgen.tmm.harmonic_balance.balance import Orbit
from tactgen.tmm.harmonic_balance.continuation import follow
from tactgen.tmm.harmonic_balance.steady import Resolution, equilibrium

#: Far beyond the moment that tips the head the contact is nearly a kink; harmonics left out may
#: move this share there.
RESOLUTION = Resolution(missing=3e-3, least=5, most=60)
#: Frequencies, evenly spaced, to which a line is fitted.
_FITTED = 300


@storable
@dataclass(frozen=True)
class LoadedDeflection:
    """First harmonic of the tip under load over frequency, in the order in which it was met.

    Attributes
    ----------
    frequencies : (n,) array
        Hz.
    displacement : (n,) complex array
        m.
    ended : str
        Why it ends inside the band; empty if it does not.
    """

    frequencies: Floats
    displacement: Complex
    ended: str

    @property
    def fitted_slope(self) -> float:
        """Slope (m/Hz) of the line fitted to its magnitude at evenly spaced frequencies."""
        at = np.linspace(self.frequencies[0], self.frequencies[-1], _FITTED)
        sizes = np.interp(at, self.frequencies, np.abs(self.displacement))
        return float(np.polyfit(at, sizes, 1)[0])


def loaded_deflection(
    head: RockingHead,
    voltage: float,
    band: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
) -> LoadedDeflection:
    """Return the response to a large voltage (V) over a band (Hz).

    The voltage is raised at the lower end, then the frequency.

    Raises
    ------
    InputError
        If the response cannot be followed up to that voltage.
    """
    raised = _raised(head, band[0], voltage)
    announce(f"deflection at {voltage:g} V")
    low, high = (2.0 * np.pi * f for f in band)
    start = replace(raised[-1], omega=low)
    branch = follow(head.oscillator, start, "omega", low, high, resolution=RESOLUTION)
    return LoadedDeflection(
        frequencies=np.array([o.frequency for o in branch.orbits]),
        displacement=np.array([_tip(head, o) for o in branch.orbits]),
        ended=branch.ended,
    )


def voltage_for(head: RockingHead, frequency: float, displacement: float, most: float) -> float:
    """Return the lowest voltage (V) at which the tip's first harmonic reaches a displacement (m).

    Straight between the points of the branch, which are a few percent apart at most.

    Raises
    ------
    InputError
        If it is not reached up to `most`, or the response cannot be followed so far.
    """
    orbits = _raised(head, frequency, most)
    sizes = np.abs([_tip(head, o) for o in orbits])
    after = int(np.argmax(sizes >= displacement))
    if sizes[after] < displacement:
        raise InputError(
            f"{1e6 * displacement:g} um at {frequency:g} Hz is not reached with {most:g} V; ask "
            "for less"
        )
    before = after - 1
    levels = [orbits[i].level for i in (before, after)]
    return float(np.interp(displacement, sizes[before : after + 1], levels))


def _tip(head: RockingHead, orbit: Orbit) -> complex:
    return complex(head.response(orbit).motion["w_tip"][1])


def _raised(head: RockingHead, frequency: float, voltage: float) -> tuple[Orbit, ...]:
    """Return orbits from rest up to a voltage."""
    rest = equilibrium(head.oscillator).with_harmonics(RESOLUTION.least)
    start = replace(rest, omega=2.0 * np.pi * frequency)
    branch = follow(head.oscillator, start, "level", 0.0, voltage, resolution=RESOLUTION)
    if branch.ended or branch.orbits[-1].level < voltage:
        raise InputError(
            f"at {frequency:g} Hz the response cannot be followed up to {voltage:g} V "
            f"({branch.ended or 'it leads back to rest'}); ask for less"
        )
    return branch.orbits
