"""Joining elements end to end without losing digits, in wave variables.

A thousandth of a beam is 10⁹ times stiffer than the beam: in its dynamic stiffness the
inertia stands in the tenth digit, and the whole row's compliance is the last digits of a
difference.  Transfer matrices keep both, but grow like cosh λ.  Wave variables keep both and
stay bounded.
With forces f on the element and displacements u, each in units of a reference stiffness Z,

    a = f + j u (incoming),   b = f − j u (outgoing),    [b_0, b_1, Q] = S [a_0, a_1, U].

A vanishing element only passes the waves on, b_0 = −a_1 and b_1 = −a_0; X is what S adds to
that, small for a short element.  S of a lossless one is unitary at any frequency and length,
and two elements are joined by Redheffer's star product (1962), here of X, whose one linear
solve is about the identity.  So it takes a few roundings to join a thousand elements.

Reference: M in units of EI κ, w of s/κ, F of EI κ²/s, with the EI of the softest element and
κ the largest wavenumber of the row (at least 1/length of the row), at each frequency.  s is 1
but where shear is softer than bending over 1/κ, s² = EI κ²/GA > 1: w is then measured against
GA κ instead of EI κ³, beside which it would have no digit left in a row as stubby as s² = 10⁵.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.tmm.beam.sections import Joint, Section
from tactgen.tmm.beam.span import dynamic_stiffness, wavenumbers


def neighbours(order: list[int]) -> tuple[list[int], list[int], list[int], list[int]]:
    """Neighbouring pairs in a row of numbers; equal pairs count once.

    Returns
    -------
    lower, upper : list of int
        Numbers of the two things of each different pair.
    left_over : list of int
        The last one of an odd row.
    order : list of int
        The shorter row, numbered by pairs, then what is left over.
    """
    pairs = list(zip(order[::2], order[1::2], strict=False))
    place = {pair: i for i, pair in enumerate(dict.fromkeys(pairs))}
    lower, upper = (list(side) for side in zip(*place, strict=True))
    left_over = order[2 * len(pairs) :]
    return lower, upper, left_over, [place[p] for p in pairs] + [len(place)] * len(left_over)


def tree(made: Complex, order: list[int]) -> Complex:
    """Join (k, n, 5, 5) in the given order: neighbours, then pairs of neighbours, and so on."""
    while len(order) > 1:
        lower, upper, left_over, order = neighbours(order)
        made = np.concatenate([star(made[lower], made[upper]), made[left_over]])
    return np.asarray(made[order[0]])


def star(lower: Complex, upper: Complex) -> Complex:
    """X (..., 5, 5) of two elements joined: both see the same U, charges add.

    At the joint a of one end is −b of the other: forces cancel, displacements agree.  The
    wave up out of the lower element is −a_0 + up, the one down into it a_1 + down:

        up = X_10 a_0 + R_1 (a_1 + down) + s_1 U,   down = R_0 (up − a_0) − X_01 a_1 − s_0 U,

    R_1, s_1, X_10 of the lower element's upper end and R_0, s_0, X_01 of the upper's lower.
    """
    below, above = lower[..., 2:4, :], upper[..., :2, :]
    back, reflected = below[..., 2:4], above[..., :2]
    # what enters the waves at the joint without `up`: columns a_0, a_1, U
    entering = -above
    right = below + back @ entering
    up = np.linalg.solve(np.eye(2) - back @ reflected, right)
    down = entering + reflected @ up
    s = lower + upper
    s[..., :2, :] = lower[..., :2, :] - down + lower[..., :2, 2:4] @ down
    s[..., 2:4, :] = upper[..., 2:4, :] + up - upper[..., 2:4, :2] @ up
    s[..., 4, :] += (lower[..., 4:5, 2:4] @ down - upper[..., 4:5, :2] @ up)[..., 0, :]
    return s


#: A beam of a length (m), or a joint with length 0.
Element: TypeAlias = tuple[Section | Joint, Any]

#: Longest element, in radians of its own shortest wave, that is taken by power series (15
#: terms then leave 1e-17); a longer one's dynamic stiffness holds its digits.
_SERIES_WAVES = 0.5
_SERIES_TERMS = 15
#: Elements times frequencies held in memory at once.
_AT_ONCE = 20_000

#: S of an element without length: b_0 = −a_1, b_1 = −a_0.
THROUGH = -np.eye(4, 5)[[2, 3, 0, 1]]


@dataclass(frozen=True)
class Reference:
    """Units of the wave variables: EI (n,) in N m², κ (n,) in 1/m, s (n,) without unit."""

    stiffness: Floats
    wavenumber: Floats
    slide: Floats

    def units(self) -> tuple[Floats, Floats]:
        """Units of [w, ψ] and of [F, M], (n, 2) each."""
        kappa, one = self.wavenumber, np.ones_like(self.wavenumber)
        force = np.stack([kappa**2 / self.slide, kappa], axis=1) * self.stiffness[:, None]
        return np.stack([self.slide / kappa, one], axis=1), force

    def at(self, points: Any) -> Reference:
        """Reference at some of the points."""
        return Reference(self.stiffness[points], self.wavenumber[points], self.slide[points])


@dataclass(frozen=True)
class _Stack:
    """Elements by kind with their places: compliances (n, 2, 2), beams' constants (k, n)."""

    joints_at: list[int]
    compliances: list[Floats]
    beams_at: list[int]
    beams: Section
    lengths: Any


def joined(row: Sequence[Element], omega: Floats) -> Complex:
    """D(Ω) (n, 5, 5) of elements joined end to end; see :mod:`tmm.ports.multiport`.

    Parameters
    ----------
    row : sequence of (Section or Joint, length)
        From base to tip; constants and lengths (m) are numbers, or arrays (n,).  An entry
        that stands in the row more than once, as the same object, is worked out once.
    omega : (n,) array
        Angular frequencies (rad/s), 0 included.
    """
    if len(row) == 1:
        return element_stiffness(*row[0], omega)
    entries, order = _different(row)
    stack = _stacked(entries, omega.size)
    reference = _reference(row, stack, omega)
    d = np.empty((omega.size, 5, 5), dtype=complex)
    size = max(1, _AT_ONCE // len(entries))
    for first in range(0, omega.size, size):
        part = slice(first, first + size)
        made = _scattering(stack, part, omega[part], reference.at(part))
        d[part] = _stiffness(tree(made, order), reference.at(part))
    if not any(np.iscomplexobj(v) for e, length in entries for v in (length, *vars(e).values())):
        d.imag = 0.0  # a lossless row: what is left there is rounding
    return d


def in_waves(
    row: Sequence[Element], omega: Floats, unit: float = 1.0
) -> tuple[Complex, list[int], Reference]:
    """X (k, n, 5, 5) of the k different entries of a row, its order and its reference.

    The row, see :func:`joined`, is entries `order[0]`, `order[1]` and so on.  Its reference
    stiffness is `unit` times the usual one.
    """
    entries, order = _different(row)
    stack = _stacked(entries, omega.size)
    usual = _reference(row, stack, omega)
    reference = Reference(unit * usual.stiffness, usual.wavenumber, usual.slide)
    return _scattering(stack, slice(None), omega, reference), order, reference


def element_stiffness(element: Section | Joint, length: Any, omega: Floats) -> Complex:
    """D(Ω) (n, 5, 5) of one element."""
    if isinstance(element, Section):
        return dynamic_stiffness(element, length, omega)
    d = np.zeros((omega.size, 5, 5), dtype=complex)
    k = np.linalg.inv(element.compliance)
    d[:, :2, :2] = d[:, 2:4, 2:4] = k
    d[:, :2, 2:4] = d[:, 2:4, :2] = -k
    return d


def scattering(beam: Section, length: Any, omega: Floats, reference: Reference) -> Complex:
    """X (n, 5, 5) of n beams: outgoing waves and charge from incoming and U.

    Constants and lengths are (n,) arrays.
    """
    units = _state_units(reference)
    system = _system(beam, omega) / units[:, :, None] * units[:, None, :]
    system *= length[:, None, None]
    short = np.abs(wavenumbers(beam, length, omega)).max(axis=0) < _SERIES_WAVES
    long = ~short
    s = np.empty((omega.size, 5, 5), dtype=complex)
    if short.any():
        charge = beam.K[short], (beam.C * length)[short]
        s[short] = _from_transfer(_exponential_less_one(system[short]), *charge)
    if long.any():
        part = Section(*(getattr(beam, f.name)[long] for f in fields(beam)))
        stiffness = dynamic_stiffness(part, length[long], omega[long])
        s[long] = _from_stiffness(stiffness, reference.at(long))
    return s


def _different(row: Sequence[Element]) -> tuple[list[Element], list[int]]:
    """Entries that differ as objects, and the place of each of the row's among them."""
    entries = {id(entry): entry for entry in row}
    place = {key: i for i, key in enumerate(entries)}
    return list(entries.values()), [place[id(entry)] for entry in row]


def _stacked(entries: Sequence[Element], n: int) -> _Stack:
    """Different elements by kind, their constants along n points."""
    beams = [i for i, (element, _) in enumerate(entries) if isinstance(element, Section)]
    joints = {i: e.compliance for i, (e, _) in enumerate(entries) if isinstance(e, Joint)}

    def along(constants: list[Any]) -> Any:
        if all(np.ndim(c) == 0 for c in constants):
            return np.broadcast_to(np.array(constants)[:, None], (len(constants), n))
        return np.stack([np.broadcast_to(c, n) for c in constants])

    return _Stack(
        list(joints),
        [np.broadcast_to(compliance, (n, 2, 2)) for compliance in joints.values()],
        beams,
        Section(*(along([getattr(entries[i][0], f.name) for i in beams]) for f in fields(Section))),
        along([entries[i][1] for i in beams]),
    )


def _scattering(stack: _Stack, part: slice, omega: Floats, reference: Reference) -> Complex:
    """X (k, n, 5, 5) of k elements at a part of the points, all beams in one go."""
    count = len(stack.beams_at)
    s = np.empty((count + len(stack.joints_at), omega.size, 5, 5), dtype=complex)
    units = _state_units(reference)
    for i, compliance in zip(stack.joints_at, stack.compliances, strict=True):
        # T − 1: the change of [w, ψ, F, M, U] from base to tip, per its value there
        t: Complex = np.zeros((omega.size, 5, 5), dtype=complex)
        t[:, :2, 2:4] = compliance[part]
        nothing = np.zeros(omega.size)
        s[i] = _from_transfer(t / units[:, :, None] * units[:, None, :], nothing, nothing)
    beams = Section(*(getattr(stack.beams, f.name)[:, part].ravel() for f in fields(Section)))
    many = Reference(*(np.tile(getattr(reference, f.name), count) for f in fields(Reference)))
    made = scattering(beams, stack.lengths[:, part].ravel(), np.tile(omega, count), many)
    s[stack.beams_at] = made.reshape(count, -1, 5, 5)
    return s


def _reference(row: Sequence[Element], stack: _Stack, omega: Floats) -> Reference:
    total = np.abs(sum(length for _, length in row))
    waves = np.abs(wavenumbers(stack.beams, 1.0, omega)).max(axis=(0, 1))
    stiffness, kappa = np.abs(stack.beams.EI).min(axis=0), np.maximum(waves, 1.0 / total)
    against_shear = kappa * np.sqrt(stiffness / np.abs(stack.beams.GA).min(axis=0))
    return Reference(stiffness, kappa, np.maximum(against_shear, 1.0))


def _state_units(reference: Reference) -> Floats:
    """Units of [w, ψ, F, M, U] (n, 5); the voltage stays in volts."""
    displacement, force = reference.units()
    return np.concatenate([displacement, force, np.ones((force.shape[0], 1))], axis=1)


def _system(beam: Section, omega: Floats) -> Complex:
    """A (n, 5, 5) of d/dz [w, ψ, F, M, U] = A [w, ψ, F, M, U]."""
    o2 = omega**2
    a = np.zeros((omega.size, 5, 5), dtype=complex)
    a[:, 0, 1], a[:, 0, 2] = -1.0, 1.0 / beam.GA  # w' = −ψ + F/GA
    a[:, 1, 3], a[:, 1, 4] = 1.0 / beam.EI, beam.K / beam.EI  # ψ' = (M + K U)/EI
    a[:, 2, 0] = -beam.m * o2  # F' = −m Ω² w
    a[:, 3, 1], a[:, 3, 2] = -beam.rhoI * o2, 1.0  # M' = F − ρI Ω² ψ
    return a


def _exponential_less_one(a: Complex) -> Complex:
    """Exp(a) − 1 (n, 5, 5) by Horner's scheme; every entry is led by its first term."""
    one = np.eye(5)
    out: Complex = np.broadcast_to(one, a.shape).astype(complex)
    for n in range(_SERIES_TERMS, 1, -1):
        out = one + (a / n) @ out
    return np.asarray(a @ out)


def _from_transfer(e: Complex, coupling: Numbers, capacitance: Numbers) -> Complex:
    """X from T − 1 in reference units; charge = coupling (ψ_1 − ψ_0) + capacitance U.

    From a_1 = r_1 + j u_1 and b_1 = r_1 − j u_1, r_0 = −(a_0 + b_0)/2, u_0 = (a_0 − b_0)/2j,
    with b_0 = −a_1 + x, b_1 = −a_0 + y.
    """
    plus, minus = (e[:, 2:4] + sign * 1j * e[:, :2] for sign in (1.0, -1.0))
    # shares of a_0 and b_0 in the upper end's waves, less those of a vanishing element
    (in_a, in_b), (out_a, out_b) = (
        (-0.5 * (1j * w[:, :, :2] + w[:, :, 2:4]), 0.5 * (1j * w[:, :, :2] - w[:, :, 2:4]))
        for w in (plus, minus)
    )
    n = e.shape[0]
    right = np.concatenate([in_a, -in_b, plus[:, :, 4:]], axis=2)
    s = np.zeros((n, 5, 5), dtype=complex)
    s[:, :2] = np.linalg.solve(np.eye(2) - in_b, right)
    s[:, 2:4] = out_b @ s[:, :2]
    s[:, 2:4, :2] += out_a
    s[:, 2:4, 2:4] -= out_b
    s[:, 2:4, 4] += minus[:, :, 4]
    s[:, 4] = coupling[:, None] * -0.5j * (s[:, 1] - s[:, 3])  # ψ_1 − ψ_0 = (x − y)/2j
    s[:, 4, 4] += capacitance
    return s


def _from_stiffness(d: Complex, reference: Reference) -> Complex:
    """X from D: u = (D + j)⁻¹ (a − D_U U), b = a − 2 j u, Q = D_Q u + C U."""
    displacement, force = (np.tile(unit, 2) for unit in reference.units())
    scaled = d.copy()
    scaled[:, :4] /= force[:, :, None]
    scaled[:, :, :4] *= displacement[:, None, :]
    n = d.shape[0]
    right = np.zeros((n, 4, 5), dtype=complex)
    right[:, :, :4], right[:, :, 4] = np.eye(4), -scaled[:, :4, 4]
    u = np.linalg.solve(scaled[:, :4, :4] + 1j * np.eye(4), right)
    s = np.empty((n, 5, 5), dtype=complex)
    s[:, :4] = np.eye(4, 5) - THROUGH - 2j * u
    s[:, 4] = (scaled[:, 4:5, :4] @ u)[:, 0]
    s[:, 4, 4] += scaled[:, 4, 4]
    return s


def _stiffness(s: Complex, reference: Reference) -> Complex:
    """D from X: (1 − S) a = 2 j u + S_U U, f = a − j u."""
    displacement, force = (np.tile(unit, 2) for unit in reference.units())
    n = s.shape[0]
    one = np.eye(4)
    right = np.zeros((n, 4, 5), dtype=complex)
    right[:, :, :4], right[:, :, 4] = 2j * one, s[:, :4, 4]
    a = np.linalg.solve(one - THROUGH[:, :4] - s[:, :4, :4], right)
    d = np.empty((n, 5, 5), dtype=complex)
    d[:, :4] = a
    d[:, :4, :4] -= 1j * one
    d[:, 4] = (s[:, 4:5, :4] @ a)[:, 0]
    d[:, 4, 4] += s[:, 4, 4]
    d[:, :4] *= force[:, :, None]
    d[:, :, :4] /= displacement[:, None, :]
    return d
