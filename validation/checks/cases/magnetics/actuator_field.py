"""The axisymmetric field of a normal actuator at a point, as finely as a check's level says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactgen.geometry.device.parameters import Device
from tactgen.validation.checks.cases.fineness import cached, counted, degree

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint


@cached
def field_point(
    device: Device, current: float, gap: float | None = None, refinement: float = 1.0
) -> FieldPoint:
    """Return a normal actuator's field at a current (A) and a gap (m), its own by default."""
    from tactgen.fem.magnetics.axisymmetric import ORDER, solve_point

    found = solve_point(
        device, current, gap, order=degree(ORDER), refinement=refinement, any_grid=True
    )
    counted(found.unknowns)
    return found
