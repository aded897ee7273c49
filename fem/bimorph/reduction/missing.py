"""What functions that a solid lacks make of its ports at any frequency, by the reduced solid.

At the ports' motions the functions w see the residual r = t_w F − K x + Ω² M x, F being the tip's
efforts.  With their own stiffness they follow by e = K_w⁻¹ r, and D(Ω) changes by −r_iᵀ e_j: to
first order, as everything that is read off D does then.
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.bimorph.reduction.port_model import PortModel
from tactgen.fem.bimorph.system import Surplus
from tactgen.geometry.arrays import Floats, Numbers
from tactgen.tmm.ports.multiport import Multiport
from tactgen.tmm.ports.port import BIMORPH

#: Rows of D that are the tip's efforts.
_TIP = slice(2, 4)
#: Sign of each row of D in the symmetric system, the last being minus the charge; the stiffness
#: of potentials has the other.
_SIGNS = np.array([1.0, 1.0, 1.0, 1.0, -1.0])


def missing_products(states: Numbers, surplus: Surplus) -> Numbers:
    """Return the products r_iᵀ K_w⁻¹ r_j (2, 2 k + 8, 2 k + 8) of displacements, of potentials.

    Of K x and of M x of every unknown of a reduced solid, then of the tip's two functionals.

    Parameters
    ----------
    states : (n, k + 3) array, complex if the solid has losses
        What the solid's unknowns are per unknown of the reduced one.
    surplus : Surplus
        The functions that the solid lacks, with the losses that it has.
    """
    return np.stack(surplus.products(np.hstack([*surplus.residuals(states), surplus.tip])))


def richer_multiports(
    model: PortModel, missing: Numbers, frequencies: Floats
) -> tuple[Multiport, Multiport]:
    """Return D(Ω) (n, 5, 5) with displacements that the solid lacks; with potentials.

    Parameters
    ----------
    model : PortModel
        The reduced solid.
    missing : (2, 2 k + 8, 2 k + 8) array
        See :func:`missing_products`.
    """
    own = model.multiport(frequencies)
    held = np.zeros_like(own.stiffness)
    held[:, :3] = np.eye(5)[[0, 1, 4]]
    held[:, 3:] = own.stiffness[:, _TIP]
    x = model.states(frequencies) @ held
    omega2 = (2.0 * np.pi * own.frequencies)[:, None, None] ** 2
    r = np.concatenate([-x, omega2 * x, held[:, 3:]], axis=1)
    changes = (r.swapaxes(1, 2) @ products @ r for products in missing)
    moved, charged = (
        Multiport(own.frequencies, own.stiffness - sign[:, None] * change, BIMORPH)
        for sign, change in zip((_SIGNS, -_SIGNS), changes, strict=True)
    )
    return moved, charged
