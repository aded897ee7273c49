"""Bars of the magnetic field in 3D: random normal actuators, coarse, against the half section."""

from __future__ import annotations

import numpy as np

from tactgen.fem.magnetics.actuator_3d import solve_solid
from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.reluctance.sector_tets import Sector
from tactgen.validation.checks.coverage.axisymmetric import Fields, judged_fields
from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.scenes import between

#: Lines of the sector's grid, of the usual: less than half to two thirds.
_REFINEMENTS = 0.4, 0.65


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device without a slot, drawn by `rng`."""

    def solved(device: Device) -> Fields:
        # drawn anew with each device: too coarse a grid is refused
        sector = Sector(refinement=between(rng, *_REFINEMENTS))
        return solve_solid(device, device.coil.current, device.gap, sector), solve_point(device)

    return judged_fields(rng, solved)
