"""Transfer matrices with section constants calibrated on the solid.

The section is that of :mod:`tmm.beam.cross_section`, with what the shear of a soft core changes by
:mod:`tmm.beam.layerwise` and what a clamp does to a wide one by :mod:`tmm.beam.plate`.  What these
lack depends on :mod:`tmm.beam.dimensionless_groups` only and was fitted to solids of random
bimorphs, clamped in all layers (:mod:`validation.evidence.calibration`):

* six factors: on bending stiffness, shear compliance, coupling and free capacitance of the section,
  and on flexibility and coupling next to the clamp, where the width cannot contract;
* three ratios of frequencies, through which bending across the width and the shear of a soft core
  make short waves stiffer or softer than any beam.

Each comes with the error that was left on devices which the fit had not seen.  Since the factors
are those of the section, every support, load and circuit has them.

The coefficients come from finite elements: this model is no witness of its own.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.segments import (
    Piece,
    beam_pieces,
    bimorph_stack,
    listed_at,
    material_of,
    stack,
)
from tactgen.geometry.device.laminate import Laminate, Layer
from tactgen.geometry.device.parameters import Beam, Device, Glue, Piezo, Shim, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.cross_section import sheet_of
from tactgen.tmm.beam.dimensionless_groups import (
    COUPLING,
    GROUPS,
    ceramics,
    clamp_sizes,
    core_shear,
    free_capacitance,
    group_names,
    groups,
    interior,
    lever,
    plain,
    root_length,
)
from tactgen.tmm.beam.layerwise import layerwise_change
from tactgen.tmm.beam.modes import natural_frequencies
from tactgen.tmm.beam.plate import plate_change
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Section, section, without_electrode
from tactgen.tmm.chebyshev import Products
from tactgen.tmm.ports.multiport import Multiport

#: Coefficients, their ranges and their errors, as ``tactgen calibrate`` writes them: of the bimorph
#: of piezo, shim and piezo, and of listed layers.
FILE, LISTED_FILE = (Path(__file__).with_name(f"calibration{of}.json") for of in ("", "_laminate"))
#: Up to how many times a natural frequency the error is that of this mode.  The next one is at 1.6
#: times, of a wide plate the first across at 2.8.
_ALIKE = 1.25
#: Times the most of the fit up to which its widened errors hold.
_COUPLES_MORE = 1.15
#: Least lever of the ceramics, see :func:`lever`: below it their motion is a small difference.
_LEVER = 0.05
#: Share of a range by which its rounded ends may be off.
_ROUNDED = 1e-3
#: Number of :func:`step_sizes`.
STEP_SIZES = 7
#: Share of the length below which a driven part begins at the clamp.
_CLOSE = 0.02
#: What the six factors act on, in order; see :class:`SectionFactors`.
FACTORS = ("stiffness", "root", "shear", "coupling", "root_coupling", "capacitance")
#: What an error is known of, in order: the tip's displacement per force and per voltage, the free
#: capacitance, natural frequencies of bending in x, and the coupling factor of the first mode.
ERRORS = ("compliance", "deflection", "capacitance", "f1", "f2", "f3", "coupling_factor")
#: Relative change of the moduli, per loss factor of each, from whose effect losses are read off;
#: what must not gain by it.  The layerwise ratios of frequencies have no losses.
_STEP, _PASSIVE = 0.01, ("EI", "GA")
#: Relative error of the loss factor in motion: of any bimorph, per width over length, per core
#: shear E_p t_p (t_s + t_p) / (G_s L²), and at most.  Not fitted: chosen on the heights of the
#: first resonance of 320 random bimorphs, half of them with losses in the core.
DAMPING, _PER_WIDTH, _PER_CORE, _LOST = 0.004, 0.02, 0.6, 3.0
#: Least length over thickness, and largest width over length, of the bimorphs of the fit.
STOUTEST, BROADEST = 4.0, 1.5
#: Width over length from which on each of the first modes may be one across the width.
WIDEST = (np.inf, 0.9, 0.54, 0.385, 0.3)
#: Errors of the fourth and the fifth mode per error of the third: 97 % of 76 random bimorphs that
#: were not fitted to were within 1.14 and 1.92 of it.
_HIGHER = (1.2, 2.0)


@dataclass(frozen=True)
class SectionFactors:
    """Calibrated bimorph relative to beam theory, by factors; lengths in m, frequencies in Hz."""

    stiffness: float  #: On EI
    shear: float  #: On GA
    coupling: float  #: On K
    capacitance: float  #: On C + K²/EI, the capacitance that bends freely
    #: On 1/EI and K/EI in the zone next to the clamp, and its length
    root: float
    root_coupling: float
    root_length: float
    #: Frequencies (5,) at which the beam's own frequency is known, and the ratio (5,) of that
    #: to the solid's
    knots: Floats
    ratios: Floats
    errors: Floats  #: (7,) Relative errors of :data:`ERRORS`
    #: How many of the first five modes surely bend along the length, none across the width
    lengthwise: int
    damping_error: float  #: Relative error of the loss factor of one section, see :data:`DAMPING`
    beyond: tuple[str, ...]  #: Groups outside the range of the fit, which their limit stands for

    def of_beam(self, frequency: Floats) -> Floats:
        """Frequencies at which the beam moves as the solid does at these."""
        ratios = np.interp(frequency, np.append(0.0, self.knots), np.append(1.0, self.ratios))
        return np.asarray(frequency * ratios)

    def frequency_error(self, frequency: Floats) -> Floats:
        """Relative errors (n,) of frequencies: of the first mode, then between the modes'.

        nan well above the last mode whose error is known.
        """
        known = self.mode_error(self.lengthwise)
        last = self.knots[self.lengthwise - 1]
        knots = np.append(self.knots[: self.lengthwise], _ALIKE * last)
        found = np.interp(frequency, knots, np.append(known, known[-1]), right=np.nan)
        return np.asarray(found)

    def mode_error(self, count: int) -> Floats:
        """Relative errors (n,) of the first natural frequencies, nan where they are not known.

        Those are modes beyond the fifth, and of a wide plate those above its first mode across.
        """
        known = np.full(max(count, len(WIDEST)), np.nan)
        third = self.errors[5]
        stated = [*self.errors[3:6], *(third * factor for factor in _HIGHER)]
        known[: self.lengthwise] = stated[: self.lengthwise]
        return known[:count]


@dataclass(frozen=True)
class Fit:
    """Coefficients over a range of groups."""

    products: Products  #: Polynomials in all groups
    clamp: Products  #: The same, each of which times each of :attr:`TheoryChange.sizes` is a term
    factors: Floats  #: (t, 6) Coefficients of the logarithms of :data:`FACTORS`
    ratios: Floats  #: (t, 3) The same of the ratios of frequencies
    errors: Floats  #: (1 + 2 g, 7) Of the logarithms of :data:`ERRORS`

    def terms(self, at: Floats, sizes: Floats) -> Floats:
        """Terms (..., t) at groups (..., g) and sizes (..., a)."""
        held = sizes[..., :, None] * self.clamp(at)[..., None, :]
        flat = held.reshape(*held.shape[:-2], -1)
        return np.concatenate([self.products(at), flat], axis=-1)


@dataclass(frozen=True)
class Widening:
    """Factors on :data:`ERRORS`, at least 1, over a range of :func:`step_sizes`."""

    low: Floats  #: (g,) Range of the sizes; those beyond count as its end
    high: Floats
    logarithms: Floats  #: (1 + g, 7) Of the factors: constant, and by size from −1 to 1

    def terms(self, sizes: Floats) -> Floats:
        """1 and sizes (..., 1 + g) over the range."""
        unit = np.clip(self._unit(sizes), -1.0, 1.0)
        return np.concatenate([np.ones_like(unit[..., :1]), unit], axis=-1)

    def outside(self, sizes: Floats) -> bool:
        """Whether one of the sizes (g,) that differ at all is beyond the range."""
        beyond = (np.abs(self._unit(sizes)) > 1.0 + _ROUNDED) & (self.high > self.low)
        return bool(beyond.any())

    def _unit(self, sizes: Floats) -> Floats:
        span = np.where(self.high > self.low, self.high - self.low, 1.0)
        return np.asarray(2.0 * (sizes - self.low) / span - 1.0)

    def __call__(self, sizes: Floats) -> Floats:
        """Factors (..., 7) at sizes (..., g)."""
        return np.asarray(np.maximum(np.exp(self.terms(sizes) @ self.logarithms), 1.0))


@dataclass(frozen=True)
class Calibration:
    """A fit, and what widens its errors."""

    fit: Fit
    #: By property that the fit does not know, such as a tab, and of ratios beyond its range; of
    #: others, such as a taper, no error is known
    beyond: dict[str, Widening]


def calibration_from(record: dict[str, Any]) -> Calibration:
    """Calibration as read from a file."""
    one = record["fit"]
    fit = Fit(
        Products(*(np.array(one[name]) for name in ("low", "high", "powers"))),
        Products(*(np.array(one[name]) for name in ("low", "high", "clamp"))),
        *(np.array(one[name]) for name in ("factors", "ratios", "errors")),
    )
    beyond = {
        name: Widening(*(np.array(of[key]) for key in ("low", "high", "logarithms")))
        for name, of in record["beyond"].items()
    }
    return Calibration(fit, beyond)


@cache
def calibration(*, listed: bool) -> Calibration:
    """Calibration that is shipped, of listed layers or of piezo, shim and piezo."""
    file = LISTED_FILE if listed else FILE
    return calibration_from(json.loads(file.read_text(encoding="utf-8")))


# ---- the calibrated section ----


def check_known(device: Device, support: Support) -> None:
    """Refuse what no calibration knows: a rod's joint.

    And materials that no solid has, ceramics that couple far more than those of the fit, or hardly
    bend it.

    Raises InputError with the remedy.
    """
    if support.kind == "rod":
        raise InputError(
            'support.kind = "rod": the model calibrated takes the bimorph without its rod; ask for '
            "--model cad, which takes both"
        )
    layers = device.bimorph.layers
    if layers and lever(plain(device)) < _LEVER:
        raise InputError(
            f'bimorph.layers = "{layers}" has ceramics that hardly bend it, which the model '
            "calibrated does not know; ask for --model tmm or solid"
        )
    for ceramic in ceramics(device):
        ceramic.ceramic().check_admissible()
    for layer in bimorph_stack(device):
        sheet_of(layer)  # which refuses what is not positive definite
    if layers:
        return
    squared, most = (
        float(at[GROUPS.index(COUPLING)])
        for at in (groups(plain(device)), calibration(listed=False).fit.products.high)
    )
    if squared > _COUPLES_MORE * most:
        raise InputError(
            f"piezo.d31 = {device.piezo.d31:.4g} m/V has a coupling factor squared of "
            f"{squared:.2g}, far beyond the {most:.2g} that the model calibrated knows; ask for "
            "--model solid"
        )


def section_factors(device: Device, beam: Beam, known: Calibration | None = None) -> SectionFactors:
    """Calibrated section of a bimorph relative to that of beam theory.

    Parameters
    ----------
    known : Calibration, optional
        By default the one that is shipped.
    """
    # the fit does not know glue, the theories do
    simple, glued = plain(device), plain(device, glue=True)
    known = known or calibration(listed=bool(simple.bimorph.layers))
    fit, at = known.fit, groups(simple)
    near, whole = root_length(simple), interior(glued)
    theory = theory_change(glued, whole, near)
    terms = fit.terms(at, theory.sizes)
    if any(layer.pitch for layer in simple.bimorph.layers) or not ceramics(simple):
        terms = 0.0 * terms  # the theories alone: all layers of the fit's are strained by d31
    further = terms @ fit.ratios  # of the higher modes as of the third
    stiffness, root, shear, coupling, root_coupling, capacitance = np.exp(
        theory.factors + terms @ fit.factors
    )
    errors = np.exp(fit.products.quadratic(at) @ fit.errors)
    outside = [group_names(simple)[i] for i in fit.products.outside(at)] + _proportions(simple)
    widened, beyond = _widened(device, beam, known, outside)
    broad = simple.bimorph.width / simple.bimorph.length
    damping = DAMPING + _PER_WIDTH * min(broad, 1.0) + _PER_CORE * core_shear(simple)
    own = section(Piece("bimorph", glued.bimorph.length), glued, beam, lossy=False)
    active = replace(whole, EI=whole.EI * stiffness, GA=whole.GA / shear)
    return SectionFactors(
        stiffness=active.EI / own.EI,
        shear=active.GA / own.GA,
        coupling=coupling * (whole.K / own.K if own.K else 1.0),
        capacitance=capacitance
        * (free_capacitance(whole) / free_capacitance(own) if own.C else 1.0),
        root=float(root), root_coupling=float(root_coupling), root_length=near,
        knots=theory.frequencies, ratios=np.exp(theory.ratios + np.pad(further, (0, 2), "edge")),
        errors=widened * errors,
        lengthwise=lengthwise_modes(simple), damping_error=damping,
        beyond=beyond,
    )  # fmt: skip


def _widened(
    device: Device, beam: Beam, known: Calibration, outside: Sequence[str]
) -> tuple[Floats, tuple[str, ...]]:
    """Factors (7,) on the errors by what the fit does not know, and what is outside of ranges."""
    unknown = properties(device)
    found = np.ones(len(ERRORS))
    if not (unknown or outside):
        return found, ()
    sizes = step_sizes(device, beam)
    if any(name in known.beyond and known.beyond[name].outside(sizes) for name in unknown):
        outside = (*outside, "proportions of the pieces")
    for name in (*unknown, *(["range"] if outside else [])):
        found *= known.beyond[name](sizes) if name in known.beyond else np.nan
    return found, tuple(outside)


def step_sizes(device: Device, beam: Beam) -> Floats:
    """Logarithms (7,) of the sizes that the errors of a row of several pieces go with.

    Thickness and width over the length that the voltage drives; the thinnest and the softest piece
    over the thickest and the stiffest; where the driven part begins, and its length, over that
    of the whole; the lever of the ceramics.
    """
    row = beam_pieces(device, Support())
    parts = [section(piece, device, beam, lossy=False) for piece in row]
    length, bending = np.array([(p.length, s.EI) for p, s in zip(row, parts, strict=True)]).T
    thickness = np.array([sum(of.thickness for of in stack(piece, device)) for piece in row])
    driven = np.array([p.electrode and s.K != 0.0 for p, s in zip(row, parts, strict=True)])
    driven |= not driven.any()
    active, whole = length[driven].sum(), length.sum()
    before = length[: np.argmax(driven)].sum()
    return np.log([
        thickness.max() / active, device.bimorph.width / active,
        thickness.min() / thickness.max(), bending.min() / bending.max(),
        _CLOSE + before / whole, active / whole, max(lever(plain(device)), _LEVER),
    ])  # fmt: skip


class TheoryChange(NamedTuple):
    """What layerwise theory and that of plates add to a beam of its section."""

    factors: Floats  #: (6,) Logarithms of :data:`FACTORS`
    #: (5,) Frequencies (Hz), and logarithms of the ratio of the beam's with these factors to them
    frequencies: Floats
    ratios: Floats
    layered: Floats  #: (5,) Relative change of the statics by layerwise theory
    #: (a,) Sizes of what a clamp does to the bending: by :func:`clamp_sizes`, and what a plate adds
    sizes: Floats


def theory_change(device: Device, whole: Section, root: float) -> TheoryChange:
    """What theories add to a beam of the section `whole` whose root has a length (m)."""
    layered = layerwise_change(device, whole, root)
    plate = plate_change(device, root, lengthwise_modes(device))
    return TheoryChange(
        layered.factors + plate.factors, layered.frequencies, layered.ratios + plate.ratios,
        layered.statics, np.append(clamp_sizes(device), plate.factors[[1, 4]]),
    )  # fmt: skip


def lengthwise_modes(device: Device) -> int:
    """How many of the first five modes surely bend along the length, none across the width."""
    wide = device.bimorph.width / device.bimorph.length
    return sum(wide < widest for widest in WIDEST)


def _proportions(device: Device) -> list[str]:
    """Proportions beyond those of the fit."""
    own = device.bimorph
    found = {
        "length/thickness": own.length < STOUTEST * own.thickness,
        "width/length": own.width > BROADEST * own.length,
        "directions across the poling": not all(
            of.ceramic().isotropic_across for of in ceramics(device)
        ),
    }
    return [name for name, beyond in found.items() if beyond]


def properties(device: Device) -> tuple[str, ...]:
    """Properties of a bimorph that the fit does not know."""
    own = device.bimorph
    found = {
        "tab": own.tab_length > 0.0, "glue": own.glue_thickness > 0.0 and not own.layers,
        "bare ends": own.bare_below + own.bare_above > 0.0, "taper": bool(own.profiles),
        "tip extension": own.tip_extension > 0.0,
        "patch": any(extent != (0.0, own.length) for extent in own.layers.extents(own.length)),
        "own widths": own.stepped, "poled along": any(layer.pitch for layer in own.layers),
    }  # fmt: skip
    return tuple(name for name, has in found.items() if has)


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
    asked = support, beam, segments
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
    device: Device, factors: SectionFactors, support: Support, beam: Beam, segments: int
) -> list[Element]:
    """Row of calibrated beams without losses."""
    left = factors.root_length
    found: list[Element] = []
    for piece in beam_pieces(device, support):
        own = factors
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
    return found


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
        loss = 0.5 * np.log(up / down) / _STEP if value else 0.0
        # next to the clamp a soft core may turn a loss into a gain, which no material has
        found[name] = value * (1.0 + 1j * (max(loss, 0.0) if name in _PASSIVE else loss))
    return replace(own, **found), length


def _corrected(own: Section, factors: SectionFactors, *, at_root: bool) -> Section:
    """Section of beam theory with the calibrated factors on it."""
    flexible, follows = (factors.root, factors.root_coupling) if at_root else (1.0, 1.0)
    stiffness = own.EI * factors.stiffness / flexible
    coupling = own.K * factors.coupling / flexible * follows
    return replace(
        own,
        EI=stiffness,
        GA=own.GA * factors.shear,
        K=coupling,
        C=free_capacitance(own) * factors.capacitance - coupling**2 / stiffness,
    )


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
