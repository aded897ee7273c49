"""The generator seen as a row of pieces, from its held end to its tip.

What every one-dimensional model starts from.  Only lengths and cross-sections are
stated here; each model computes its own section constants from them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

from tactgen.geometry.device.parameters import NOMINAL_GAP, Bimorph, Device, Support

#: Points closer than this share of the ceramic's length are one.
_APART = 1e-9


@dataclass(frozen=True)
class Layers:
    """Width and layer thicknesses of the ceramic's cross-section (m)."""

    width: Any
    piezo_thickness: Any
    shim_thickness: Any


@dataclass(frozen=True)
class Piece:
    """A stretch of the generator.

    Attributes
    ----------
    section : {"bimorph", "shim", "cylinder", "bond"}
        Cross-section: the three layers, the bare shim, solid rod steel, or the tab glued
        into the rod's slot (it lies beside the head and adds nothing to the row's height).
    length : float
        Axial length (m).
    radius : float
        Radius of a cylinder (m), 0 otherwise.
    ends : (Layers, Layers) or None
        Layers at the lower and the upper end, varying linearly between them; None where they
        are the device's own.
    electrode : bool
        Whether the ceramic's outer faces carry electrodes.
    """

    section: Literal["bimorph", "shim", "cylinder", "bond"]
    length: float
    radius: float = 0.0
    ends: tuple[Layers, Layers] | None = None
    electrode: bool = True

    @property
    def tapered(self) -> bool:
        """Whether the cross-section changes along the piece."""
        return self.ends is not None and self.ends[0] != self.ends[1]

    def layers(self, bimorph: Bimorph, share: Any = 0.5) -> Layers:
        """Return the layers at a share (number or array) of the length from the lower end."""
        if self.ends is None:
            return Layers(bimorph.width, bimorph.piezo_thickness, bimorph.shim_thickness)
        low, high = self.ends
        return Layers(
            low.width + share * (high.width - low.width),
            low.piezo_thickness + share * (high.piezo_thickness - low.piezo_thickness),
            low.shim_thickness + share * (high.shim_thickness - low.shim_thickness),
        )


def beam_pieces(device: Device, support: Support) -> tuple[Piece, ...]:
    """Return the pieces from the held end to the tip.

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
    return (*pieces, *_ceramic_pieces(bimorph))


def _ceramic_pieces(bimorph: Bimorph) -> list[Piece]:
    """Cut the ceramic at every point of a profile and at the electrodes' edges."""
    length = bimorph.length
    lower_edge, upper_edge = bimorph.bare_below, length - bimorph.bare_above
    points = [z for profile in bimorph.profiles.values() for z, _ in profile]
    cuts = [0.0]
    for z in sorted([lower_edge, upper_edge, *points, length]):
        if cuts[-1] + _APART * length < z <= length:
            cuts.append(z)
    cuts[-1] = length
    return [
        Piece(
            "bimorph",
            high - low,
            ends=_ends(bimorph, low, high),
            electrode=lower_edge < 0.5 * (low + high) < upper_edge,
        )
        for low, high in pairwise(cuts)
    ]


def _ends(bimorph: Bimorph, low: float, high: float) -> tuple[Layers, Layers] | None:
    if not bimorph.profiles:
        return None
    dimensions = [
        profile.between(low, high) if profile else (uniform, uniform)
        for profile, uniform in (
            (bimorph.width_profile, bimorph.width),
            (bimorph.piezo_thickness_profile, bimorph.piezo_thickness),
            (bimorph.shim_thickness_profile, bimorph.shim_thickness),
        )
    ]
    lower, upper = zip(*dimensions, strict=True)
    return Layers(*lower), Layers(*upper)


def _rod_pieces(device: Device) -> list[Piece]:
    rod = device.rod
    pieces = (
        Piece("cylinder", rod.length - rod.flange_position - rod.flange_thickness, rod.radius),
        Piece("cylinder", rod.flange_thickness, rod.flange_radius),
        Piece("cylinder", rod.flange_position + NOMINAL_GAP, rod.radius),
        Piece("cylinder", rod.head_thickness, rod.head_radius),
    )
    return [piece for piece in pieces if piece.length > 1e-12]
