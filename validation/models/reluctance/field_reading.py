"""What an axisymmetric field says of a circuit's parts: fluxes, mmf, what iron takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tactgen.fem.reluctance.axisymmetric.force import virtual_work_force
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.gap_permeance import pole_radii

if TYPE_CHECKING:
    from tactgen.fem.reluctance.axisymmetric.field import MagneticField


@dataclass(frozen=True)
class FieldReading:
    """A solved field of a device at a gap (m); heights z (m) are from the sleeve's top.

    Fluxes run up the shaft, down the sleeve; an mmf counts in that direction.
    """

    device: Device
    gap: float
    field: MagneticField

    @property
    def current(self) -> float:
        """The winding's current (A)."""
        return float(self.field.currents[0])

    @property
    def pull(self) -> float:
        """The pull (N), positive when it closes the gap."""
        return -virtual_work_force(self.field)

    @property
    def flux_linkage(self) -> float:
        """The winding's flux linkage (Wb)."""
        return float(self.field.flux_linkage[0])

    @cached_property
    def gap_mmf(self) -> float:
        """The mean mmf (A) between the pole's faces."""
        inner, outer = pole_radii(self.device)
        grid = self.field.discretisation.grid
        strength = -self._mean_strength(inner, outer)
        z = 0.5 * (grid.z[1:] + grid.z[:-1])
        between = (z > 0.0) & (z < self.gap)
        return float(strength[between] @ np.diff(grid.z)[between])

    def flux(self, radius: float) -> Callable[[Floats | float], Floats]:
        """Return the flux (Wb) up through the circle of a radius (m) by the circle's height (m).

        B_z is integrated over rows of quadrature points; a smooth curve joins their heights.
        """
        from scipy.interpolate import PchipInterpolator

        d = self.field.discretisation
        levels, row = np.unique(d.reference.levels.round(12), return_inverse=True)
        weights = np.bincount(row, d.reference.weights)
        inside = int(np.argmin(np.abs(d.grid.r - radius)))
        per_point = self.field.flux_density[..., 1] * d.volumes
        heights = np.diff(d.grid.z)
        columns = per_point.reshape(d.grid.r.size - 1, heights.size, -1)[:inside].sum(axis=0)
        rows = np.stack([columns[:, row == n].sum(axis=1) for n in range(levels.size)], axis=1)
        z = d.grid.z[:-1, None] + heights[:, None] * levels
        found: Callable[[Floats | float], Floats] = PchipInterpolator(
            z.ravel(), (rows / (weights * heights[:, None])).ravel()
        )
        return found

    def drop_along_sleeve(self, z: Floats) -> Floats:
        """Return the mmf (A) that the sleeve's wall takes from its top down to heights z (m)."""
        grid = self.field.discretisation.grid
        sleeve = self.device.sleeve
        strength = -self._mean_strength(sleeve.inner_radius, sleeve.outer_radius)
        taken = np.append(0.0, np.cumsum(strength * np.diff(grid.z)))
        return np.asarray(np.interp(0.0, grid.z, taken) - np.interp(z, grid.z, taken))

    def taken_by(self, *names: str) -> float:
        """Return ∫H·B dV (J) over regions: the flux times the mmf that each of its tubes takes."""
        d = self.field.discretisation
        wanted = [n for n, region in enumerate(d.grid.regions) if region.name in names]
        cells = np.isin(d.cell_labels, wanted)
        product = (self.field.field_strength[cells] * self.field.flux_density[cells]).sum(axis=-1)
        return float((product * d.volumes[cells]).sum())

    def _mean_strength(self, inner: float, outer: float) -> Floats:
        """Return the mean H_z (A/m) of each row of cells between two radii (m)."""
        d = self.field.discretisation
        r = 0.5 * (d.grid.r[1:] + d.grid.r[:-1])
        columns = (r > inner) & (r < outer)
        shape = r.size, d.grid.z.size - 1
        moment, volume = (
            of.sum(axis=1).reshape(shape)[columns].sum(axis=0)
            for of in (self.field.field_strength[..., 1] * d.volumes, d.volumes)
        )
        return np.asarray(moment / volume)
