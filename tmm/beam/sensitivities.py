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
(:mod:`tmm.beam.transfer.timoshenko`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from geometry.arrays import Complex, Floats, Numbers
from geometry.errors import InputError
from tmm.beam.modes import bending_frequencies
from tmm.beam.parametric import Actuator, check_keys, parameter_keys, terminated
from tmm.beam.port_quantities import READOUTS, drive, evaluate
from tmm.beam.transfer.transfer_matrix import sections
from tmm.ports.invariants import symmetric_form
from tmm.ports.multiport import hold, respond

_RADIUS, _POINTS = 0.003, 16

#: Quantities with a derivative; the frequencies are arrays over the modes.
DIFFERENTIABLE = (
    *READOUTS,
    "short_circuit_frequencies",
    "open_circuit_frequencies",
    "coupling_factor",
)

#: The factor on Ω², treated as one more parameter; and the one that A does not hold.
_SQUARED_FREQUENCY, _VOLTAGE = "squared frequency", "drive.voltage"
#: Points of contours worked out at once.
_AT_ONCE = 20_000


def values(
    actuator: Actuator, quantity: str, frequencies: Floats | None = None, modes: int = 1
) -> Numbers:
    """Return a quantity: (n,) over frequencies, (modes,), or (1,) for a single number.

    Raises
    ------
    InputError
        If the quantity has no derivative here, or frequencies are missing.
    """
    _check(quantity, frequencies)
    if quantity in READOUTS:
        at = np.zeros(1) if frequencies is None else np.asarray(frequencies, dtype=float)
        found = evaluate(actuator, quantity, {}, at[:1] if READOUTS[quantity].static else at)
        return np.asarray(found.real if READOUTS[quantity].static else found)
    if quantity == "coupling_factor":
        ratio = _frequencies(actuator, 1, open_circuit=False) / _frequencies(
            actuator, 1, open_circuit=True
        )
        return np.sqrt(1.0 - ratio**2)
    return _frequencies(actuator, modes, open_circuit=quantity.startswith("open"))


def derivatives(
    actuator: Actuator,
    quantity: str,
    keys: Sequence[str] | None = None,
    frequencies: Floats | None = None,
    modes: int = 1,
) -> dict[str, Numbers]:
    """Return dq/dp for each key (all that the model reads by default), SI.

    Parameters
    ----------
    quantity : str
        One of :data:`DIFFERENTIABLE`.
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

    Raises
    ------
    InputError
        If the model does not depend smoothly on a key, the quantity has no derivative
        here, or frequencies are missing.
    """
    _check(quantity, frequencies)
    if keys is None:
        keys = parameter_keys(actuator)
    else:
        check_keys(actuator, keys)
    if quantity in READOUTS:
        at = np.zeros(1) if frequencies is None else np.asarray(frequencies, dtype=float)
        return _of_readout(actuator, quantity, keys, at)
    if quantity == "coupling_factor":
        return _of_coupling(actuator, keys)
    return _of_frequencies(actuator, keys, modes, open_circuit=quantity.startswith("open"))


def logarithmic_sensitivities(
    actuator: Actuator,
    quantity: str,
    keys: Sequence[str] | None = None,
    frequencies: Floats | None = None,
    modes: int = 1,
) -> dict[str, Floats]:
    """Return d ln|q| / d ln|p|: the percentage by which q changes per percent of p.

    See :func:`derivatives`.
    """
    value = values(actuator, quantity, frequencies, modes)
    found = derivatives(actuator, quantity, keys, frequencies, modes)
    with np.errstate(invalid="ignore"):  # a quantity that is zero has no relative change
        return {
            key: np.asarray(actuator.value(key) * (slope / value).real)
            for key, slope in found.items()
        }


def _check(quantity: str, frequencies: Floats | None) -> None:
    if quantity not in DIFFERENTIABLE:
        raise InputError(
            f'quantity "{quantity}" has no derivative here; use one of {", ".join(DIFFERENTIABLE)}'
        )
    if quantity in READOUTS and not READOUTS[quantity].static and frequencies is None:
        raise InputError(f"quantity {quantity} depends on frequency; state the frequencies in Hz")


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
    """Return dA/dp (keys, n, k, k) from all points of all contours at once."""
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
    actuator: Actuator, quantity: str, keys: Sequence[str], frequencies: Floats
) -> dict[str, Numbers]:
    read = READOUTS[quantity]
    at = np.zeros(1) if read.static else frequencies
    port = terminated(actuator, {}, at, lossless=read.static)
    driven = drive(port, read, 1.0 if read.unit_voltage else actuator.drive.voltage)
    motion = respond(port, driven).motion
    rate = 2j * np.pi * at if read.rate else 1.0
    found: dict[str, Numbers] = {}
    for key, slope in _matrix_derivatives(actuator, keys, at, lossless=read.static):
        explicit = dict(
            zip(port.names, np.einsum("nij,jn->in", slope, list(motion.values())), strict=True)
        )
        stepped = dict.fromkeys(driven, 0.0)
        stepped["voltage"] = float(key == _VOLTAGE and not read.unit_voltage)
        moved = respond(port, stepped, {name: -explicit[name] for name in port.others(driven)})
        if read.of == "motion":
            change = moved.motion[read.port]
        else:
            change = explicit[read.port] + moved.effort[read.port]
        change = change * rate
        found[key] = np.asarray(change.real if read.static else change)
    return found


def _frequencies(actuator: Actuator, modes: int, *, open_circuit: bool) -> Floats:
    pieces = sections(
        actuator.device, actuator.support, actuator.beam, lossy=False, segments=actuator.segments
    )
    return bending_frequencies(pieces, actuator.ends, modes, open_circuit=open_circuit)


def _of_frequencies(
    actuator: Actuator, keys: Sequence[str], modes: int, *, open_circuit: bool
) -> dict[str, Numbers]:
    at = _frequencies(actuator, modes, open_circuit=open_circuit)
    port = terminated(actuator, {}, at, lossless=True)

    def form(stiffness: Complex) -> Floats:
        moving = replace(port, stiffness=stiffness)
        return symmetric_form(moving if open_circuit else hold(moving, "voltage")).real

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


def _of_coupling(actuator: Actuator, keys: Sequence[str]) -> dict[str, Numbers]:
    short, opened = (_frequencies(actuator, 1, open_circuit=c) for c in (False, True))
    slopes = [_of_frequencies(actuator, keys, 1, open_circuit=c) for c in (False, True)]
    ratio = short / opened
    factor = np.sqrt(1.0 - ratio**2)
    return {
        key: -ratio / factor * (slopes[0][key] / opened - ratio * slopes[1][key] / opened)
        for key in keys
    }
