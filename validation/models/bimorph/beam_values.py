"""What a bridge follows, by the transfer-matrix model with any constants of the section."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tactgen.geometry.bimorph.pieces import Piece, beam_pieces
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Section, without_electrode
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import Multiport, respond
from tactgen.tmm.ports.readout import ELECTRICAL, MECHANICAL
from tactgen.validation.catalogue.bimorph import coupling_factor
from tactgen.validation.scene.scene import Scene


class Values(NamedTuple):
    """What a bridge follows.

    Attributes
    ----------
    deflection : float
        Static tip displacement per volt (m).
    first_frequency, open_frequency : float
        Of the first bending mode in x (Hz), at U = 0 and at Q = 0.
    capacitance, blocked_capacitance : float
        Static, with a free tip, and with base and tip held (F).
    coupling : float
        sqrt(1 - (first / open)²).
    """

    deflection: float
    first_frequency: float
    capacitance: float
    open_frequency: float
    coupling: float
    blocked_capacitance: float

    def step_from(self, before: Values) -> Steps:
        """Return the relative changes from another set of values."""
        return Steps(*(float(a / b - 1.0) for a, b in zip(self, before, strict=True)))


class Steps(NamedTuple):
    """Relative changes of :class:`Values`; nan where none is known."""

    deflection: float = np.nan
    first_frequency: float = np.nan
    capacitance: float = np.nan
    open_frequency: float = np.nan
    coupling: float = np.nan
    blocked_capacitance: float = np.nan


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
    short, opened = (
        float(bending_frequencies(row, scene.ends, 1, open_circuit=circuit)[0])
        for circuit in (False, True)
    )
    return values_from(scene, port, short, opened)


def values_from(scene: Scene, static: Multiport, short: float, opened: float) -> Values:
    """Return what D(0) says on the scene's support, under its load, with its first frequencies.

    `short` and `opened` are those of the first bending mode in x (Hz).
    """
    port = attach(static, scene.ends.lossless)
    free = respond(port, {ELECTRICAL: 1.0})
    held = {name: 0.0 for name in MECHANICAL if name in port.names}
    blocked = respond(port, {ELECTRICAL: 1.0} | held)
    return Values(
        deflection=float(free.motion["w_tip"][0].real),
        first_frequency=short,
        capacitance=float(free.effort[ELECTRICAL][0].real),
        open_frequency=opened,
        coupling=float(coupling_factor(short, opened)),
        blocked_capacitance=float(blocked.effort[ELECTRICAL][0].real),
    )


def bimorph_piece(scene: Scene) -> Piece:
    """Return the electroded piece of the ceramic."""
    pieces = beam_pieces(scene.device, scene.support)
    return next(p for p in pieces if p.section == "bimorph" and p.electrode)
