"""The coil over one step: pull and current that keep the field's energy balance, to rounding.

O. Gonzalez, Time integration and discrete Hamiltonian systems, J. Nonlinear Sci. 6 (1996) 449:
the trapezoidal mean of a gradient plus the least correction after which gradient times change is
the change of the potential.  The potential is W' over (i, g) where the current is prescribed, and
the stored energy W = iλ − W' over (λ, g) where the voltage is: their gradients are (λ, −F) and
(i, F).
"""

from __future__ import annotations

from typing import NamedTuple

from tactgen.tmm.reluctance.coenergy.cells import CoenergyPoint

#: Below this square of the relative change no correction is made: the mean's own error, of third
#: order, is then 1e-15 of the energy, and the correction would be made of rounding.
_STILL = 1e-10


class Means(NamedTuple):
    """Pull (N), current (A) and the source's work (J) over a step."""

    pull: float
    current: float
    work: float


def held_current(
    i0: float, g0: float, p0: CoenergyPoint, i1: float, g1: float, p1: CoenergyPoint, width: float
) -> Means:
    """Return the means between two states of which the currents are given.

    `width` (m) is the gap that the whole circuit is worth.  The work is ∫ i dλ.
    """
    di, dg = i1 - i0, g1 - g0
    pull = 0.5 * (p0.force + p1.force)
    linkage = 0.5 * (p0.flux_linkage + p1.flux_linkage)
    current = 0.5 * (i0 + i1)
    # relative changes of current and gap
    size = max(abs(i0), abs(i1))
    ci = di / size if size > 0.0 else 0.0
    cg = dg / width
    s = ci * ci + cg * cg
    work = current * (p1.flux_linkage - p0.flux_linkage)
    if s > _STILL:
        short = (p1.coenergy - p0.coenergy - linkage * di + pull * dg) / s
        pull -= short * cg / width
        work -= short * ci * ci
    return Means(pull, current, work)


def held_linkage(
    i0: float, g0: float, p0: CoenergyPoint, i1: float, g1: float, p1: CoenergyPoint, width: float
) -> Means:
    """Return the means between two states whose flux linkages are those of the points.

    The work is what goes into the field and the mechanics: mean current times change of λ.
    """
    dl, dg = p1.flux_linkage - p0.flux_linkage, g1 - g0
    pull = 0.5 * (p0.force + p1.force)
    current = 0.5 * (i0 + i1)
    size = max(abs(p0.flux_linkage), abs(p1.flux_linkage))
    cl = dl / size if size > 0.0 else 0.0
    cg = dg / width
    s = cl * cl + cg * cg
    if s > _STILL:
        stored = i1 * p1.flux_linkage - i0 * p0.flux_linkage - (p1.coenergy - p0.coenergy)
        short = (stored - current * dl - pull * dg) / s
        pull += short * cg / width
        if size > 0.0:
            current += short * cl / size
    return Means(pull, current, current * dl)
