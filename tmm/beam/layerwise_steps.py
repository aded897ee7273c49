"""Steps along a bimorph by layerwise theory: where layers begin or end.

A layer that ends is free of stress there and takes up its share within some thicknesses only, on a
soft core within many; until then the others bend alone.  Under a moment or a voltage, without
shear force, each piece of the row has its beam theory and modes of slip that decay from its ends
(:mod:`tmm.beam.layerwise`), uₖ″ = κₖ² uₖ.  At a step the layers that go on have one displacement
and one force on both sides, and what ends has no force.  Far from the step that is a jump of the
beams' rotation.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.segments import Piece, stack
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.beam.layerwise import SlipModes, counted, slip_modes

#: Curvature at a voltage, relative to the largest of the row, of a piece that it does not bend.
_UNDRIVEN = 1e-9


class Step(NamedTuple):
    """What a step adds to the rotation of the beams on both sides.

    As the length (m) of a piece that turns as much: under a moment of the more flexible one beside
    it, at a voltage of the nearest that it bends, of two the one that bends more; negative where
    it turns less.
    """

    softer: int  #: Number of the piece in the row
    by_moment: float
    driven: int
    by_voltage: float


class _Part(NamedTuple):
    """One piece: its modes of slip, its length (m), and the unknowns of each layer.

    By its region, and its number among those of the same, such as glue below and above.
    """

    modes: SlipModes
    length: float
    layers: dict[tuple[str, int], Ints]

    def at(self, share: float) -> Floats:
        """Modes and their slopes along z (2, k, 2 k) at an end, of what starts at either end."""
        decay, z = self.modes.decay, share * self.length
        still = decay == 0.0
        from_below, from_above = np.exp(-decay * z), np.exp(-decay * (self.length - z))
        values = np.where(still, 1.0, from_below), np.where(still, z, from_above)
        slopes = np.where(still, 0.0, -decay * from_below), np.where(still, 1.0, decay * from_above)
        return np.array([np.hstack([np.diag(one) for one in each]) for each in (values, slopes)])

    def at_end(self, share: float) -> tuple[Floats, Floats, Floats]:
        """Displacement and force (n, 2 k) of each unknown at an end, and force per voltage (n,)."""
        values, slopes = self.at(share)
        return self.modes.shapes @ values, self.modes.forces @ slopes, self.modes.volt

    def unknowns(self, regions: Collection[tuple[str, int]]) -> Ints:
        """Unknowns of some layers."""
        named = [at for name, at in self.layers.items() if name in regions]
        return np.unique(named)

    @property
    def rotation(self) -> Floats:
        """Rotation (2,) per unit of the two modes that beam theory has."""
        faces = self.modes.faces
        beam = np.zeros((2, self.modes.decay.size))
        beam[0, : faces.size], beam[1, : faces.size] = 1.0, faces
        return np.asarray(np.linalg.inv((self.modes.forces.T @ beam.T)[:2])[1])


def layer_steps(device: Device, row: Sequence[Piece]) -> list[Step | None]:
    """Step between each piece of a row (n,) and the next one (n − 1,).

    None where the same layers go on.  Layers of a piece touch.
    """
    if len(row) == 1:
        return []
    parts = []
    for piece in row:
        layers = counted(stack(piece, device))
        count = len(layers)
        unknowns = {}
        for i, of in enumerate(layers):
            same = sum(other.region == of.region for other in layers[:i])
            own = [i, i + 1, count + 1 + 2 * i, count + 2 + 2 * i]
            unknowns[of.region, same] = np.array(own)
        modes = slip_modes(layers, device.bimorph.width, varying_field=True)
        parts.append(_Part(modes, piece.length, unknowns))
    return _steps(parts)


def _steps(parts: Sequence[_Part]) -> list[Step | None]:
    bent = _amplitudes(parts)
    curved = np.array([_curvature(*each) for each in zip(parts, bent, strict=True)])
    found: list[Step | None] = []
    for number, (below, above) in enumerate(pairwise(parts)):
        if below.layers.keys() == above.layers.keys():
            found.append(None)
            continue
        _, at_end = _turned(below, bent[number])
        at_start, _ = _turned(above, bent[number + 1])
        by_moment, by_voltage = at_start - at_end
        softer = number + int(abs(curved[number + 1, 0]) > abs(curved[number, 0]))
        driven = _nearest_driven(np.abs(curved[:, 1]), number)
        turned = by_voltage / curved[driven, 1] if curved[driven, 1] else 0.0
        found.append(Step(softer, float(by_moment / curved[softer, 0]), driven, float(turned)))
    return found


def _nearest_driven(bends: Floats, below: int) -> int:
    """Piece nearest to the step above piece `below` that a voltage bends; any if it bends none."""
    driven = np.flatnonzero(bends > _UNDRIVEN * bends.max())
    nearest = sorted(driven, key=lambda n: (abs(n - below - 0.5), -bends[n]))
    return int(nearest[0]) if nearest else below


def _turned(part: _Part, amplitudes: Floats) -> tuple[Floats, Floats]:
    """Rotation (2,) of the beam at the lower and the upper end, per moment and per voltage."""
    start = part.rotation @ amplitudes[:2]
    return start, start + part.length * _curvature(part, amplitudes)


def _curvature(part: _Part, amplitudes: Floats) -> Floats:
    """Curvature (2,) of the beam per moment and per voltage."""
    k = part.modes.decay.size
    return np.asarray(part.rotation @ amplitudes[k : k + 2])


def _amplitudes(parts: Sequence[_Part]) -> list[Floats]:
    """Amplitudes (2 k, 2) of each part's modes from either end, per moment and per voltage.

    The base is held; on the tip the moment acts as beam theory has it.
    """
    ends = np.cumsum([0, *(2 * part.modes.decay.size for part in parts)])
    own = [slice(*pair) for pair in pairwise(ends)]
    rows, right = list[Floats](), list[Floats]()

    def equal(*terms: tuple[Floats, slice], given: Floats | None = None) -> None:
        """Let the sum of blocks times the amplitudes of their parts be 0, or what is given."""
        row = np.zeros((len(terms[0][0]), ends[-1]))
        for block, columns in terms:
            row[:, columns] = block
        rows.append(row)
        right.append(np.zeros((len(row), 2)) if given is None else given)

    def per_volt(force: Floats) -> Floats:
        return np.stack([np.zeros_like(force), force], axis=1)

    equal((parts[0].at(0.0)[0], own[0]))
    for (below, here), (above, beyond) in pairwise(zip(parts, own, strict=True)):
        both = below.layers.keys() & above.layers.keys()
        (u, f, volt), (v, g, volt_above) = below.at_end(1.0), above.at_end(0.0)
        low, high = below.unknowns(both), above.unknowns(both)
        equal((u[low], here), (-v[high], beyond))
        equal((f[low], here), (-g[high], beyond), given=per_volt(volt[low] - volt_above[high]))
        for force, by_volt, goes_on, columns in (
            (f, volt, low, here), (g, volt_above, high, beyond),
        ):  # fmt: skip
            free = np.setdiff1d(np.arange(len(force)), goes_on)
            equal((force[free], columns), given=per_volt(by_volt[free]))
    last = parts[-1]
    values, slopes = last.at(1.0)
    by_volt = (last.modes.shapes.T @ last.modes.volt)[:2]
    equal((slopes[:2], own[-1]), given=np.stack([last.rotation, by_volt], axis=1))
    equal((values[2:], own[-1]))
    matrix = np.concatenate(rows)
    scale = np.abs(matrix).max(axis=1, keepdims=True)
    found = np.linalg.solve(matrix / scale, np.concatenate(right) / scale)
    return [found[columns] for columns in own]
