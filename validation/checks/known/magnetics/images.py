"""A ring winding above a half-space of iron, by its image: inductance, and the pull on the iron.

The field of a filament at a height h above µr is its own and that of an image at −h, of
(µr − 1)/(µr + 1) times its current.
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import MagneticField, solve_field
from tactgen.fem.magnetics.axisymmetric_force import virtual_work_force
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.geometry.device.steel_law import linear
from tactgen.geometry.reluctance.section_grid import Region, graded_grid
from tactgen.validation.checks.case import Answer, Case, case
from tactgen.validation.checks.cases.fineness import cached, counted, degree
from tactgen.validation.checks.cases.magnetics.coaxial_coils import (
    between_windings,
    mutual_inductance,
    mutual_inductance_slope,
)
from tactgen.validation.checks.drawings.bodies import rings

#: Radii of the ring's section (m), its height above the iron, half its own height; permeability.
_RADII, _ABOVE, _HALF, _PERMEABILITY = (0.19, 0.21), 0.05, 0.01, 1000.0
#: Radius of the box (m): a hundred of the ring.
_WALLS = 20.0
_SHARE = (_PERMEABILITY - 1.0) / (_PERMEABILITY + 1.0)


def _ring(height: float = _ABOVE) -> Region:
    return Region("ring", _RADII, (height - _HALF, height + _HALF), turns=1.0, moves=True)


def _below(permeability: float, extent: float = _WALLS) -> Region:
    return Region("iron", (0.0, extent), (-extent, 0.0), linear(permeability))


@cached
def _solved(permeability: float) -> MagneticField:
    """Return the field of 1 A above a body of this permeability, 1 for none."""
    regions = (_ring(), _below(permeability))
    space = discretise(graded_grid(regions, _WALLS, refinement=2.0), degree(4))
    counted(space.size)
    return solve_field(space, np.array([1.0]))


def _gained() -> float:
    """Return by how much the iron raises the ring's inductance (H), on one grid."""
    above, alone = (float(_solved(mu).flux_linkage[0]) for mu in (_PERMEABILITY, 1.0))
    return above - alone


CASES: tuple[Case, ...] = (
    case(
        "IMAGE",
        "Ring winding above a half-space of iron",
        "One turn of 1 A on a section of 20 x 20 mm, mean radius 0.2 m, its middle 50 mm above "
        "iron of µr = 1000.",
        model="axisymmetric field, quadrilaterals of order 4 on a graded grid, walls at a hundred "
        "radii",
        source="image current (µr − 1)/(µr + 1) (J. D. Jackson, Classical Electrodynamics, 3rd "
        "ed., ch. 5), by Maxwell's elliptic integrals over both sections",
        tolerance=1e-5,
        reason="the mesh and walls at a hundred radii, 2e-6 each",
        answers=[
            Answer("The iron adds the image's mutual inductance.",
                   _SHARE * between_windings(_ring(-_ABOVE), _ring(), mutual_inductance), "H",
                   _gained),
            Answer("The iron pulls as the image does.",
                   _SHARE * between_windings(_ring(-_ABOVE), _ring(), mutual_inductance_slope),
                   "N", lambda: virtual_work_force(_solved(_PERMEABILITY))),
        ],
        setup=lambda: rings((_ring(), _below(_PERMEABILITY, 0.3))),
    ),
)  # fmt: skip
