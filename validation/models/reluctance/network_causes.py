"""Why the network's number is not the field's: named causes whose shares add up to the difference.

Both are solved with iron that resists nothing, with iron of a constant permeability, and with
the steel's own curve.  With perfect iron they differ by the air alone: where tubes are, and how
wide.  What a finite permeability adds, and then saturation, is how the flux spreads in the iron.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_law import linear
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.tmm.reluctance.circuit import FULL
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout

IronKind = Literal["perfect", "linear", "saturating"]

#: Relative permeability that counts as perfect: the field changes by 1e-6 from a tenth of it.
_PERFECT = 1e7
#: Order of the field's elements: its force is then right to 1e-4.
_ORDER = 4
#: From the assumption that both share most to the one that they share least.
_CAUSES: tuple[tuple[str, str, IronKind], ...] = (
    ("air", "the tubes' shapes in the air, told with perfect iron", "perfect"),
    ("permeability", "a finite permeability: how the flux spreads in the iron", "linear"),
    ("saturation", "flux that no tube has fills the iron too, and sooner", "saturating"),
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


def network_causes(device: Device, current: float, gap: float) -> list[NetworkCause]:
    """Return why the network differs from the axisymmetric field at a current (A) and gap (m)."""
    causes, before = [], dict.fromkeys(_read(_Point(1.0, 1.0, 1.0, 1.0, 1.0)), 1.0)
    force = linkage = 1.0
    for name, meaning, iron in _CAUSES:
        network, field = (of(device, current, gap, iron) for of in (_network, _field))
        now = _read(network), _read(field)
        ratio = {key: now[0][key] / now[1][key] for key in before}
        forces, linkages = network.force / field.force, network.flux_linkage / field.flux_linkage
        share = {key: ratio[key] - before[key] for key in before}
        causes.append(NetworkCause(name, meaning, forces - force, linkages - linkage, share))
        before, force, linkage = ratio, forces, linkages
    return causes


def _read(point: _Point) -> dict[str, float]:
    """Return all quantities of one current and gap."""
    return {
        name: row.read.of(point)
        for name, row in QUANTITIES.items()
        if isinstance(row.read, AnswerReadout) and row.read.need == "magnetic_point"
    }


def _network(device: Device, current: float, gap: float, iron: IronKind) -> _Point:
    found = network_samples(device, np.array([current]), np.array([gap]), replace(FULL, iron=iron))
    tables = found.force, found.flux_linkage, found.coenergy, found.incremental_inductance
    return _Point(current, *(float(np.asarray(table)[0, 0]) for table in tables))


def _field(device: Device, current: float, gap: float, iron: IronKind) -> _Point:
    from tactgen.fem.reluctance.axisymmetric.field import solve_field
    from tactgen.fem.reluctance.axisymmetric.force import virtual_work_force
    from tactgen.fem.reluctance.axisymmetric.space import discretise
    from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS, graded_grid
    from tactgen.geometry.reluctance.section_regions import actuator_regions

    regions = actuator_regions(device, gap)
    if iron != "saturating":
        highest = magnetisation_curve(device.steel).highest_permeability
        curve = linear(_PERFECT if iron == "perfect" else highest)
        regions = tuple(replace(r, curve=r.curve and curve) for r in regions)
    found: Any = solve_field(
        discretise(graded_grid(regions, OUTER_RADIUS), _ORDER), np.array([current])
    )
    return _Point(
        current,
        -virtual_work_force(found),
        float(found.flux_linkage[0]),
        found.coenergy,
        float(found.incremental_inductance[0, 0]),
    )
