"""The network's circuit at one gap and current, in which iron may carry the sum of several fluxes.

What tmm.reluctance.flux_ladder solves as a ladder is here a circuit of any shape, so that it can be
told what the ladder does not know (validation.models.reluctance.told_by_field).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from tactgen.fem.solvers.newton import minimise
from tactgen.geometry.arrays import Floats, Sparse
from tactgen.geometry.device.steel_law import MagnetisationCurve
from tactgen.tmm.reluctance.flux_ladder import Ladder

#: Flux density (T) at which the first guess takes the iron's reluctivity.
_GUESSED_AT = 1.0


@dataclass(frozen=True)
class Answer:
    """What a circuit does at its current: fluxes (n,) in Wb, and the values that it gives."""

    flux: Floats
    coenergy: float
    flux_linkage: float
    force: float
    incremental_inductance: float


@dataclass(frozen=True)
class Circuit:
    """Π over the fluxes (n,) of the network's cells, then of what tubes were added.

    As in tmm.reluctance.flux_ladder, but an iron element may carry the sum of several fluxes.

    Attributes
    ----------
    current : float
        In the winding (A).
    carried : (E, n) array
        Flux of each iron element per unknown flux.
    area, length, d_length : (E,) array
        Of the iron elements (m², m) and by the gap.
    across : (R, n) array
        Flux of each rung or tube of air per unknown flux.
    reluctance, d_reluctance : (R,) array
        Of these (1/H), and by the gap.
    turns, d_turns : (n,) array
        What drives each unknown flux.
    to_changes : (R,) array
        Reluctances of air to changes of flux, as multiples of those to flux: a change may leave
        full steel elsewhere.
    beside, beside_changes : float
        Inductance (H) of flux that the winding links and the shaft does not carry; of changes.
    """

    current: float
    curve: MagnetisationCurve | None
    carried: Floats
    area: Floats
    length: Floats
    d_length: Floats
    across: Floats
    reluctance: Floats
    d_reluctance: Floats
    turns: Floats
    d_turns: Floats
    to_changes: Floats
    beside: float = 0.0
    beside_changes: float = 0.0

    @classmethod
    def of(cls, ladder: Ladder, current: float) -> Circuit:
        """Return the circuit of a ladder at its one gap, at a current (A) above 0."""
        n = ladder.turns.shape[1]
        return cls(
            current,
            ladder.curve,
            np.eye(n)[ladder.cell],
            ladder.area[0],
            ladder.length[0],
            ladder.d_length[0],
            np.eye(n + 1, n) - np.eye(n + 1, n, -1),
            ladder.reluctance[0],
            ladder.d_reluctance[0],
            ladder.turns[0],
            ladder.d_turns[0],
            np.ones(n + 1),
        )

    def solved(self) -> Answer:
        """Return what the circuit does."""
        guess = 0.0 if self.curve is None else self.curve.field_strength(np.array(_GUESSED_AT))
        start = self._air(self.reluctance) + self._iron(
            guess / _GUESSED_AT * self.length / self.area
        )
        flux = minimise(self, np.linalg.solve(start, self.current * self.turns)).x
        changes = self._air(self.reluctance * self.to_changes) + self._incremental_iron(flux)
        response = np.linalg.solve(changes, self.turns)
        return Answer(
            flux,
            coenergy=0.5 * self.beside * self.current**2 - self.value(flux),
            flux_linkage=self.beside * self.current + float(self.turns @ flux),
            force=self.slope(flux),
            incremental_inductance=self.beside_changes + float(self.turns @ response),
        )

    def value(self, x: Floats) -> float:
        """Return Π (J)."""
        return self.scale(x) - self.current * float(self.turns @ x)

    def scale(self, x: Floats) -> float:
        """Return the energy stored (J)."""
        air = 0.5 * float(self.reluctance @ (self.across @ x) ** 2)
        return air + float((self.area * self.length) @ self._energy_density(x))

    def gradient(self, x: Floats) -> Floats:
        """Return the mmf (n,) that is not balanced (A)."""
        air = self.across.T @ (self.reluctance * (self.across @ x))
        found = air - self.current * self.turns
        if self.curve is not None:
            b = self._flux_density(x)
            drop = np.sign(b) * self.curve.field_strength(np.abs(b)) * self.length
            found = found + self.carried.T @ drop
        return np.asarray(found)

    def hessian(self, x: Floats) -> Sparse:
        """Return the incremental reluctances (n, n) in 1/H."""
        return csr_matrix(self._air(self.reluctance) + self._incremental_iron(x))

    def slope(self, x: Floats) -> float:
        """Return ∂Π/∂g at fixed fluxes, the pull (N)."""
        air = 0.5 * float(self.d_reluctance @ (self.across @ x) ** 2)
        iron = float((self.area * self.d_length) @ self._energy_density(x))
        return air + iron - self.current * float(self.d_turns @ x)

    def _air(self, reluctance: Floats) -> Floats:
        return np.asarray(self.across.T @ (reluctance[:, None] * self.across))

    def _incremental_iron(self, x: Floats) -> Floats:
        if self.curve is None:
            return np.zeros((x.size, x.size))
        slope = self.curve.slope(np.abs(self._flux_density(x)))
        return self._iron(slope * self.length / self.area)

    def _iron(self, reluctance: Floats) -> Floats:
        return np.asarray(self.carried.T @ (reluctance[:, None] * self.carried))

    def _energy_density(self, x: Floats) -> Floats:
        if self.curve is None:
            return np.zeros(self.area.size)
        return np.asarray(self.curve.energy_density(np.abs(self._flux_density(x))))

    def _flux_density(self, x: Floats) -> Floats:
        return np.asarray(self.carried @ x / self.area)
