"""The piezoelectric Timoshenko beam once more, from its equations, to 60 digits and more.

Owes nothing to :mod:`tmm`: the state [w, ψ, M, F, q, U] obeys y' = S y with

    w' = F/GA − ψ,  ψ' = (M + K U)/EI,  M' = F − ρI Ω² ψ,  F' = −m Ω² w,
    q' = K ψ' + C U,  U' = 0,

so a beam is the 6 x 6 matrix exponential of S l.  Long beams are put together by
doubling a short one's dynamic stiffness, which never grows exponentially.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ParamSpec, TypeAlias, TypeVar, cast

import mpmath as mp
import numpy as np

from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Beam, Device

#: Decimal digits carried; exponential, inversions and doublings cost fewer than 20 of them.
DIGITS = 80

_P = ParamSpec("_P")
_R = TypeVar("_R")

#: Bits after the point in the exponential: 126 decimals, of which entries may be small by 26.
_FIXED = 420

#: Wave phase |λ| up to which one matrix exponential is taken.
_ONE_PIECE = 8


def _exact(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Make a function work with `DIGITS` digits."""
    return cast("Callable[_P, _R]", mp.workdps(DIGITS)(function))


@dataclass(frozen=True)
class Constants:
    """Section constants EI, GA, m, ρI, K and C as mpmath numbers."""

    EI: Any
    GA: Any
    m: Any
    rhoI: Any
    K: Any
    C: Any


def constants(beam: Any) -> Constants:
    """Take the constants of any object with these attributes, digit for digit."""
    if isinstance(beam, Constants):
        return beam
    values = (beam.EI, beam.GA, beam.m, beam.rhoI, beam.K, beam.C)
    return Constants(*(mp.mpmathify(complex(v)) for v in values))


@_exact
def bimorph_constants(device: Device, beam: Beam, *, lossy: bool = True) -> Constants:
    """Integrate T = E (x ψ' − d f U), D = d T + ε f U over the three layers, poled along −x.

    f is the field along x per volt across each layer and d the strain constant with the poling's
    sign; M = ∫ x T dA = EI ψ' − K U and the charge per length is ∫ f D dA.
    """
    bimorph, piezo, shim = device.bimorph, device.piezo, device.shim
    half, hp = mp.mpf(bimorph.shim_thickness) / 2, mp.mpf(bimorph.piezo_thickness)
    modulus, shear = 1 / mp.mpf(piezo.s11), 1 / mp.mpf(piezo.s55)
    permittivity = mp.mpf(piezo.eps33) * mp.mpf(EPS0)
    if lossy:
        modulus *= 1 + mp.j / mp.mpf(piezo.quality_factor)
        permittivity *= 1 - mp.j * mp.mpf(piezo.loss_tangent)
    d, rho = -mp.mpf(piezo.d31), mp.mpf(piezo.density)
    core = [mp.mpf(v) for v in (shim.youngs_modulus, shim.shear_modulus, shim.density)]
    ei = ga = m = rho_i = k = c = mp.mpf(0)
    for low, high, e, g, density, f in (
        (-half - hp, -half, modulus, shear, rho, 1 / hp),
        (-half, half, *core, mp.mpf(0)),
        (half, half + hp, modulus, shear, rho, -1 / hp),
    ):
        area, first, second = (mp.mpf(bimorph.width) * (high**n - low**n) / n for n in (1, 2, 3))
        ei += e * second
        ga += mp.mpf(beam.shear_correction) * g * area
        m += density * area
        rho_i += density * second
        k += e * d * f * first
        c += (permittivity - e * d**2) * f**2 * area
    return Constants(ei, ga, m, rho_i, k, c)


@_exact
def transfer(beam: Constants, length: Any, omega: Any) -> mp.matrix:
    """Exp(S l), 6 x 6, over the internal state [w, ψ, M, F, q, U]."""
    o2, span = mp.mpf(omega) ** 2, mp.mpf(length)
    s = mp.zeros(6)
    s[0, 1], s[0, 3] = -1, 1 / beam.GA
    s[1, 2], s[1, 5] = 1 / beam.EI, beam.K / beam.EI
    s[2, 1], s[2, 3] = -beam.rhoI * o2, 1
    s[3, 0] = -beam.m * o2
    s[4, 2], s[4, 5] = beam.K / beam.EI, beam.K**2 / beam.EI + beam.C
    return _exponential(s * span)


def _exponential(matrix: mp.matrix) -> mp.matrix:
    """Exp of A + jB by its power series in whole numbers, multiples of 2^-_FIXED.

    Of [[A, -B], [B, A]], whose left half tells all, or of A alone: thrice as fast as mpmath's own.
    """
    n = matrix.rows
    parts = [
        np.array([int(mp.ldexp(part(v), _FIXED)) for v in matrix], dtype=object).reshape(n, n)
        for part in (mp.re, mp.im)
    ]
    real, imaginary = parts
    whole = np.block([[real, -imaginary], [imaginary, real]]) if imaginary.any() else real
    power = np.array([[int(i == j) << _FIXED for j in range(n)] for i in range(len(whole))], object)
    total, k, ended = power, 0, 0
    # any power is made of the n before it (Cayley, Hamilton): n that are rounding end the series
    while ended < n:
        k += 1
        power = (whole @ power >> _FIXED) // k
        total = total + power
        ended = ended + 1 if (abs(power) <= 1).all() else 0
    back = [[mp.ldexp(mp.mpf(v), -_FIXED) for v in row] for row in total]
    return mp.matrix(back[:n]) + (mp.j * mp.matrix(back[n:]) if back[n:] else mp.zeros(n))


def without_electrode(active: Constants) -> Constants:
    """Section without electrodes: U follows from K ψ' + C U = 0."""
    with mp.workdps(DIGITS):
        return replace(active, EI=active.EI + active.K**2 / active.C, K=mp.mpf(0), C=mp.mpf(0))


@_exact
def dynamic_stiffness(beam: Constants, length: Any, omega: Any) -> mp.matrix:
    """D, 5 x 5, over [w_0, ψ_0, w_l, ψ_l, U]; forces act on the beam from outside."""
    waves = abs(beam.m * mp.mpf(omega) ** 2 / beam.EI) ** 0.25 * length
    waves = max(waves, mp.mpf(omega) * length * mp.sqrt(abs(beam.m / beam.GA)))
    doublings = max(0, int(mp.ceil(mp.log(waves / _ONE_PIECE, 2)))) if waves > 0 else 0
    d = _from_transfer(transfer(beam, mp.mpf(length) / 2**doublings, omega))
    for _ in range(doublings):
        d = join(d, d)
    return d


def _from_transfer(t: mp.matrix) -> mp.matrix:
    below, d = mp.zeros(6, 5), mp.zeros(5)  # the state at the lower end; [w, ψ] at the upper one
    below[0, 0] = below[1, 1] = below[5, 4] = 1
    motion = mp.zeros(2, 5)
    motion[0, 2] = motion[1, 3] = 1
    below[2:4, :] = mp.inverse(t[0:2, 2:4]) * (motion - t[0:2, :] * below)
    above = t[2:5, :] * below  # [M, F, q]
    d[0, :], d[1, :] = -below[3, :], -below[2, :]
    d[2, :], d[3, :], d[4, :] = above[1, :], above[0, :], above[2, :]
    return d


@_exact
def join(lower: mp.matrix, upper: mp.matrix) -> mp.matrix:
    """D of two beams end to end: equal motion, no force left over at the joint."""
    both = mp.zeros(7)  # base 2, joint 2, tip 2, U
    for block, at in ((lower, (0, 1, 2, 3, 6)), (upper, (2, 3, 4, 5, 6))):
        for i in range(5):
            for j in range(5):
                both[at[i], at[j]] += block[i, j]
    joint, ends = [2, 3], [0, 1, 4, 5, 6]
    moved = mp.inverse(_pick(both, joint, joint)) * _pick(both, joint, ends)
    return _pick(both, ends, ends) - _pick(both, ends, joint) * moved


@_exact
def tip_motion(d: mp.matrix, base: tuple[Any, Any] | None, tip: Any) -> tuple[Any, Any, Any]:
    """Tip displacement, charge and tip rotation per volt, base held (None) or sprung."""
    held = d.copy()
    held[2, 2] += mp.mpmathify(tip)
    if base is not None:
        held[0, 0] += mp.mpmathify(base[0])
        held[1, 1] += mp.mpmathify(base[1])
    free = [2, 3] if base is None else [0, 1, 2, 3]
    motion = mp.lu_solve(_pick(held, free, free), -_pick(held, free, [4]))
    charge = d[4, 4] + sum(d[4, port] * motion[i] for i, port in enumerate(free))
    return motion[free.index(2)], charge, motion[free.index(3)]


@_exact
def relative_error(value: Any, exact: Any) -> float:
    """|value − exact|/|exact| of a double, 0 for 0 against 0."""
    if exact == 0:
        return 0.0 if value == 0 else float("inf")
    return float(abs(mp.mpmathify(complex(value)) - exact) / abs(exact))


def _pick(matrix: mp.matrix, rows: Sequence[int], columns: Sequence[int]) -> mp.matrix:
    return mp.matrix([[matrix[i, j] for j in columns] for i in rows])


#: Section constants (of mpmath or as doubles) or a joint's compliance, and the length (m).
Row: TypeAlias = Sequence[tuple[Any, Any]]

#: Relative step of the secant that finds the root next to a frequency.
_STEP = mp.mpf("1e-9")


def natural_frequency(row: Row, ends: Ends, near: Any, *, open_circuit: bool) -> mp.mpf:
    """Natural frequency (Hz) next to one that is right to some nine digits.

    One secant over a step of 1e-9: what it misses is the product of step and distance.
    """
    with mp.workdps(DIGITS):
        near = mp.mpf(near)
        low, high = (
            _end_condition(row, ends, near * (1 + step), open_circuit=open_circuit)
            for step in (-_STEP, _STEP)
        )
        return near * (1 - _STEP * (high + low) / (high - low))


def offset(row: Row, ends: Ends, frequency: float, *, open_circuit: bool = False) -> float:
    """Relative distance of a frequency from the nearest root."""
    root = natural_frequency(row, ends, frequency, open_circuit=open_circuit)
    with mp.workdps(DIGITS):
        return float(mp.mpf(frequency) / root - 1)


def _end_condition(row: Row, ends: Ends, frequency: Any, *, open_circuit: bool) -> Any:
    """Determinant of [M, F] at the loaded upper end; with an open circuit of q, too."""
    omega = 2 * mp.pi * frequency
    state = mp.zeros(6, 3)
    state[5, 2] = 1
    if ends.base is None:
        state[2, 0] = state[3, 1] = 1
    else:
        state[0, 0] = state[1, 1] = 1
        state[3, 0] = mp.mpf(ends.base.lateral_stiffness)
        state[2, 1] = ends.base.rotational_stiffness - omega**2 * mp.mpf(
            ends.base.rotational_inertia
        )
    for element, length in row:
        state = _transfer(element, length, omega) * state
    load = ends.conservative_tip
    tip = load.stiffness - omega**2 * mp.mpf(load.mass)
    unknowns = 3 if open_circuit else 2
    moment, charge = ([state[k, j] for j in range(unknowns)] for k in (2, 4))
    force = [state[3, j] + tip * state[0, j] for j in range(unknowns)]
    return mp.re(mp.det(mp.matrix([moment, force, charge][:unknowns])))


def _transfer(element: Any, length: Any, omega: Any) -> mp.matrix:
    if not hasattr(element, "compliance"):
        return transfer(constants(element), length, omega)
    across = mp.eye(6)
    for i in range(2):
        for j in range(2):  # [w, ψ] jump by the compliance times [F, M]
            across[i, 3 - j] += mp.mpf(float(element.compliance[i, j]))
    return across
