"""Quantities of the transfer-matrix model at many points, each with its own parameter values.

Read off the terminated ports of :mod:`tmm.beam.parametric`: responses, static values, the first
natural frequency and the resonance peak.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints, Numbers
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.bimorph.segments import CentreLine
from tactgen.tmm.beam.modes import Row, bending_frequencies
from tactgen.tmm.beam.parametric import Actuator, Values, charge_drawn, terminated, tip_response
from tactgen.tmm.beam.scattering import Element, element_stiffness
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.ports.excitation import ELECTRICAL, PortState, resistor_power
from tactgen.tmm.ports.multiport import hold, symmetric_form
from tactgen.tmm.ports.readout import Readout
from tactgen.tmm.ports.supports_and_loads import base_stiffness, tip_matrix


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


#: Stations along a row, about.
_STATIONS = 80


def cut(row: Row) -> Row:
    """Row with its beams divided, so that there are about so many stations."""
    total = sum(float(length) for _, length in row)
    parts: list[Element] = []
    for element, length in row:
        number = 1
        if isinstance(element, Section):
            number = max(1, math.ceil(_STATIONS * float(length) / total))
        parts += [(element, float(length) / number)] * number
    return parts


def mode_lines(row: Row, ends: Ends, count: int, *, open_circuit: bool) -> list[CentreLine]:
    """Lowest `count` modes of a lossless row, ascending, of unit tip displacement."""
    parts = cut(row)
    frequencies = bending_frequencies(row, ends, count, open_circuit=open_circuit)
    return [_mode(parts, ends.lossless, float(f), open_circuit=open_circuit) for f in frequencies]


def line_between(row: Row, state: PortState, *, inertia: bool = True) -> CentreLine:
    """Line, relative to the ground, between ends that move as given.

    Without `inertia` it is the static one: the lumped model's shape.
    """
    parts = cut(row)
    matrix, coupling, _ = _assembled(parts, Ends(Springs(0.0, 0.0)), inertia * state.frequency)
    *ends, voltage = state.ports
    motion = np.zeros(matrix.shape[0], dtype=np.asarray(state.ports).dtype)
    motion[[0, 1, -2, -1]] = ends
    inner = slice(2, -2)
    right = -(matrix[inner] @ motion) - coupling[inner] * voltage
    scale = 1.0 / np.sqrt(np.abs(np.diag(matrix)[inner]))
    balanced = matrix[inner, inner] * scale[:, None] * scale
    found = scale * np.linalg.solve(balanced, scale * right)
    motion[inner] = found if np.iscomplexobj(motion) else found.real
    return state.line(_z(parts), motion[::2], motion[1::2])


def _mode(parts: Row, ends: Ends, frequency: float, *, open_circuit: bool) -> CentreLine:
    """Null vector of the matrix at a natural frequency."""
    dynamic, per_volt, complex_capacitance = _assembled(parts, ends, frequency)
    matrix, coupling = dynamic.real, per_volt.real
    capacitance = complex_capacitance.real
    if open_circuit and capacitance > 0.0:
        matrix = matrix + np.outer(coupling, coupling) / capacitance
    free = _free(matrix.shape[0], ends)
    held = matrix[np.ix_(free, free)]
    scale = 1.0 / np.sqrt(np.abs(np.diag(held)))
    values, vectors = np.linalg.eigh(held * scale[:, None] * scale)
    motion = np.zeros(matrix.shape[0])
    motion[free] = scale * vectors[:, np.abs(values).argmin()]
    motion /= motion[-2]
    voltage = float(coupling @ motion / capacitance) if open_circuit and capacitance > 0.0 else 0.0
    charge = float(-coupling @ motion + capacitance * voltage)
    return CentreLine(_z(parts), motion[::2], motion[1::2], charge, voltage, frequency)


def _assembled(parts: Row, ends: Ends, frequency: float) -> tuple[Complex, Complex, complex]:
    """Stiffness over [w, ψ] at all stations, forces per volt to hold it, and C (F).

    The charge is minus the forces per volt times the motion, and C times the voltage.
    """
    omega = np.array([2.0 * np.pi * frequency])
    known: dict[tuple[int, float], Complex] = {}
    size = 2 * len(parts) + 2
    matrix, coupling = np.zeros((size, size), dtype=complex), np.zeros(size, dtype=complex)
    capacitance = 0.0 + 0.0j
    for k, (element, length) in enumerate(parts):
        if (id(element), length) not in known:
            known[id(element), length] = element_stiffness(element, length, omega)[0]
        d = known[id(element), length]
        at = slice(2 * k, 2 * k + 4)
        matrix[at, at] += d[:4, :4]
        coupling[at] += d[:4, 4]
        capacitance += d[4, 4]
    frequencies = np.array([frequency])
    matrix[-2:, -2:] += tip_matrix(ends.tip, frequencies)[0]
    if ends.base is not None:
        for at_base, stiffness in enumerate(base_stiffness(ends.base, frequencies)):
            matrix[at_base, at_base] += stiffness[0]
    return matrix, coupling, capacitance


def _free(size: int, ends: Ends) -> Ints:
    return np.arange(2 if ends.base is None else 0, size)


def _z(parts: Row) -> Floats:
    return np.concatenate([[0.0], np.cumsum([length for _, length in parts])])
