"""What a bridge follows, by the transfer-matrix model with any constants of the section."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.bimorph.pieces import Piece, beam_pieces
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.section.section import Section, without_electrode
from tactgen.tmm.beam.transfer import transfer_matrix
from tactgen.tmm.beam.transfer.scattering import Element
from tactgen.tmm.ports.multiport import Multiport, respond
from tactgen.tmm.ports.terminations import attach
from tactgen.validation.models.bimorph.bridge.rung import Values
from tactgen.validation.scene.scene import Scene


def beam_row(scene: Scene, active: Section | None = None) -> list[Element]:
    """Return the scene's row of beams; `active` replaces the section under the electrodes.

    Where the ceramic has none, the same section follows without charge.
    """
    row: list[Element] = []
    for piece in beam_pieces(scene.device, scene.support):
        if active is not None and piece.section == "bimorph":
            row.append((active if piece.electrode else without_electrode(active), piece.length))
        else:
            row += transfer_matrix.elements(
                piece, scene.device, scene.beam, lossy=False, segments=transfer_matrix.SEGMENTS
            )
    return row


def beam_values(scene: Scene, active: Section | None = None) -> Values:
    """Return the beam model's values on the scene's support."""
    return values_of_row(scene, beam_row(scene, active))


def values_of_row(scene: Scene, row: list[Element]) -> Values:
    """Return the values of a row of beams on the scene's support, under its load."""
    port = transfer_matrix.chain(row, np.zeros(1))
    first = bending_frequencies(row, scene.ends, 1, open_circuit=False)[0]
    return static_values(scene, port, float(first))


def static_values(scene: Scene, static: Multiport, first_frequency: float) -> Values:
    """Return a first frequency (Hz) with what D(0) says on the scene's support, under its load."""
    response = respond(attach(static, scene.ends.lossless), {"voltage": 1.0})
    moved, charge = response.motion["w_tip"][0], response.effort["voltage"][0]
    return Values(float(moved.real), first_frequency, float(charge.real))


def bimorph_piece(scene: Scene) -> Piece:
    """Return the electroded piece of the ceramic."""
    pieces = beam_pieces(scene.device, scene.support)
    return next(p for p in pieces if p.section == "bimorph" and p.electrode)
