"""The transfer-matrix model against 80-digit arithmetic, far beyond any use.

Compared are all entries of the 5 x 5 dynamic stiffness of one beam, and tip displacement
(hence velocity), rotation and charge with the ends attached.  Inputs are the double-precision
section constants, length and Ω, taken as exact on both sides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import Any

import mpmath as mp
import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Load, Piezo, Support
from tactgen.geometry.formats import engineering
from tactgen.tmm.beam.modes import bending_frequencies, natural_frequencies
from tactgen.tmm.beam.mounted_beam import mounted_response
from tactgen.tmm.beam.sections import Section, section
from tactgen.tmm.beam.span import (
    EPS,
    EXTENDED_EPS,
    EXTENDED_ROUNDINGS,
    Span,
    condition,
    dynamic_stiffness,
    error_bound,
    span,
)
from tactgen.tmm.beam.transfer_matrix import chain
from tactgen.tmm.ports.elements import base_stiffness, ends_of, tip_stiffness
from tactgen.validation.evidence.cases import exact_beam as reference
from tactgen.validation.evidence.cases import textbook_beam
from tactgen.validation.evidence.cases.exact_beam import offset
from tactgen.validation.evidence.stress import (
    WANTED,
    Approach,
    ErrorMap,
    Family,
    PartRequest,
    Point,
    Row,
    Stress,
    judged,
)

#: Condition number up to which the wanted accuracy is promised.
CONDITION_LIMIT = (WANTED - 2.0 * EPS) / (EXTENDED_ROUNDINGS * EXTENDED_EPS)

#: Entries of D that are not zero by symmetry.
_ENTRIES = tuple(set(product(range(5), repeat=2)) - {(0, 4), (4, 0), (2, 4), (4, 2)})
#: Magnitude below which a double loses digits, or becomes 0.
_UNDERFLOW = 1e-290


def point(beam: Section, length: float, frequency: float, ends: Ends, where: str) -> Point:
    """Compare D and the terminated response at one point."""
    omega = 2.0 * np.pi * frequency
    exact = reference.dynamic_stiffness(reference.constants(beam), length, omega)
    f = np.array([frequency])
    base = None
    if ends.base is not None:
        lateral, rotational = base_stiffness(ends.base, f)
        base = complex(lateral[0]), complex(rotational[0])
    tip = complex(tip_stiffness(ends.tip, f)[0])
    w_tip, charge, psi_tip = reference.tip_motion(exact, base, tip)
    ours = mounted_response(beam, length, omega, base=base, tip=tip)
    errors = [
        entry_error(dynamic_stiffness(beam, length, omega), exact),
        reference.relative_error(ours.w_tip, w_tip),
        reference.relative_error(ours.charge, charge),
        reference.relative_error(ours.psi_tip, psi_tip),
    ]
    worst = max(float(condition(beam, length, omega).max()), float(ours.condition))
    naive = math.nan
    if frequency > 0.0:
        velocity = textbook_beam.tip_velocity(beam, length, f, base=base, tip=tip)[0]
        naive = max(
            entry_error(textbook_beam.dynamic_stiffness(beam, length, f)[0], exact),
            _finite(reference.relative_error(velocity / (1j * omega), w_tip)),
        )
    return Point(where, max(errors), worst, float(error_bound(worst)), naive)


def entry_error(got: Any, exact: Any) -> float:
    """Worst relative error of the entries of D (5, 5); infinite for nan."""
    return max(
        _finite(reference.relative_error(got[at], exact[at]))
        for at in _ENTRIES
        if abs(exact[at]) > _UNDERFLOW
    )


def _finite(error: float) -> float:
    return math.inf if math.isnan(error) else error


_LENGTH = 20e-3
#: Frequencies above 0 Hz and lengths of the grids, of a quick run and of a full one.
_QUICK, _FULL = (12, 8), (25, 13)
#: Relative distances from the cut-off, and quality factors, of a quick run.
_NEAR_CUT_OFF = (0.0, 1e-14, 1e-10, 1e-6, 1e-3)
_QUALITIES = (1.0, 1e3, 1e9)
_PAPER = ends_of(Support(), Load())
_CLAMPED_FREE = Ends()


def run(asked: PartRequest) -> Stress:
    """Run all families; some 400 points if quick, else some 1300."""
    found = asked.keep((asked.quick,), lambda: _found(asked.quick, asked.announce))
    return Stress("tmm", _statement(), *found)


def _found(
    quick: bool, announce: Callable[[str], None]
) -> tuple[tuple[Row, ...], tuple[ErrorMap, ...], tuple[Approach, ...]]:
    maps, rows, approaches = [], [], []
    for lossy in (True, False):
        announce(f"tmm: frequency against length, {'lossy' if lossy else 'lossless'}")
        table, row = _grid(lossy, quick)
        maps.append(table)
        rows.append(row)
    for family in (
        _static, _cut_off, _ratios, _constants, _quality, _chains, _natural_frequencies,
    ):  # fmt: skip
        announce(f"tmm: {family.__name__.strip('_').replace('_', ' ')}")
        rows.append(family(quick))
    for approach in (_held_resonance, _mounted_resonance):
        announce("tmm: into a resonance")
        line, row = approach(quick)
        approaches.append(line)
        rows.append(row)
    return tuple(rows), tuple(maps), tuple(approaches)


def _statement() -> str:
    return (
        "Relative error of every entry, of tip velocity, of tip rotation and of charge at most "
        f"{WANTED:.0e} wherever the condition number (size of the terms over size of their sum; "
        f"1/distance in radians of phase to the next pole or zero) is below {CONDITION_LIMIT:.0e}; "
        f"beyond, at most {EXTENDED_ROUNDINGS:g} x {EXTENDED_EPS:.1e} x condition, "
        f"{EXTENDED_EPS:.1e} being the rounding unit of this machine's long double. "
        "Exactly at a resonance of a lossless beam the condition number, like the value, has no "
        "bound."
    )


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


def _grid(lossy: bool, quick: bool) -> tuple[ErrorMap, Row]:
    n_f, n_l = _QUICK if quick else _FULL
    frequencies = np.array([0.0, *np.geomspace(1e-6, 1e6, n_f)])
    lengths = np.geomspace(1e-4, 10.0, n_l)
    beam, ends = beam_of(lossy=lossy), _PAPER if lossy else _CLAMPED_FREE
    name = "lossy, on the paper's springs under the finger" if lossy else "lossless cantilever"
    points = [
        point(beam, float(l), float(f), ends, f"{_si(l, 'm')}, {_si(f, 'Hz')}")
        for l, f in product(lengths, frequencies)
    ]

    def table(attribute: str) -> Floats:
        values = [getattr(p, attribute) for p in points]
        return np.array(values).reshape(lengths.size, frequencies.size)

    grids = (table(name) for name in ("error", "naive", "condition"))
    what = f"0 Hz and 1 µHz to 1 MHz, 0.1 mm to 10 m, {name}"
    row = judged(f"frequency x length, {'lossy' if lossy else 'lossless'}", what, points)
    return ErrorMap(name, frequencies, lengths, *grids), row


def _static(_: bool) -> Row:
    """Go to the static limit."""
    frequencies = (0.0, 1e-9, 1e-6, 1e-3, 1.0)
    lengths = (1e-4, 1e-2, 1.0, 10.0)
    points = _points(beam_of(), _PAPER, lengths, frequencies)
    return judged("static limit", "0 Hz and just above, 0.1 mm to 10 m, lossy", list(points))


def _cut_off(quick: bool) -> Row:
    """Go through the cut-off of the second spectrum."""
    steps = _NEAR_CUT_OFF if quick else (0.0, *10.0 ** -np.arange(2.0, 16.0))
    points = []
    for lossy in (True, False):
        beam = beam_of(lossy=lossy)
        cut = math.sqrt(beam.GA / beam.rhoI) / (2.0 * math.pi)
        for length, step, side in product((1e-3, _LENGTH, 1.0, 10.0), steps, (-1.0, 1.0)):
            if not step and side < 0.0:
                continue  # the same point
            where = f"{_si(length, 'm')}, cut-off (1 {'+' if side > 0 else '-'} {step:.0e})"
            frequency = cut * (1.0 + side * step)
            points.append(point(beam, length, frequency, _CLAMPED_FREE, where))
    what = "ρI Ω² = GA to the last bit and around it, 1 mm to 10 m, lossy and lossless"
    return judged("cut-off", what, points)


def _ratios(quick: bool) -> Row:
    """Vary the layer thicknesses."""
    points: list[Point] = []
    for ratio in 10.0 ** np.arange(-3.0, 3.5, 2.0 if quick else 1.0):
        beam = beam_of(device_of(ratio=ratio))
        points += _points(beam, _PAPER, (1e-3, _LENGTH), (1.0, 1e3, 1e5, 1e6), f"ratio {ratio:g}, ")
    what = "shim over piezo thickness 1e-3 to 1e3, 1 and 20 mm, 1 Hz to 1 MHz"
    return judged("thickness ratio", what, points)


def _constants(_: bool) -> Row:
    """Compare the section constants with integrals over the layers."""
    points = []
    for ratio, quality in product(10.0 ** np.arange(-3.0, 3.5, 1.0), (1.0, 60.0, 1e9)):
        device = device_of(ratio, quality)
        got = beam_of(device)
        exact = reference.bimorph_constants(device, Beam())
        error = max(
            reference.relative_error(getattr(got, name), getattr(exact, name))
            for name in ("EI", "GA", "m", "rhoI", "K", "C")
        )
        points.append(
            Point(f"ratio {ratio:g}, Q {quality:g}", error, 1.0, float(error_bound(1.0)), math.nan)
        )
    what = "EI, GA, m, ρI, K, C against integrals over the layers, ratios 1e-3 to 1e3, Q 1 to 1e9"
    return judged("section constants", what, points)


def _quality(quick: bool) -> Row:
    """Vary the quality factor."""
    points: list[Point] = []
    for quality in _QUALITIES if quick else (1.0, 3.0, 10.0, 1e2, 1e3, 1e5, 1e7, 1e9):
        beam = beam_of(device_of(quality=quality))
        points += _points(
            beam, _PAPER, (_LENGTH, 1.0), (1e2, 1044.0, 1e4, 1e5, 1e6), f"Q {quality:g}, "
        )
    return judged("quality factor", "Q 1 to 1e9, 20 mm and 1 m, 100 Hz to 1 MHz", points)


def _chains(quick: bool) -> Row:
    """Cut the beam and join it again."""
    beam, points = beam_of(), []
    for pieces, frequency in product((2, 8, 32) if quick else (2, 8, 32, 128), (10.0, 1e3, 1e5)):
        length = _LENGTH / pieces
        got = chain([(beam, length)] * pieces, np.array([frequency])).stiffness[0]
        exact = reference.dynamic_stiffness(
            reference.constants(beam), mp.mpf(length) * pieces, 2.0 * np.pi * frequency
        )
        # a piece is n³ times stiffer than the row, and each joint is a difference of two
        limit = float(error_bound(1.0)) + 4.0 * EPS * pieces**3
        where = f"{pieces} pieces, {_si(frequency, 'Hz')}"
        points.append(Point(where, entry_error(got, exact), float(pieces) ** 3, limit, math.nan))
    what = "20 mm cut in equal pieces and joined by their matrices; the condition is pieces³"
    return judged("long chain", what, points)


def _held_resonance(quick: bool) -> tuple[Approach, Row]:
    """Approach a pole of D, a resonance with both ends held."""
    beam = beam_of(lossy=False)
    # E, whose zeros these poles are
    pole = _root(
        lambda f: float(span(beam, _LENGTH, 2.0 * np.pi * f, Span)[0].even[0].real), 4e3, 9e3
    )
    return _approach("resonance, both ends held", beam, pole, quick)


def _mounted_resonance(quick: bool) -> tuple[Approach, Row]:
    """Approach a resonance of the cantilever."""
    beam = beam_of(lossy=False)
    first = bending_frequencies([(beam, _LENGTH)], _CLAMPED_FREE, 1, open_circuit=False)
    return _approach("resonance, cantilever", beam, float(first[0]), quick)


def _approach(name: str, beam: Section, pole: float, quick: bool) -> tuple[Approach, Row]:
    steps = 10.0 ** -np.arange(1.0, 16.0, 2.0 if quick else 0.5)
    points = [
        point(beam, _LENGTH, pole * (1.0 + s), _CLAMPED_FREE, f"{_si(pole, 'Hz')} (1 + {s:.0e})")
        for s in (*steps, 0.0)
    ]
    columns = (np.array([getattr(p, n) for p in points]) for n in ("condition", "error", "bound"))
    what = f"lossless 20 mm, {pole:.6g} Hz, from 10 % away to the last bit"
    return Approach(name, *columns), judged(name, what, points)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function changes sign, to the last bit."""
    positive = function(low) > 0.0
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return middle
        low, high = (middle, high) if (function(middle) > 0.0) == positive else (low, middle)


def _points(
    beam: Section, ends: Ends, lengths: Sequence[float], frequencies: Sequence[float],
    label: str = "",
) -> Iterator[Point]:  # fmt: skip
    for length, frequency in product(lengths, frequencies):
        where = f"{label}{_si(length, 'm')}, {_si(frequency, 'Hz')}"
        yield point(beam, length, frequency, ends, where)


def _si(value: float, unit: str) -> str:
    return engineering(float(value), unit, 3)


_ENDS = {"clamped": Ends(), "on springs": Ends(Springs(3.0, 0.24)), "free": Ends(Springs(0.0, 0.0))}
_MODES = 3


def _natural_frequencies(quick: bool) -> Row:
    """Vary φ over 28 decades and the rotary inertia over 8, at three kinds of ends."""
    family = Family()
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
    return family.row(
        "natural frequencies: slenderness",
        "three modes, EI/(GA l²) 1e-12 to 1e16, clamped, on springs and free, against 80 digits",
    )
