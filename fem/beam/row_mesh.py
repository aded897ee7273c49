"""The line mesh of a row of beams: how many elements each piece has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Ints
from tactgen.geometry.bimorph.pieces import Piece
from tactgen.geometry.device.parameters import Bimorph


def thinnest(piece: Piece, bimorph: Bimorph) -> float:
    """Return the least thickness (m) of a piece in the direction in which it bends."""
    if piece.section == "cylinder":
        return 2.0 * piece.radius
    ends = [piece.layers(bimorph, end) for end in (0.0, 1.0)]
    layers = 2.0 if piece.section == "bimorph" else 0.0
    return float(min(layers * end.piezo_thickness + end.shim_thickness for end in ends))


def row_mesh(
    pieces: Sequence[Piece],
    bimorph: Bimorph,
    elements: int,
    halvings: int = 0,
    shift: float = 0.0,
) -> tuple[Any, Ints, list[tuple[int, float]]]:
    """Return the line mesh from base to tip, the beam of each element, and the joints.

    Bending waves are the shorter the thinner a piece is: their number goes as its length over
    the root of its thickness, and so does its share of the elements.

    `elements` are shared out, rounded up in each piece; then each is halved so many times:
    a mesh and its halved one differ in every piece.  Nodes inside of a piece lie `shift` elements
    higher than evenly.

    A joint is a node, whose successor lies at the same height and which no element connects
    to it, and the depth of the slot (m).
    """
    from skfem import MeshLine

    waves = [piece.length / math.sqrt(thinnest(piece, bimorph)) for piece in pieces]
    total = sum(n for n, piece in zip(waves, pieces, strict=True) if piece.section != "bond")
    nodes, cells, piece_of, joints = [0.0], [], [], []
    beams = 0
    for piece, share in zip(pieces, waves, strict=True):
        last = len(nodes) - 1
        if piece.section == "bond":
            joints.append((last, piece.length))
            nodes.append(nodes[-1])
            continue
        count = math.ceil(elements * share / total) * 2**halvings
        inside = piece.length * (np.arange(1, count) + shift) / count
        nodes += [*(nodes[-1] + inside), nodes[-1] + piece.length]
        cells += [(last + i, last + i + 1) for i in range(count)]
        piece_of += count * [beams]
        beams += 1
    mesh = MeshLine(np.array([nodes]), np.array(cells).T, sort_t=False)
    return mesh, np.array(piece_of), joints
