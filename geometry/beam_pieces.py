"""The generator seen as a row of prismatic pieces, from its held end to its tip.

What every one-dimensional model starts from.  Only lengths and cross-sections are
stated here; each model computes its own section constants from them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from geometry.parameters import NOMINAL_GAP, Device, Support


@dataclass(frozen=True)
class Piece:
    """A prismatic stretch of the generator.

    Attributes
    ----------
    section : {"bimorph", "shim", "cylinder"}
        Cross-section: the three layers, the bare shim, or solid rod steel.
    length : float
        Axial length (m).
    radius : float
        Radius of a cylinder (m), 0 otherwise.
    """

    section: Literal["bimorph", "shim", "cylinder"]
    length: float
    radius: float = 0.0


def beam_pieces(device: Device, support: Support) -> tuple[Piece, ...]:
    """Return the pieces from the held end to the tip.

    With ``support.kind = "rod"`` the rod is a stepped beam held at its lower face and the
    tab is clamped where it leaves the head (the glue is taken as rigid); otherwise the row
    starts at the tab's lower end, or at the ceramic where there is no tab.
    """
    bimorph = device.bimorph
    on_rod = support.kind == "rod"
    pieces = list(_rod_pieces(device)) if on_rod else []
    tab = device.ceramic_base if on_rod else bimorph.tab_length
    if tab > 0.0:
        pieces.append(Piece("shim", tab))
    pieces.append(Piece("bimorph", bimorph.length))
    return tuple(pieces)


def _rod_pieces(device: Device) -> tuple[Piece, ...]:
    rod = device.rod
    pieces = (
        Piece("cylinder", rod.length - rod.flange_position - rod.flange_thickness, rod.radius),
        Piece("cylinder", rod.flange_thickness, rod.flange_radius),
        Piece("cylinder", rod.flange_position + NOMINAL_GAP, rod.radius),
        Piece("cylinder", rod.head_thickness, rod.head_radius),
    )
    return tuple(piece for piece in pieces if piece.length > 1e-12)
