"""TEAM Workshop problem 20 (COMPUMAG), "3-D static force problem": geometry, coil, mesh.

A steel pole hangs in the window of a steel yoke, inside a coil; the force that pulls it
down was measured.  Dimensions in mm, z up, symmetric in x and y:

    yoke    127 x 25 x 150 (x, y, z), z from 0; window |x| < 38.5, 25 < z < 125;
            slot |x| < 13.5 through the top
    pole    25 x 10, z from 26.5 to 125: a gap of 1.5 below
    coil    round corners, inside 39 x 39 (radius 5), outside 75 x 75 (radius 23),
            z from 26.7 to 123.3

Dimensions are those of the definition on compumag.org ("problem20"); the measured forces
are table 6, the measured flux densities table 4 of N. Takahashi, T. Nakata, H. Morishige,
COMPEL 14 (1995) 57.  All are taken as restated in the validation case of the public
repository Raiden-Numerics/mufem-examples, which gives them alike.  The steel is
:data:`geometry.device.magnetisation.TEAM20`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, graded_planes

#: Ampere-turns at which the force was measured, and that force (N), downwards.
MEASURED_FORCE = {1000.0: 8.1, 3000.0: 54.4, 4500.0: 75.0, 5000.0: 80.1}

#: Vertical flux density (T) measured at those: at the two points, then the means over a section
#: of the pole and of one leg of the yoke.
MEASURED_FLUX_DENSITY = {
    1000.0: (0.36, 0.24, 0.72, 0.13),
    3000.0: (0.84, 0.63, 1.75, 0.36),
    4500.0: (0.99, 0.72, 2.01, 0.43),
    5000.0: (1.03, 0.74, 2.05, 0.46),
}
#: The points (m), half way across the gap: below the pole's centre, and below its corner, where
#: the field is steep.
PROBES = ((0.0, 0.0, 25.75e-3), (12.5e-3, 5e-3, 25.75e-3))
#: Height (m) at which the mean flux density of pole and yoke was measured, and the quarter of
#: the sections there (x and y from, to, in m): all of the pole's, one leg's of the yoke.
HALF_WAY_UP = 75e-3
POLE_SECTION = ((0.0, 12.5e-3), (0.0, 5e-3))
LEG_SECTION = ((38.5e-3, 63.5e-3), (0.0, 12.5e-3))

_MM = 1e-3
POLE = (12.5, 5.0, 26.5, 125.0)  # half widths in x and y, bottom, top
YOKE = (63.5, 12.5, 0.0, 150.0)
WINDOW = (38.5, 25.0, 125.0)  # half width, bottom, top
SLOT = 13.5
COIL_BOTTOM, COIL_TOP = 26.7, 123.3
INSIDE, OUTSIDE = 19.5, 37.5  # half widths of the coil
_INNER_RADIUS, _OUTER_RADIUS = 5.0, 23.0
_CENTRE = INSIDE - _INNER_RADIUS  # of the round corners, in x and in y

_REGIONS = ("pole", "yoke", "coil", "shell", "air")


@dataclass(frozen=True)
class Team20Meshing:
    """Mesh settings of a quarter of the problem."""

    #: Factor on all interval lengths and on their growth away from the steel's edges
    scale: float = 1.0
    #: Where the outer walls are (m from the origin; the same above and below the yoke)
    far: float = 0.3


def team20_mesh(meshing: Team20Meshing) -> Mesh:
    """Quarter (x ≥ 0, y ≥ 0) with regions pole, yoke, coil, shell and air.

    ``shell`` is the air around the pole, within the window and the slot: it has no current
    and :func:`team20_source` vanishes there.  ``coil`` has all boxes that the coil reaches
    into; its round corners are in the source, not in the mesh.
    """
    f, far = meshing.scale, meshing.far / _MM

    def planes(*stops: tuple[float, float]) -> Floats:
        return graded_planes([(at, f * size) for at, size in stops], growth=f)

    # fine where two witnesses of the field disagree most: around the pole's edges
    x = planes(
        (0.0, 6.0), (POLE[0], 0.8), (SLOT, 0.8), (INSIDE, 8.0), (OUTSIDE, 20.0),
        (WINDOW[0], 20.0), (YOKE[0], 25.0), (far, 200.0),
    )  # fmt: skip
    y = planes(
        (0.0, 2.5), (POLE[1], 0.7), (YOKE[1], 8.0), (INSIDE, 12.0), (OUTSIDE, 20.0),
        (far, 200.0),
    )  # fmt: skip
    z = planes(
        (-far, 200.0), (YOKE[2], 20.0), (WINDOW[1], 0.8), (POLE[2], 0.8), (COIL_BOTTOM, 0.8),
        (COIL_TOP, 1.5), (POLE[3], 0.4), (YOKE[3], 25.0), (YOKE[3] + far, 200.0),
    )  # fmt: skip
    mid = np.meshgrid(*(0.5 * (v[1:] + v[:-1]) for v in (x, y, z)), indexing="ij")
    region = np.full(mid[0].shape, _REGIONS.index("air"))
    wide = np.maximum(mid[0], mid[1])
    heights = (mid[2] > WINDOW[1]) & (mid[2] < YOKE[3])
    region[heights & (wide < INSIDE)] = _REGIONS.index("shell")
    # the box in the round corner is partly coil
    reach = _distance(x[1:, None], y[None, 1:])[..., None] > _INNER_RADIUS * (1.0 + 1e-9)
    inside = (mid[2] > COIL_BOTTOM) & (mid[2] < COIL_TOP)
    region[inside & reach & (wide < OUTSIDE)] = _REGIONS.index("coil")
    region[_in_yoke(*mid)] = _REGIONS.index("yoke")
    pole = (mid[0] < POLE[0]) & (mid[1] < POLE[1]) & (mid[2] > POLE[2]) & (mid[2] < POLE[3])
    region[pole] = _REGIONS.index("pole")
    return box_tetrahedra(_MM * x, _MM * y, _MM * z, region, _REGIONS)


def _in_yoke(x: Floats, y: Floats, z: Floats) -> Floats:
    half_x, half_y, bottom, top = YOKE
    hull = (x < half_x) & (y < half_y) & (z > bottom) & (z < top)
    window = (x < WINDOW[0]) & (z > WINDOW[1]) & (z < WINDOW[2])
    return np.asarray(hull & ~window & ~((x < SLOT) & (z > WINDOW[2])))


def _distance(x: Floats, y: Floats) -> Floats:
    """Distance (mm) from the square on which the coil's corners are centred."""
    beside = np.maximum(np.abs(x) - _CENTRE, 0.0)
    return np.hypot(beside, np.maximum(np.abs(y) - _CENTRE, 0.0))


def team20_source(points: Floats) -> Floats:
    """T0 (..., 3) in A/m at points (..., 3) in m, for one ampere-turn.

    Vertical, within the coil's height only; it falls linearly from 0 inside the coil to
    −1/height outside, so its curl is the uniform current of the winding, anticlockwise
    seen from above, and exactly solenoidal in the round corners too.  A jump of a
    vertical field over a horizontal plane has no curl.  Zero in the pole and its gap and
    constant in the yoke's legs, so that no potential has a large part of it to cancel.
    """
    x, y, z = np.moveaxis(points / _MM, -1, 0)
    width = _OUTER_RADIUS - _INNER_RADIUS
    ramp = np.clip((_distance(x, y) - _INNER_RADIUS) / width, 0.0, 1.0)
    height = (COIL_TOP - COIL_BOTTOM) * _MM
    within = (z > COIL_BOTTOM) & (z < COIL_TOP)
    field = np.zeros(points.shape)
    field[..., 2] = np.where(within, -ramp / height, 0.0)
    return field
