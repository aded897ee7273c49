"""Stress, field and current of the driven ceramic, along any row of pieces.

From the tip's motion down to the ceramic's lower edge, slice by slice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, TipLoad
from tactgen.geometry.bimorph.segments import Piece, beam_pieces, stack
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam.scattering import Element, element_stiffness
from tactgen.tmm.beam.sections import Joint, Section, ceramic_stresses, section
from tactgen.tmm.beam.span import wavenumbers
from tactgen.tmm.beam.transfer_matrix import elements
from tactgen.tmm.ports.excitation_and_circuit import Excitation
from tactgen.tmm.ports.multiport import Response
from tactgen.tmm.ports.supports_and_loads import tip_matrix

#: Heights at which the stress is looked for, along the ceramic from its root: a mode of order n
#: has its largest curvature within a tenth of a wave of one of them up to n = 5.
_HEIGHTS = 20
#: Where bending waves decay by more than this exponent along the ceramic, its root cannot be told
#: from its tip: e^20 leaves seven of sixteen digits.
_DECAY = 20.0
#: Ω² m l⁴/EI of a part up to which its inertia is that of rest: there both that and its rounding
#: are off by a few 1e-9.
_AT_REST = 2e-6
#: Frequencies at which all heights are worked out at once: some megabytes.
_AT_ONCE = 500


@dataclass(frozen=True)
class DrivenCeramic:
    """Peak amplitudes, (n,) over the frequencies."""

    #: Largest axial stress along the ceramic, at the faces of its layers (Pa); nan where bending
    #: waves die out along the ceramic
    stress: Floats
    field: Floats  #: Largest field in a layer (V/m)
    current: Floats  #: Drawn by one bimorph (A)


def driven_ceramic(
    device: Device,
    beam: Beam,
    ends: Ends,
    frequencies: Floats,
    response: Response,
    excitation: Excitation,
) -> DrivenCeramic:
    """Stress state of the ceramic, from the tip's motion, the voltage and the charge.

    Parameters
    ----------
    frequencies : (n,) float
        Hz.
    response : Response
        Motions `w_tip`, `psi_tip` (m, rad), `voltage` (V) and effort `voltage` (C) of the
        terminated actuator, relative to its base.
    excitation : Excitation
        To which it responds.
    """
    bimorph = device.bimorph
    layer = (0.5 if bimorph.wiring == "series" else 1.0) * response.motion["voltage"]
    tip = np.stack([response.motion["w_tip"], response.motion["psi_tip"]], axis=1)
    effort = -(tip_matrix(ends.tip, frequencies) @ tip[:, :, None])[:, :, 0]
    effort[:, 0] += excitation.force
    if isinstance(ends.tip, TipLoad):
        effort -= excitation.acceleration * ends.tip.mass * np.array(ends.tip.arm)
    return DrivenCeramic(
        stress=_stress(device, beam, frequencies, tip, effort, layer, excitation.acceleration),
        field=np.abs(layer) / bimorph.electrode_distance,
        current=np.abs(2.0 * np.pi * frequencies * response.effort["voltage"]),
    )


def _stress(
    device: Device,
    beam: Beam,
    frequencies: Floats,
    tip: Complex,
    effort: Complex,
    layer: Complex,
    acceleration: float,
) -> Floats:
    """Largest stress over height and faces (n,) in Pa.

    From the tip's motion and what acts on it down, element by element, through whatever lies above
    the ceramic's lower edge.
    """
    row = _down_to_the_ceramic(device, beam)
    omega = 2.0 * np.pi * frequencies
    decay = np.zeros(omega.size)
    for one in row:
        for element, length in one.beams:
            if isinstance(element, Section):
                decay += one.repeats * wavenumbers(element, length, omega)[1]
    known = np.flatnonzero(decay < _DECAY)
    largest = np.full(frequencies.shape, np.nan)
    for first in range(0, known.size, _AT_ONCE):
        at = known[first : first + _AT_ONCE]
        motion, on_top, found, across = tip[at], effort[at], np.zeros(at.size), layer[at]
        for one in row:
            parts = [_loaded(*beam, omega[at], across, acceleration) for beam in one.beams[::-1]]
            for _ in range(one.repeats):
                for part, own in parts:
                    motion, on_top = _below(part, motion, on_top, own)
                for per_curvature, per_volt in one.stresses:
                    curvature = (on_top[:, 1] + one.section.K * across) / one.section.EI
                    found = np.maximum(found, np.abs(per_curvature * curvature + per_volt * across))
        largest[at] = found
    return largest


def _loaded(
    element: Section | Joint, length: float, omega: Floats, across: Complex, acceleration: float
) -> tuple[Complex, Complex]:
    """Dynamic stiffness (n, 5, 5) of a part, and what holds its ends at rest (n, 5)."""
    part = element_stiffness(element, length, omega)
    own = part[..., 4] * across[:, None]
    if acceleration and isinstance(element, Section):
        own[:, :4] -= acceleration * _inertia(element, length, omega)
    return part, own


class _Slice(NamedTuple):
    """A slice of the row above the ceramic's lower edge, or several equal ones."""

    beams: list[Element]  #: From its lower end to its upper one; none at the ceramic's upper end
    section: Section  #: At its lower end
    #: Stress per curvature (Pa m) and per volt (Pa/V) at each face of its ceramics
    stresses: list[tuple[complex, complex]]
    repeats: int = 1  #: How many equal slices lie one below the other


def _down_to_the_ceramic(device: Device, beam: Beam) -> list[_Slice]:
    """Elements from the tip down to the ceramic's lower edge."""
    pieces = list(beam_pieces(device, Support(kind="clamped")))
    while pieces[0].section != "bimorph":
        pieces.pop(0)
    parts: list[_Slice] = []
    for above, piece in pairwise([pieces[-1], *pieces[::-1]]):
        ends_here = piece.without != above.without  # a patch, above which the stress is another
        number = max(1, math.ceil(_HEIGHTS * piece.length / device.bimorph.length))
        if not piece.tapered:
            if ends_here:
                parts.append(_slice_from(piece, device, beam, 1.0, []))
            within = replace(piece, length=piece.length / number)
            beams = elements(within, device, beam, lossy=True, segments=1)
            parts.append(_slice_from(piece, device, beam, 0.0, beams)._replace(repeats=number))
            continue
        shares = np.linspace(0.0, 1.0, number + 1).tolist()
        for low, high in reversed(list(pairwise(shares))):
            ends = (piece.layers(device.bimorph, low), piece.layers(device.bimorph, high))
            length = (high - low) * piece.length
            within = replace(piece, length=length, ends=ends)
            beams = elements(within, device, beam, lossy=True, segments=1)
            # of a taper the upper end counts too; elsewhere it is strained as what is next to it
            if not any(part.stresses for part in parts) or (ends_here and high == 1.0):
                parts.append(_slice_from(piece, device, beam, high, []))
            parts.append(_slice_from(piece, device, beam, low, beams))
    return parts


def _slice_from(
    piece: Piece, device: Device, beam: Beam, share: float, beams: list[Element]
) -> _Slice:
    """Slice whose lower end is at a share of a piece."""
    of = section(piece, device, beam, lossy=True, share=share)
    ceramic = piece.section == "bimorph"
    return _Slice(beams, of, ceramic_stresses(stack(piece, device, share)) if ceramic else [])


def _inertia(element: Section, length: float, omega: Floats) -> Complex:
    """Efforts (n, 4) at the ends of a part per acceleration of the base; nan at 0 Hz.

    As of :func:`tmm.ports.excitation_and_circuit.inertia`, a small difference of large
    stiffnesses; below some frequency it is that of rest within 1e-8.
    """
    slowest = np.sqrt(_AT_REST * abs(element.EI) / element.m) / length**2
    at = np.maximum(np.where(omega > 0.0, omega, np.nan), slowest)
    translation = np.array([1.0, 0.0, 1.0, 0.0])
    held = element_stiffness(element, length, at)[:, :4, :4] @ translation
    return np.asarray(held / at[:, None] ** 2)


def _below(part: Complex, top: Complex, effort: Complex, own: Complex) -> tuple[Complex, Complex]:
    """Motion below a part, and what the part exerts there on what is below it, (n, 2) each.

    From its dynamic stiffness (n, 5, 5), w and ψ (n, 2) at its `top`, force and moment (n, 2) that
    act on it there, and what holds its ends at rest (n, 5), by its voltage and its inertia.
    """
    to_top, to_base = part[..., 2:4, 2:4], part[..., 2:4, 0:2]
    rest = effort - np.einsum("...ij,...j->...i", to_top, top) - own[..., 2:4]
    base = np.linalg.solve(to_base, rest[..., None])[..., 0]
    on_base = np.einsum("...ij,...j->...i", part[..., 0:2, 0:2], base)
    on_base += np.einsum("...ij,...j->...i", part[..., 0:2, 2:4], top) + own[..., 0:2]
    return base, -on_base
