"""The solid's matrices as sums of fixed ones, each times a product of lengths and constants.

On bricks stretched piece by piece (:mod:`geometry.bimorph.stretching`) a derivative along an
axis is one of the undivided shape over the stretch s of its piece, so in a zone (one piece
along each axis) and for one entry C of its tensor

    ∫ ∂_a v_p C ∂_b u_q dV  =  C s_x s_y s_z / (s_a s_b)  ∫ ∂_a v_p ∂_b u_q dV  undivided.

Displacements are carried as û_p = g_p u_p, g the stretch of the whole along axis p: then
a uniformly stretched body has strains S_pq = Ŝ_pq / (g_p g_q), bending stays free of shear,
and few shapes serve a wide range.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.fem.piezo.system import Material, materials
from tactgen.geometry.arrays import Floats, Ints, Numbers
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.bimorph.stretching import Pieces, piece_breaks, piece_lengths
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.store.values import storable

#: Numbers by scene key such as ``bimorph.length``, each an array over the points.
Values = Mapping[str, Any]
#: Groups of scene keys that the solid reads.
GROUPS = ("bimorph", "piezo", "shim", "glue")
#: Place of the potential among (u_x, u_y, u_z, φ).
POTENTIAL = 3


@storable
@dataclass(frozen=True)
class Expansion:
    """Which terms the matrices of a family have.

    Attributes
    ----------
    regions : tuple of str
        Material of each zone.
    places : (zones, 2) int array
        Piece along x and along z of each zone.
    x, y, z : (pieces,) array
        Lengths of the undivided body's pieces (m).
    elastic, coupling, dielectric : (terms, 5) int array
        Zone, p, a, q, b of the terms of stiffness between displacements, from displacement q
        to potential p, and between potentials; of two that mirror each other the first.
    inertial : (terms, 2) int array
        Zone and component of the terms of mass.
    unit : float
        Size of the potential's unit (V).
    """

    regions: tuple[str, ...]
    places: Ints
    x: Floats
    y: Floats
    z: Floats
    elastic: Ints
    coupling: Ints
    dielectric: Ints
    inertial: Ints
    unit: float

    def coefficients(self, device: Device, values: Values, *, lossy: bool = False) -> Coefficients:
        """Return what the terms are worth for bimorphs that differ from `device` in `values`.

        Raises
        ------
        InputError
            If one of them has other pieces than the family, or constants that no material has.
        """
        own = {key.removeprefix("bimorph."): value for key, value in values.items()}
        pieces = piece_lengths(device.bimorph, own)
        tensors, density = _materials(device, values, self.regions, self.unit, lossy=lossy)
        ix, iz = self.places.T
        s = np.stack(
            np.broadcast_arrays(
                (pieces.x / self.x)[:, ix],
                pieces.y / self.y,
                (pieces.z / self.z)[:, iz],
            ),
            axis=-1,
        )
        whole = [
            p.sum(axis=1) / own.sum()
            for p, own in zip(pieces.axes, (self.x, self.y, self.z), strict=True)
        ]
        g = np.column_stack(np.broadcast_arrays(*whole, np.ones(1)))
        volume = s.prod(axis=-1)

        def stiffness(terms: Ints) -> Numbers:
            zone, p, a, q, b = terms.T
            entry = tensors[:, zone, p, a, q, b]
            sides = s[:, zone, a] * s[:, zone, b] * g[:, p] * g[:, q]
            return np.asarray(entry * volume[:, zone] / sides)

        zone, component = self.inertial.T
        inertia = density[:, zone] * volume[:, zone] / g[:, component] ** 2
        parts = [stiffness(terms) for terms in (self.elastic, self.coupling, self.dielectric)]
        count = max(parts[0].shape[0], inertia.shape[0])

        def for_all(array: Numbers) -> Any:
            return np.broadcast_to(array, (count, *array.shape[1:]))

        return Coefficients(
            Pieces(*(for_all(axis) for axis in pieces.axes)),
            for_all(g[:, :POTENTIAL]),
            for_all(density),
            *(for_all(part) for part in (*parts, inertia)),
        )


@dataclass(frozen=True)
class Coefficients:
    """What the terms of an :class:`Expansion` are worth for n bimorphs.

    `scale` (n, 3) is g; `density` (n, zones) in kg/m³; the others (n, terms).
    """

    pieces: Pieces
    scale: Floats
    density: Floats
    elastic: Numbers
    coupling: Numbers
    dielectric: Numbers
    inertial: Floats

    @property
    def count(self) -> int:
        """Number of bimorphs."""
        return int(self.scale.shape[0])


def expansion(device: Device, bricks: Bricks, unit: float) -> Expansion:
    """Return the terms of a family whose undivided member is `device` on `bricks`."""
    known = materials(device, bricks.regions, device.piezo.ceramic(), lossy=False)
    across, _, along = piece_breaks(bricks)
    regions, places = [], []
    for i, low in enumerate(across[:-1]):
        for k, start in enumerate(along[:-1]):
            for slab in bricks.slabs:
                if slab.x[0] <= low < slab.x[1] and slab.z[0] <= start < slab.z[1]:
                    regions.append(slab.region)
                    places.append((i, k))
    pieces = piece_lengths(device.bimorph, {})
    terms = [(zone, *entry) for zone, name in enumerate(regions) for entry in _entries(known[name])]
    table = np.array(terms)
    potentials = (table[:, [1, 3]] == POTENTIAL).sum(axis=1)
    return Expansion(
        regions=tuple(regions),
        places=np.array(places),
        x=pieces.x[0],
        y=pieces.y[0],
        z=pieces.z[0],
        elastic=table[potentials == 0],
        coupling=table[potentials == 1],
        dielectric=table[potentials == 2],
        inertial=np.array([(zone, c) for zone in range(len(regions)) for c in range(POTENTIAL)]),
        unit=unit,
    )


def _entries(material: Material) -> list[tuple[int, int, int, int]]:
    """Return p, a, q, b of a material's entries: one of two mirrored, the potential's row first."""
    found = np.argwhere(material.flux_tensor(1.0) != 0.0)
    return [
        (int(p), int(a), int(q), int(b))
        for p, a, q, b in found
        if (p == POTENTIAL and q != POTENTIAL)
        or ((p == POTENTIAL) == (q == POTENTIAL) and (p, a) <= (q, b))
    ]


def _materials(
    device: Device, values: Values, regions: tuple[str, ...], unit: float, *, lossy: bool
) -> tuple[Numbers, Floats]:
    """Return tensors (n or 1, zones, 4, 3, 4, 3) and densities (n or 1, zones)."""
    varied = {key: np.atleast_1d(v) for key, v in values.items() if not key.startswith("bimorph.")}
    count = max((v.size for v in varied.values()), default=1)
    names = tuple(dict.fromkeys(regions))
    tensors, densities = [], []
    for point in range(count):
        member = with_values(
            device, {k: float(v[min(point, v.size - 1)]) for k, v in varied.items()}
        )
        known = materials(member, names, member.piezo.ceramic(), lossy=lossy)
        tensors.append([known[name].flux_tensor(unit) for name in regions])
        densities.append([known[name].density for name in regions])
    return np.array(tensors), np.array(densities)


def with_values(device: Device, values: Mapping[str, float]) -> Device:
    """Return the device with other values of some scene keys, such as ``piezo.s11``."""
    groups: dict[str, dict[str, float]] = {}
    for key, value in values.items():
        group, _, name = key.partition(".")
        groups.setdefault(group, {})[name] = value
    changed = {
        group: getattr(device, group).model_copy(update=fields) for group, fields in groups.items()
    }
    return device.model_copy(update=changed)
