"""The generator seen as a row of pieces, from its held end to its tip.

What every one-dimensional model starts from.  Only lengths and cross-sections are
stated here; each model computes its own section constants from them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain, pairwise
from math import fsum
from typing import Any, Literal

import numpy as np

from tactgen.geometry.arrays import Floats, Ints, Numbers
from tactgen.geometry.device.bimorph import Dimensions
from tactgen.geometry.device.laminate import OWN, Laminate, Layer
from tactgen.geometry.device.parameters import (
    NOMINAL_GAP,
    Bimorph,
    Device,
    Glue,
    Piezo,
    Shim,
    Support,
)
from tactgen.geometry.meshing.mesh import Mesh

#: Points closer than this share of the ceramic's length are one.
_APART = 1e-9


@dataclass(frozen=True)
class Piece:
    """A stretch of the generator."""

    #: Cross-section: the three layers, the bare shim, solid rod steel, or the tab glued into the
    #: rod's slot (it lies beside the head and adds nothing to the row's height)
    section: Literal["bimorph", "shim", "cylinder", "bond"]
    length: float  #: Axial length (m)
    radius: float = 0.0  #: Radius of a cylinder (m), 0 otherwise
    #: Layers at the lower and the upper end, varying linearly between them; None
    #: where they are the device's own
    ends: tuple[Dimensions, Dimensions] | None = None
    electrode: bool = True  #: Whether the ceramic's outer faces carry electrodes
    #: Numbers, from 0, of the listed layers that do not reach here
    without: tuple[int, ...] = ()

    @property
    def tapered(self) -> bool:
        """Whether the cross-section changes along the piece."""
        return self.ends is not None and self.ends[0] != self.ends[1]

    def layers(self, bimorph: Bimorph, share: Any = 0.5) -> Dimensions:
        """Layers at a share (number or array) of the length from the lower end."""
        if self.ends is None:
            return Dimensions(bimorph.width, bimorph.piezo_thickness, bimorph.shim_thickness)
        low, high = self.ends
        return Dimensions(
            low.width + share * (high.width - low.width),
            low.piezo_thickness + share * (high.piezo_thickness - low.piezo_thickness),
            low.shim_thickness + share * (high.shim_thickness - low.shim_thickness),
        )


def beam_pieces(device: Device, support: Support) -> tuple[Piece, ...]:
    """Pieces from the held end to the tip.

    With ``support.kind = "rod"`` the rod is a stepped beam held at its lower face, the glued
    part of the tab hangs in its head, and the free part follows; otherwise the row starts at
    the tab's lower end, or at the ceramic where there is no tab.
    """
    bimorph = device.bimorph
    pieces: list[Piece] = []
    tab = bimorph.tab_length
    if support.kind == "rod":
        tab = device.ceramic_base
        pieces += _rod_pieces(device)
        pieces.append(Piece("bond", device.rod.slot_depth - device.glue.thickness))
    if tab > 0.0:
        pieces.append(Piece("shim", tab))
    pieces += _ceramic_pieces(bimorph)
    if bimorph.tip_extension > 0.0:
        pieces.append(Piece("shim", bimorph.tip_extension))
    return tuple(pieces)


def measured_pieces(device: Device, support: Support) -> list[Piece]:
    """Pieces with the one divided in which the place of measurement lies, if it is not the tip."""
    bimorph, below = device.bimorph, device.measurement.below_tip
    found, rest = list(beam_pieces(device, support)), below
    for k in range(len(found) - 1, -1, -1):
        piece, rest = found[k], rest - found[k].length
        if not below or abs(rest) < _APART * piece.length:
            break
        if rest < 0.0:
            share = -rest / piece.length
            lower = replace(piece, length=-rest)
            upper = replace(piece, length=rest + piece.length)
            if piece.ends is not None:
                at = piece.layers(bimorph, share)
                lower = replace(lower, ends=(piece.ends[0], at))
                upper = replace(upper, ends=(at, piece.ends[1]))
            return [*found[:k], lower, upper, *found[k + 1 :]]
    return found


@dataclass(frozen=True)
class StackLayer:
    """One layer of a cross-section, plain numbers or arrays along a taper."""

    region: str  #: Name of its part of the body
    material: Piezo | Shim | Glue
    #: Faces along x (m), 0 in the middle of the whole
    low: Any
    high: Any
    poling: float = 0.0  #: +1 or −1 along x of a ceramic
    #: Face along x at the voltage; 0 where both are at 0 V
    hot: float = 0.0
    electrodes: bool = True  #: Whether a ceramic's faces carry electrodes
    share: float = 1.0  #: Width over that of the bimorph, both in the middle
    uniform: bool = False  #: Whether electrodes hold the field in all of it, not its mean alone

    @property
    def thickness(self) -> Any:
        """Distance of the faces (m)."""
        return self.high - self.low


def bimorph_stack(device: Device) -> list[StackLayer]:
    """All layers from −x to +x, as where the ceramics are and no listed one ends."""
    return stack(Piece("bimorph", device.bimorph.length), device)


def stack(piece: Piece, device: Device, share: Any = 0.5) -> list[StackLayer]:
    """Layers of a piece of section ``bimorph`` or ``shim`` from −x to +x.

    `share` is where along the piece (number or array), from its lower end.
    """
    bimorph, active = device.bimorph, piece.section == "bimorph"
    if bimorph.layers:
        return _stated(device, piece)
    sizes = piece.layers(bimorph, share)
    half, sign = 0.5 * np.asarray(sizes.shim_thickness), bimorph.poling_sign
    core = StackLayer("shim", device.shim, -half, half)
    if not active:
        return [core]
    face = half + bimorph.glue_thickness
    outer = face + np.asarray(sizes.piezo_thickness)
    bonds = []
    if bimorph.glue_thickness > 0.0:
        bonds = [
            StackLayer("glue", device.glue, -face, -half),
            StackLayer("glue", device.glue, half, face),
        ]
    piezo, at = device.piezo, piece.electrode
    below = StackLayer("piezo_bottom", piezo, -outer, -face, sign, -1.0, at)
    above = StackLayer("piezo_top", piezo, face, outer, sign, 1.0, at)
    return [below, *bonds[:1], core, *bonds[1:], above]


def _stated(device: Device, piece: Piece) -> list[StackLayer]:
    """Layers that the bimorph lists and that are there; where the ceramic ends those that go on."""
    layers = device.bimorph.layers
    sizes, found = [layer.thickness for layer in layers], []
    # rounded alike from both sides, so that layers that mirror each other do so to the last digit
    add = fsum if all(isinstance(size, float) for size in sizes) else sum
    faces = [0.5 * (add(sizes[:n]) - add(sizes[n:])) for n in range(len(sizes) + 1)]
    for number in listed_at(piece, layers):
        layer, (low, high) = layers[number], faces[number : number + 2]
        at = piece.electrode and layer.electrodes != "bare"
        region, of = layers.region(number), material_of(device, layer)
        poling, hot = device.bimorph.drive_poling(number), layers.hot(number)
        share = layer.width / device.bimorph.width if np.any(layer.width) else 1.0
        uniform = layer.pitch > 0.0
        found.append(StackLayer(region, of, low, high, poling, hot, at, share, uniform))
    return found


def listed_at(piece: Piece, layers: Laminate) -> list[int]:
    """Numbers of the listed layers that reach a piece."""
    if piece.section == "bimorph":
        return [number for number in range(len(layers)) if number not in piece.without]
    return [number for number, goes_on in enumerate(layers.continues) if goes_on]


def material_of(device: Device, layer: Layer) -> Piezo | Shim | Glue:
    """Constants of a listed layer: its own, the scene's groups, or the library's.

    Those of a ceramic poled along are of one poled through its thickness that does the same.
    """
    stated: Piezo | Shim | Glue
    if layer.of is not None:  # already as the section has them
        stated = layer.of
        return stated
    if layer.material in OWN:
        stated = getattr(device, layer.material)
    else:
        stated = _of_library(layer.material, ceramic=layer.is_ceramic)
    if layer.pitch and isinstance(stated, Piezo):
        return _along(stated, layer.thickness / layer.pitch)
    return stated


@lru_cache(maxsize=64)
def _along(stated: Piezo, share: float) -> Piezo:
    return stated.along(share)


@lru_cache(maxsize=64)
def _of_library(name: str, *, ceramic: bool) -> Piezo | Shim:
    return Piezo(material=name) if ceramic else Shim(material=name)


def _ceramic_pieces(bimorph: Bimorph) -> list[Piece]:
    """Cut the ceramic at every point of a profile, at the electrodes' and the layers' edges."""
    length, extents = bimorph.length, bimorph.layers.extents(bimorph.length)
    lower_edge, upper_edge = bimorph.bare_below, length - bimorph.bare_above
    points = [z for profile in bimorph.profiles.values() for z, _ in profile]
    cuts = cuts_along([lower_edge, upper_edge, *points, *chain(*extents)], length)
    return [
        Piece(
            "bimorph",
            high - low,
            ends=bimorph.dimensions(low, high) if bimorph.profiles else None,
            electrode=lower_edge < 0.5 * (low + high) < upper_edge,
            without=tuple(
                number
                for number, (start, end) in enumerate(extents)
                if not start < 0.5 * (low + high) < end
            ),
        )
        for low, high in pairwise(cuts)
    ]


def cuts_along(points: Iterable[float], length: float) -> list[float]:
    """Ascending points (m) from 0 to `length`, both among them; those too close count once."""
    cuts = [0.0]
    for z in sorted([*points, length]):
        if cuts[-1] + _APART * length < z <= length:
            cuts.append(z)
    cuts[-1] = length
    return cuts


def side_edges(halves: Iterable[float]) -> list[float]:
    """Half widths (m), ascending from 0; those that differ by less than a millionth count once."""
    known = list(halves)
    most = max(known)
    return [0.0, *(most * share for share in sorted({round(of / most, 6) for of in known}))]


def _rod_pieces(device: Device) -> list[Piece]:
    rod = device.rod
    pieces = (
        Piece("cylinder", rod.length - rod.flange_position - rod.flange_thickness, rod.radius),
        Piece("cylinder", rod.flange_thickness, rod.flange_radius),
        Piece("cylinder", rod.flange_position + NOMINAL_GAP, rod.radius),
        Piece("cylinder", rod.head_thickness, rod.head_radius),
    )
    return [piece for piece in pieces if piece.length > 1e-12]


#: Points across a round piece, along x and along y.
_ROUND = 9


@dataclass(frozen=True)
class CentreLine:
    """Motion of a row's centre line at stations from its held end to its tip."""

    #: (n,) Height above the row's held end (m), ascending; a joint is two stations at one height
    z: Floats
    #: (n,) Displacement along x (m) and rotation of the section (rad), u_z = x ψ
    w: Numbers
    psi: Numbers
    charge: complex  #: On the outer electrodes (C), layers in parallel
    voltage: complex  #: Across each layer (V)
    frequency: float  #: Hz

    def measured(self, below_tip: float) -> complex:
        """Displacement (m) at a distance (m) below the tip, by a cubic through the stations."""
        from scipy.interpolate import CubicSpline  # slow to import

        if not below_tip:
            return complex(self.w[-1])
        z, at = np.unique(self.z, return_index=True)
        return complex(CubicSpline(z, self.w[at])(self.z[-1] - below_tip))


@dataclass(frozen=True)
class RowShape:
    """A row of pieces as eight-cornered cells, each piece and layer with points of its own."""

    mesh: Mesh  #: Points in m, z = 0 at the top face of the rod or at the tab's lower end
    station: Ints  #: (n_points,) The station of the centre line that each point moves with
    #: (n_points,) Potential over the voltage across a layer: 1 on the outer electrodes, 0 in the
    #: shim
    potential_share: Floats

    def values(self, line: CentreLine) -> Numbers:
        """(u_x, u_y, u_z, φ) in m and V at the points, (n_points, 4)."""
        w, psi = line.w[self.station], line.psi[self.station]
        x = self.mesh.points[:, 0]
        voltage = self.potential_share * line.voltage
        return np.stack([w, np.zeros_like(w), x * psi, voltage], axis=1)


def row_shape(pieces: Sequence[Piece], device: Device, z: Floats, top: float) -> RowShape:
    """Shape of a row whose centre line has stations at z (n,), its tip at `top` (m)."""
    points, cells, regions, station, share = [], [], [], [], []
    names: list[str] = []
    low, count, offset = 0.0, 0, top - float(z[-1])
    tolerance = 1e-9 * float(z[-1])
    for piece in pieces:
        if piece.section == "bond":
            continue
        high = low + piece.length
        inside = np.flatnonzero((z > low - tolerance) & (z < high + tolerance))
        # where a joint is, the upper of its two stations begins a piece, the lower one ends it
        below, above = (np.abs(z[inside] - end) < tolerance for end in (low, high))
        inside = inside[below.sum() - 1 : inside.size - above.sum() + 1]
        for name, plan, through in _sections(piece, device, (z[inside] - low) / piece.length):
            if name not in names:
                names.append(name)
            n_z, n_x, n_y, _ = plan.shape
            heights = np.broadcast_to((z[inside] + offset)[:, None, None, None], (n_z, n_x, n_y, 1))
            points.append(np.concatenate([plan, heights], axis=-1).reshape(-1, 3))
            cells.append(count + block_cells(n_z, n_x, n_y))
            regions.append(np.full(len(cells[-1]), names.index(name)))
            station.append(np.repeat(inside, n_x * n_y))
            active = through if piece.electrode else 0.0 * through
            share.append(np.broadcast_to(active[None, :, None], (n_z, n_x, n_y)).ravel())
            count += n_z * n_x * n_y
        low = high
    mesh = Mesh(
        points=np.concatenate(points),
        cells=np.concatenate(cells),
        kind="hexahedron",
        region_of_cell=np.concatenate(regions).astype(np.int64),
        regions=tuple(names),
        faces={},
    )
    return RowShape(mesh, np.concatenate(station), np.concatenate(share))


def _sections(piece: Piece, device: Device, shares: Floats) -> list[tuple[str, Floats, Floats]]:
    """Each region's name, (x, y) at stations (n_z, n_x, n_y, 2) and φ/U over x (n_x,)."""
    if piece.section == "cylinder":
        return [("rod", np.repeat(_disc(piece.radius)[None], shares.size, 0), np.zeros(_ROUND))]
    width = np.asarray(piece.layers(device.bimorph, shares).width)
    half = np.broadcast_to(0.5 * width, shares.shape)
    found = []
    for layer in stack(piece, device, shares):
        low, high = (np.broadcast_to(face, shares.shape) for face in (layer.low, layer.high))
        x, y = np.stack([low, high], axis=1), layer.share * np.stack([-half, half], axis=1)
        plan = np.stack(np.broadcast_arrays(x[:, :, None], y[:, None, :]), axis=-1)
        at = np.array([layer.hot < 0.0, layer.hot > 0.0], dtype=float)
        at = np.full(2, at.mean()) if layer.uniform else at  # fingers at 0 V and at the voltage
        found.append((layer.region, plan, at))
    return found


def _disc(radius: float) -> Floats:
    """Square grid (n, n, 2) drawn out to a disc, its rim on the circle."""
    side = np.linspace(-1.0, 1.0, _ROUND)
    x, y = np.meshgrid(side, side, indexing="ij")
    across = np.stack([x * np.sqrt(1.0 - 0.5 * y**2), y * np.sqrt(1.0 - 0.5 * x**2)], axis=-1)
    return np.asarray(radius * across)


def block_cells(n_z: int, n_x: int, n_y: int) -> Ints:
    """Cells of a block of points, y fastest, in VTK order."""
    k, i, j = (
        a.ravel() for a in np.meshgrid(*(np.arange(n - 1) for n in (n_z, n_x, n_y)), indexing="ij")
    )

    def at(dz: int, dx: int, dy: int) -> Ints:
        return np.asarray(((k + dz) * n_x + i + dx) * n_y + j + dy)

    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    return np.stack([at(dz, dx, dy) for dz in (0, 1) for dx, dy in around], axis=1)
