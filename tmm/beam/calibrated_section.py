"""Section constants calibrated on the solid, and how far answers from them may be off.

The section is that of :mod:`tmm.beam.cross_section`, with what the shear of a soft core changes by
:mod:`tmm.beam.layerwise`, what a clamp does to a wide one by :mod:`tmm.beam.plate` and what the
ends of layers do by :mod:`tmm.beam.layerwise_steps`.  What these lack of a plain bimorph depends on
:mod:`tmm.beam.dimensionless_groups` only and was fitted to solids of random ones, clamped in all
layers (:mod:`validation.evidence.calibration`):

* six factors: on bending stiffness, shear compliance, coupling and free capacitance of the section,
  and on flexibility and coupling next to the clamp, where the width cannot contract;
* three ratios of frequencies, through which bending across the width and the shear of a soft core
  make short waves stiffer or softer than any beam.

Each comes with the error that was left on devices which the fit had not seen.  Since the factors
are those of the section, every support, load and circuit has them.

The coefficients come from finite elements: this model is no witness of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import Piece, beam_pieces, bimorph_stack, stack
from tactgen.geometry.device.parameters import Beam, Device, Piezo, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.calibration_fit import ERRORS, Calibration, calibration
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
from tactgen.tmm.beam.layerwise_steps import layer_steps
from tactgen.tmm.beam.plate import plate_change
from tactgen.tmm.beam.sections import Section, section

#: Up to how many times a natural frequency the error is that of this mode.  The next one is at 1.6
#: times, of a wide plate the first across at 2.8.
_ALIKE = 1.25
#: Times the most of the fit up to which its widened errors hold.
_COUPLES_MORE = 1.15
#: Least lever of the ceramics, see :func:`lever`: below it their motion is a small difference.
_LEVER = 0.05
#: Gap between layers, as a share of the thickness, that is none.
_ROUNDING = 1e-9
#: What solids beyond the range of the fit told of by how much its errors grow there; share of a
#: range by which anything else may be beyond before no error is known.
_TRIED = frozenset(
    ("length/thickness", "end zone/length", "width/length", "ceramic/shim thickness")
)
_FAR = 0.05
#: No error is known of layers more unequal than this width of the narrowest over that of the
#: widest, the least of the fit, and of glue softer than this (Pa), half the least of the fit.
_NARROWEST, _SOFT_GLUE = 0.15, 0.5e9
#: Share of the motion by a voltage that steps leave below which no error of it is known, and which
#: of :data:`ERRORS` are of it.
_LEAST_LEFT, _BY_VOLTAGE = 0.3, np.array([0, 1, 0, 0, 0, 0, 1])
#: Length of driven pieces between steps, in thicknesses of the bimorph, from which on it counts.
_SHORTEST = 3.0
#: Share of the length below which a driven part begins at the clamp.
_CLOSE = 0.02
#: Relative error of the loss factor in motion: of any bimorph, per width over length, and per core
#: shear E_p t_p (t_s + t_p) / (G_s L²).  Not fitted: chosen on the heights of the first resonance
#: of 320 random bimorphs, half of them with losses in the core.
DAMPING, _PER_WIDTH, _PER_CORE = 0.004, 0.02, 0.6
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


def check_known(device: Device, support: Support) -> None:
    """Refuse what no calibration knows: a rod's joint, layers that lie apart where others end.

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
    thin = _ROUNDING * device.bimorph.thickness
    stacks = (stack(piece, device) for piece in beam_pieces(device, support))
    if any(above.low - below.high > thin for of in stacks for below, above in pairwise(of)):
        raise InputError(
            f'bimorph.layers = "{layers}" has layers that lie apart where others end and bend by '
            "themselves there, which the model calibrated does not know; ask for --model solid"
        )
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
    outside, far = (
        [group_names(simple)[i] for i in fit.products.outside(at, by)] + _proportions(simple)
        for by in (0.0, _FAR)
    )
    widened, beyond = _widened(device, beam, known, outside)
    if not _TRIED.issuperset(far):
        widened = widened * np.nan
    # where steps leave little of the motion by a voltage, it is a difference
    left = _left_by_steps(device)
    widened = widened / (left if left > _LEAST_LEFT else np.nan) ** _BY_VOLTAGE
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
    """Factors (7,) on the errors by what the fit does not know, and what is outside of ranges.

    What several properties add to the errors adds up.
    """
    unknown = properties(device)
    found = np.ones(len(ERRORS))
    if not (unknown or outside):
        return found, ()
    sizes = step_sizes(device, beam)
    if any(name in known.beyond and known.beyond[name].outside(sizes) for name in unknown):
        outside = (*outside, "proportions of the pieces")
    for name in (*unknown, *(["range"] if outside else [])):
        found += known.beyond[name](sizes) - 1.0 if name in known.beyond else np.nan
    return found, tuple(outside)


def step_sizes(device: Device, beam: Beam) -> Floats:
    """Logarithms (8,) of the sizes that the errors of a row of several pieces go with.

    Thickness and width over the length that the voltage drives; the thinnest and the softest piece
    over the thickest and the stiffest; where the driven part begins, and its length, over that
    of the whole; the lever of the ceramics; the narrowest layer over the widest.
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
        thickness.max() / active, plain(device).bimorph.width / active,
        thickness.min() / thickness.max(), bending.min() / bending.max(),
        _CLOSE + before / whole, active / whole, max(lever(plain(device)), _LEVER),
        _narrowest(device),
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
            of.material.ceramic().isotropic_across
            for of in bimorph_stack(device)
            if isinstance(of.material, Piezo) and not of.uniform
        ),
    }
    return [name for name, beyond in found.items() if beyond]


def _narrowest(device: Device) -> float:
    """Width of the narrowest layer over that of the widest."""
    widths = device.bimorph.widths or [1.0]
    return float(min(widths) / max(widths))


def _left_by_steps(device: Device) -> float:
    """Share of the voltage's rotation that the steps between pieces leave, at most 1.

    0 of pieces so short that what each step adds is no length of its own.
    """
    row = beam_pieces(device, Support())
    steps = [step for step in layer_steps(device, row) if step]
    driven = sum(row[n].length for n in {step.driven for step in steps})
    added = sum(step.by_voltage for step in steps)
    if not steps:
        return 1.0
    short = driven < _SHORTEST * device.bimorph.thickness
    return 0.0 if short else min(abs(1.0 + added / driven), 1.0)


def properties(device: Device) -> tuple[str, ...]:
    """Properties of a bimorph that the fit does not know."""
    own = device.bimorph
    found = {
        "tab": own.tab_length > 0.0, "glue": own.glue_thickness > 0.0 and not own.layers,
        "bare ends": own.bare_below + own.bare_above > 0.0, "taper": bool(own.profiles),
        "tip extension": own.tip_extension > 0.0,
        "patch": any(extent != (0.0, own.length) for extent in own.layers.extents(own.length)),
        "own widths": own.stepped,
        "very unequal widths": _narrowest(device) < _NARROWEST,
        "soft glue": "glue" in own.own_materials and device.glue.youngs_modulus < _SOFT_GLUE,
        "poled along": any(layer.pitch for layer in own.layers),
    }  # fmt: skip
    return tuple(name for name, has in found.items() if has)
