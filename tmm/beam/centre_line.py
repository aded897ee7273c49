"""How a row of beams moves between its ends: lines of modes, and under ports that move as given."""

from __future__ import annotations

import math

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.bimorph.segments import CentreLine
from tactgen.tmm.beam.modes import Row, bending_frequencies
from tactgen.tmm.beam.scattering import Element, element_stiffness
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.ports.excitation_and_circuit import PortState
from tactgen.tmm.ports.supports_and_loads import base_stiffness, tip_matrix

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
