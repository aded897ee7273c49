"""What statics on two levels of a mesh count with at least: they may agree by chance in one."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.engine.error_bars import least_difference


def least_at_rest(fine: Multiport, coarse: Multiport) -> Floats:
    """Return the relative difference (n,) that all at 0 Hz counts with at least.

    Parameters
    ----------
    fine, coarse : Multiport
        D(0) of n bimorphs without losses on the finer and on the coarser level.
    """
    return least_difference(_sizes(fine), _sizes(coarse))


def _sizes(port: Multiport) -> Floats:
    """Return sizes (n, 4) of what is read at 0 Hz on a held base.

    The tip's compliance, its displacement per volt, the capacitance with the tip held and free.
    """
    held = port.block("w_tip", "psi_tip", "voltage").stiffness.real
    compliance, moved = np.linalg.inv(held[:, :2, :2]), held[:, :2, 2]
    per_volt = np.einsum("nij,nj->ni", compliance, moved)
    clamped = held[:, 2, 2]
    free = clamped - np.einsum("ni,ni->n", moved, per_volt)
    sizes = np.stack([compliance[:, 0, 0], per_volt[:, 0], clamped, free], axis=1)
    return np.asarray(np.abs(sizes))
