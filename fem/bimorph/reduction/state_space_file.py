"""State spaces of reduced solids as files (npz), with what they differ by, measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tactgen.fem.bimorph.reduction.extremes import extremes, motions
from tactgen.fem.bimorph.reduction.port_model import PortModel
from tactgen.fem.bimorph.reduction.state_space import StateSpace, state_space
from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Ends, Springs
from tactgen.geometry.files import written_whole

#: What the entry `title` says.
TITLE = "state space of a piezoelectric solid on its support"
_CONVENTIONS = (
    "SI; x' = a x + b u, y = c x + d u; energy x.x / 2; inputs and outputs are conjugate, their "
    "products are powers; the load is what you connect at the tip (force = -what it takes); "
    "each mode has viscous damping in place of constant Q, the capacitance has branches of "
    "resistor and capacitor in place of a constant loss tangent"
)


def write_state_space(
    path: str | Path, model: PortModel, base: Springs | None, frequencies: tuple[float, float]
) -> None:
    """Write the state space of a reduced solid on its support, whole or not at all.

    Beside the matrices: the frequencies of all peaks and dips of the solid's response to a
    voltage in the range (Hz), its amplitudes there, and how far (relative) those of the state
    space lie, for tip velocity, tip angular velocity and current (rows).

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    found = state_space(model, base, frequencies)
    at, solid, error = differences(model, base, found, frequencies)
    with written_whole(path) as temporary:
        np.savez_compressed(
            temporary,
            title=np.array(TITLE),
            conventions=np.array(_CONVENTIONS),
            a=found.a,
            b=found.b,
            c=found.c,
            d=found.d,
            inputs=np.array(found.inputs),
            outputs=np.array(found.outputs),
            range=np.array(frequencies),
            extreme_frequencies=at,
            extreme_amplitudes=np.abs(solid),
            extreme_errors=error,
        )


def differences(
    model: PortModel,
    base: Springs | None,
    found: StateSpace,
    frequencies: tuple[float, float],
) -> tuple[Floats, Complex, Floats]:
    """Compare with the solid at every peak and dip of its response to 1 V, the tip free.

    Returns
    -------
    frequencies : (n,) array
    solid : (3, n) complex array
        Tip velocity, tip angular velocity and current of the lossy solid.
    error : (3, n) array
        Distance of the state space's, relative.
    """
    ends = Ends(base)
    at = extremes(model, *frequencies, (ends,))
    solid = 2j * np.pi * at * motions(model.multiport(at), ends)
    causal = found.frequency_response(at)[:, -3:, -1].T
    return at, solid, np.asarray(np.abs(causal - solid) / np.abs(solid))
