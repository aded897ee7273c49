"""A load as springs, dampers and masses that a time simulation can carry along.

The terms of a passive fit are networks of a few parts each, hung onto the same tip.  With
p = s² + 2ζω s + ω² below, a resonator's dynamic stiffness s (a s + b)/p is the sum of

    κ s (s + 2ζω)/p:  a spring κ to a mass κ/ω² that a damper 2ζκ/ω holds to the ground,
    κ s²/p:           a spring κ, a damper κ/(2ζω) and a mass κ/ω² in a row,

with κ = b/(2ζω) in the first and a − b/(2ζω) in the second.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Law, TipLoad
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.loads.finger import FINGER_RANGE, finger_impedance, finger_stiffness
from tactgen.tmm.ports.loads.measured_law import MeasuredLaw
from tactgen.tmm.ports.loads.passive_fit import Dictionary, PassiveFit, passive_fit

#: Points over the finger's range to which its load is fitted.
_POINTS = 200
#: A few resonators for the finger.  Its magnitude and phase were fitted each by itself, and no
#: passive load has both: five times as many parts come as near as 8 % (root mean square), these 9.
_FEW = Dictionary(per_decade=3, ratios=(0.7,), reach=3.0)


@dataclass(frozen=True)
class Chain:
    """A mechanical network whose first coordinate is the tip.

    Attributes
    ----------
    mass, damping, stiffness : (q, q) float
        Symmetric, none negative; coordinates without mass are held by a damper.
    carried : float
        What moves with the tip along the axis too (kg).
    misfit : float
        Largest relative distance from the law that it stands for, in the law's own range.
    """

    mass: Floats
    damping: Floats
    stiffness: Floats
    carried: float = 0.0
    misfit: float = 0.0

    def stiffness_at(self, frequencies: Floats) -> Complex:
        """Return the dynamic stiffness (n,) in N/m at the tip, at frequencies above 0 (Hz)."""
        s = 2j * np.pi * np.asarray(frequencies, dtype=float)[:, None, None]
        whole = self.mass * s**2 + self.damping * s + self.stiffness
        if whole.shape[1] == 1:
            return np.asarray(whole[:, 0, 0])
        inner = np.linalg.solve(whole[:, 1:, 1:], whole[:, 1:, :1])
        return np.asarray(whole[:, 0, 0] - (whole[:, :1, 1:] @ inner)[:, 0, 0])


def chain_of(tip: TipLoad | Law) -> Chain:
    """Return the load of a tip as parts.

    Raises
    ------
    InputError
        If it is a law of frequency to which no parts are fitted.
    """
    if isinstance(tip, TipLoad):
        mass, damping, stiffness = np.reshape([tip.mass, tip.damping, tip.stiffness], (3, 1, 1))
        return Chain(mass, damping, stiffness, carried=tip.mass)
    if tip is finger_stiffness:
        return finger_chain()
    if isinstance(tip, MeasuredLaw) and tip.fits:
        return _of_fit(tip.fits[0], tip.misfit[0])
    raise InputError(
        "the load is a law of frequency, which time simulation takes as springs, dampers and "
        "masses only; set load.extrapolation = passive_fit"
    )


@lru_cache(maxsize=1)
def finger_chain() -> Chain:
    """Return the paper's finger (eqs 1-3) as parts, fitted over its own range."""
    frequencies = np.geomspace(*FINGER_RANGE, _POINTS)
    impedance = finger_impedance(frequencies)
    fit = passive_fit(frequencies, impedance, _FEW)
    off = fit.stiffness_at(frequencies) / (2j * np.pi * frequencies * impedance) - 1.0
    return _of_fit(fit, float(np.abs(off).max()))


def _of_fit(fit: PassiveFit, misfit: float) -> Chain:
    """Return the parts of a fit."""
    width = 2.0 * fit.ratio * fit.omega
    grounded = fit.b / width
    rows = [(k, w, d) for k, w, d in zip(grounded, fit.omega, width, strict=True) if k > 0.0]
    series = [
        (k, w, d) for k, w, d in zip(fit.a - grounded, fit.omega, width, strict=True) if k > 0.0
    ]
    count = 1 + len(rows) + 2 * len(series)
    mass, damping, stiffness = (np.zeros((count, count)) for _ in range(3))
    mass[0, 0], damping[0, 0], stiffness[0, 0] = fit.mass, fit.damping, fit.stiffness
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    at = 1
    for k, w, d in rows:
        stiffness[np.ix_([0, at], [0, at])] += k * pair
        mass[at, at], damping[at, at] = k / w**2, k * d / w**2
        at += 1
    for k, w, d in series:
        stiffness[np.ix_([0, at], [0, at])] += k * pair
        damping[np.ix_([at, at + 1], [at, at + 1])] += (k / d) * pair
        mass[at + 1, at + 1] = k / w**2
        at += 2
    return Chain(mass, damping, stiffness, misfit=misfit)
