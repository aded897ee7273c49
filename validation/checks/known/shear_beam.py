"""A sandwich that bends because a patch in its core is sheared, as public programs model it."""

from __future__ import annotations

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.geometry.device.material_library import LIBRARY
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.validation.checks.case import Answer, Case, case
from tactgen.validation.checks.cases.boxes import Box, Held, Where, graded, statics
from tactgen.validation.checks.drawings.sections import section
from tactgen.validation.checks.known.resonators import poled

_LOW, _HIGH, _PATCH = 8e-3, 10e-3, (55e-3, 65e-3)


def _beam() -> Box:
    """Return half of the beam: x through the layers, z along it."""
    metal = Material(isotropic_stiffness(70e9, 0.33), 2700.0)
    foam = Material(isotropic_stiffness(35.3e6, 0.383), 32.0)
    z = np.array([0, 2, 10, 30, 50, 54, 55, 56, 60, 64, 65, 66, 70, 85, 100]) * 1e-3
    first, last = (int(np.flatnonzero(z == at)[0]) for at in _PATCH)
    all_along = (0, z.size - 1)
    return Box(
        graded([0.0, _LOW, _HIGH, 18e-3], 3),
        graded([0.0, 7.5e-3, 14e-3, 15e-3], 3),
        graded(z, 3),
        (
            (Slab("metal", (0, 1), all_along), metal),
            (Slab("metal", (2, 3), all_along), metal),
            (Slab("foam", (1, 2), (0, first)), foam),
            (Slab("piezo", (1, 2), (first, last)), poled(LIBRARY["PZT-5H"], "z")),
            (Slab("foam", (1, 2), (last, z.size - 1)), foam),
        ),
        (
            Held(Where(z=0.0), ("x", "y", "z")),
            Held(Where(y=0.0), ("y",)),
            Held(Where(x=_LOW, z=_PATCH), ("phi",)),
            Held(Where(x=_HIGH, z=_PATCH), ("phi",), 20.0),
        ),
    )


def _tip() -> float:
    """Return how far (m) the tip's upper face has moved."""
    return abs(statics(_beam()).mean(Where(x=18e-3, z=0.1), "x"))


CASES: tuple[Case, ...] = (
    case(
        "SHEAR",
        "Sandwich with a patch in shear (COMSOL's shear bender)",
        "100 x 30 x 18 mm: aluminium of 8 mm (70 GPa, ν = 0.33) on both sides of a core of 2 mm, "
        "of foam (35.3 MPa, ν = 0.383) but for PZT-5H poled along the beam from 55 to 65 mm; one "
        "end held, 20 V across the patch.",
        model="bricks of the model solid, degree 3, graded towards the patch's ends",
        source="the shear bender of COMSOL's application library, as arXiv 2110.11834 gives it",
        tolerance=5e-3,
        reason="the field is singular at the patch's ends and the published mesh is not stated: "
        "quadratic bricks on this one give 0.5 % more than these cubic ones",
        answers=[Answer("The tip moves by 82.965 nm.", 82.965e-9, "m", _tip)],
        setup=section(_beam),
    ),
)  # fmt: skip
