"""What an axisymmetric field says of a circuit's parts: fluxes, mmf, what iron takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import MagneticField
from tactgen.fem.magnetics.axisymmetric_force import virtual_work_force
from tactgen.fem.magnetics.iron import reluctivity_tensor
from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_law import MU0
from tactgen.tmm.reluctance.circuit import pole_radii


@dataclass(frozen=True)
class _Changes(MagneticField):
    """What a field changes by as its current grows, per share of the current: a linear field.

    Attributes
    ----------
    tensor : (n_e, n_q, 2, 2) float
        dH/dB of the field that changes (m/H).
    """

    tensor: Floats

    @cached_property
    def field_strength(self) -> Floats:
        """The change of H (A/m) at the quadrature points, (n_e, n_q, 2)."""
        return np.asarray((self.tensor @ self.flux_density[..., None])[..., 0])


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
    def changes(self) -> FieldReading:
        """The same of what the field changes by, as if it grew so from nothing."""
        field = self.field
        tensor = reluctivity_tensor(field.discretisation.iron, field.flux_density)
        of = field.discretisation, field.currents, field.tangent @ field.currents, field.tangent
        return FieldReading(self.device, self.gap, _Changes(*of, 0, tensor))

    @cached_property
    def gap_mmf(self) -> float:
        """The mean mmf (A) between the pole's faces."""
        inner, outer = pole_radii(self.device)
        grid = self.field.discretisation.grid
        strength = -self._mean_strength(inner, outer)
        z = 0.5 * (grid.z[1:] + grid.z[:-1])
        between = (z > 0.0) & (z < self.gap)
        return float(strength[between] @ np.diff(grid.z)[between])

    @property
    def gap_slope(self) -> float:
        """The permeance that the gap gains as it widens (H/m), if nothing else makes the pull."""
        return -2.0 * self.pull / self.gap_mmf**2

    @cached_property
    def permeabilities(self) -> dict[str, float]:
        """The one relative permeability of each region of iron that would take what it takes."""
        regions = self.field.discretisation.grid.regions
        found = {}
        for name in (region.name for region in regions if region.curve is not None):
            b, volumes = (of[self._cells(name)] for of in (self.field.flux_density, self._volumes))
            found[name] = float((b**2).sum(axis=-1).ravel() @ volumes.ravel())
        return {name: of / (MU0 * self.taken_by(name)) for name, of in found.items()}

    def flux(self, radius: float) -> Callable[[Floats | float], Floats]:
        """Return the flux (Wb) up through the circle of a radius (m) by the circle's height (m).

        B_z is integrated over rows of quadrature points; a smooth curve joins their heights.
        """
        from scipy.interpolate import PchipInterpolator

        inside = self._centres < radius
        found: Callable[[Floats | float], Floats] = PchipInterpolator(
            *self._rows(self.field.flux_density[..., 1], inside)
        )
        return found

    def taken_below(self, name: str) -> Callable[[Floats | float], Floats]:
        """Return ∫H·B dV (J) over what of a region lies below a height (m), by that height."""
        from scipy.interpolate import PchipInterpolator

        density = np.zeros_like(self._product)
        density[self._cells(name)] = self._product[self._cells(name)]
        z, rows = self._rows(density, np.ones_like(self._centres, dtype=bool))
        there = np.flatnonzero(rows)
        first, last = there[0], there[-1] + 1
        taken = PchipInterpolator(z[first:last], rows[first:last]).antiderivative()
        lines = self.field.discretisation.grid.z
        points = z.size // (lines.size - 1)
        low, high = lines[first // points], lines[last // points]
        return lambda height: np.asarray(taken(np.clip(height, low, high)) - taken(low))

    def drop_along_sleeve(self, z: Floats) -> Floats:
        """Return the mmf (A) that the sleeve's wall takes from its top down to heights z (m)."""
        grid = self.field.discretisation.grid
        sleeve = self.device.sleeve
        strength = -self._mean_strength(sleeve.inner_radius, sleeve.outer_radius)
        taken = np.append(0.0, np.cumsum(strength * np.diff(grid.z)))
        return np.asarray(np.interp(0.0, grid.z, taken) - np.interp(z, grid.z, taken))

    def taken_by(self, *names: str) -> float:
        """Return ∫H·B dV (J) over regions: the flux times the mmf that each of its tubes takes."""
        cells = self._cells(*names)
        return float((self._product[cells] * self._volumes[cells]).sum())

    @property
    def _volumes(self) -> Floats:
        return self.field.discretisation.volumes

    @cached_property
    def _product(self) -> Floats:
        """H·B at the quadrature points (J/m³)."""
        return np.asarray((self.field.field_strength * self.field.flux_density).sum(axis=-1))

    @property
    def _centres(self) -> Floats:
        """Radii (m) of the middles of the grid's columns."""
        r = self.field.discretisation.grid.r
        return np.asarray(0.5 * (r[1:] + r[:-1]))

    def _cells(self, *names: str) -> Ints:
        """Return the cells of regions."""
        d = self.field.discretisation
        wanted = [n for n, region in enumerate(d.grid.regions) if region.name in names]
        return np.flatnonzero(np.isin(d.cell_labels, wanted))

    def _rows(self, density: Floats, columns: Bools) -> tuple[Floats, Floats]:
        """Return heights (m) of rows of points, and a density's integral over some columns there.

        Per length of height: of (n_e, n_q) values at the quadrature points.
        """
        d = self.field.discretisation
        levels, row = np.unique(d.reference.levels.round(12), return_inverse=True)
        weights = np.bincount(row, d.reference.weights)
        heights = np.diff(d.grid.z)
        per_point = (density * d.volumes).reshape(columns.size, heights.size, -1)
        summed = per_point[columns].sum(axis=0)
        rows = np.stack([summed[:, row == n].sum(axis=1) for n in range(levels.size)], axis=1)
        z = d.grid.z[:-1, None] + heights[:, None] * levels
        return z.ravel(), (rows / (weights * heights[:, None])).ravel()

    def _mean_strength(self, inner: float, outer: float) -> Floats:
        """Return the mean H_z (A/m) of each row of cells between two radii (m)."""
        d = self.field.discretisation
        columns = (self._centres > inner) & (self._centres < outer)
        shape = columns.size, d.grid.z.size - 1
        moment, volume = (
            of.sum(axis=1).reshape(shape)[columns].sum(axis=0)
            for of in (self.field.field_strength[..., 1] * d.volumes, d.volumes)
        )
        return np.asarray(moment / volume)
