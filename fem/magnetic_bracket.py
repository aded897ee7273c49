"""How far two potentials' fields are apart: a bound on the error of either.

A solenoidal B and an H with the right curl, of any accuracy, obey (Prager and Synge;
for magnetic fields: J. Rikabi, C. F. Bryant, E. M. Freeman, Int. J. Numer. Methods Eng.
26 (1988) 1963)

    ∫ w(B) + w'(H) − B·H dV  =  W'(H) − W'(B)  ≥ 0,

and the integrand is nowhere negative, zero only where B and H lie on the curve.  Its sum
is the width of the bracket on the co-energy; its density shows where the mesh is too coarse.
"""

from __future__ import annotations

import numpy as np

from fem.magnetic_iron import coenergy_density, energy_density
from fem.magnetic_problem import MagneticField
from geometry.arrays import Floats


def disagreement(vector: MagneticField, scalar: MagneticField) -> Floats:
    """Return ∫ w(B) + w'(H) − B·H dV (n_cells,) in J for each cell, whole device.

    Parameters
    ----------
    vector, scalar : MagneticField
        Fields from the vector and the scalar potential on one mesh at one current.
    """
    solid = vector.solid
    b, h = vector.flux_density, scalar.field_strength
    density = energy_density(solid.iron, b) + coenergy_density(solid.iron, h)
    density -= np.einsum("cqa,cqa->cq", b, h)
    return np.asarray(solid.problem.copies * np.sum(solid.weights * density, axis=1))
