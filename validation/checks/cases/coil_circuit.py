"""A coil of constant inductance in a circuit, by the machine's own steps in time."""

from __future__ import annotations

import numpy as np

from tactgen.tmm.generator.transient.march import simulate_steps
from tactgen.tmm.generator.transient.record import Run
from tactgen.tmm.generator.transient.system import Coil, System
from tactgen.tmm.generator.transient.waveform import Sine, Sources, Step
from tactgen.tmm.reluctance.coenergy_map import CoenergyPoint
from tactgen.validation.checks.cases.fineness import steps

_ONE, _UNIT = np.ones(1), np.eye(1)


class _Inductor:
    """A constant inductance (H)."""

    def __init__(self, inductance: float) -> None:
        self.inductance = inductance

    def at(self, current: float, gap: float) -> CoenergyPoint:
        """Return W' = L i²/2 and its derivatives, whatever the gap."""
        linkage = self.inductance * current
        return CoenergyPoint(0.5 * linkage * current, linkage, 0.0, self.inductance, 0.0, 0.0)


def run_of_coil(
    inductance: float, resistance: float, voltage: Step | Sine, until: float, wanted: int
) -> Run:
    """Return the run of a coil (H, ohm) at a voltage until a time (s), in so many steps."""
    zero = 0.0 * _ONE
    coil = Coil(_Inductor(inductance), zero, 1.0, resistance, "voltage")
    system = System(_UNIT, 0.0 * _UNIT, _UNIT, zero, zero, 0.0, (), (), coil)
    return simulate_steps(system, Sources(coil=voltage), until, steps(wanted))


def settled_current(
    inductance: float, resistance: float, amplitude: float, hertz: float
) -> complex:
    """Return the current's phasor (A) at amplitude · sin(2π f t), from the last of ten periods."""
    periods, each = 10, 400
    run = run_of_coil(
        inductance, resistance, Sine(amplitude, hertz), periods / hertz, periods * each
    )
    last = run.time > (periods - 1.0) / hertz + 1e-9 / hertz
    angle = 2.0 * np.pi * hertz * run.time[last]
    sine, cosine = (2.0 * np.mean(run.current[last] * of(angle)) for of in (np.sin, np.cos))
    return complex(sine, cosine)
