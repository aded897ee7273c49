"""Why the network's rod does not rest where the field's does: the pull's causes, at both stops.

A place of rest is not in proportion to the pull: a percent of it decides at which stop the rod is.
So the network is told at both stops, and each time the rod is let rest by what it then pulls.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.positions import RestingPlace, axial_forces, resting_place
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.engine.results import Estimate
from tactgen.validation.models.reluctance.model import MagneticModel
from tactgen.validation.models.reluctance.network_causes import NetworkCause, told_pulls
from tactgen.validation.models.reluctance.rest import RestingState


@dataclass(frozen=True)
class _Scaled:
    """A map's pull times a factor that is known at two gaps (m), a straight line between them."""

    map: CoenergyMap
    gaps: tuple[float, float]
    factors: tuple[float, float]

    @property
    def gap_limits(self) -> tuple[float, float]:
        return self.map.gap_limits

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        return np.asarray(self._factor(gap) * self.map.force(current, gap))

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        (low, high), (first, last) = self.gaps, self.factors
        slope = (last - first) / (high - low)
        steeper = self._factor(gap) * self.map.force_gradient(current, gap)
        return np.asarray(steeper + slope * self.map.force(current, gap))

    def _factor(self, gap: Floats | float) -> Floats:
        return np.asarray(np.interp(gap, self.gaps, self.factors))


def rest_causes(field: MagneticModel) -> list[NetworkCause]:
    """Return why the network's rod rests elsewhere than that of a model of the field."""
    scene, pull, state = field.scene, field.map(), field.rest()
    device, pressed = scene.device, scene.load.normal_force
    current = abs(scene.coil.current)
    gaps = device.spring.stop_gap, device.gap
    low, high = (told_pulls(device, current, gap) for gap in gaps)
    by_map = [float(pull.force(current, gap)) for gap in gaps]
    values = []
    for first, last in zip(low, high, strict=True):
        factors = first.pull / by_map[0], last.pull / by_map[1]
        forces = axial_forces(device, _Scaled(pull, gaps, factors), pressed)
        values.append(_read(_at(resting_place(forces, current, scene.coil.history))))
    of_field = {name: found.value for name, found in _read(state).items()}
    causes = []
    for told, (before, after) in zip(low[1:], pairwise(values), strict=True):
        share = {name: (before[name] - after[name]) / of for name, of in of_field.items() if of}
        causes.append(NetworkCause(told.name, told.meaning, share))
    return causes


def _at(place: RestingPlace) -> SimpleNamespace:
    """Return what rows read off a resting state, of a place alone."""
    return SimpleNamespace(
        position=place.lift,
        finger_force=place.finger_force,
        contact_force=place.contact_force,
        places=None,
    )


def _read(state: RestingState | SimpleNamespace) -> dict[str, Any]:
    """Return the single values of a state of rest by quantity; lists of places have no shares."""
    rows = {n: r.read for n, r in QUANTITIES.items() if isinstance(r.read, AnswerReadout)}
    found = {name: read.of(state) for name, read in rows.items() if read.need == "rest"}
    return {name: one for name, one in found.items() if isinstance(one, float | Estimate)}
