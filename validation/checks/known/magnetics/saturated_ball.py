"""A ball of saturating steel in a uniform field: B inside is uniform whatever the law.

What is uniform inside leaves a dipole outside, as of a linear ball: with q = (R/R₀)³,

    H₀ = (B/µ0 + 2 H(B))/3 − (B/µ0 − H(B)) q/3,

where φ = −H₀ z is held on a concentric sphere of radius R₀ (J. A. Stratton, Electromagnetic
Theory, 1941, section 4.18, with that outer condition).
"""

from __future__ import annotations

from functools import partial

import numpy as np

from tactgen.fem.magnetics.scalar_potential import ScalarPotential
from tactgen.fem.magnetics.vector_potential import VectorPotential
from tactgen.geometry.device.steel_law import MU0, TEAM20
from tactgen.validation.checks.case import Answer, Case, case
from tactgen.validation.checks.cases.fineness import cached, counted, intervals
from tactgen.validation.checks.cases.magnetics.sphere_in_field import Potential, sampled_ball
from tactgen.validation.checks.cases.magnetics.sphere_mesh import OUTER, RADIUS
from tactgen.validation.checks.drawings.bodies import in_uniform_field

#: Of the field far away (A/m): 2.17 T in the ball, where the steel's µr has fallen to 25.
_FIELD = 600e3


def _exact() -> float:
    """Return B in the ball (T)."""
    from scipy.optimize import brentq

    share = (RADIUS / OUTER) ** 3 / 3.0

    def missing(b: float) -> float:
        h = float(TEAM20.field_strength(np.array(b)))
        return (b / MU0 + 2.0 * h) / 3.0 - (b / MU0 - h) * share - _FIELD

    return float(brentq(missing, 1e-6, 10.0, xtol=1e-15))


@cached
def _mean(potential: Potential) -> float:
    """Return the mean of B_z in the ball (T), three intervals along an edge."""
    solid = sampled_ball(intervals(3, least=1), TEAM20)
    solver = potential(solid)
    counted(solver.size)
    field = solver.solve(_FIELD)
    cells = solid.problem.mesh.cells_of("ball")
    weights = solid.weights[cells]
    return float(np.sum(weights * field.flux_density[cells][..., 2]) / weights.sum())


CASES: tuple[Case, ...] = (
    case(
        "SATBALL",
        "Ball of saturating steel in a uniform field",
        "Radius 1, the steel of TEAM problem 20, φ = −H₀ z on a concentric sphere of radius 3, "
        "H₀ = 600 kA/m: the mean of B in the ball.",
        model="vector and scalar potential, quadratic tetrahedra, three intervals along an edge, "
        "Newton's method",
        source="J. A. Stratton, Electromagnetic Theory, 1941, section 4.18: what is uniform inside "
        "leaves a dipole outside, whatever the law; here closed by the outer sphere",
        tolerance=1e-3,
        reason="three intervals per edge leave 4e-3 locally, most of which averages out",
        answers=[
            Answer(f"B by the {words} is that of the dipole.", _exact(), "T",
                   partial(_mean, potential),
                   heavy=potential is VectorPotential)
            for potential, words in (
                (VectorPotential, "vector potential"), (ScalarPotential, "scalar potential"),
            )
        ],
        setup=in_uniform_field,
    ),
)  # fmt: skip
