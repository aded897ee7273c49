"""The transfer-matrix model against 80-digit arithmetic, far beyond any use.

Compared are all entries of the 5 x 5 dynamic stiffness of one beam, and tip displacement
(hence velocity), rotation and charge with the ends attached, each with its own bound.  Inputs are
the double-precision section constants, length and Ω, taken as exact on both sides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cache, partial
from itertools import product
from typing import Any

import mpmath as mp
import numpy as np

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Load, Piezo, Support
from tactgen.geometry.formats import engineering
from tactgen.tmm.beam.modes import bending_frequencies, natural_frequencies
from tactgen.tmm.beam.mounted_beam import mounted_response
from tactgen.tmm.beam.sections import Section, section
from tactgen.tmm.beam.span import EPS, dynamic_stiffness, rounding
from tactgen.tmm.beam.transfer_matrix import chain
from tactgen.tmm.ports.supports_and_loads import base_stiffness, ends_of, tip_stiffness
from tactgen.validation.evidence.cases import exact_beam as reference
from tactgen.validation.evidence.cases.exact_beam import offset
from tactgen.validation.evidence.judgement import Family, Judged

#: Entries of D that are not zero by symmetry.
_ENTRIES = tuple(set(product(range(5), repeat=2)) - {(0, 4), (4, 0), (2, 4), (4, 2)})
#: Magnitude below which a double loses digits, or becomes 0.
_UNDERFLOW = 1e-290

_LENGTH = 20e-3
#: Frequencies above 0 Hz and lengths of the grids, of a quick run and of a full one.
_QUICK, _FULL = (12, 8), (25, 13)
#: Relative distances from the cut-off, and quality factors, of a quick run.
_NEAR_CUT_OFF = (0.0, 1e-14, 1e-10, 1e-6, 1e-3)
_QUALITIES = (1.0, 1e3, 1e9)
_PAPER = ends_of(Support(), Load())
_CLAMPED_FREE = Ends()


@cache
def compared(beam: Section, length: float, frequency: float, ends: Ends) -> tuple[float, float]:
    """Relative error of D or of the mounted response, with its bound: the worst beside this."""
    omega, (base, tip) = 2.0 * np.pi * frequency, attached(ends, frequency)
    exact, (w_tip, charge, psi_tip) = exactly(beam, length, frequency, ends)
    ours = mounted_response(beam, length, omega, base=base, tip=tip)
    d, bounds = dynamic_stiffness(beam, length, omega), rounding(beam, length, omega)
    found = [(d[at], exact[at], float(bounds[at])) for at in _ENTRIES]
    found += [
        (value, right, float(ours.error))
        for value, right in ((ours.w_tip, w_tip), (ours.charge, charge), (ours.psi_tip, psi_tip))
    ]
    errors = [
        (finite(reference.relative_error(value, right)), bound)
        for value, right, bound in found
        if abs(right) > _UNDERFLOW
    ]
    return max(errors, key=lambda one: Judged("", "", *one).share)


def exactly(beam: Section, length: float, frequency: float, ends: Ends) -> tuple[Any, Any]:
    """D (5, 5), and per volt (w_tip, charge, ψ_tip) on these ends."""
    omega = 2.0 * np.pi * frequency
    d = reference.dynamic_stiffness(reference.constants(beam), length, omega)
    return d, reference.tip_motion(d, *attached(ends, frequency))


def attached(ends: Ends, frequency: float) -> tuple[tuple[complex, complex] | None, complex]:
    """Dynamic stiffness of support, None of a clamp, and load."""
    f = np.array([frequency])
    tip = complex(tip_stiffness(ends.tip, f)[0])
    if ends.base is None:
        return None, tip
    lateral, rotational = base_stiffness(ends.base, f)
    return (complex(lateral[0]), complex(rotational[0])), tip


def entry_error(got: Any, exact: Any) -> float:
    """Worst relative error of the entries of D (5, 5); infinite for nan."""
    return max(
        finite(reference.relative_error(got[at], exact[at]))
        for at in _ENTRIES
        if abs(exact[at]) > _UNDERFLOW
    )


def finite(error: float) -> float:
    """Error, infinite for nan."""
    return math.inf if math.isnan(error) else error


def device_of(ratio: float | None = None, quality: float | None = None) -> Device:
    """Paper's device with another shim/piezo thickness ratio or quality factor."""
    bimorph, piezo = Bimorph(), Piezo()
    if ratio is not None:
        layer = float(bimorph.thickness / (2.0 + ratio))
        bimorph = Bimorph(piezo_thickness=layer, shim_thickness=float(layer * ratio))
    if quality is not None:
        piezo = Piezo(quality_factor=quality)
    return Device(bimorph=bimorph, piezo=piezo)


def beam_of(device: Device | None = None, *, lossy: bool = True) -> Section:
    """Section constants of a device's bimorph."""
    return section(Piece("bimorph", _LENGTH), device or Device(), Beam(), lossy=lossy)


def plane(quick: bool) -> tuple[list[float], list[float]]:
    """Lengths (m) and frequencies (Hz) of the maps."""
    n_f, n_l = _QUICK if quick else _FULL
    return (
        [*map(float, np.geomspace(1e-4, 10.0, n_l))],
        [0.0, *map(float, np.geomspace(1e-6, 1e6, n_f))],
    )


KINDS = {
    True: ("lossy, on the paper's springs under the finger", _PAPER),
    False: ("lossless cantilever", _CLAMPED_FREE),
}


def _grid(lossy: bool, family: Family, quick: bool) -> None:
    """Go over the plane of the maps."""
    _add(family, beam_of(lossy=lossy), KINDS[lossy][1], *plane(quick))


def _cut_off(family: Family, quick: bool) -> None:
    """Go through the cut-off of the second spectrum."""
    steps = _NEAR_CUT_OFF if quick else (0.0, *10.0 ** -np.arange(2.0, 16.0))
    for lossy in (True, False):
        beam = beam_of(lossy=lossy)
        cut = math.sqrt(beam.GA / beam.rhoI) / (2.0 * math.pi)
        beside = (cut * (1.0 + sign * step) for step in steps for sign in (-1.0, 1.0))
        frequencies = [*dict.fromkeys(map(float, beside))]
        _add(family, beam, _CLAMPED_FREE, (1e-3, _LENGTH, 1.0, 10.0), frequencies, "cut-off, ")


def _ratios(family: Family, quick: bool) -> None:
    """Vary the layer thicknesses."""
    for ratio in 10.0 ** np.arange(-3.0, 3.5, 2.0 if quick else 1.0):
        beam = beam_of(device_of(ratio=ratio))
        at = (1e-3, _LENGTH), (1.0, 1e3, 1e5, 1e6)
        _add(family, beam, _PAPER, *at, f"ratio {ratio:g}, ")


def _constants(family: Family, _: bool) -> None:
    """Compare the section constants with integrals over the layers."""
    for ratio, quality in product(10.0 ** np.arange(-3.0, 3.5, 1.0), (1.0, 60.0, 1e9)):
        device = device_of(ratio, quality)
        got, exact = beam_of(device), reference.bimorph_constants(device, Beam())
        error = max(
            reference.relative_error(getattr(got, name), getattr(exact, name))
            for name in ("EI", "GA", "m", "rhoI", "K", "C")
        )
        # a layer's integrals are differences over its faces
        thinnest = min(device.bimorph.piezo_thickness, device.bimorph.shim_thickness)
        bound = 4.0 * EPS * device.bimorph.thickness / thinnest
        family.add(f"ratio {ratio:g}, Q {quality:g}", error, bound)


def _quality(family: Family, quick: bool) -> None:
    """Vary the quality factor."""
    for quality in _QUALITIES if quick else (1.0, 3.0, 10.0, 1e2, 1e3, 1e5, 1e7, 1e9):
        beam = beam_of(device_of(quality=quality))
        at = (_LENGTH, 1.0), (1e2, 1044.0, 1e4, 1e5, 1e6)
        _add(family, beam, _PAPER, *at, f"Q {quality:g}, ")


def _chains(family: Family, quick: bool) -> None:
    """Cut the beam and join it again."""
    beam = beam_of()
    for pieces, frequency in product((2, 8, 32) if quick else (2, 8, 32, 128), (10.0, 1e3, 1e5)):
        length, omega = _LENGTH / pieces, 2.0 * np.pi * frequency
        got = chain([(beam, length)] * pieces, np.array([frequency])).stiffness[0]
        exact = reference.dynamic_stiffness(
            reference.constants(beam), mp.mpf(length) * pieces, omega
        )
        whole = float(rounding(beam, _LENGTH, omega).max())
        # a piece is n³ times stiffer than the row, and each joint is a difference of two
        bound = whole + 4.0 * EPS * pieces**3
        family.add(f"{pieces} pieces, {_si(frequency, 'Hz')}", entry_error(got, exact), bound)


def _resonances(family: Family, quick: bool) -> None:
    """Approach a pole of D, a resonance with both ends held, and a resonance of the cantilever."""
    beam = beam_of(lossy=False)
    first = bending_frequencies([(beam, _LENGTH)], _CLAMPED_FREE, 1, open_circuit=False)
    held = _root(
        lambda f: float(dynamic_stiffness(beam, _LENGTH, 2.0 * np.pi * f)[0, 2].real), 6e3, 7e3
    )
    steps = 10.0 ** -np.arange(1.0, 16.0, 2.0 if quick else 0.5)
    for name, pole in (("held", held), ("cantilever", float(first[0]))):
        frequencies = [float(pole * (1.0 + step)) for step in steps]
        _add(family, beam, _CLAMPED_FREE, (_LENGTH,), frequencies, f"{name}, ")


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function changes sign, to the last bit, where it may be nan."""
    positive = function(low) > 0.0
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return middle
        low, high = (middle, high) if (function(middle) > 0.0) == positive else (low, middle)


def _add(
    family: Family, beam: Section, ends: Ends, lengths: Iterable[float],
    frequencies: Sequence[float], label: str = "",
) -> None:  # fmt: skip
    for length, frequency in product(lengths, frequencies):
        where = f"{label}{_si(length, 'm')}, {_si(frequency, 'Hz')}"
        family.add(where, *compared(beam, length, frequency, ends))


def _si(value: float, unit: str) -> str:
    return engineering(float(value), unit, 3)


_ENDS = {"clamped": Ends(), "on springs": Ends(Springs(3.0, 0.24)), "free": Ends(Springs(0.0, 0.0))}
_MODES = 3


def _natural_frequencies(family: Family, quick: bool) -> None:
    """Vary φ over 28 decades and the rotary inertia over 8, at three kinds of ends."""
    powers = (-12, -4, 4, 8, 16) if quick else range(-12, 17, 2)
    inertias = (1e-3,) if quick else (1e-8, 1e-3, 1.0)
    for power, rho_i, (name, ends) in product(powers, inertias, _ENDS.items()):
        beam = Section(EI=1.0, GA=10.0**-power, m=1.0, rhoI=rho_i)
        where = f"φ 1e{power}, ρI/ml² {rho_i:g}, {name}"
        solved: list[tuple[float, float]] = []
        with family.attempt():
            found = natural_frequencies([(beam, 1.0)], ends, _MODES, open_circuit=False)
            solved = list(zip(found.frequencies, found.rounding, strict=True))
        for frequency, bar in solved:
            family.add(where, abs(offset([(beam, 1.0)], ends, float(frequency))), bar)


_PLANE = "0 Hz and 1 µHz to 1 MHz, 0.1 mm to 10 m"
#: By title, with the range.
FAMILIES: dict[str, Callable[[Family, bool], None]] = {
    **{f"frequency x length: {_PLANE}, {name}": partial(_grid, lossy)
       for lossy, (name, _) in KINDS.items()},
    "cut-off: ρI Ω² = GA to the last bit and around it, 1 mm to 10 m, lossy and lossless": _cut_off,
    "thickness ratio: shim over piezo thickness 1e-3 to 1e3, 1 and 20 mm, 1 Hz to 1 MHz": _ratios,
    "section constants: EI, GA, m, ρI, K, C against integrals over the layers, ratios 1e-3 to 1e3, "
    "Q 1 to 1e9": _constants,
    "quality factor: Q 1 to 1e9, 20 mm and 1 m, 100 Hz to 1 MHz": _quality,
    "long chain: 20 mm cut in equal pieces and joined by their matrices": _chains,
    "resonance: lossless 20 mm, ends held and cantilever, from 10 % away to the last bit":
        _resonances,
    "natural frequencies: three modes, EI/(GA l²) 1e-12 to 1e16, clamped, on springs and free, "
    "against 80 digits": _natural_frequencies,
}  # fmt: skip
