"""Exact derivatives of transfer-matrix quantities with respect to any parameter.

The port matrix A(p), support and load attached, is analytic in every parameter p, but
complex already through its losses, so that the plain complex step does not apply.  Its
derivative is Cauchy's integral on a circle around p, by the trapezoidal rule (Lyness and
Moler 1967; Fornberg 1981),

    dA/dp = 1/(N h) Σ (A(p + h e^{jθ_k}) − A(p)) e^{−jθ_k},   θ_k = 2πk/N,

and the rest is exact algebra on the solved ports.  With A x = r (x motions and voltage,
r forces and charge; free ports have r = 0)

    dx_free = −A_free⁻¹ (dA x + A_U dU)_free,   dr = dA x + A dx,

and at a natural frequency, where the symmetric lossless form S has the null vector x,

    d ln f/dp = −½ (xᵀ ∂S/∂p x) / (xᵀ ∂S/∂ln Ω² x).

So resonances do not spoil the contour: A(p) itself has poles only where the actuator
vibrates with all its ports held.  With h = 0.003 |p| and N = 16 the truncation is (h/R)^16
for a distance R to such a pole: below rounding from R = 0.03 |p| on, 4e-9 at 0.01 |p|.
Rounding is that of A over 0.003: some 1e-13 of the largest part of a derivative, and not
more than 1.3e-9 where an entry of A is itself near a pole or zero
(:mod:`tmm.beam.span`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.parametric import Actuator, check_keys, parameter_keys, terminated
from tactgen.tmm.beam.port_quantities import evaluate
from tactgen.tmm.beam.transfer_matrix import sections
from tactgen.tmm.ports.multiport import hold, respond, symmetric_form
from tactgen.tmm.ports.readout import ELECTRICAL, Circuit, ModalReadout, Readout

_RADIUS, _POINTS = 0.003, 16

#: The factor on Ω², treated as one more parameter; and the one that A does not hold.
_SQUARED_FREQUENCY, _VOLTAGE = "squared frequency", "drive.voltage"
#: Relative imaginary step in a frequency: its square is nothing beside 1.
_IMAGINARY = 1e-30
#: Points of contours worked out at once.
_AT_ONCE = 20_000


def values(
    actuator: Actuator,
    read: Readout | ModalReadout,
    frequencies: Floats | None = None,
    modes: int = 1,
) -> Numbers:
    """Quantity: (n,) over frequencies, (modes,), or (1,) for a single number.

    Raises InputError if frequencies are missing.
    """
    if isinstance(read, Readout):
        found = evaluate(actuator, read, {}, _points(read, frequencies))
        return np.asarray(found.real if read.static else found)
    if read.combine is None:
        return _frequencies(actuator, modes, read.circuits[0])
    return np.asarray(read.combine(*(_frequencies(actuator, 1, c) for c in read.circuits)))


def derivatives(
    actuator: Actuator,
    read: Readout | ModalReadout,
    keys: Sequence[str] | None = None,
    frequencies: Floats | None = None,
    modes: int = 1,
) -> dict[str, Numbers]:
    """Dq/dp for each key (all that the model reads by default), SI.

    Parameters
    ----------
    read : Readout or ModalReadout
        How the quantity is read.
    keys : sequence of str, optional
        Scene keys such as ``piezo.s11``.
    frequencies : (n,) array, optional
        Frequencies (Hz), for quantities that depend on them.
    modes : int
        How many natural frequencies.

    Returns
    -------
    dict of str to array
        Of the shape of :func:`values`; complex for quantities that are.

    Raises InputError if the model does not depend smoothly on a key, or frequencies are missing.
    """
    if keys is None:
        keys = parameter_keys(actuator)
    else:
        check_keys(actuator, keys)
    if isinstance(read, Readout):
        return _of_readout(actuator, read, keys, _points(read, frequencies))
    if read.combine is None:
        return _of_frequencies(actuator, keys, modes, read.circuits[0])
    return _of_combination(actuator, keys, read)


def logarithmic_sensitivities(
    actuator: Actuator,
    read: Readout | ModalReadout,
    keys: Sequence[str] | None = None,
    frequencies: Floats | None = None,
    modes: int = 1,
) -> dict[str, Floats]:
    """D ln|q| / d ln|p|: the percentage by which q changes per percent of p.

    See :func:`derivatives`.
    """
    value = values(actuator, read, frequencies, modes)
    found = derivatives(actuator, read, keys, frequencies, modes)
    with np.errstate(invalid="ignore"):  # a quantity that is zero has no relative change
        return {
            key: np.asarray(actuator.value(key) * (slope / value).real)
            for key, slope in found.items()
        }


def _points(read: Readout, frequencies: Floats | None) -> Floats:
    """Frequencies (n,) at which something is read; one, 0 Hz, for a static value."""
    if read.static:
        return np.zeros(1)
    if frequencies is None:
        raise InputError("a response depends on frequency; state the frequencies in Hz")
    return np.asarray(frequencies, dtype=float)


def _matrix_derivatives(
    actuator: Actuator, keys: Sequence[str], frequencies: Floats, *, lossless: bool
) -> Iterator[tuple[str, Complex]]:
    """Yield each key with dA/dp (n, k, k); for the factor on Ω² it is dA/d ln Ω²."""
    n = frequencies.size
    at_once = max(1, _AT_ONCE // (n * (_POINTS + 1)))
    for first in range(0, len(keys), at_once):
        part = keys[first : first + at_once]
        yield from zip(
            part, _on_contours(actuator, part, frequencies, lossless=lossless), strict=True
        )


def _on_contours(
    actuator: Actuator, keys: Sequence[str], frequencies: Floats, *, lossless: bool
) -> Complex:
    """DA/dp (keys, n, k, k) from all points of all contours at once."""
    n, count = frequencies.size, len(keys)
    turns = np.exp(2j * np.pi * np.arange(_POINTS) / _POINTS)
    # of each key the centre and its contour, (keys, points + 1, n); others stay put there
    offsets = np.concatenate([[0.0], turns])
    values: dict[str, Complex] = {}
    radii = np.ones(count)
    for i, key in enumerate(keys):
        if key == _VOLTAGE:
            continue  # A does not depend on it
        centre = 1.0 if key == _SQUARED_FREQUENCY else actuator.value(key)
        radii[i] = _RADIUS * abs(centre)
        moved = np.full((count, _POINTS + 1, n), centre, dtype=complex)
        moved[i] += (radii[i] * offsets)[:, None]
        values[key] = moved.ravel()
    inertia = values.pop(_SQUARED_FREQUENCY, 1.0)
    everywhere = np.tile(frequencies, count * (_POINTS + 1))
    port = terminated(actuator, values, everywhere, lossless=lossless, inertia=inertia)
    matrix = port.stiffness.reshape(count, _POINTS + 1, n, *port.stiffness.shape[1:])
    # less the centre, so that what does not depend on p gives zero
    change = matrix[:, 1:] - matrix[:, :1]
    found = np.einsum("k,pknij->pnij", turns.conj(), change)
    return np.asarray(found / (_POINTS * radii[:, None, None, None]))


def _of_readout(
    actuator: Actuator, read: Readout, keys: Sequence[str], at: Floats
) -> dict[str, Numbers]:
    port = terminated(actuator, {}, at, lossless=read.static)
    drive = read.drive(port, 1.0)
    response = respond(port, drive)
    variable, motion = read.variable(response), list(response.motion.values())
    still, voltage = dict.fromkeys(drive, 0.0), actuator.drive.voltage
    found: dict[str, Numbers] = {}
    for key, slope in _matrix_derivatives(actuator, keys, at, lossless=read.static):
        explicit = dict(zip(port.names, np.einsum("nij,jn->in", slope, motion), strict=True))
        moved = respond(port, still, {name: -explicit[name] for name in port.others(drive)})
        change = read.variable(moved)
        if read.of == "effort":
            change = change + explicit[read.port]
        found[key] = _scaled_change(read, variable, change, voltage, at)
        if key == _VOLTAGE and not read.unit_voltage:  # which A does not hold
            found[key] = read.scaled(variable, 1.0, at)
        if read.static:
            found[key] = found[key].real
    return found


def _scaled_change(
    read: Readout, variable: Complex, change: Complex, voltage: float, at: Floats
) -> Complex:
    """Change of the quantity with that of the port's variable per volt."""
    if read.level is None:
        return read.scaled(change, voltage, at)
    # the level stays, so that the voltage that reaches it falls as the variable's size rises
    sign = -1.0 if read.unit_voltage else 1.0
    with np.errstate(invalid="ignore", divide="ignore"):  # what does not respond has no voltage
        return np.asarray(sign * read.scaled(variable, voltage, at) * (change / variable).real)


def _frequencies(actuator: Actuator, modes: int, circuit: Circuit) -> Floats:
    pieces = sections(
        actuator.device, actuator.support, actuator.beam, lossy=False, segments=actuator.segments
    )
    return bending_frequencies(pieces, actuator.ends, modes, open_circuit=circuit == "open")


def _of_frequencies(
    actuator: Actuator, keys: Sequence[str], modes: int, circuit: Circuit
) -> dict[str, Numbers]:
    at = _frequencies(actuator, modes, circuit)
    port = terminated(actuator, {}, at, lossless=True)

    def form(stiffness: Complex) -> Floats:
        moving = replace(port, stiffness=stiffness)
        return symmetric_form(moving if circuit == "open" else hold(moving, ELECTRICAL)).real

    here = form(port.stiffness)
    scale = 1.0 / np.sqrt(np.abs(here).max(axis=2))
    eigenvalues, vectors = np.linalg.eigh(here * scale[:, :, None] * scale[:, None, :])
    nearest = np.abs(eigenvalues).argmin(axis=1)
    shape = scale * np.take_along_axis(vectors, nearest[:, None, None], axis=2)[:, :, 0]

    wanted = [*keys, _SQUARED_FREQUENCY]
    energies = {
        key: np.einsum("ni,nij,nj->n", shape, form(slope), shape)
        for key, slope in _matrix_derivatives(actuator, wanted, at, lossless=True)
    }
    return {key: -0.5 * at * energies[key] / energies[_SQUARED_FREQUENCY] for key in keys}


def _of_combination(
    actuator: Actuator, keys: Sequence[str], read: ModalReadout
) -> dict[str, Numbers]:
    assert read.combine is not None
    first = [_frequencies(actuator, 1, circuit) for circuit in read.circuits]
    found: dict[str, Numbers] = {key: np.zeros(1) for key in keys}
    for i, circuit in enumerate(read.circuits):
        moved = [f * (1.0 + 1j * _IMAGINARY * (j == i)) for j, f in enumerate(first)]
        by_log = read.combine(*moved).imag / _IMAGINARY  # exact: nothing is subtracted
        for key, slope in _of_frequencies(actuator, keys, 1, circuit).items():
            found[key] = found[key] + by_log * slope / first[i]
    return found
