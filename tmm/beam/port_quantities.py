"""Quantities of the transfer-matrix model at many points, each with its own parameter values.

Read off the terminated ports of :mod:`tmm.beam.parametric`: responses, static values, the first
natural frequency and the resonance peak.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.tmm.beam.parametric import Actuator, Values, charge_drawn, terminated, tip_response
from tactgen.tmm.ports.excitation_and_circuit import ELECTRICAL, resistor_power
from tactgen.tmm.ports.multiport import hold, symmetric_form
from tactgen.tmm.ports.readout import Readout


def evaluate(actuator: Actuator, read: Readout, values: Values, frequencies: Floats) -> Complex:
    """Quantity at every point, (n,); static ones have no imaginary part."""
    frequencies = np.asarray(frequencies, dtype=float)
    at = np.zeros_like(frequencies) if read.static else frequencies
    voltage = actuator.with_values(values).drive.voltage
    if read.is_of_tip:
        response = tip_response(actuator, values, at, lossless=read.static)
        return read.scaled(read.variable(response), voltage, at)
    return read.read(terminated(actuator, values, at, lossless=read.static), voltage)


def circuit_power(actuator: Actuator, values: Values, frequencies: Floats) -> Floats:
    """Mean power (n,) in W into the circuit's resistor at every point."""
    charge = charge_drawn(actuator, values, frequencies)
    circuit = actuator.with_values({k: v for k, v in values.items() if k.startswith("circuit.")})
    return resistor_power(circuit.circuit, frequencies, charge)


#: Relative step of the difference quotient in Newton's method for natural frequencies, and
#: the last step taken: the quotient and Newton's own convergence leave 1e-6 of it.
_STEP, _LAST = 1e-6, 1e-6
#: Steps of that method, and the largest, relative: a first guess is within a factor of two.
_MOST_STEPS, _LONGEST_STEP = 30, 0.3
#: Eigenvalues at rest below this, of a matrix with ones on its diagonal, belong to rigid motions.
_RIGID = 1e-9
#: Frequencies of a round of the search for a peak, how far they lie to either side of the middle
#: in the first (relative), and by how much each further one is narrower: two intervals are left.
_TRIALS, _REACH, _NARROWER = 17, 0.1, 8.0


def first_frequency(
    actuator: Actuator, values: Values, start: Floats, *, open_circuit: bool
) -> Floats:
    """First natural frequency (n,) in Hz of the lossless actuator at every point.

    Newton's method on the eigenvalue of the symmetric port matrix that vanishes there.
    Eigenvalues fall with frequency and are finite up to the first mode with all ports
    held, so the one that is lowest at 0 Hz, rigid motions left out, belongs to mode one.
    `start` (n,) is a first guess (Hz).
    """

    def reduced(frequencies: Floats, given: Values) -> Floats:
        port = terminated(actuator, given, frequencies, lossless=True)
        return symmetric_form(port if open_circuit else hold(port, ELECTRICAL)).real

    at_rest = reduced(np.zeros(1), {})[0]
    scale = 1.0 / np.sqrt(np.abs(np.diag(at_rest)))
    weights = scale[:, None] * scale
    # below: rigid motions, and the electrical port, whose capacitance counts as negative
    mode = int((np.linalg.eigvalsh(at_rest * weights) < _RIGID).sum())
    found = np.asarray(start, dtype=float)
    for _ in range(_MOST_STEPS):
        here = reduced(found, values) * weights
        there = reduced(found * (1.0 + _STEP), values) * weights
        shape = np.linalg.eigh(here)[1][:, :, mode]
        value, slope = (
            np.einsum("ni,nij,nj->n", shape, m, shape) for m in (here, (there - here) / _STEP)
        )
        step = np.clip(-value / slope, -_LONGEST_STEP, _LONGEST_STEP)
        found = found * (1.0 + step)
        if np.abs(step).max() < _LAST:
            return np.asarray(found)
    raise ArithmeticError("the search for the first natural frequency did not converge")


def resonance_peak(
    of: Callable[[Values, Floats], Numbers], values: Values, start: Floats, rounds: int = 5
) -> tuple[Floats, Floats]:
    """Frequency (Hz) and height of the first peak of a response, both (n,).

    It lies close to `start` (n,), for a free tip the first short-circuit frequency.
    Each round narrows a grid of frequencies around its highest.
    """
    offsets = np.linspace(-1.0, 1.0, _TRIALS)
    centre, reach = np.asarray(start, dtype=float), _REACH
    count = centre.size
    spread = {key: np.repeat(np.broadcast_to(v, count), _TRIALS) for key, v in values.items()}
    for _ in range(rounds):
        trials = centre[:, None] * (1.0 + reach * offsets)
        size = np.abs(of(spread, trials.ravel()))
        level = np.log(size.reshape(count, _TRIALS))
        best = np.clip(level.argmax(axis=1), 1, _TRIALS - 2)
        rows = np.arange(count)
        left, middle, right = (level[rows, best + i] for i in (-1, 0, 1))
        # a parabola through the highest three
        shift = 0.5 * (left - right) / (left - 2.0 * middle + right)
        centre = trials[rows, best] + shift * (trials[:, 1] - trials[:, 0])
        reach /= _NARROWER
    return centre, np.abs(of(values, centre))
