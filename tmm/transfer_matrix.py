"""The semi-analytical model: exact pieces in a row, and their lossless modes.

The paper's Transfer Matrix Method in displacement form; :mod:`tmm.appendix_a` gives the
printed matrix A, which is one change of variables away.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import numpy as np

from geometry.arrays import Floats
from geometry.beam_pieces import beam_pieces
from geometry.parameters import Beam, Device, Support
from tmm.multiport import Multiport, cascade
from tmm.section import Section, section
from tmm.timoshenko import dynamic_stiffness


def sections(
    device: Device, support: Support, beam: Beam, *, lossy: bool
) -> list[tuple[Section, float]]:
    """Return (section, length) of every piece from base to tip."""
    return [
        (section(piece, device, beam, lossy=lossy), piece.length)
        for piece in beam_pieces(device, support)
    ]


def chain(pieces: Sequence[tuple[Section, float]], frequencies: Floats) -> Multiport:
    """Return the multiport of beams joined end to end."""
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    omega = 2.0 * np.pi * frequencies
    blocks = (dynamic_stiffness(piece, length, omega) for piece, length in pieces)
    return Multiport(frequencies, reduce(cascade, blocks))


def multiport(
    device: Device, support: Support, beam: Beam, frequencies: Floats, *, lossy: bool = True
) -> Multiport:
    """Return the transfer-matrix model of the device over its five ports (parallel wiring)."""
    return chain(sections(device, support, beam, lossy=lossy), frequencies)
