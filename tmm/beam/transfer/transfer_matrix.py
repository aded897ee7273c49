"""The semi-analytical model: exact beams in a row, and their ports.

The paper's Transfer Matrix Method, its pieces joined in wave variables
(:mod:`tmm.beam.transfer.scattering`); :mod:`tmm.beam.printed_formulas` gives the printed matrix A,
which is one change of variables away.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.pieces import Piece, beam_pieces
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam.section.section import Section, section
from tactgen.tmm.beam.section.tapered import segmented
from tactgen.tmm.beam.transfer.bonded_tab import bonded_tab
from tactgen.tmm.beam.transfer.scattering import Element, joined
from tactgen.tmm.ports.multiport import Multiport
from tactgen.tmm.ports.port import BIMORPH

#: Segments of a tapered piece.
SEGMENTS = 32


def sections(
    device: Device, support: Support, beam: Beam, *, lossy: bool, segments: int = SEGMENTS
) -> list[Element]:
    """Return (section or joint, length) of every element from base to tip.

    A tapered piece is divided into `segments`; the error of every result falls with the
    fourth power of their number.
    """
    return [
        element
        for piece in beam_pieces(device, support)
        for element in elements(piece, device, beam, lossy=lossy, segments=segments)
    ]


def is_tapered(device: Device, support: Support) -> bool:
    """Return whether some piece is tapered, so that the number of segments matters."""
    return any(piece.tapered for piece in beam_pieces(device, support))


def elements(
    piece: Piece, device: Device, beam: Beam, *, lossy: bool, segments: int
) -> list[Element]:
    """Return what one piece consists of: a joint, a prismatic beam or the segments of a taper."""
    if piece.section == "bond":
        return [(bonded_tab(piece, device, beam, lossy=lossy), 0.0)]
    if piece.tapered:
        along = partial(_section_at, piece, device, beam, lossy)
        return [*segmented(along, piece.length, segments)]
    return [(section(piece, device, beam, lossy=lossy), piece.length)]


def _section_at(piece: Piece, device: Device, beam: Beam, lossy: bool, share: float) -> Section:
    return section(piece, device, beam, lossy=lossy, share=share)


def chain(row: Sequence[Element], frequencies: Floats) -> Multiport:
    """Return the multiport of elements joined end to end."""
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    return Multiport(frequencies, joined(row, 2.0 * np.pi * frequencies), BIMORPH)


def multiport(
    device: Device,
    support: Support,
    beam: Beam,
    frequencies: Floats,
    *,
    lossy: bool = True,
    segments: int = SEGMENTS,
) -> Multiport:
    """Return the transfer-matrix model of the device over its five ports (parallel wiring)."""
    return chain(sections(device, support, beam, lossy=lossy, segments=segments), frequencies)
