"""The semi-analytical model: exact beams in a row, and their ports.

The paper's Transfer Matrix Method, its pieces joined in wave variables
(:mod:`tmm.beam.scattering`); :mod:`tmm.beam.printed_formulas` gives the printed matrix A,
which is one change of variables away.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import Piece, beam_pieces, measured_pieces
from tactgen.geometry.device.materials import lossy_modulus
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.scattering import Element, joined
from tactgen.tmm.beam.sections import Constant, Joint, Section, section, segmented
from tactgen.tmm.beam.span import dynamic_stiffness
from tactgen.tmm.ports.multiport import BIMORPH, Multiport, measured_between

#: Gives the section of a piece, such as :func:`tmm.beam.sections.section`.
SectionOf: TypeAlias = Callable[..., Section]


def bonded_tab(piece: Piece, device: Device, beam: Beam, *, lossy: bool = False) -> Joint:
    """Joint of a piece of section ``bond`` at the slot.

    Analytic in all parameters, which may be arrays (n,); `lossy` switches the losses of glue
    and tab on.
    """
    glue, tab = device.glue, device.bimorph
    b, h, t = tab.width, tab.shim_thickness, glue.thickness
    modulus = lossy_modulus(glue.youngs_modulus, glue.loss_factor, lossy=lossy)
    shear = modulus / (2.0 * (1.0 + glue.poisson_ratio))
    nu = glue.poisson_ratio
    squeezed = modulus * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
    lateral = 2.0 * (squeezed * b + shear * h) / t
    rotational = 2.0 * shear * (b * h**2 / 4.0 + h**3 / 12.0) / t
    shim = section(Piece("shim", piece.length), device, beam, lossy=lossy)
    # complex: roots of negative numbers are meant
    founded = dynamic_stiffness(
        replace(shim, m=-lateral + 0j, rhoI=-rotational + 0j), piece.length, np.ones(())
    )
    low, across, high = founded[..., :2, :2], founded[..., :2, 2:4], founded[..., 2:4, 2:4]
    end = _diagonal(shear * b * h / t, squeezed * b * h**3 / (12.0 * t))
    stiffness = high - np.swapaxes(across, -1, -2) @ np.linalg.solve(low + end, across)
    compliance = np.linalg.inv(stiffness)
    given = (lateral, rotational, shim.EI, shim.GA, piece.length)
    return Joint(compliance if any(np.iscomplexobj(v) for v in given) else compliance.real)


def _diagonal(first: Constant, second: Constant) -> Constant:
    """Diagonal matrices (..., 2, 2)."""
    return np.stack(np.broadcast_arrays(first, second), axis=-1)[..., None] * np.eye(2)


#: Lengths whose sums differ by no more, relative, are equal.
_ROUNDING = 1e-12
#: Segments of a tapered piece.
SEGMENTS = 32


def sections(
    device: Device,
    support: Support,
    beam: Beam,
    *,
    lossy: bool,
    segments: int = SEGMENTS,
    measured: bool = False,
    section_of: SectionOf = section,
) -> list[Element]:
    """(section or joint, length) of every element from base to tip.

    A tapered piece is divided into `segments`; the error of every result falls with the
    fourth power of their number.  What is read inside a segment is worse, so where something is
    `measured` a piece ends.
    """
    return [
        element
        for piece in (measured_pieces if measured else beam_pieces)(device, support)
        for element in elements(
            piece, device, beam, lossy=lossy, segments=segments, section_of=section_of
        )
    ]


def is_tapered(device: Device, support: Support) -> bool:
    """Whether some piece is tapered, so that the number of segments matters."""
    return any(piece.tapered for piece in beam_pieces(device, support))


def elements(
    piece: Piece,
    device: Device,
    beam: Beam,
    *,
    lossy: bool,
    segments: int,
    section_of: SectionOf = section,
) -> list[Element]:
    """Elements of one piece: a joint, a prismatic beam or the segments of a taper.

    `section_of` gives the section of a piece, in bending along x unless said otherwise.
    """
    if piece.section == "bond":
        return [(bonded_tab(piece, device, beam, lossy=lossy), 0.0)]
    if piece.tapered:

        def along(share: float) -> Section:
            return section_of(piece, device, beam, lossy=lossy, share=share)

        return [*segmented(along, piece.length, segments)]
    return [(section_of(piece, device, beam, lossy=lossy), piece.length)]


def chain(
    row: Sequence[Element], frequencies: Floats, below_tip: float = 0.0, omega: Floats | None = None
) -> Multiport:
    """Multiport of elements joined end to end.

    Parameters
    ----------
    below_tip : float
        Distance from the tip (m) of the place of measurement, a port if this is not 0.
    omega : (n,) array, optional
        Angular frequencies (rad/s) at which the elements are taken, if not those of `frequencies`.
    """
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    at = 2.0 * np.pi * f if omega is None else omega
    parts = [Multiport(f, joined(part, at), BIMORPH) for part in divided(row, below_tip)]
    return measured_between(*parts) if len(parts) == 2 else parts[0]


def divided(row: Sequence[Element], below_tip: float) -> list[list[Element]]:
    """Row below and above a distance from the tip (m); the whole row if that is 0.

    Raises InputError if the row's lengths are arrays, and the distance does not end in the same
    element for all of them.
    """
    if not below_tip:
        return [list(row)]
    rest: Any = below_tip
    rounding = _ROUNDING * below_tip
    for k in range(len(row) - 1, -1, -1):
        element, length = row[k]
        if np.all(length > rest + rounding):
            return [[*row[:k], (element, length - rest)], [(element, rest), *row[k + 1 :]]]
        if np.any(length > rest + rounding):
            break
        rest = rest - length
        if np.all(np.abs(rest) <= rounding):
            return [list(row[:k]), list(row[k:])]
    raise InputError(
        f"measurement.below_tip = {below_tip * 1e3:g} mm ends in another part of the bimorph where "
        "its lengths vary; measure less far below the tip"
    )


def multiport(
    device: Device,
    support: Support,
    beam: Beam,
    frequencies: Floats,
    *,
    lossy: bool = True,
    segments: int = SEGMENTS,
) -> Multiport:
    """Transfer-matrix model of the device over its ports (parallel wiring)."""
    row = sections(device, support, beam, lossy=lossy, segments=segments, measured=True)
    return chain(row, frequencies, device.measurement.below_tip)
