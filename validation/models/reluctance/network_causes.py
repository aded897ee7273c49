"""Why the network's number is not the field's: named causes, each measured, and what they leave.

The network is told what it does not know, one thing after the other, by the field that it is held
against and by one with perfect iron, in which air alone decides
(validation.models.reluctance.told_by_field).  A cause's share is what its telling changes.  The
shares need not add up to the difference: what they leave is the test of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_law import linear
from tactgen.tmm.reluctance.circuit import FULL, circuit
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.models.reluctance.field_reading import FieldReading
from tactgen.validation.models.reluctance.open_circuit import Answer, Circuit
from tactgen.validation.models.reluctance.told_by_field import ToldByField

if TYPE_CHECKING:
    from tactgen.fem.reluctance.axisymmetric.field import MagneticField

#: Relative permeability that counts as perfect: the field changes by 1e-6 from a tenth of it.
_PERFECT = 1e7
#: Order of the field's elements: its force is then right to 1e-4.
_ORDER = 4


@dataclass(frozen=True)
class NetworkCause:
    """One reason, and what it adds to (network / field − 1).

    Attributes
    ----------
    name, meaning : str
        Short, and in a sentence.
    of : mapping of str to float
        Its shares by quantity.
    """

    name: str
    meaning: str
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


def network_causes(device: Device, current: float, gap: float) -> list[NetworkCause]:
    """Return why the network differs from the axisymmetric field at a current (A) and gap (m)."""
    size = abs(current)
    steel = FieldReading(device, gap, _field(device, size, gap))
    against = _read(_of_field(steel))
    before = _read(_of_network(_network(device, size, gap), size))
    causes = []
    for name, meaning, told in _told(device, size, gap, steel):
        now = _read(_of_network(told, size))
        share = {key: (before[key] - now[key]) / against[key] for key in now}
        causes.append(NetworkCause(name, meaning, share))
        before = now
    return causes


def _told(
    device: Device, current: float, gap: float, steel: FieldReading
) -> Iterator[tuple[str, str, Circuit]]:
    """Yield name and meaning of each cause, and the network told of all causes so far."""
    telling = ToldByField(steel)
    air = ToldByField(FieldReading(device, gap, _field(device, current, gap, perfect=True))).air(
        _network(device, current, gap, perfect=True)
    )
    told = telling.flux_outside(_network(device, current, gap))
    yield (
        "flux outside",
        "flux that returns outside the sleeve fills the shaft and spares the sleeve",
        told,
    )
    told = telling.air_at_flange(told, air.at_flange)
    yield (
        "air at the flange",
        "flux leaves the flange's faces too, not only straight from its side",
        told,
    )
    told = telling.air_at_gap(told, air)
    yield (
        "air at the gap",
        "the tubes beside the pole's faces have other widths, and change otherwise with the gap",
        told,
    )
    told = telling.flux_beside_shaft(told)
    yield (
        "flux in the winding",
        "the turns link flux that runs beside the shaft, and miss what turns back before them",
        told,
    )
    told = telling.flange_foot(told)
    yield (
        "flange's foot",
        "flux spreads from the shaft into the flange over a way on which it is still crowded",
        told,
    )
    yield (
        "flux in the iron",
        "how flux is spread over the sections of shaft, head and sleeve",
        telling.flux_in_iron(told),
    )


def _network(device: Device, current: float, gap: float, *, perfect: bool = False) -> Circuit:
    refinements = replace(FULL, iron="perfect") if perfect else FULL
    return Circuit.of(circuit(device, np.array([gap]), refinements), current)


def _of_network(told: Circuit, current: float) -> _Point:
    found: Answer = told.solved()
    return _Point(
        current,
        found.force,
        found.flux_linkage,
        found.coenergy,
        found.incremental_inductance,
    )


def _of_field(found: FieldReading) -> _Point:
    return _Point(
        found.current,
        found.pull,
        found.flux_linkage,
        found.field.coenergy,
        float(found.field.incremental_inductance[0, 0]),
    )


def _read(point: _Point) -> dict[str, float]:
    """Return all quantities of one current and gap."""
    return {
        name: row.read.of(point)
        for name, row in QUANTITIES.items()
        if isinstance(row.read, AnswerReadout) and row.read.need == "magnetic_point"
    }


def _field(device: Device, current: float, gap: float, *, perfect: bool = False) -> MagneticField:
    from tactgen.fem.reluctance.axisymmetric.field import solve_field
    from tactgen.fem.reluctance.axisymmetric.space import discretise
    from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS, graded_grid
    from tactgen.geometry.reluctance.section_regions import actuator_regions

    regions = actuator_regions(device, gap)
    if perfect:
        regions = tuple(replace(r, curve=r.curve and linear(_PERFECT)) for r in regions)
    grid = graded_grid(regions, OUTER_RADIUS)
    return solve_field(discretise(grid, _ORDER), np.array([current]))
