"""A family of the solid of which thousands of members will be asked, on as few shapes as serve."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.answers import mode_states, static_states
from tactgen.fem.bimorph.reduction.parametric.compression import compressed
from tactgen.fem.bimorph.reduction.parametric.reduced import Members
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats
from tactgen.tmm.ports.readout import ModalReadout
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.models.bimorph.family.solid_family import SolidFamily
from tactgen.validation.models.bimorph.family.values import FamilyValues, family_values
from tactgen.validation.scene.scene import Scene

#: Members whose states are looked at, and others on which the fewer shapes are tried, for each
#: key that varies.
_LOOKED_AT, _TRIED = 32, 16
#: Root of the energy left out, in units of the bound's root: at first, and how much less each
#: time that this widens a bar too much.
_LEFT_OUT, _CLOSER, _ROUNDS = 4.0, 0.5, 8
#: How much wider a bar may become, if it is above this share of the accuracy asked for.
_WIDER, _NARROW = 1.1, 0.05


def for_many(
    scene: Scene,
    family: SolidFamily,
    quantities: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> SolidFamily:
    """Return the family on the shapes that the quantities need as the scene is held and loaded.

    On members whose states were not looked at, bars that are not far below the accuracy asked
    for are at most a tenth wider; where that needs all shapes, and for responses, it is the
    family itself.
    """
    rows = [QUANTITIES[name] for name in quantities]
    if any(row.by_frequency for row in rows):
        return family
    announce("solid family: the shapes that these quantities need")
    looked_at, tried = _points(family, _LOOKED_AT, 5), _points(family, _TRIED, 6)
    corners = np.array(list(itertools.product(*family.ranges.values()))).T
    looked_at = {
        key: np.concatenate([found, ends])
        for (key, found), ends in zip(looked_at.items(), corners, strict=True)
    }
    circuits = {c for row in rows if isinstance(row.read, ModalReadout) for c in row.read.circuits}
    at_rest = any(not isinstance(row.read, ModalReadout) for row in rows)
    counts = {  # at rest nothing moves in a class of motion without ports
        motion: count
        for motion, count in family.counts(scene.modes).items()
        if circuits or family.fine.motions[motion].has_ports
    }
    levels = [
        replace(level, motions={motion: level.motions[motion] for motion in counts})
        for level in (family.fine, family.coarse)
    ]

    def states(motion: Motion, members: Members) -> Floats:
        found = [
            mode_states(members, scene.ends, counts[motion], open_circuit=circuit == "open")
            for circuit in sorted(circuits)
        ]
        if at_rest and members.ports is not None:
            found.append(static_states(members))
        return np.concatenate(found, axis=2)

    before = family_values(scene, family, tried, quantities)
    least = _LEFT_OUT * float(np.sqrt(max(family.fine.bound, family.coarse.bound)))
    for _ in range(_ROUNDS):
        fine, coarse = (
            compressed(level, scene.device, looked_at, states, least) for level in levels
        )
        fewer = SolidFamily(fine, coarse, family.surplus)
        after = family_values(scene, fewer, tried, quantities)
        if all(_as_good(after[name], before[name], scene.accuracy) for name in quantities):
            return fewer
        least *= _CLOSER
    return family


def _as_good(after: FamilyValues, before: FamilyValues, accuracy: float) -> bool:
    enough = np.maximum(_WIDER * before.error, _NARROW * accuracy * np.abs(before.value))
    return bool((after.error <= enough).all())


def _points(family: SolidFamily, count: int, seed: int) -> dict[str, Floats]:
    rng = np.random.default_rng(seed)
    return {key: rng.uniform(*ends, count * len(family.ranges))
            for key, ends in family.ranges.items()}  # fmt: skip
