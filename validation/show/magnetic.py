"""The normal actuator's field, revolved: B and H in its parts, and flux lines in the section.

Values at the corners of the half section's cells are extrapolated from their Gauss points and
averaged within a part, so that they jump where parts meet.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.formats import engineering
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.models.reluctance.field import AxisymmetricModel
from tactgen.validation.scene.conditions import conditions
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.field import FieldResult, State

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric_field import MagneticField

#: Part that each region of the section belongs to.
_PARTS = {
    "rod": "rod", "flange": "rod", "head": "rod", "sleeve": "sleeve", "collar": "sleeve",
    "coil": "coil",
}  # fmt: skip
#: Pieces of a cell along r and z, and angle (rad) between half planes.
_PIECES = 2
_STEP = np.pi / 16.0
#: From where to where a device is revolved that is to be looked into.
_OPENED = (-0.5 * np.pi, np.pi)
#: Flux lines, and how far around the parts (m) they are drawn.
_LINES = 16
_AROUND = 0.8e-3


@dataclass(frozen=True)
class Section:
    """The parts' half section in quadrilaterals."""

    places: Floats  #: (n, 2) r and z (m), each of one part
    quads: Ints  #: (m, 4) Counter-clockwise in (r, z)
    part: Ints  #: (m,) Index into `names`
    names: tuple[str, ...]  #: Parts
    #: (n, 2) B (T) and H (A/m) along r and z
    flux_density: Floats
    field_strength: Floats


def gather_magnetic(
    scene: Scene,
    announce: Callable[[str], None] = lambda _: None,
    *,
    opened: bool = True,
    reuse: Solution | None = None,
) -> FieldResult:
    """Field at the scene's current and gap, by the axisymmetric model.

    Parameters
    ----------
    opened : bool
        Leave out a quarter turn, so that the section is seen.
    reuse : Solution, optional
        An earlier one, whose force is not computed again.
    """
    solution = solve(scene, ["axisymmetric"], ["magnetic_force"], announce, reuse)
    model = solution.models["axisymmetric"]
    assert isinstance(model, AxisymmetricModel)
    announce("field of axisymmetric")
    field = model.field()
    section = section_of(field)
    low, high = _OPENED
    angles = np.arange(low, (high if opened else low + 2.0 * np.pi) + 1e-9, _STEP)
    mesh, turn = revolved(section, angles)
    force = solution.get("magnetic_force", "axisymmetric")
    state = State(
        name=f"{engineering(scene.coil.current, 'A', 4)}, gap {engineering(scene.gap, 'm', 4)}",
        kind="static",
        circuit="driven",
        frequency=0.0,
        error=float("nan"),
        fields={
            "flux_density": turn(section.flux_density),
            "magnetic_field": turn(section.field_strength),
        },
        pull=(float(force.value), float(force.error)),
    )
    lines = flux_lines(field, section) if opened else None
    return FieldResult(
        scene.name, "axisymmetric", mesh, (state,), "", "", "field", lines,
        conditions=conditions(scene),
    )  # fmt: skip


def section_of(field: MagneticField) -> Section:
    """Parts of a converged field with B and H at the corners of pieces of its cells."""
    d = field.discretisation
    grid = d.grid
    fields = np.concatenate([field.flux_density, field.field_strength], axis=-1)
    inside = gauss_columns(field, fields)
    spread = _from_gauss_points(inside.shape[1])
    corners = np.einsum("ia,cabk,jb->cijk", spread, inside, spread)
    names = tuple(dict.fromkeys(_PARTS[region.name] for region in grid.regions))
    part_of = np.array([names.index(_PARTS[region.name]) for region in grid.regions])
    r, z = (_divided(lines) for lines in (grid.r, grid.z))
    # points of the divided grid, apart for each part
    keys, quads, owners, places, both = [], [], [], [], []
    nodes = np.arange(_PIECES + 1)
    for i, j in np.argwhere(grid.labels >= 0):
        part = int(part_of[grid.labels[i, j]])
        at_r, at_z = np.meshgrid(i * _PIECES + nodes, j * _PIECES + nodes, indexing="ij")
        number = (part * r.size + at_r) * z.size + at_z
        keys.append(number.ravel())
        places.append(np.stack([r[at_r], z[at_z]], axis=-1).reshape(-1, 2))
        both.append(corners[i * (grid.z.size - 1) + j].reshape(-1, 4))
        a, b, c, e = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
        quads.append(np.stack([a, b, c, e], axis=-1).reshape(-1, 4))
        owners.append(np.full(len(quads[-1]), part))
    different, first, where = np.unique(
        np.concatenate(keys), return_index=True, return_inverse=True
    )
    values = np.zeros((different.size, 4))
    np.add.at(values, where, np.concatenate(both))
    values /= np.bincount(where)[:, None]
    return Section(
        places=np.concatenate(places)[first],
        quads=np.searchsorted(different, np.concatenate(quads)),
        part=np.concatenate(owners),
        names=names,
        flux_density=values[:, :2],
        field_strength=values[:, 2:],
    )


def gauss_columns(field: MagneticField, values: Floats) -> Floats:
    """Values (cells, p², k) at the Gauss points as (cells, p, p, k), along r and z."""
    d = field.discretisation
    across = round(np.sqrt(d.radii.shape[1]))
    # rounding must not tell points of one column apart
    order = np.lexsort((d.elevations, np.round(d.radii, 12)))[..., None]
    return np.take_along_axis(values, order, axis=1).reshape(-1, across, across, values.shape[-1])


def _from_gauss_points(across: int) -> Floats:
    """Matrix (pieces + 1, across) from Gauss points to even points of a cell."""
    points = np.polynomial.legendre.leggauss(across)[0]
    wanted = np.linspace(-1.0, 1.0, _PIECES + 1)
    return np.asarray(
        np.vander(wanted, across) @ np.linalg.inv(np.vander(points, across)), dtype=float
    )


def _divided(lines: Floats) -> Floats:
    shares = np.arange(_PIECES) / _PIECES
    inner = lines[:-1, None] + np.diff(lines)[:, None] * shares
    return np.append(inner.ravel(), lines[-1])


def revolved(section: Section, angles: Floats) -> tuple[Mesh, Callable[[Floats], Floats]]:
    """Section swept through angles (rad), with the rotation of vectors (n, 2).

    At the axis bricks are wedges with an edge of no length; a whole turn is closed.
    """
    whole = bool(angles[-1] - angles[0] > 2.0 * np.pi - 1e-6)
    kept = angles[:-1] if whole else angles
    n, count = len(section.places), kept.size
    cosine, sine = np.cos(kept)[:, None], np.sin(kept)[:, None]

    def turn(vectors: Floats) -> Floats:
        along_r, along_z = vectors[:, 0], np.broadcast_to(vectors[:, 1], (count, n))
        turned = np.stack([cosine * along_r, sine * along_r, along_z], axis=-1)
        return np.asarray(turned.reshape(-1, 3))

    number = np.arange(count - (0 if whole else 1))
    here, there = number * n, (number + 1) % count * n
    quads = section.quads
    # seen along the turn (r, z) is left-handed, so the quadrilateral is taken the other way
    back = quads[:, [0, 3, 2, 1]]
    cells = np.concatenate([back + here[:, None, None], back + there[:, None, None]], axis=-1)
    return (
        Mesh(
            points=turn(section.places),
            cells=cells.reshape(-1, 8),
            kind="hexahedron",
            region_of_cell=np.tile(section.part, number.size),
            regions=section.names,
            faces={},
        ),
        turn,
    )


def flux_lines(field: MagneticField, section: Section) -> Floats:
    """Segments (m, 2, 3) of lines between which the same flux runs, on both faces."""
    from contourpy import contour_generator

    grid, psi = field.discretisation.grid, field.flux_function
    largest = float(psi.flat[np.argmax(np.abs(psi))])
    contours = contour_generator(grid.r, grid.z, psi.T)
    low = section.places.min(axis=0) - _AROUND
    high = section.places.max(axis=0) + _AROUND
    found = []
    for share in (np.arange(_LINES) + 0.5) / _LINES:
        for contour in contours.lines(share * largest):
            line = np.asarray(contour, dtype=float)
            inside = ((line > low) & (line < high)).all(axis=1)
            both = inside[:-1] & inside[1:]
            found.append(np.stack([line[:-1], line[1:]], axis=1)[both])
    segments = np.concatenate(found)
    faces = []
    for angle in _OPENED:
        r, z = segments[..., 0], segments[..., 1]
        faces.append(np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=-1))
    return np.concatenate(faces)
