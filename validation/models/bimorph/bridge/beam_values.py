"""What a bridge follows, by the transfer-matrix model with any constants of the section."""

from __future__ import annotations

import numpy as np

from geometry.bimorph.pieces import Piece, beam_pieces
from tmm.beam.modes import Fixture, bending_frequencies
from tmm.beam.section.section import Section, without_electrode
from tmm.beam.transfer import transfer_matrix
from tmm.beam.transfer.scattering import Element
from tmm.ports.multiport import respond
from tmm.ports.terminations import conservative_load, static_termination
from validation.models.bimorph.bridge.rung import Values
from validation.scene.scene import Scene


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
    response = respond(port, static_termination(scene.support, scene.load), 1.0)
    tip = conservative_load(scene.load)
    base = base_springs(scene)
    fixture = Fixture(base is None, *(base or (0.0, 0.0, 0.0)), *tip)
    first = bending_frequencies(row, fixture, 1, open_circuit=False)[0]
    return Values(
        float(response.w_tip[0].real), float(first), float(response.charge[0].real)
    )  # fmt: skip


def base_springs(scene: Scene) -> tuple[float, float, float] | None:
    """Return lateral and rotational stiffness and inertia of the support, None for a clamp."""
    support = scene.support
    if support.kind != "spring":
        return None
    return support.lateral_stiffness, support.rotational_stiffness, support.rotational_inertia


def bimorph_piece(scene: Scene) -> Piece:
    """Return the electroded piece of the ceramic."""
    pieces = beam_pieces(scene.device, scene.support)
    return next(p for p in pieces if p.section == "bimorph" and p.electrode)
