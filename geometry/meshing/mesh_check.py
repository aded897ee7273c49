"""Holds a finished mesh against CAD: volumes, areas, conformity, shape of the elements.

Wrong regions give plausible numbers, so a mesh that is off is refused, not repaired.
Works in millimetres, on ten-node tetrahedra (straight ones have their mid-edge nodes
halfway).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.tessellation import Face
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.mesh import (
    TET_FACES,
    jacobian_coefficients,
    smallest_dihedral_angles,
    triangle_areas,
)

#: Largest relative difference between mesh and CAD: where cylinders are involved, …
TOLERANCE = 1e-3

#: … and for the volume of a solid bounded by planes only.  Such a mesh has it to rounding;
#: a difference means that an edge or a corner was cut off.
PLANE_TOLERANCE = 1e-6

#: Smallest dihedral angle (degrees) that passes.
SMALLEST_ANGLE = 3.0

#: Elements whose Jacobians are worked out at a time: bounds the memory.
_CHUNK = 20_000


def check_volumes(
    points: Floats, cells: Ints, labels: Ints, expected: dict[str, float], plane: set[str]
) -> None:
    """Refuse a region whose volume is off, or an element that is turned inside out.

    Parameters
    ----------
    points : (n_points, 3) array
        Coordinates (mm).
    cells : (n_cells, 10) int array
        Nodes of ten-node tetrahedra.
    labels : (n_cells,) int array
        Region of each cell: position in `expected`.
    expected : dict of str to float
        Volume of each region (mm³), from CAD.
    plane : set of str
        Regions bounded by planes only.

    Raises MeshError naming the region and by how much it is off.
    """
    volumes = np.empty(len(cells))
    for start in range(0, len(cells), _CHUNK):
        coefficients = jacobian_coefficients(points[cells[start : start + _CHUNK]])
        volumes[start : start + _CHUNK] = coefficients.mean(axis=1) / 6.0
        if coefficients.min() <= 0.0:
            raise MeshError("a curved element folds over; choose a smaller edge length")
    for label, (name, volume) in enumerate(expected.items()):
        tolerance = PLANE_TOLERANCE if name in plane else TOLERANCE
        found = float(volumes[labels == label].sum())
        _compare(f"volume of {name}", found, volume, "mm^3", tolerance)


def check_areas(points: Floats, triangles: Ints, face: Ints, faces: Sequence[Face]) -> None:
    """Refuse a CAD face whose triangles do not add up to its area.

    Parameters
    ----------
    points : (n_points, 3) array
        Coordinates (mm).
    triangles : (n_triangles, 6) int array
        Nodes of six-node triangles.
    face : (n_triangles,) int array
        CAD face of each triangle.
    faces : sequence of Face
        The CAD faces.

    Raises MeshError naming the two sides of the face and by how much it is off.
    """
    areas = np.bincount(face, triangle_areas(points[triangles]), minlength=len(faces))
    for i, expected in enumerate(faces):
        sides = " and ".join(sorted(expected.sides))
        _compare(f"area between {sides}", float(areas[i]), expected.area, "mm^2", TOLERANCE)


def _compare(what: str, found: float, expected: float, unit: str, tolerance: float) -> None:
    off = found / expected - 1.0
    if not abs(off) <= tolerance:
        raise MeshError(
            f"the {what} is {found:.6g} {unit} in the mesh but {expected:.6g} {unit} in CAD "
            f"({off * 100:+.2g} %); choose a smaller edge length"
        )


def check_conformity(tets: Ints, n_skin: int) -> None:
    """Refuse a mesh in which a face belongs to more than two cells, or that is torn.

    Parameters
    ----------
    tets : (n_cells, 4) int array
        Corners.
    n_skin : int
        Number of triangles between the regions and outside.

    Raises MeshError if faces do not match.
    """
    faces = np.sort(tets[:, TET_FACES].reshape(-1, 3), axis=1)
    _, count = np.unique(faces, axis=0, return_counts=True)
    if count.max() > 2 or np.count_nonzero(count == 1) != n_skin:
        raise MeshError("neighbouring elements do not share their faces; change the edge length")


def check_shape(points: Floats, tets: Ints) -> None:
    """Refuse flat elements; inverted ones have turned volumes (:func:`check_volumes`).

    Raises MeshError saying how many there are.
    """
    poor = is_poor(points, tets)
    if poor.any():
        raise MeshError(
            f"{np.count_nonzero(poor)} elements have angles below {SMALLEST_ANGLE:g} degrees; "
            "choose a smaller edge length"
        )


def is_poor(points: Floats, tets: Ints) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which tetrahedra (n, 4) are flat; those inside out have the same angles."""
    return np.asarray(smallest_dihedral_angles(points[tets]) < SMALLEST_ANGLE)
