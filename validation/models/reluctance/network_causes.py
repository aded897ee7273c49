"""Why the network's number is not the field's: named causes, each measured, and what they leave.

The network is told what it does not know, one thing after the other, by the field that it is held
against, by one with perfect iron, in which air alone decides, and by one whose iron has one
permeability in each part (validation.models.reluctance.told_by_field).  A cause's share is what its
telling changes.  The shares need not add up to the difference: what they leave is the test of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_law import linear
from tactgen.tmm.reluctance.circuit import FULL, circuit
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.tmm.reluctance.switching import switching
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.models.reluctance.field_reading import FieldReading
from tactgen.validation.models.reluctance.open_circuit import Answer, Circuit
from tactgen.validation.models.reluctance.switching import SwitchingCurrents
from tactgen.validation.models.reluctance.told_by_field import ToldByField

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric_field import MagneticField

#: Relative permeability that counts as perfect: the field changes by 1e-6 from a tenth of it.
_PERFECT = 1e7
#: Share of a current at which the secant method begins beside it, and to which it settles.
_NEARBY, _SETTLED = 0.99, 1e-6
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

    def ratios(told: Circuit) -> dict[str, float]:
        found = _read(_of_network(told, size))
        return {name: value / against[name] for name, value in found.items()}

    return _causes(device, steel, ratios)


def stroke_causes(
    device: Device, pull: CoenergyMap, currents: SwitchingCurrents
) -> list[NetworkCause]:
    """Return why the network's switching currents differ from the field's, whose these are.

    At each, the current is sought at which the network, told so far, pulls as the field does: what
    the spring bears.  Where the rod is stuck between its stops the gap is the field's: the
    balance's current is extreme there, so the network's own lies next to it.

    Parameters
    ----------
    pull : CoenergyMap
        The field's.
    """
    found: list[NetworkCause] = []
    for (current, gap), names in _balances(device, pull, currents).items():
        steel = FieldReading(device, gap, _field(device, current, gap))

        def ratios(
            told: Circuit, steel: FieldReading = steel, names: list[str] = names
        ) -> dict[str, float]:
            return dict.fromkeys(names, _current_for(told, steel.pull) / steel.current)

        causes = _causes(device, steel, ratios)
        if all(np.isfinite(share) for cause in causes for share in cause.of.values()):
            found = together(found, causes) if found else causes
    return found


@dataclass(frozen=True)
class ToldPull:
    """The network's pull (N) once it is told of one cause more, with its name and meaning."""

    name: str
    meaning: str
    pull: float


def told_pulls(device: Device, current: float, gap: float) -> list[ToldPull]:
    """Return the network's pull at a current (A) and gap (m): untold, then after each telling."""
    steel = FieldReading(device, gap, _field(device, current, gap))
    untold = ("the network", "as it is", _network(device, current, gap))
    return [
        ToldPull(name, meaning, told.solved().force)
        for name, meaning, told in (untold, *_told(device, steel))
    ]


def together(causes: list[NetworkCause], more: list[NetworkCause]) -> list[NetworkCause]:
    """Return causes with their shares of more quantities."""
    both = zip(causes, more, strict=True)
    return [replace(cause, of={**cause.of, **other.of}) for cause, other in both]


def _balances(
    device: Device, pull: CoenergyMap, currents: SwitchingCurrents
) -> dict[tuple[float, float], list[str]]:
    """Return the quantities that are the same current (A), balanced at the same gap (m)."""
    by_map = switching(device, pull)
    gaps = SimpleNamespace(
        lift_off=device.gap,
        pull_in=by_map.pull_in_gap,
        holding=device.spring.stop_gap,
        drop_out=by_map.drop_out_gap,
    )
    found: dict[tuple[float, float], list[str]] = {}
    for name, row in QUANTITIES.items():
        if isinstance(row.read, AnswerReadout) and row.read.need == "magnetic_map":
            current = row.read.of(currents).value
            if np.isfinite(current) and current > 0.0:
                found.setdefault((current, row.read.of(gaps)), []).append(name)
    return found


def _current_for(told: Circuit, pull: float) -> float:
    """Return the current (A) near the circuit's own at which it pulls so (N), nan for none."""
    from scipy.optimize import newton

    def missing(current: float) -> float:
        return replace(told, current=current).solved().force / pull - 1.0

    start = told.current
    found, how = newton(
        missing, start, x1=_NEARBY * start, tol=_SETTLED * start, full_output=True, disp=False
    )
    return float(found) if how.converged else np.nan


def _causes(
    device: Device, steel: FieldReading, ratios: Callable[[Circuit], dict[str, float]]
) -> list[NetworkCause]:
    """Return the causes by what each telling changes of ratios to the field's values."""
    before = ratios(_network(device, steel.current, steel.gap))
    causes = []
    for name, meaning, told in _told(device, steel):
        now = ratios(told)
        share = {key: before[key] - value for key, value in now.items()}
        causes.append(NetworkCause(name, meaning, share))
        before = now
    return causes


def _told(device: Device, steel: FieldReading) -> Iterator[tuple[str, str, Circuit]]:
    """Yield name and meaning of each cause, and the network told of all causes so far."""
    current, gap = steel.current, steel.gap
    telling = ToldByField(steel)
    even = steel.permeabilities
    of_perfect = _field(device, current, gap, dict.fromkeys(even, _PERFECT))
    perfect = ToldByField(FieldReading(device, gap, of_perfect))
    air = perfect.air(_network(device, current, gap, perfect=True))
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
    slope = FieldReading(device, gap, _field(device, current, gap, even)).gap_slope
    told = telling.gap_of_steel(told, perfect, slope)
    yield (
        "steel at the gap",
        "steel parts flux between the tubes otherwise than perfect iron, and changes of it more so",
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


def _field(
    device: Device, current: float, gap: float, permeabilities: Mapping[str, float] | None = None
) -> MagneticField:
    """Return the field, of steel or of iron with one relative permeability by region."""
    from tactgen.fem.magnetics.axisymmetric_field import solve_field
    from tactgen.fem.magnetics.axisymmetric_space import discretise
    from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS, actuator_regions, graded_grid

    regions = actuator_regions(device, gap)
    if permeabilities:
        regions = tuple(
            replace(r, curve=r.curve and linear(permeabilities[r.name])) for r in regions
        )
    grid = graded_grid(regions, OUTER_RADIUS)
    return solve_field(discretise(grid, _ORDER), np.array([current]))
