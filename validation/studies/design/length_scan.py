"""The lowest margin m(l) over a range of lengths, so closely that no crossing is missed.

A longer actuator repeats the picture of a shorter one at a lower frequency: its minima move
as a power of the length (about length^-1.57 on the paper's support, length^-2 clamped).  m(l)
therefore changes over a share of the length, not over millimetres, and the scan takes steps
of such a share.  Where the margin is only just kept or missed between two steps, the extreme
of m there is located and added.
"""

from __future__ import annotations

import math

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.pieces import beam_pieces
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.parametric import Actuator
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.timoshenko import wavenumbers
from tactgen.validation.studies.design.aim import Aim
from tactgen.validation.studies.design.length_map import (
    band_points,
    check_lengths,
    check_moves,
    local_minima,
    tip_amplitude,
)

#: Largest step of the scan, as a share of the length: the paper's two gaps, 18.40 to 22.64 mm
#: and 68.19 to 74.53 mm, are 14 and 6 steps wide.
_STEP = 0.015
#: Half waves along the actuator at the band's end up to which its minima are told apart: with
#: n of them the next minimum is 1/n further in ln l and 2/n in ln f, then 8 steps of length
#: and 6 of frequency away.
_HALF_WAVES = 8
#: Relative accuracy to which an extreme of m is located before the crossings beside it are.
_LOCATED = 1e-4


def lowest_margin(device: Actuator, aim: Aim, lengths: Floats) -> tuple[Floats, Floats]:
    """Return m (n,) and the frequency (n,) in Hz that decides it, for lengths (n,) in m."""
    lengths = np.asarray(lengths, dtype=float)
    f = band_points(aim.band)

    def ratio(which: Ints, frequencies: Floats) -> Floats:
        w = tip_amplitude(device, lengths[which][:, None], frequencies)
        return np.asarray(w / aim.threshold.at(frequencies))

    on_grid = ratio(np.arange(lengths.size), f)
    at = np.argmin(on_grid, axis=1)
    lowest, where = on_grid[np.arange(lengths.size), at], f[at]
    for row, frequency, value in zip(*local_minima(f, on_grid, ratio), strict=True):
        if value < lowest[row]:
            lowest[row], where[row] = value, frequency
    return lowest, where


def scan(device: Actuator, aim: Aim, own: float) -> tuple[Floats, Floats]:
    """Return lengths (n,) in m, ascending over the aim's range, and their m (n,).

    The length `own` (m) is one of them if the range holds it.

    Raises
    ------
    InputError
        If the tip does not move, or the range holds lengths that are not to be had or that
        no beam model describes.
    """
    check_range(device, aim)
    low, high = aim.lengths
    steps = math.ceil(math.log(high / low) / math.log1p(_STEP))
    inner = np.geomspace(low, high, steps + 1)[1:-1]
    lengths = np.unique([low, *inner, high, min(max(own, low), high)])
    margins, _ = lowest_margin(device, aim, lengths)
    check_moves(margins)
    added = np.array(_hidden(device, aim, lengths, margins))
    if added.size:
        at = np.searchsorted(lengths, added)
        lengths = np.insert(lengths, at, added)
        margins = np.insert(margins, at, lowest_margin(device, aim, added)[0])
    return lengths, margins


def _hidden(device: Actuator, aim: Aim, lengths: Floats, margins: Floats) -> list[float]:
    """Return where m has a minimum between lengths that keep the margin, or a maximum else."""
    from scipy.optimize import minimize_scalar

    found = []
    for i in range(1, lengths.size - 1):
        sign = 1.0 if margins[i] >= aim.margin else -1.0
        before, here, after = sign * margins[i - 1 : i + 2]
        same_side = sign * (margins[i - 1 : i + 2] - aim.margin) >= 0.0
        if here < before and here <= after and same_side.all():
            extreme = minimize_scalar(
                lambda l, sign=sign: sign * lowest_margin(device, aim, np.array([l]))[0][0],
                bounds=(lengths[i - 1], lengths[i + 1]),
                method="bounded",
                options={"xatol": _LOCATED * lengths[i]},
            )
            if extreme.fun < here:
                found.append(float(extreme.x))
    return found


def check_range(device: Actuator, aim: Aim) -> None:
    """Refuse lengths that are not to be had or no beam, or have more minima than are told apart."""
    check_lengths(device, np.array(aim.lengths))
    mm = 1e3
    (low, high), top = aim.lengths, aim.band[1]
    thickness = device.device.bimorph.thickness
    if low < thickness:
        raise InputError(
            f"lengths from {mm * low:g} mm are shorter than the actuator is thick, no beam; start "
            f"at {mm * thickness:g} mm or more"
        )
    ceramic = (p for p in beam_pieces(device.device, device.support) if p.section == "bimorph")
    wavenumber = max(
        float(np.max(wavenumbers(section(p, device.device, device.beam, lossy=False), 1.0,
                                 np.array([2.0 * np.pi * top]))))
        for p in ceramic
    )  # fmt: skip
    half_waves = wavenumber * high / np.pi
    if half_waves > _HALF_WAVES:
        longest = _HALF_WAVES * np.pi / wavenumber
        raise InputError(
            f"lengths to {mm * high:g} mm hold up to {half_waves:.3g} half waves at {top:g} Hz, "
            f"and beyond {_HALF_WAVES} their minima are not told apart; stop at "
            f"{mm * longest:.4g} mm or take a narrower --band"
        )
