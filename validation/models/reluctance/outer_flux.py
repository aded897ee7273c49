"""The network given the flux that it has no tubes for: what returns outside the sleeve.

All of it goes through the shaft, and not through the sleeve beside it.  How much there is, and how
far down it meets the sleeve's wall, is measured in a field with perfect iron, in which it is a
matter of the air alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_matrix

from tactgen.fem.solvers.newton import minimise
from tactgen.geometry.arrays import Floats, Sparse
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.circuit import sleeve_heights
from tactgen.tmm.reluctance.flux_ladder import Ladder, LadderSolution, solve
from tactgen.tmm.reluctance.gap_permeance import pole_radii

if TYPE_CHECKING:
    from tactgen.fem.reluctance.axisymmetric.field import MagneticField


@dataclass(frozen=True)
class OuterFlux:
    """What a field with perfect iron tells of the flux outside the sleeve.

    Attributes
    ----------
    share : (E,) array
        Flux outside the sleeve beside each iron element of the sleeve, 0 of the others, over the
        flux that the shaft leads to the head.
    permeance : float
        That flux over the working gap's mmf (H).
    """

    share: Floats
    permeance: float


def outer_flux(device: Device, gap: float, field: MagneticField) -> OuterFlux:
    """Return what the field of perfect iron at a gap (m) tells; the sleeve's top is at z = 0."""
    grid = field.discretisation.grid
    flux = 2.0 * np.pi * field.flux_function
    sleeve, rod = (
        np.argmin(np.abs(grid.r - radius))
        for radius in (device.sleeve.outer_radius, device.rod.radius)
    )
    head = float(np.interp(0.0, grid.z, flux[rod]))
    beside = np.interp(sleeve_heights(device, gap), grid.z, flux[sleeve])
    return OuterFlux(
        share=np.nan_to_num(beside) / head,
        permeance=head / _gap_mmf(device, gap, field),
    )


def _gap_mmf(device: Device, gap: float, field: MagneticField) -> float:
    """Return the mean mmf (A) between the pole's faces, in the direction of the shaft's flux."""
    d = field.discretisation
    shape = d.grid.r.size - 1, d.grid.z.size - 1
    moment, volume = (
        of.sum(axis=1).reshape(shape)
        for of in (field.field_strength[..., 1] * d.volumes, d.volumes)
    )
    inner, outer = pole_radii(device)
    r, z = (0.5 * (lines[1:] + lines[:-1]) for lines in (d.grid.r, d.grid.z))
    between = np.ix_((r > inner) & (r < outer), (z > 0.0) & (z < gap))
    mean = moment[between].sum(axis=0) / volume[between].sum(axis=0)
    return -float(mean @ np.diff(d.grid.z)[between[1].ravel()])


def with_outer_flux(ladder: Ladder, outer: OuterFlux, current: float) -> LadderSolution:
    """Return what a circuit at one gap does at a current (A) with that flux; arrays (1, 1)."""
    circuit = _Circuit.of(ladder, outer, current)
    flux = minimise(circuit, solve(ladder, np.array([current])).flux[0, 0]).x
    response = np.linalg.solve(circuit.hessian(flux).toarray(), circuit.turns)
    found = (
        -circuit.value(flux),
        circuit.turns @ flux,
        circuit.slope(flux),
        circuit.turns @ response,
    )
    return LadderSolution(flux[None, None], *(np.array([[float(value)]]) for value in found))


@dataclass(frozen=True)
class _Circuit:
    """Π over the fluxes (n,) of the cells, as in tmm.reluctance.flux_ladder, and more in the iron.

    Attributes
    ----------
    carried : (E, n) array
        Flux of each iron element per flux of a cell.
    across : (n + 1, n) array
        The same of each rung.
    reluctance, d_reluctance : (n + 1,) array
        Of the rungs (1/H), and by the gap.
    """

    ladder: Ladder
    current: float
    carried: Floats
    across: Floats
    reluctance: Floats
    d_reluctance: Floats

    @classmethod
    def of(cls, ladder: Ladder, outer: OuterFlux, current: float) -> _Circuit:
        """Return the circuit whose sleeve does without the flux outside."""
        n = ladder.turns.shape[1]
        carried = np.eye(n)[ladder.cell]
        carried[:, -1] -= outer.share
        reluctance, d_reluctance = ladder.reluctance[0].copy(), ladder.d_reluctance[0].copy()
        # what is added to the permeance does not know the gap
        d_reluctance[-1] /= (outer.permeance * reluctance[-1]) ** 2
        reluctance[-1] = 1.0 / outer.permeance
        across = np.eye(n + 1, n) - np.eye(n + 1, n, -1)
        return cls(ladder, current, carried, across, reluctance, d_reluctance)

    @property
    def turns(self) -> Floats:
        """Turns that drive each cell (n,)."""
        return np.asarray(self.ladder.turns[0])

    def value(self, x: Floats) -> float:
        return self._stored(x) - self.current * float(self.turns @ x)

    def scale(self, x: Floats) -> float:
        return self._stored(x)

    def gradient(self, x: Floats) -> Floats:
        rungs = self.across.T @ (self.reluctance * (self.across @ x))
        found = rungs - self.current * self.turns
        if self.ladder.curve is not None:
            b = self._flux_density(x)
            drop = np.sign(b) * self.ladder.curve.field_strength(np.abs(b)) * self.ladder.length[0]
            found = found + self.carried.T @ drop
        return np.asarray(found)

    def hessian(self, x: Floats) -> Sparse:
        found = self.across.T @ (self.reluctance[:, None] * self.across)
        if self.ladder.curve is not None:
            slope = self.ladder.curve.slope(np.abs(self._flux_density(x)))
            stiff = slope * self.ladder.length[0] / self.ladder.area[0]
            found = found + self.carried.T @ (stiff[:, None] * self.carried)
        return csr_matrix(found)

    def slope(self, x: Floats) -> float:
        """Return ∂Π/∂g at fixed fluxes, the pull (N)."""
        ladder = self.ladder
        rungs = 0.5 * float(self.d_reluctance @ (self.across @ x) ** 2)
        found = rungs - self.current * float(ladder.d_turns[0] @ x)
        if ladder.curve is None:
            return found
        density = ladder.curve.energy_density(np.abs(self._flux_density(x)))
        return found + float((ladder.area * ladder.d_length)[0] @ density)

    def _stored(self, x: Floats) -> float:
        ladder = self.ladder
        found = 0.5 * float(self.reluctance @ (self.across @ x) ** 2)
        if ladder.curve is None:
            return found
        density = ladder.curve.energy_density(np.abs(self._flux_density(x)))
        return found + float((ladder.area * ladder.length)[0] @ density)

    def _flux_density(self, x: Floats) -> Floats:
        return np.asarray(self.carried @ x / self.ladder.area[0])
