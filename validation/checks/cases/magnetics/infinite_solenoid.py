"""An infinitely long thick solenoid, empty or with an iron core: Ampère's law is the answer.

H = J (r2 − r) in the winding, J (r2 − r1) inside it, whatever the iron; the profile of
the ANSYS verification manual's VM172.
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import MagneticField, solve_field
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.steel_law import MU0, MagnetisationCurve
from tactgen.geometry.reluctance.section_grid import Grid, Region
from tactgen.validation.checks.cases.fineness import counted, degree

#: Radii of the winding and of the core (m).
INNER, OUTER, CORE = 10e-3, 20e-3, 8e-3
_HEIGHT = 5e-3
#: u has a term 1/r² outside the bore.  In the cell where that is worst, 10 to 12.5 mm, its pole
#: lies 9 half widths from the middle: polynomials gain 9 + √80 ≈ 18 per degree, B loses one.
SOLENOID_ERROR = 18.0**-5


def infinite_solenoid(
    density: float, core: MagnetisationCurve | None = None, order: int = 6
) -> MagneticField:
    """Return the field of the winding carrying `density` (A/m²).

    All sides are left open for tangential H = 0: exact outside an infinite solenoid.
    """
    parts = [Region("winding", (INNER, OUTER), (0.0, _HEIGHT), turns=1.0)]
    if core:
        parts.append(Region("core", (0.0, CORE), (0.0, _HEIGHT), core))
    spans = ((0.0, CORE), (CORE, INNER), (INNER, OUTER), (OUTER, 1.5 * OUTER))
    r = np.unique(np.concatenate([np.linspace(a, b, 5) for a, b in spans]))
    grid = Grid(r, np.array([0.0, _HEIGHT]), tuple(parts))
    d = discretise(grid, degree(order), closed=())
    counted(d.size)
    return solve_field(d, np.array([density * (OUTER - INNER) * _HEIGHT]))


def exact_profile(density: float, radii: Floats) -> Floats:
    """Return B_z (T) of the empty solenoid."""
    return np.asarray(MU0 * density * np.clip(OUTER - radii, 0.0, OUTER - INNER))


def flux_density_in_core(field: MagneticField) -> Floats:
    """Return B_z (n_e, n_q) in the cells of the core (T)."""
    return np.asarray(field.flux_density[..., 1][field.discretisation.cell_labels == 1])


def core_tolerance(core: MagnetisationCurve) -> float:
    """Return how far B in the core may be off, relative.

    The flux's error is the square of the field's, weighed by the core's permeability; the
    second term is the tolerance of Newton's method.
    """
    largest = 1.0 / (MU0 * float(core.reluctivity(np.linspace(0.0, 2.0, 200)).min()))
    return 4.0 * largest * SOLENOID_ERROR**2 + 1e-8
