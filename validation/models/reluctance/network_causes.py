"""Why the network's number is not the field's: named causes whose shares add up to the difference.

First the network is given the flux outside the sleeve, which the shaft carries and the sleeve does
not (validation.models.reluctance.outer_flux).  What is left is told by solving both with iron that
resists nothing, with iron of a constant permeability, and with the steel's own curve.  With perfect
iron they differ by the air alone: where tubes are, and how wide.  What a finite permeability adds,
and then saturation, is how the flux spreads in the iron.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_law import linear
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.tmm.reluctance.circuit import FULL, circuit
from tactgen.tmm.reluctance.flux_ladder import LadderSolution, solve
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.models.reluctance.outer_flux import outer_flux, with_outer_flux

if TYPE_CHECKING:
    from tactgen.fem.reluctance.axisymmetric.field import MagneticField

IronKind = Literal["perfect", "linear", "saturating"]

#: Relative permeability that counts as perfect: the field changes by 1e-6 from a tenth of it.
_PERFECT = 1e7
#: Order of the field's elements: its force is then right to 1e-4.
_ORDER = 4
#: From the assumption that both share most to the one that they share least.
_CAUSES: tuple[tuple[str, str, IronKind], ...] = (
    ("air", "the tubes' shapes in the air, told with perfect iron", "perfect"),
    (
        "permeability",
        "a finite permeability: how the flux spreads in the iron, most of all into the flange",
        "linear",
    ),
    (
        "saturation",
        "the steel's own curve: flux crowds, most of all where the shaft meets the flange",
        "saturating",
    ),
)
#: Added last: what the network that is given that flux does not know.
_OUTSIDE = (
    "flux outside",
    "flux that returns outside the sleeve fills the shaft and spares the sleeve",
)


@dataclass(frozen=True)
class NetworkCause:
    """One reason, and what it adds to (network / field − 1).

    Attributes
    ----------
    name, meaning : str
        Short, and in a sentence.
    force, flux_linkage : float
        Its shares of these two.
    of : mapping of str to float
        Its shares by quantity.
    """

    name: str
    meaning: str
    force: float
    flux_linkage: float
    of: Mapping[str, float]


@dataclass(frozen=True)
class _Point:
    """Values at one current and gap, as a quantity's row reads them off an answer."""

    current: float
    force: float
    flux_linkage: float
    coenergy: float
    incremental_inductance: float

    @property
    def inductance(self) -> float:
        """Flux linkage per current (H)."""
        return self.flux_linkage / self.current


#: Name and meaning of a cause, and what network and field give with it.
_Step: TypeAlias = tuple[tuple[str, str], _Point, _Point]


def network_causes(device: Device, current: float, gap: float) -> list[NetworkCause]:
    """Return why the network differs from the axisymmetric field at a current (A) and gap (m)."""
    causes: list[NetworkCause] = []
    before: dict[str, float] = {}
    force = linkage = 1.0
    for cause, network, field in _steps(device, current, gap):
        against = _read(field)
        ratio = {key: value / against[key] for key, value in _read(network).items()}
        share = {key: value - before.get(key, 1.0) for key, value in ratio.items()}
        forces, linkages = network.force / field.force, network.flux_linkage / field.flux_linkage
        causes.append(NetworkCause(*cause, forces - force, linkages - linkage, share))
        before, force, linkage = ratio, forces, linkages
    return causes


def _steps(device: Device, current: float, gap: float) -> Iterator[_Step]:
    """Yield each cause, and what network and field give with all causes so far."""
    at = np.array([gap])
    for name, meaning, iron in _CAUSES:
        field = _field(device, current, gap, iron)
        if iron == "perfect":
            outer = outer_flux(device, gap, field)
        ladder, told = circuit(device, at, replace(FULL, iron=iron)), _of_field(field)
        yield (name, meaning), _of_network(with_outer_flux(ladder, outer, current), current), told
    yield _OUTSIDE, _of_network(solve(ladder, np.array([current])), current), told


def _of_network(found: LadderSolution, current: float) -> _Point:
    tables = found.force, found.flux_linkage, found.coenergy, found.incremental_inductance
    return _Point(current, *(float(table[0, 0]) for table in tables))


def _of_field(found: MagneticField) -> _Point:
    from tactgen.fem.reluctance.axisymmetric.force import virtual_work_force

    return _Point(
        float(found.currents[0]),
        -virtual_work_force(found),
        float(found.flux_linkage[0]),
        found.coenergy,
        float(found.incremental_inductance[0, 0]),
    )


def _read(point: _Point) -> dict[str, float]:
    """Return all quantities of one current and gap."""
    return {
        name: row.read.of(point)
        for name, row in QUANTITIES.items()
        if isinstance(row.read, AnswerReadout) and row.read.need == "magnetic_point"
    }


def _field(device: Device, current: float, gap: float, iron: IronKind) -> MagneticField:
    from tactgen.fem.reluctance.axisymmetric.field import solve_field
    from tactgen.fem.reluctance.axisymmetric.space import discretise
    from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS, graded_grid
    from tactgen.geometry.reluctance.section_regions import actuator_regions

    regions = actuator_regions(device, gap)
    if iron != "saturating":
        highest = magnetisation_curve(device.steel).highest_permeability
        curve = linear(_PERFECT if iron == "perfect" else highest)
        regions = tuple(replace(r, curve=r.curve and curve) for r in regions)
    grid = graded_grid(regions, OUTER_RADIUS)
    return solve_field(discretise(grid, _ORDER), np.array([current]))
