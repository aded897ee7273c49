"""Tip displacement over frequency and length of the actuator (the paper's Fig 9).

By the transfer-matrix model, for any support, load and segmented beam that it can hold.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.parametric import Actuator, check_length_free
from tactgen.tmm.beam.port_quantities import evaluate
from tactgen.validation.catalogue.quantities import TIP_DISPLACEMENT
from tactgen.validation.engine.derivatives import PLACES, extrapolated
from tactgen.validation.scene.scene import Scene

#: Frequencies of the map over the band; minima between them are located by narrowing.
_POINTS = 120
#: Points per round of narrowing, and rounds: the bracket, 8 % of a frequency, shrinks to 2e-7
#: of it, where rounding hides what is left of a smooth minimum.
_PROBES, _ROUNDS = 17, 6
#: Points of a curve around each of its extremes, at these shares of its frequency: from a
#: sharp minimum's own width up to the spacing of the other points.
_AROUND = 4e-4 * 2.0 ** np.arange(8)
#: Frequencies that a power law misses by more than this (relative) do not follow one.
_LAWFUL = 0.1
#: Relative distance of differences: truncation beside a sharp dip and rounding are then alike.
_CLOSE = 2e-4


@dataclass(frozen=True)
class Minimum:
    """A minimum over frequency: where (Hz) and how low (m)."""

    frequency: float
    displacement: float


@dataclass(frozen=True)
class LengthMap:
    """Tip displacement of one actuator in several lengths."""

    lengths: Floats  #: (m,) Ceramic length (m)
    frequencies: Floats  #: (n,) Hz: evenly in ln f, and around every minimum and maximum of a curve
    displacement: Floats  #: (m, n) Amplitudes (m)
    #: Deepest minimum inside the band for each length; None where there is none
    minima: tuple[Minimum | None, ...]

    @property
    def minimum_law(self) -> tuple[float, float] | None:
        """Exponent n and worst relative misfit of f_min = C length^n.

        None below three minima, or where another of them becomes the deepest in between.
        """
        points = [(l, m.frequency) for l, m in zip(self.lengths, self.minima, strict=True) if m]
        if len(points) < 3:
            return None
        l, f = np.log(np.array(points)).T
        slope, offset = np.polyfit(l, f, 1)
        misfit = float(np.abs(np.expm1(offset + slope * l - f)).max())
        return (float(slope), misfit) if misfit < _LAWFUL else None


def actuator(scene: Scene) -> Actuator:
    """Lateral actuator of a scene with support, load and drive."""
    return Actuator(scene.device, scene.held, scene.load, scene.beam, scene.drive, scene.circuit)


def tip_amplitude(device: Actuator, lengths: Floats, frequencies: Floats) -> Floats:
    """|w_tip| (m); lengths (m) and frequencies (Hz) broadcast against each other."""
    l, f = np.broadcast_arrays(np.asarray(lengths, float), np.asarray(frequencies, float))
    read = TIP_DISPLACEMENT.port_readout
    moved = evaluate(device, read, {"bimorph.length": l.ravel()}, f.ravel())
    return np.asarray(np.abs(moved).reshape(l.shape))


def tip_slopes(device: Actuator, keys: Sequence[str], frequency: float) -> dict[str, float]:
    """D ln|w_tip| / d ln p at one frequency (Hz), by extrapolated central differences."""
    values = 1.0 + _CLOSE * np.array([0.0, *PLACES])
    at, read = np.full(values.size, frequency), TIP_DISPLACEMENT.port_readout
    slopes = {}
    for key in keys:
        moved = evaluate(device, read, {key: device.value(key) * values}, at)
        slopes[key] = float(extrapolated(np.log(np.abs(moved)), np.zeros(()), _CLOSE)[0])
    return slopes


def band_points(band: tuple[float, float]) -> Floats:
    """Log-spaced frequencies (n,) with exact ends."""
    return np.array([band[0], *np.geomspace(*band, _POINTS)[1:-1], band[1]])


def length_map(scene: Scene, lengths: Floats, band: tuple[float, float]) -> LengthMap:
    """Map of a scene's actuator over lengths (m,) in m and a band in Hz.

    Raises InputError if the tip does not move at all, or a length cannot be had.
    """
    device, f = actuator(scene), band_points(band)
    lengths = np.asarray(lengths, dtype=float)
    check_lengths(device, lengths)
    displacement = tip_amplitude(device, lengths[:, None], f)
    check_moves(displacement)

    def at(which: Ints, frequencies: Floats) -> Floats:
        return tip_amplitude(device, lengths[which][:, None], frequencies)

    which, where, values = local_minima(f, displacement, at)
    minima: list[Minimum | None] = [None] * lengths.size
    for number, *one in zip(which, where.tolist(), values.tolist(), strict=True):
        found, deepest = Minimum(*one), minima[number]
        inside = band[0] < found.frequency < band[1]
        if inside and (deepest is None or found.displacement < deepest.displacement):
            minima[number] = found
    peaks = local_minima(f, -displacement, lambda row, x: -at(row, x))[1]
    near = np.outer([*where, *peaks], [*(1.0 - _AROUND), 1.0, *(1.0 + _AROUND)])
    f = np.unique([*f, *near[(near > band[0]) & (near < band[1])]])
    return LengthMap(lengths, f, tip_amplitude(device, lengths[:, None], f), tuple(minima))


def check_lengths(device: Actuator, lengths: Floats) -> None:
    """Refuse lengths (n,) in m under a profile, or that leave no electrode."""
    bimorph, mm = device.device.bimorph, 1e3
    check_length_free(bimorph)
    bare, shortest = bimorph.bare_below + bimorph.bare_above, float(lengths.min())
    if shortest <= bare:
        raise InputError(
            f"lengths from {mm * shortest:g} mm leave no electrode beside bimorph.bare_below = "
            f"{mm * bimorph.bare_below:g} mm and bimorph.bare_above = "
            f"{mm * bimorph.bare_above:g} mm; start above {mm * bare:g} mm"
        )
    covered = max((max(layer.start, layer.end) for layer in bimorph.layers), default=0.0)
    if shortest < covered:
        raise InputError(
            f"lengths from {mm * shortest:g} mm end below a layer of bimorph.layers = "
            f'"{bimorph.layers}"; start at {mm * covered:g} mm or more'
        )


def check_moves(displacement: Floats) -> None:
    """Refuse an actuator of which all displacements are zero."""
    if not displacement.any():
        raise InputError(
            "drive.voltage or piezo.d31 is 0, so that the tip does not move at any length; "
            "give both a value"
        )


def local_minima(
    frequencies: Floats, values: Floats, evaluate: Callable[[Ints, Floats], Floats]
) -> tuple[Ints, Floats, Floats]:
    """Locate every minimum over the band, its ends included, by narrowing a bracket in ln f.

    Of m functions with `values` (m, n) on an ascending grid of frequencies (n,) in Hz; `evaluate`
    gives values (k, p) from row numbers (k,) and frequencies (k, p).  Returns of each minimum its
    row, its frequency (Hz) and its value, (k,) each.
    """
    # an end lower than its neighbour may hide a dip between the two
    walled = np.pad(values, ((0, 0), (1, 1)), constant_values=np.inf)
    rows, columns = np.nonzero((values < walled[:, :-2]) & (values <= walled[:, 2:]))
    last = frequencies.size - 1
    low, high = frequencies[np.maximum(columns - 1, 0)], frequencies[np.minimum(columns + 1, last)]
    where, lowest = frequencies[columns], values[rows, columns]
    each = np.arange(rows.size)
    steps = np.linspace(0.0, 1.0, _PROBES)
    for _ in range(_ROUNDS if rows.size else 0):
        probes = low[:, None] * (high / low)[:, None] ** steps
        probes[:, -1] = high  # rounding must not step over the band's end
        probed = evaluate(rows, probes)
        best = np.argmin(probed, axis=1)
        better = probed[each, best] < lowest
        where = np.where(better, probes[each, best], where)
        lowest = np.where(better, probed[each, best], lowest)
        low = probes[each, np.maximum(best - 1, 0)]
        high = probes[each, np.minimum(best + 1, _PROBES - 1)]
    return rows, where, lowest
