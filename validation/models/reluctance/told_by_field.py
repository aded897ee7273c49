"""What a field tells the network's circuit, one thing that it does not know after the other.

It is told permeances, to flux and to its changes, lengths of iron and an inductance, never a flux
or a pull at the point that is explained: what the circuit then answers there is still its own, and
can still be wrong.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device
from tactgen.tmm.reluctance.circuit import IronPlaces, iron_places
from tactgen.validation.models.reluctance.field_reading import FieldReading
from tactgen.validation.models.reluctance.open_circuit import Circuit

#: Elements of the sleeve below the network's own, where flux from outside comes back.
_BELOW = 24
#: Least permeance of a tube (H): one whose flux runs the other way is left out.
_LEAST = 1e-15


@dataclass(frozen=True)
class Air:
    """Permeances (H) that a field with perfect iron tells, in which air alone decides.

    Attributes
    ----------
    at_flange : (k,) array
        Of the rungs beside the flange and of the one at its top.
    at_gap, d_at_gap : float
        Of the working gap without the tubes outside, and what all permeance that its mmf drives
        gains as it widens (H/m).
    """

    at_flange: Floats
    at_gap: float
    d_at_gap: float


@dataclass(frozen=True)
class ToldByField:
    """What one field tells of the device at its gap.

    Attributes
    ----------
    reading : FieldReading
        The field.
    """

    reading: FieldReading

    @property
    def device(self) -> Device:
        """Whose field it is."""
        return self.reading.device

    @cached_property
    def places(self) -> IronPlaces:
        """Where the network's iron elements lie."""
        return iron_places(self.device, self.reading.gap)

    @property
    def _path_cells(self) -> int:
        """Cells of the network below the gap, each with an element of rod and one of sleeve."""
        return self.places.middles.size

    @cached_property
    def _sleeve_edges(self) -> Floats:
        """Heights (m) of the ends of the sleeve's elements, from its lower end up."""
        edges = self.places.ends
        below = np.linspace(-self.device.sleeve.length, edges[0], _BELOW + 1)
        return np.concatenate([below[:-1], edges])

    def flux_outside(self, circuit: Circuit) -> Circuit:
        """Return the circuit with the tubes that return outside the sleeve, which it then spares.

        Each runs from the head to an element of the sleeve, across whose wall it sees the gap's
        mmf and what the sleeve takes on the way down to it.
        """
        edges, permeance = self._sleeve_edges, self._permeance_outside
        tubes, elements, n = permeance.size, circuit.area.size, circuit.turns.size
        spared = np.tril(np.ones((tubes, tubes)), -1) + 0.5 * np.eye(tubes)
        carried = np.zeros((elements + _BELOW, n + tubes))
        carried[:elements, :n] = circuit.carried
        of_sleeve = np.flatnonzero(self.places.sleeve)
        carried[np.append(np.arange(elements, elements + _BELOW), of_sleeve), n:] = -spared
        across = np.zeros((n + 1 + tubes, n + tubes))
        across[: n + 1, :n], across[n, n:], across[n + 1 :, n:] = circuit.across, 1.0, np.eye(tubes)
        none, wall = np.zeros(tubes), np.full(_BELOW, circuit.area[of_sleeve[0]])
        told = replace(
            circuit,
            carried=carried,
            across=across,
            area=np.append(circuit.area, wall),
            length=np.append(circuit.length, np.diff(edges[: _BELOW + 1])),
            d_length=np.append(circuit.d_length, np.zeros(_BELOW)),
            reluctance=np.append(circuit.reluctance, 1.0 / permeance),
            d_reluctance=np.append(circuit.d_reluctance, none),
            turns=np.append(circuit.turns, none),
            d_turns=np.append(circuit.d_turns, none),
            to_changes=np.append(
                circuit.to_changes, permeance / self._of_changes._permeance_outside
            ),
        )
        slope = -circuit.d_reluctance[n] / circuit.reluctance[n] ** 2
        return self._with_gap(told, self._inside_sleeve, slope)

    def air(self, perfect: Circuit) -> Air:
        """Return what this field of perfect iron tells, given the network with such iron.

        The flux beside the coil's middle, where tubes run as in the network, parts what leaves the
        rod above from what returns to it below.
        """
        reading, rod, coil = self.reading, self.device.rod, self.device.coil
        circuit = self.flux_outside(perfect)
        gap, mmf = self._gap_rung, reading.gap_mmf
        over = mmf - circuit.current * np.cumsum(circuit.turns[:gap][::-1])[::-1]
        leaving = over / circuit.reluctance[:gap]
        height = self.places.middles
        middle = reading.gap - NOMINAL_GAP - coil.position - 0.5 * coil.length
        at = int(np.argmin(np.abs(height - middle)))
        flux = float(reading.flux(rod.radius)(height[at]))
        top = int(self.places.flange.sum())
        in_flange = reading.flux(rod.flange_radius)(height[:top])
        rest = flux - in_flange[-1] + leaving[top + 1 : at + 1].sum()
        at_flange = np.append(np.diff(in_flange, prepend=0.0), rest) / -over[: top + 1]
        outside = mmf * (1.0 / circuit.reluctance[gap + 1 :]).sum()
        at_gap = (flux - leaving[at + 1 :].sum() - outside) / mmf
        return Air(at_flange, at_gap, reading.gap_slope)

    def air_at_flange(self, circuit: Circuit, permeance: Floats) -> Circuit:
        """Return the circuit with the permeances of the rungs at the flange."""
        reluctance = circuit.reluctance.copy()
        reluctance[: permeance.size] = 1.0 / np.maximum(permeance, _LEAST)
        return replace(circuit, reluctance=reluctance)

    def air_at_gap(self, circuit: Circuit, air: Air) -> Circuit:
        """Return the circuit with the working gap's permeance, which alone changes with the gap.

        Seen from the rod, iron and turns stay where they are; what the sleeve's top takes along
        lies at the gap's mmf.
        """
        still = replace(
            circuit,
            d_length=np.zeros_like(circuit.d_length),
            d_reluctance=np.zeros_like(circuit.d_reluctance),
            d_turns=np.zeros_like(circuit.d_turns),
        )
        return self._with_gap(still, air.at_gap, air.d_at_gap)

    def gap_of_steel(self, circuit: Circuit, perfect: ToldByField, slope: float) -> Circuit:
        """Return the circuit whose gap has as much less permeance as steel makes of perfect iron.

        Both are what crosses at the sleeve's top per mmf of the faces, which alone is less than
        the gap's with the tubes beside it.

        Parameters
        ----------
        slope : float
            What permeance steel gains as the gap widens (H/m).
        """
        n = self._gap_rung
        changed = self._inside_sleeve - perfect._inside_sleeve
        told = self._with_gap(circuit, 1.0 / circuit.reluctance[n] + changed, slope)
        to_changes = circuit.to_changes.copy()
        to_changes[n] = self._inside_sleeve / self._of_changes._inside_sleeve
        return replace(told, to_changes=to_changes)

    @cached_property
    def _of_changes(self) -> ToldByField:
        """What the field's changes with the current tell."""
        return ToldByField(self.reading.changes)

    @cached_property
    def _permeance_outside(self) -> Floats:
        """Permeances (H) of the tubes to the sleeve's elements, from its lower end up."""
        reading, edges = self.reading, self._sleeve_edges
        outside = reading.flux(self.device.sleeve.outer_radius)(edges)
        landing = np.diff(outside)
        landing[0] += outside[0]
        mmf = reading.gap_mmf + reading.drop_along_sleeve(0.5 * (edges[1:] + edges[:-1]))
        return np.asarray(np.maximum(landing / mmf, _LEAST))

    @cached_property
    def _inside_sleeve(self) -> float:
        """Permeance (H) of the gap by the flux that returns inside the sleeve's outer radius."""
        reading = self.reading
        outside = float(reading.flux(self.device.sleeve.outer_radius)(self._sleeve_edges)[-1])
        inside = float(reading.flux(self.device.rod.radius)(0.0)) - outside
        return inside / reading.gap_mmf

    def flux_beside_shaft(self, circuit: Circuit) -> Circuit:
        """Return the circuit whose winding links the flux at its turns, not the shaft's."""
        changes = self._of_changes._beside_shaft
        return replace(circuit, beside=self._beside_shaft, beside_changes=changes)

    @cached_property
    def _beside_shaft(self) -> float:
        """Inductance (H) of what the winding links and the shaft does not carry."""
        reading, coil = self.reading, self.device.coil
        top = reading.gap - NOMINAL_GAP - coil.position
        points, weights = np.polynomial.legendre.leggauss(64)
        in_shaft = reading.flux(self.device.rod.radius)(top - 0.5 * coil.length * (1.0 + points))
        missing = reading.flux_linkage - coil.turns * float(0.5 * weights @ in_shaft)
        return float(missing / reading.current)

    def flange_foot(self, circuit: Circuit) -> Circuit:
        """Return the circuit whose shaft reaches into the flange as far as flux spreads there."""
        rod, flange = self.device.rod, self.places.flange
        foot = int(flange.sum()) - 1
        flux = self.reading.flux(rod.flange_radius)(self.places.middles[: foot + 1])
        more = self.reading.taken_by("flange") - self._by_rule(circuit, flange, flux).sum()
        shaft = np.pi * rod.radius**2
        assert circuit.curve is not None
        per_length = flux[-1] * float(circuit.curve.field_strength(np.array(flux[-1] / shaft)))
        return replace(
            circuit,
            carried=np.vstack([circuit.carried, circuit.carried[foot]]),
            area=np.append(circuit.area, shaft),
            length=np.append(circuit.length, max(more / per_length, 0.0)),
            d_length=np.append(circuit.d_length, 0.0),
        )

    def flux_in_iron(self, circuit: Circuit) -> Circuit:
        """Return the circuit whose rod and sleeve take the mmf that they take in the field.

        The shaft beside the sleeve element by element: nearly full steel is uneven along it.
        """
        reading, places, sleeve = self.reading, self.places, self.device.sleeve
        below = 0.5 * (self._sleeve_edges[1:] + self._sleeve_edges[:-1])[:_BELOW]
        head = np.zeros(places.sleeve.size - 2 * self._path_cells)
        height = np.concatenate([places.middles, places.middles, head, below])
        of_sleeve = np.append(places.sleeve, np.ones(_BELOW, dtype=bool))
        of_rod = ~of_sleeve & ~np.append(places.flange, np.zeros(_BELOW, dtype=bool))
        shaft, inside, outside = (
            reading.flux(radius)(height)
            for radius in (self.device.rod.radius, sleeve.inner_radius, sleeve.outer_radius)
        )
        flux = np.where(of_sleeve, inside - outside, shaft)
        taken = reading.taken_below("rod")
        above = reading.taken_by("rod", "head") - float(taken(0.0))
        along, of_head = np.split(np.flatnonzero(of_rod), [-head.size])
        parts = [
            (of_head, above),
            (np.flatnonzero(of_sleeve), reading.taken_by("sleeve", "collar")),
        ]
        parts += zip(along[:, None], np.diff(taken(places.ends))[along], strict=True)
        length = circuit.length.copy()
        for elements, share in parts:
            length[elements] *= share / self._by_rule(circuit, elements, flux[elements]).sum()
        return replace(circuit, length=length)

    @property
    def _gap_rung(self) -> int:
        """Place of the working gap among the rungs, which is also the number of cells."""
        return self._path_cells + 1

    def _with_gap(self, circuit: Circuit, permeance: float, slope: float) -> Circuit:
        reluctance, d_reluctance = circuit.reluctance.copy(), circuit.d_reluctance.copy()
        reluctance[self._gap_rung] = 1.0 / permeance
        d_reluctance[self._gap_rung] = -slope / permeance**2
        return replace(circuit, reluctance=reluctance, d_reluctance=d_reluctance)

    @staticmethod
    def _by_rule(circuit: Circuit, elements: Bools | Ints, flux: Floats) -> Floats:
        """Return φ H(φ/A) l (J) of some elements at fluxes (Wb) of the field."""
        assert circuit.curve is not None
        size = np.abs(flux)
        chosen = np.flatnonzero(elements) if elements.dtype == bool else elements
        strength = circuit.curve.field_strength(size / circuit.area[chosen])
        return np.asarray(size * strength * circuit.length[chosen])
