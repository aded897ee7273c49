"""Up to which voltage the lateral actuator may be driven, and what a drive beyond it does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Limits

if TYPE_CHECKING:
    from tactgen.tmm.beam.port_quantities import DrivenCeramic

#: What limits the voltage, in the order of :func:`voltage_limits`.
REASONS = ("the ceramic's strength", "the field against the poling", "the amplifier's current")


def voltage_limits(driven: DrivenCeramic, limits: Limits) -> Floats:
    """Return the voltage (3, n) at which each of :data:`REASONS` is reached (V).

    Infinite where nothing is strained or drawn, or where the stress is not known.
    """
    share = limits.amplifier_current / limits.amplifier_channels
    with np.errstate(divide="ignore"):
        found = np.broadcast_arrays(
            limits.ceramic_strength / np.abs(driven.stress),
            limits.depoling_field / driven.field,
            np.abs(share) / driven.current,
        )
    return np.asarray(np.where(np.isnan(found), np.inf, found))
