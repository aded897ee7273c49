"""What the finer bricks of a family miss: the estimate of a few members, carried over the range.

The middle of the range, and both ends of each key, are judged as a single bimorph is: by what
polynomials of one degree more make of their residual, at rest and of natural frequencies
(:mod:`fem.piezo.brick_error`).  As shares of an answer these vary slowly with
dimensions and constants, so that parabolas of their logarithms along each key say what they are in
between.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.expansion import with_values
from tactgen.fem.piezo.brick_error import BrickSurplus
from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.piezo.ports import judged_at_rest
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.bimorph.bricks import Axis, Bricks
from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.bimorph.stretching import dividing, stretched
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.store.values import storable
from tactgen.validation.models.bimorph.lowest_modes import MeshModes, mesh_modes

#: Least share whose logarithm is taken: nothing is missing without piezoelectricity.
_NOTHING = 1e-30


@storable
@dataclass(frozen=True)
class FamilySurplus:
    """What displacements and potentials that the bricks lack make of 1 + 2 keys members.

    These are the middle of the range, then the low and the high end of each key with all others
    in the middle.

    Attributes
    ----------
    ranges : dict of str to (float, float)
        Lowest and highest value of each scene key that varies (SI).
    shares : (members, 2, 3) array
        What a volt, a tip force and a tip moment gain in work at rest, over the work they do.
    together : (members, 2, 3, 3) array
        How much two of them gain in common, between -1 and 1.
    modes : tuple of MeshModes
        Their modes, with what judges these.
    """

    ranges: dict[str, tuple[float, float]]
    shares: Floats
    together: Floats
    modes: tuple[MeshModes, ...]

    def at_rest(self, values: Mapping[str, Floats], work: Floats) -> Floats:
        """Return what is gained (n, 2, 3, 3) by n points, at which the loads do `work` (n, 3)."""
        share = np.exp(self._carried(values, np.log(self.shares)))
        together = np.clip(self._carried(values, self.together), -1.0, 1.0)
        size = np.sqrt(share * np.abs(work)[:, None])
        return np.asarray(together * size[..., :, None] * size[..., None, :])

    def of_modes(
        self, values: Mapping[str, Floats], ends: Ends, count: int, *, open_circuit: bool
    ) -> dict[Motion, Floats]:
        """Return by how much n points' frequencies move (n, 2, modes), relative, by class."""
        moved = [_moved(each, ends, count, open_circuit=open_circuit) for each in self.modes]
        found = {}
        for motion in moved[0]:
            least = min(each[motion].shape[1] for each in moved)
            every = np.array([each[motion][:, :least] for each in moved])
            size = self._carried(values, np.log(np.maximum(np.abs(every), _NOTHING)))
            found[motion] = np.sign(every[0]) * np.exp(size)
        return found

    def opened(self, values: Mapping[str, Floats], ends: Ends) -> Floats:
        """Return how far off n points' Ω² of open circuit is beside short circuit's (n,)."""
        each = np.array([of.opened(ends) for of in self.modes])
        return np.exp(self._carried(values, np.log(np.maximum(each, _NOTHING))))

    def _carried(self, values: Mapping[str, Floats], of: Floats) -> Floats:
        """Return parabolas (n, ...) along each key through what is known of members."""
        middle, *ends = of
        count = max((np.size(at) for at in values.values()), default=1)
        found = np.repeat(middle[None], count, axis=0)
        for (key, (start, stop)), low, high in zip(
            self.ranges.items(), ends[::2], ends[1::2], strict=True
        ):
            t = (2.0 * np.asarray(values[key]) - start - stop) / (stop - start)
            t = t.reshape(-1, *[1] * middle.ndim)
            found = found + 0.5 * t * (high - low) + t**2 * (0.5 * (high + low) - middle)
        return np.asarray(found)


def family_surplus(
    device: Device,
    ranges: Mapping[str, tuple[float, float]],
    meshing: BrickMeshing,
    modes: Mapping[Motion, int],
) -> FamilySurplus:
    """Judge a few members of a range on the family's bricks, so many modes of each class."""
    count = modes["bending_x"]
    others: dict[Motion, int] = {motion: n for motion, n in modes.items() if motion != "bending_x"}
    shares, together, found = [], [], []
    for member, bricks in _members(device, ranges, meshing):
        lacking = cache(BrickSurplus(member, bricks).of)
        system = assemble_bricks(member, bricks, lossy=False)
        work, gained = judged_at_rest(system, lacking("bending_x"))
        own = np.einsum("kii->ki", gained)
        size = np.sqrt(np.maximum(own, _NOTHING * np.abs(work)))
        shares.append(size**2 / np.abs(work))
        together.append(gained / size[:, :, None] / size[:, None, :])
        found.append(mesh_modes(system, others, count, lacking))
    return FamilySurplus(dict(ranges), np.array(shares), np.array(together), tuple(found))


def _members(
    device: Device, ranges: Mapping[str, tuple[float, float]], meshing: BrickMeshing
) -> Iterator[tuple[Device, Bricks]]:
    """Return the members that are judged, each with its bricks, polynomials told by degree."""
    corners = itertools.product(*ranges.values())
    extremes = [with_values(device, dict(zip(ranges, at, strict=True))) for at in corners]
    bricks = dividing(extremes, meshing)
    middle = {key: 0.5 * sum(ends) for key, ends in ranges.items()}
    for point in (middle, *({**middle, key: end} for key in ranges for end in ranges[key])):
        member = with_values(device, point)
        own = stretched(bricks, member.bimorph)
        x, y, z = (Axis(axis.breaks, axis.degree, hierarchic=True) for axis in own.axes)
        yield member, replace(own, x=x, y=y, z=z)


def _moved(of: MeshModes, ends: Ends, count: int, *, open_circuit: bool) -> dict[Motion, Floats]:
    """Return by how much the judges' frequencies differ (2, modes), relative, by class."""
    own, *judges = (
        {
            motion: np.array([mode.frequency for mode in found])
            for motion, found in each.lowest(ends, count, open_circuit=open_circuit).items()
        }
        for each in (of, *of.judges)
    )
    return {
        motion: np.array([judge[motion] / frequencies - 1.0 for judge in judges])
        for motion, frequencies in own.items()
    }
