"""Peaks and dips of the terminated response, where a reduced model is hardest to trust."""

from __future__ import annotations

import numpy as np

from tactgen.fem.bimorph.reduction.port_model import PortModel
from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.geometry.bimorph.ends import Ends, Springs
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import Multiport, respond

#: Frequencies of the search grid; a peak is as wide as 1/Q, and Q is below some hundreds.
_GRID = 2000
#: Where the grid begins: at this share of the highest frequency, and at so many Hz, at least.
_BOTTOM, _LOWEST = 1e-3, 1e-3
#: Relative distance below which two of its frequencies are one.
_SAME = 1e-6
#: Steps of the golden section, each shrinking a bracket to 0.618: of 1.4e-2 of its frequency, the
#: widest of the grid, 4e-7 are left, a thousandth of the width of a peak.
_STEPS = 22


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
    bottom = max(low, _BOTTOM * high, _LOWEST)
    if high <= bottom:
        return np.zeros(0)
    both = np.geomspace(bottom, high, _GRID // 2), np.linspace(bottom, high, _GRID // 2)
    grid = np.union1d(*both)
    # of points that all but coincide, only rounding tells the higher one
    grid = grid[np.append(np.diff(grid) > _SAME * grid[:-1], True)]
    port = model.multiport(grid)
    found: list[Floats] = [np.zeros(0)]
    for end in ends:
        values = np.abs(motions(port, end))
        rise: Floats = np.sign(np.diff(values, axis=1))
        rise[~values.all(axis=1)] = 0.0  # a passive ceramic moves nothing
        row, turn = np.nonzero(rise[:, 1:] != rise[:, :-1])
        if row.size:
            sign = np.asarray(rise[row, turn])
            found.append(_refined(model, end, row, grid[turn], grid[turn + 2], sign))
    return np.unique(np.concatenate(found))


def _refined(
    model: PortModel, end: Ends, row: Ints, low: Floats, high: Floats, sign: Floats
) -> Floats:
    """Return where sign · log|motion| is largest in each bracket (m,), `row` telling the motion."""

    def values(at: Floats) -> Floats:
        """Return them at (2, m) frequencies."""
        moved = motions(model.multiport(at.ravel()), end).reshape(3, *at.shape)
        return np.asarray(sign * np.log(np.abs(moved[row, :, np.arange(row.size)].T)))

    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(_STEPS):
        step = golden * (high - low)
        inner = np.stack([high - step, low + step])
        left = np.greater(*values(inner))
        low, high = np.where(left, low, inner[0]), np.where(left, inner[1], high)
    return np.asarray(0.5 * (low + high))
