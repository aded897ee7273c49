"""A reduced family on fewer shapes: those that the answers wanted of its range are made of.

A basis that serves any support and load holds more than the modes on one of them need.  The
states of some members are looked at, and the shapes kept that hold all but a little of their
energy; the residual's bound, which is of the large system, then covers both reductions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.family import ReducedFamily
from tactgen.fem.bimorph.reduction.parametric.reduced import Members, ReducedMotion
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device

#: What is looked at: displacements (n, k, m) of members in one class of motion.
States = Callable[[Motion, Members], Floats]


def compressed(
    family: ReducedFamily,
    device: Device,
    values: Mapping[str, Floats],
    states: States,
    least: float,
) -> ReducedFamily:
    """Return the family on the shapes that the states of some members are made of.

    Parameters
    ----------
    values : mapping of str to (n,) array
        Where in the range the members are.
    states : callable
        What is wanted of them.
    least : float
        Root of the share of a state's energy below which a shape is left out.
    """
    c = family.terms.coefficients(device, values)
    return replace(
        family,
        motions={
            motion: _on_fewer(reduced, reduced.members(family.terms, c), states, least)
            for motion, reduced in family.motions.items()
        },
    )


def _on_fewer(
    reduced: ReducedMotion, members: Members, states: States, least: float
) -> ReducedMotion:
    wanted = states(reduced.motion, members)
    # the basis is orthonormal in the energy of the undivided member
    wanted = wanted / np.linalg.norm(wanted, axis=1, keepdims=True)
    follows, per_volt = reduced.potentials(members.coefficients)
    field = follows @ wanted
    if per_volt.shape[2]:
        size = np.linalg.norm(per_volt, axis=1, keepdims=True)
        field = np.concatenate([field, per_volt / np.where(size > 0.0, size, 1.0)], axis=2)
    return reduced.projected(_shapes(wanted, least), _shapes(field, least))


def _shapes(columns: Floats, least: float) -> Floats:
    """Return orthonormal shapes (k, l) that hold columns (n, k, m) up to a root of energy."""
    flat = np.moveaxis(columns, 1, 0).reshape(columns.shape[1], -1)
    energies, shapes = np.linalg.eigh(flat @ flat.T)
    return np.asarray(shapes[:, energies > least**2])
