"""The 5 x 5 ports of an assembled solid by direct solution, one factorisation per frequency.

The tip is a mean over a face, not an unknown, so a solid first answers base motion, voltage
and tip *forces*; inverting the tip's compliance gives the stiffness of all five ports.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from tactgen.fem.piezo.brick_error import MotionEstimator
from tactgen.fem.piezo.system import SolidSystem
from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.tmm.ports.multiport import BIMORPH, MEASURED, Multiport

#: The mixed form of D, see :func:`ports_from_blocks`, at one frequency.
Blocks: TypeAlias = tuple[Numbers, Numbers, Numbers, Numbers]


def direct_multiport(system: SolidSystem, frequencies: Floats) -> Multiport:
    """D(Ω) (n, p, p), each frequency by its own factorisation; real at 0 Hz without losses.

    Accurate enough to judge what is faster: the residual is that of K and M apart, in long
    double, since rounding K − Ω² M alone moves a peak by a millionth of its width.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    found = []
    for frequency in frequencies:
        omega2 = (2.0 * np.pi * frequency) ** 2
        found.append(_blocks(system, omega2, _states(system, omega2)))
    return _multiport(frequencies, found)


def static_multiports(
    system: SolidSystem, surplus: MotionEstimator
) -> tuple[Multiport, Multiport, Multiport]:
    """D(0) of a lossless system, with its hierarchical error.

    Of these those of displacement alone, and those of potential alone.
    """
    x = _states(system, 0.0)
    residuals = -surplus.residuals(x.astype(float))[0]
    residuals[:, 3:] += surplus.seen
    moved, charged = surplus.products(residuals)
    blocks = held, through, follows, compliance = _blocks(system, 0.0, x)
    richer = [
        (
            held - more[:3, :3],
            through - more[:3, 3:],
            follows + more[3:, :3],
            compliance + more[3:, 3:],
        )
        for more in (moved, -charged)
    ]
    fine, *better = (_multiport(np.zeros(1), [of]) for of in (blocks, *richer))
    return fine, better[0], better[1]


def _states(system: SolidSystem, omega2: float) -> Numbers:
    """Y (n + 3, p) in long double: per unit w_base, ψ_base, U, and forces on what is seen."""
    wide, plain = (np.clongdouble, complex) if system.lossy else (np.longdouble, float)
    n, factor, seen = system.inner, system.dynamic_factor(omega2), system.seen
    x = np.zeros((system.size, 3 + seen.shape[1]), dtype=wide)
    x[n:, :3] = np.eye(3)
    last: Floats = np.zeros(x.shape[1])
    for _ in range(1 + _REFINEMENTS):
        missing = _force(system, omega2, x)
        missing[:, 3:] -= seen
        step = factor.solve(missing[:n].astype(plain))
        x[:n] -= step
        size = _norms(step)
        # the next step is to this one as this one is to the last
        if (size * size <= _ROUNDING * last * _norms(x[:n])).all():
            break
        last = size
    return x


def _blocks(system: SolidSystem, omega2: float, x: Numbers) -> Blocks:
    force = system.stiffness.at_ports(x) - omega2 * system.mass.at_ports(x)
    seen = system.seen.T @ x
    return force[:, :3], force[:, 3:], seen[:, :3], seen[:, 3:]


def _multiport(frequencies: Floats, blocks: Sequence[Blocks]) -> Multiport:
    stacked = (np.array(part, dtype=complex) for part in zip(*blocks, strict=True))
    return ports_from_blocks(frequencies, *stacked)


def _norms(columns: Numbers) -> Floats:
    return np.asarray(np.linalg.norm(columns.astype(complex), axis=0))


def _force(system: SolidSystem, omega2: float, x: Numbers) -> Numbers:
    """Forces (n + 3, p) that hold x, in long double."""
    stiff = system.stiffness.wide_product(x)
    return stiff if omega2 == 0.0 else stiff - omega2 * system.mass.wide_product(x)


def static_multiport(system: SolidSystem) -> Multiport:
    """D(0) of a lossless system by one real factorisation."""
    return direct_multiport(system, np.zeros(1))


def ports_from_blocks(
    frequencies: Floats, held: Complex, through: Complex, follows: Complex, compliance: Complex
) -> Multiport:
    """D(Ω) (n, p, p) from its mixed form, the place of measurement being a sixth port.

    `frequencies` (n,) are in Hz.  With the tip free, `held` (n, 3, 3) are base force, base moment
    and −charge, `follows` (n, t, 3) the motion seen, per unit (w_base, ψ_base, U); `through` (n, 3,
    t) and `compliance` (n, t, t) are the same per unit force on what is seen: on the tip, its
    moment, at the place of measurement.
    """
    stiff, t = np.linalg.inv(compliance), compliance.shape[-1]
    source, seen = np.array(SOURCE), np.array(SEEN[:t])
    s = np.zeros((held.shape[0], 3 + t, 3 + t), dtype=complex)
    source_by_tip = through @ stiff
    s[:, seen[:, None], seen] = stiff
    s[:, seen[:, None], source] = -stiff @ follows
    s[:, source[:, None], seen] = source_by_tip
    s[:, source[:, None], source] = held - source_by_tip @ follows
    s[:, 4] *= -1.0  # the symmetric system's last row is minus the charge
    return Multiport(frequencies, s, (*BIMORPH, MEASURED)[: 3 + t])


#: Most steps of iterative refinement; each gains as many digits as the last one: some seven,
#: or one where the matrix is next to singular.
_REFINEMENTS = 8
#: A step of this size, relative to the solution, is rounding.
_ROUNDING = 1e-13
#: Positions in D of (w_base, ψ_base, U), which are given as motions, and of what is seen.
SOURCE, SEEN = [0, 1, 4], [2, 3, 5]
