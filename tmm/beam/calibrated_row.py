"""Row of beams with calibrated sections, softer at its clamp and at the ends of layers.

Losses follow from the moduli that a section depends on, by small steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import Piece, beam_pieces, listed_at, material_of
from tactgen.geometry.device.laminate import Laminate, Layer
from tactgen.geometry.device.parameters import Beam, Device, Glue, Piezo, Shim, Support
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.calibrated_section import SectionFactors, section_factors
from tactgen.tmm.beam.dimensionless_groups import free_capacitance, plain
from tactgen.tmm.beam.layerwise_steps import Step, layer_steps
from tactgen.tmm.beam.modes import natural_frequencies
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Section, without_electrode
from tactgen.tmm.ports.multiport import Multiport

#: Largest relative error of a loss factor.
_LOST = 3.0
#: Thicknesses of the bimorph, at most half a piece, over which what a step adds is spread: shear
#: lag dies out within about one.
_NEAR_STEP = 2.0
#: Coupling factor squared of a section at most.
_MOST_COUPLED = 0.9
#: Share of a length which is none.
_ROUNDING = 1e-9
#: Relative change of the moduli, per loss factor of each, from whose effect losses are read off;
#: what must not gain by it.  The layerwise ratios of frequencies have no losses.
_STEP, _PASSIVE = 0.01, ("EI", "GA")


def sections(
    device: Device,
    support: Support,
    beam: Beam,
    factors: SectionFactors,
    *,
    lossy: bool,
    segments: int = transfer_matrix.SEGMENTS,
) -> list[Element]:
    """Row of calibrated beams from base to tip, see :func:`tmm.beam.transfer_matrix.sections`."""
    steps = layer_steps(device, beam_pieces(device, support))
    asked = support, beam, segments, steps
    row = _row(device, factors, *asked)
    if not lossy:
        return row
    stiffer, softer = (
        _row(one, _over(section_factors(one, beam), factors.root_length), *asked)
        for one in (_stiffened(device, step) for step in (_STEP, -_STEP))
    )
    return [_with_losses(*three) for three in zip(row, stiffer, softer, strict=True)]


def _over(factors: SectionFactors, root_length: float) -> SectionFactors:
    """Factors of a zone at the clamp of another length, in which it turns as much in all."""
    share = factors.root_length / root_length
    return replace(
        factors,
        root=1.0 + share * (factors.root - 1.0),
        root_coupling=1.0 + share * (factors.root_coupling - 1.0),
        root_length=root_length,
    )


def _row(
    device: Device, factors: SectionFactors, support: Support, beam: Beam, segments: int,
    steps: Sequence[Step | None],
) -> list[Element]:  # fmt: skip
    """Row of calibrated beams without losses."""
    left = factors.root_length
    rows: list[list[Element]] = []
    for piece in beam_pieces(device, support):
        own, found = factors, list[Element]()
        if piece.section != "bimorph" or piece.without:
            own = _over(section_factors(_part(device, piece), beam), factors.root_length)
        parts = transfer_matrix.elements(
            replace(piece, electrode=True), device, beam, lossy=False, segments=segments
        )
        for element, length in parts:
            assert isinstance(element, Section)
            near = min(left, length)
            left -= near
            for active, of in (
                (_corrected(element, own, at_root=True), near),
                (_corrected(element, own, at_root=False), length - near),
            ):
                if of > 0.0:
                    found.append((active if piece.electrode else without_electrode(active), of))
        rows.append(found)
    near = _NEAR_STEP * device.bimorph.thickness
    for number, step in enumerate(steps):
        if step:
            _add_step(rows, number, step, near)
    return list(chain(*rows))


def _add_step(rows: list[list[Element]], below: int, step: Step, near: float) -> None:
    """Let beams turn by what the step above piece `below` adds, within `near` (m) of their ends."""
    for piece, softer, further in (
        (step.softer, step.by_moment, 0.0), (step.driven, 0.0, step.by_voltage),
    ):  # fmt: skip
        row = rows[piece]
        reach = min(near, 0.5 * sum(length for _, length in row))
        order = 1 if piece > below else -1  # from the step on
        changed, left = list[Element](), reach
        for element, length in row[::order]:
            inside = min(left, length)
            left -= inside
            assert isinstance(element, Section)
            zone = _turning(element, 1.0 + softer / reach, 1.0 + further / reach)
            both = (zone, inside), (element, length - inside)
            changed += [(of, l) for of, l in both if l > _ROUNDING * reach]
        row[:] = changed[::order]


def _turning(own: Section, flexible: float, follows: float) -> Section:
    """Section that bends more by these factors, per moment and per voltage; not freer of charge.

    Its coupling stays below 1.
    """
    stiffness, free = own.EI / flexible, free_capacitance(own) if own.C else 0.0
    most = np.sqrt(_MOST_COUPLED * free * stiffness)
    coupling = min(max(own.K * follows / flexible, -most), most)
    return replace(own, EI=stiffness, K=coupling, C=free - coupling**2 / stiffness)


def _part(device: Device, piece: Piece) -> Device:
    """Bimorph that has all along the layers of a piece, and no others."""
    own = plain(device).bimorph
    layers = Laminate((Layer("shim", own.shim_thickness),))
    if listed := own.layers:
        layers = Laminate(
            listed[n]._replace(hot=0 if listed[n].pitch else listed.hot(n), start=0.0, end=0.0)
            for n in listed_at(piece, listed)
        )
    return device.model_copy(update={"bimorph": own.model_copy(update={"layers": layers})})


def loss_error(row: Sequence[Element], factors: SectionFactors) -> float:
    """Relative error of the loss factor in motion of a row with losses.

    Beside that of one section: the error of the compliance, if the energy that it stands for were
    in the piece whose loss factor is the farthest from the mean.  Energy is as under a force on
    the tip.
    """
    stored, lost, factor = 0.0, 0.0, []
    above = sum(length for _, length in row)
    for element, length in row:
        assert isinstance(element, Section)
        flexible, above = (above**3 - (above - length) ** 3) / element.EI, above - length
        stored, lost = stored + flexible.real, lost - flexible.imag
        factor.append(-flexible.imag / flexible.real)
    mean = lost / stored
    apart = max(abs(of / mean - 1.0) for of in factor) if mean else 0.0
    return min(factors.damping_error + float(factors.errors[0]) * apart, _LOST)


def _stiffened(device: Device, step: float) -> Device:
    """Device whose moduli have changed by a step times their loss factors.

    With j in place of the step they have their losses; to the first order in these, any constant
    that depends on them then has losses by its derivative.
    """
    layers = (
        layer._replace(of=_changed(material_of(device, layer), step))
        for layer in device.bimorph.layers
    )
    own = {name: _changed(getattr(device, name), step) for name in ("piezo", "shim", "glue")}
    bimorph = device.bimorph.model_copy(update={"layers": Laminate(layers)})
    return device.model_copy(update=own | {"bimorph": bimorph})


def _changed(of: Piezo | Shim | Glue, step: float) -> Piezo | Shim | Glue:
    if isinstance(of, Piezo):
        stiffer = 1.0 + step / of.quality_factor
        less, weaker = 1.0 - step * of.loss_tangent, 1.0 - step * of.coupling_loss
        return of.model_copy(update={
            "s11": of.s11 / stiffer, "s55": of.s55 / stiffer, "eps33": of.eps33 * less,
            "d31": of.d31 * weaker,
        })  # fmt: skip
    stiffer = 1.0 + step * of.loss_factor
    moduli = {name: value for name, value in of if name.endswith("_modulus") and value}
    return of.model_copy(update={name: stiffer * value for name, value in moduli.items()})


def _with_losses(entry: Element, stiffer: Element, softer: Element) -> Element:
    """Element with its losses, from two whose moduli have changed."""
    (own, length), more, less = entry, stiffer[0], softer[0]
    assert isinstance(own, Section)
    found = {}
    for name in ("EI", "GA", "K", "C"):
        value, up, down = (getattr(one, name) for one in (own, more, less))
        # a coupling that is 0 but for rounding has none
        loss = 0.5 * np.log(up / down) / _STEP if up * down > 0.0 else 0.0
        # next to the clamp a soft core may turn a loss into a gain, which no material has
        found[name] = value * (1.0 + 1j * (max(loss, 0.0) if name in _PASSIVE else loss))
    return replace(own, **found), length


def _corrected(own: Section, factors: SectionFactors, *, at_root: bool) -> Section:
    """Section of beam theory with the calibrated factors on it."""
    stiffness, coupling = own.EI * factors.stiffness, own.K * factors.coupling
    free = free_capacitance(own) * factors.capacitance
    plain = replace(
        own, EI=stiffness, GA=own.GA * factors.shear, K=coupling, C=free - coupling**2 / stiffness
    )
    return _turning(plain, factors.root, factors.root_coupling) if at_root else plain


def with_inertia(entry: Element, factor: float) -> Element:
    """Element with its inertia times a factor."""
    element, length = entry
    if not isinstance(element, Section):
        return entry
    return replace(element, m=element.m * factor, rhoI=element.rhoI * factor), length


def multiport(
    row: Sequence[Element], factors: SectionFactors, frequencies: Floats, below_tip: float = 0.0
) -> Multiport:
    """Calibrated row over its ports (parallel wiring), see :mod:`tmm.beam.transfer_matrix`."""
    at = np.atleast_1d(np.asarray(frequencies, dtype=float))
    omega = 2.0 * np.pi * factors.of_beam(at)
    return transfer_matrix.chain(row, at, below_tip, omega)


def bending_frequencies(
    row: Sequence[Element], factors: SectionFactors, ends: Ends, count: int, *, open_circuit: bool
) -> Floats:
    """Lowest `count` natural frequencies (Hz) of a lossless calibrated row."""
    return natural_frequencies(
        row, ends, count, open_circuit=open_circuit, of_row=factors.of_beam
    ).frequencies
