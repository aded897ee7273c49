"""Peaks and dips of the terminated response, where a reduced model is hardest to trust."""

from __future__ import annotations

import numpy as np

from tactgen.fem.bimorph.reduction.port_model import PortModel
from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Ends, Springs
from tactgen.tmm.ports.multiport import Multiport, respond
from tactgen.tmm.ports.terminations import attach

#: Frequencies of the search grid; a peak is as wide as 1/Q, and Q is below some hundreds.
_GRID = 2000
#: Steps of the golden section, each shrinking a bracket to 0.618: 1e-2 to 1e-9.
_STEPS = 34


def standard_ends(model: PortModel) -> tuple[Ends, Ends]:
    """Return two ends to judge by: clamped, and on springs as stiff as the solid; tip free.

    Without any support the rigid motion at low frequencies is a matter of rounding.
    """
    port = model.multiport(np.zeros(1))
    own = (float(port[name, name][0].real) for name in ("w_base", "psi_base"))
    return Ends(), Ends(Springs(*own))


def motions(port: Multiport, ends: Ends) -> Complex:
    """Return tip displacement, tip rotation and charge per volt, (3, n)."""
    answer = respond(attach(port, ends), {"voltage": 1.0})
    return np.array([answer.motion["w_tip"], answer.motion["psi_tip"], answer.effort["voltage"]])


def extremes(model: PortModel, low: float, high: float, ends: tuple[Ends, ...]) -> Floats:
    """Return the frequencies (Hz) of all local maxima and minima of |motions|, ascending.

    Bracketed on a grid, linear and logarithmic, then refined by golden section.
    """
    bottom = max(low, 1e-3 * high, 1e-3)
    if high <= bottom:
        return np.zeros(0)
    both = np.geomspace(bottom, high, _GRID // 2), np.linspace(bottom, high, _GRID // 2)
    grid = np.union1d(*both)
    # of points that all but coincide, only rounding tells the higher one
    grid = grid[np.append(np.diff(grid) > 1e-6 * grid[:-1], True)]
    port = model.multiport(grid)
    found = []
    for end in ends:
        for row, values in enumerate(np.abs(motions(port, end))):
            if not values.all():  # a passive ceramic moves nothing
                continue
            rise = np.sign(np.diff(values))
            turn = np.flatnonzero(rise[1:] != rise[:-1])
            if turn.size:
                found.append(_refined(model, end, row, grid[turn], grid[turn + 2], rise[turn]))
    return np.unique(np.concatenate(found)) if found else np.zeros(0)


def _refined(
    model: PortModel, end: Ends, row: int, low: Floats, high: Floats, sign: Floats
) -> Floats:
    """Return where sign · log|motion| is largest in each bracket."""

    def value(at: Floats) -> Floats:
        return np.asarray(sign * np.log(np.abs(motions(model.multiport(at), end)[row])))

    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(_STEPS):
        inner = high - golden * (high - low), low + golden * (high - low)
        left = value(inner[0]) > value(inner[1])
        low, high = np.where(left, low, inner[0]), np.where(left, inner[1], high)
    return np.asarray(0.5 * (low + high))
