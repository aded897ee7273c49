"""What the centre line of a row of beams does between its ends: modes and driven motion.

The row is cut at stations; every part has its exact dynamic stiffness, and what is joined and
attached is one small symmetric matrix over w and ψ at all stations.  No interpolation: at the
stations the numbers are the transfer-matrix model's own.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints, Numbers
from tactgen.geometry.bimorph.ends import Ends, Springs
from tactgen.geometry.bimorph.row_shape import CentreLine
from tactgen.tmm.beam.modes import Row, bending_frequencies
from tactgen.tmm.beam.scattering import Element, element_stiffness
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.ports.elements import base_stiffness, tip_stiffness

#: Stations along a row, about.
_STATIONS = 80


def cut(row: Row) -> Row:
    """Return the row with its beams divided, so that there are about so many stations."""
    total = sum(float(length) for _, length in row)
    parts: list[Element] = []
    for element, length in row:
        number = 1
        if isinstance(element, Section):
            number = max(1, math.ceil(_STATIONS * float(length) / total))
        parts += [(element, float(length) / number)] * number
    return parts


def mode_lines(row: Row, ends: Ends, count: int, *, open_circuit: bool) -> list[CentreLine]:
    """Return the lowest `count` modes of a lossless row, ascending, of unit tip displacement."""
    parts = cut(row)
    frequencies = bending_frequencies(row, ends, count, open_circuit=open_circuit)
    return [_mode(parts, ends.lossless, float(f), open_circuit=open_circuit) for f in frequencies]


def driven_line(row: Row, ends: Ends, frequency: float, voltage: complex) -> CentreLine:
    """Return the motion at a voltage (V) across each layer."""
    parts = cut(row)
    matrix, coupling, capacitance = _assembled(parts, ends, frequency)
    free = _free(matrix.shape[0], ends)
    motion = np.zeros(matrix.shape[0], dtype=complex)
    scale = 1.0 / np.sqrt(np.abs(np.diag(matrix)[free]))
    balanced = matrix[np.ix_(free, free)] * scale[:, None] * scale
    motion[free] = scale * np.linalg.solve(balanced, scale * (-coupling[free] * voltage))
    charge = -coupling @ motion + capacitance * voltage
    return CentreLine(_z(parts), motion[::2], motion[1::2], complex(charge), voltage, frequency)


def static_line(row: Row, ports: Numbers, charge: complex, frequency: float) -> CentreLine:
    """Return the static line between ends that move as given: the lumped model's shape.

    Parameters
    ----------
    ports : (5,) array
        w_base, ψ_base, w_tip, ψ_tip (m, rad) and the voltage across each layer (V).
    """
    parts = cut(row)
    matrix, coupling, _ = _assembled(parts, Ends(Springs(0.0, 0.0)), 0.0)
    motion = np.zeros(matrix.shape[0], dtype=np.asarray(ports).dtype)
    motion[[0, 1, -2, -1]] = ports[:4]
    inner = slice(2, -2)
    right = -(matrix[inner] @ motion) - coupling[inner] * ports[4]
    scale = 1.0 / np.sqrt(np.abs(np.diag(matrix)[inner]))
    balanced = matrix[inner, inner] * scale[:, None] * scale
    motion[inner] = _as(motion.dtype, scale * np.linalg.solve(balanced, scale * right))
    return CentreLine(_z(parts), motion[::2], motion[1::2], charge, complex(ports[4]), frequency)


def _as(kind: Any, values: Complex) -> Numbers:
    """Return values as real numbers where the rest is real."""
    return values if np.issubdtype(kind, np.complexfloating) else values.real


def _mode(parts: Row, ends: Ends, frequency: float, *, open_circuit: bool) -> CentreLine:
    """Return the null vector of the matrix at a natural frequency."""
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
    """Return the stiffness over [w, ψ] at all stations, forces per volt to hold it, and C (F).

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
    matrix[-2, -2] += tip_stiffness(ends.tip, frequencies)[0]
    if ends.base is not None:
        for at_base, stiffness in enumerate(base_stiffness(ends.base, frequencies)):
            matrix[at_base, at_base] += stiffness[0]
    return matrix, coupling, capacitance


def _free(size: int, ends: Ends) -> Ints:
    return np.arange(2 if ends.base is None else 0, size)


def _z(parts: Row) -> Floats:
    return np.concatenate([[0.0], np.cumsum([length for _, length in parts])])
