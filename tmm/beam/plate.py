"""Bending of a clamped plate of layers: what a beam lacks as the width cannot curve at the clamp.

Kirchhoff's plate of the layers' laminate, clamped at z = 0 and free at its other edges, by Ritz's
method: the curvature along z is Σ a_ij P_i(s) P_j(y) with Legendre's polynomials, those across the
width even, and s such that they are denser within a width of the clamp.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre
from numpy.polynomial.legendre import leggauss, legint, legval, legvander

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import bimorph_stack
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.beam.cross_section import sheet_of
from tactgen.tmm.beam.laminate import laminate_energy
from tactgen.tmm.beam.layerwise import eigenpairs, frequencies_with_root

#: Polynomials along and across: within 1e-3 of finer ones.
_ALONG, _ACROSS = 16, 4
#: Length in half widths within which the polynomials along are about equally dense.
_ZONE = 2.0
_MODES = 5


class PlateChange(NamedTuple):
    """What a plate adds to a beam of its section, both clamped."""

    #: (6,) Logarithms of factors, see :data:`tmm.beam.calibration_fit.FACTORS`
    factors: Floats
    #: (5,) Logarithms of the beam's frequencies with these factors over the plate's
    ratios: Floats


def plate_change(device: Device, root: float, lengthwise: int) -> PlateChange:
    """Factors that give a beam the statics of a plate, and ratios of frequencies.

    The zone of the length `root` (m) next to the clamp has factors of its own.  The first
    `lengthwise` modes surely bend along the length; the ratio of the last of these goes on.
    """
    length, half = device.bimorph.length, 0.5 * device.bimorph.width
    bending, moment, capacitance, twist = _laminate(device)
    z, y = _along(np.log1p(length / (_ZONE * half))), _across()
    turned = (length / half) ** 2

    def product(along: tuple[int, int], across: tuple[int, int]) -> Floats:
        return np.kron(z.products[along], y.products[across])

    stiffness = bending[0, 0] * product((2, 2), (0, 0)) + 4.0 * twist * turned * product(
        (1, 1), (1, 1)
    )
    stiffness += bending[1, 1] * turned**2 * product((0, 0), (2, 2))
    stiffness += bending[0, 1] * turned * (product((2, 0), (0, 2)) + product((0, 2), (2, 0)))
    volt = moment[0] * np.kron(z.means[2], y.means[0])
    volt += moment[1] * turned * np.kron(z.means[0], y.means[2])
    tip = np.kron(z.tip, y.means[0])
    # a beam's own, which curves freely across
    curls = bending[0, 1] / bending[1, 1]
    own, coupling = bending[0, 0] - bending[0, 1] * curls, moment[0] - curls * moment[1]
    free = capacitance + moment[1] ** 2 / bending[1, 1] + coupling**2 / own
    by_force, by_voltage = np.linalg.solve(stiffness, np.stack([tip, volt], axis=1)).T
    near = root / length
    beyond = (1.0 - near) ** 3
    softer = (3.0 * own * tip @ by_force - beyond) / (1.0 - beyond)
    follows = 1.0
    if coupling:
        moved = own / coupling * tip @ by_voltage - 0.5 * (1.0 - near) ** 2
        follows = moved / (near * (1.0 - 0.5 * near))
    charged = (capacitance + volt @ by_voltage) / free if free else 1.0
    inverse, _ = eigenpairs(product((0, 0), (0, 0)), stiffness)
    beam = frequencies_with_root(near, softer)
    ratios = 0.5 * np.log(beam**2 * own * inverse[: -_MODES - 1 : -1])
    ratios[lengthwise:] = ratios[lengthwise - 1]
    return PlateChange(np.log([1.0, softer, 1.0, 1.0, follows, charged]), ratios)


def _laminate(device: Device) -> tuple[Floats, Floats, float, float]:
    """Constants per width, without force in the plane.

    Stiffness (2, 2) of both curvatures, moments (2,) per voltage, capacitance at no curvature, and
    stiffness of twist.
    """
    form = laminate_energy(device)
    free, kept = [0, 1], [2, 3, 4]
    follows = np.linalg.solve(form[np.ix_(free, free)], form[np.ix_(free, kept)])
    form = form[np.ix_(kept, kept)] - form[np.ix_(kept, free)] @ follows
    sums = np.zeros(3)
    for layer in bimorph_stack(device):
        low, high = layer.low, layer.high
        powers = [high - low, (high**2 - low**2) / 2.0, (high**3 - low**3) / 3.0]
        sums += layer.share * sheet_of(layer).c[3, 3] * np.array(powers)
    return form[:2, :2], -form[:2, 2], float(-form[2, 2]), float(sums[2] - sums[1] ** 2 / sums[0])


class _Line(NamedTuple):
    """Functions along a line from 0 to 1."""

    products: dict[tuple[int, int], Floats]  #: (n, n) Integrals of derivatives of both orders
    means: Floats  #: (3, n) Of the functions and their first two derivatives
    tip: Floats  #: (n,) At 1


def _line(values: Floats, weights: Floats, tip: Floats) -> _Line:
    """Line from values and derivatives (3, n, m) at points with weights (m,)."""
    orders = range(3)
    products = {(a, b): (values[a] * weights) @ values[b].T for a in orders for b in orders}
    return _Line(products, values @ weights, tip)


@cache
def _across() -> _Line:
    """Even polynomials over y from −1 to 1 (half widths), their mean taken."""
    x, weights = leggauss(2 * _ACROSS + 2)
    of = [Legendre.basis(2 * n) for n in range(_ACROSS)]
    values = np.array([[p.deriv(k)(x) if k else p(x) for p in of] for k in range(3)])
    return _line(values, 0.5 * weights, np.ones(_ACROSS))


@cache
def _points() -> tuple[Floats, Floats, Floats, Floats]:
    """Gauss points and weights (m,) over 0 to 1, and polynomials (n, m) there.

    And the matrix (m, m) that integrates from 0 on.
    """
    count = 2 * _ALONG + 8
    x, weights = leggauss(count)
    integral = legval(x, legint(np.eye(count), lbnd=-1)).T @ np.linalg.inv(legvander(x, count - 1))
    return 0.5 * (x + 1.0), 0.5 * weights, legvander(x, _ALONG - 1).T, 0.5 * integral


def _along(density: float) -> _Line:
    """Twice integrated P_i(s) over z from 0 to 1, z growing like an exponential of s."""
    s, weights, curved, integral = _points()
    faster = density * np.exp(density * s) / np.expm1(density)  # dz/ds
    turned = (curved * faster) @ integral.T
    moved = (turned * faster) @ integral.T
    return _line(np.array([moved, turned, curved]), weights * faster, turned @ (weights * faster))
