"""The normal actuator with the air around it: a quarter, in curved tetrahedra made from CAD.

The parts as CAD has them, less what is beyond the symmetry planes x = 0 and y = 0, in a
box of air.  The slot for the shim's tab is symmetric about both planes and may be there or
be filled with the rod's own steel.  The mesher is fTetWild.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.cad.solids import build_solids, fuse, thinnest_feature
from tactgen.geometry.cad.tessellation import tessellate
from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.device.parts import MM, Turned, layout
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.tetwild.conform import conform
from tactgen.geometry.meshing.tetwild.mesher import SizingField, run_ftetwild, sizing_on_grid
from tactgen.geometry.reluctance.section_grid import actuator_regions, air_radius
from tactgen.geometry.store.store import cached_result

if TYPE_CHECKING:
    import cadquery as cq

#: Regions of every 3D mesh of the actuator: the iron, the winding, the air next to the sleeve,
#: the other air, and the air at the outer walls.
REGIONS = ("rod", "coil", "sleeve", "near", "air", "far")

#: Those of one unit.
PARTS = ("rod", "coil", "sleeve")

#: What makes a mesh; the mesher's own process is started by its file.
_MADE_OF = ("tactgen.geometry.reluctance.tets", "tactgen.geometry.meshing.tetwild")
#: Envelope and deflection of the cylinders, as shares of the thinnest feature, and how much
#: tighter each further attempt is; as in :mod:`geometry.bimorph.tets`.
_ENVELOPE, _DEFLECTION, _TIGHTER = 0.2, 0.125, 0.7
_ATTEMPTS = 2
#: Longest edge of the box that fTetWild fills, and how far the sizing reaches beyond the
#: device's air, as shares of the diagonal: fTetWild goes 0.15 beyond, or by the longest edge.
_LONGEST, _MARGIN = 0.1, 0.2
#: Largest ratio of neighbouring intervals of the sizing's grid.
_RATIO = 1.5
#: Edge lengths: in the working gap and in the flange's clearance as shares of their widths, at
#: the iron's edges as a share of the distance from the other part, but not below a share of
#: the narrower of the two.
_IN_GAP, _IN_CLEARANCE, _AT_EDGE, _FINEST = 0.3, 1.5, 0.15, 0.4
#: How far the sizing's grid is fine: beyond the widest part and below the sleeve, as a share of it,
#: above the head, as one of gap and head; and its steps there, per gap.
_ACROSS, _DOWN, _UP, _PER_GAP = 1.1, 1.05, 1.5, 4.0
#: Distance (m) up to which a corner counts as on an outer wall.
_ON_WALL = 1e-9


@dataclass(frozen=True)
class ActuatorMeshing:
    """Mesh settings."""

    size: float = 1.3  #: Factor on all edge lengths; at 1 they are 0.3 of the working gap in it
    growth: float = 0.7  #: Growth of the edge length per distance from there
    #: Half width of the box of air, as a share of
    #: :func:`geometry.reluctance.section_grid.air_radius`
    far: float = 1.0 / 3.0
    slot: bool = False  #: Whether the rod has the slot for the shim's tab
    time_limit: float = 300.0  #: Processor time for the mesher, all attempts together (s)


def actuator_tets(device: Device, gap: float, meshing: ActuatorMeshing) -> Mesh:
    """Quarter (x ≥ 0, y ≥ 0) with `REGIONS`; z = 0 is the sleeve's top face.

    A mesh made before from the same geometry and options is read from the store.

    Raises InputError if the device cannot be built, MeshError if no mesh passes its checks, or the
    time is up.
    """
    at_gap = with_fitting_tab(device, gap)
    parts = layout(at_gap, "rod", PARTS)
    return cached_result(
        "mesh",
        (parts, replace(meshing, time_limit=0.0)),
        _MADE_OF,
        lambda: _with_air_divided(_first_good_mesh(at_gap, meshing), at_gap),
    )


def with_fitting_tab(device: Device, gap: float) -> Device:
    """Device at a gap, with a bimorph whose tab fits the slot, whatever its own."""
    given = device.bimorph
    fitting = Bimorph().model_copy(
        update={
            "width": given.width,
            "shim_thickness": given.shim_thickness,
            "tab_length": device.rod.slot_depth,
        }
    )
    return device.model_copy(update={"gap": gap, "bimorph": fitting})


def actuator_solids(device: Device, meshing: ActuatorMeshing) -> dict[str, cq.Solid]:
    """Quarter of each part and of the air (mm), fused; z = 0 is the sleeve's top.

    The device's bimorph must fit the slot.  What the winding encloses is cut at its ends,
    where its source field jumps: pieces are named after the region they belong to, then how
    they came about.

    Raises InputError if the device cannot be built.
    """
    import cadquery as cq

    built: dict[str, cq.Shape] = dict(build_solids(device, PARTS, "rod"))
    slot = layout(device, "rod", PARTS)["rod"].cut
    if slot is not None and not meshing.slot:
        dx, dy, dz = (high - low for low, high in zip(slot.low, slot.high, strict=True))
        filling = cq.Solid.makeBox(dx, dy, dz, cq.Vector(*slot.low))
        built["rod"] = built["rod"].fuse(filling).clean()
    up = cq.Vector(0.0, 0.0, (device.rod.head_thickness + device.gap) * MM)
    built = {name: solid.translate(up) for name, solid in built.items()}
    far = meshing.far * air_radius(actuator_regions(device, device.gap)) * MM
    quarter = cq.Solid.makeBox(far, far, 2.0 * far, cq.Vector(0.0, 0.0, -far))
    cut = {name: solid.intersect(quarter) for name, solid in built.items()}
    ends = cut["coil"].BoundingBox()
    height = ends.zmax - ends.zmin
    core = cq.Solid.makeCylinder(device.coil.inner_radius * MM, height, cq.Vector(0, 0, ends.zmin))
    rod = cut.pop("rod")
    cut |= {"rod-in": rod.intersect(core), "rod-out": rod.cut(core)}
    cut["coil-bore"] = core.intersect(quarter).cut(rod)
    cut["air"] = quarter.cut(*cut.values())
    return fuse(
        {
            f"{name}-{number}": piece
            for name, shape in cut.items()
            for number, piece in enumerate(shape.Solids())
        }
    )


def _first_good_mesh(device: Device, meshing: ActuatorMeshing) -> Mesh:
    """First mesh that passes all checks, with a tighter envelope each time."""
    solids = actuator_solids(device, meshing)
    thinnest = thinnest_feature(solids)
    tessellation = tessellate(solids, _DEFLECTION * thinnest)
    diagonal = float(np.linalg.norm(np.ptp(tessellation.points, axis=0)))
    sizing = _sizing(device, meshing, tessellation.points, _MARGIN * diagonal)
    for attempt in range(_ATTEMPTS):
        envelope = _ENVELOPE * thinnest * _TIGHTER**attempt
        try:
            raw, tets = run_ftetwild(
                tessellation.points,
                tessellation.triangles,
                edge_length=_LONGEST * diagonal,
                envelope=envelope,
                sizing=sizing,
                time_limit=meshing.time_limit / _ATTEMPTS,
            )
            slack = envelope + _DEFLECTION * thinnest
            return conform(raw, tets, solids, tessellation, slack, {}, curved=True)
        except MeshError:
            if attempt == _ATTEMPTS - 1:
                raise
    raise AssertionError("unreachable: the last attempt returns or raises")


def _sizing(device: Device, meshing: ActuatorMeshing, points: Floats, margin: float) -> SizingField:
    """Target edge lengths (mm) on a grid that is fine around the iron."""
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    sleeve, rod = device.sleeve, device.rod
    widest = _ACROSS * max(sleeve.outer_radius, rod.head_radius) * MM
    ends = -_DOWN * sleeve.length * MM, _UP * (device.gap + rod.head_thickness) * MM
    step = device.gap * MM / _PER_GAP
    axes = [
        _axis(low[i], first, last, high[i], step)
        for i, (first, last) in enumerate([(0.0, widest), (0.0, widest), ends])
    ]

    def lengths(points: Floats) -> Floats:
        beyond = np.maximum(-points[:, :2].min(axis=1), 0.0)
        return np.asarray(_edge_length(device, meshing, points) + beyond)

    return sizing_on_grid(axes, lengths)


def _axis(low: float, first: float, last: float, high: float, step: float) -> Floats:
    """Divide [low, high]: by `step` between `first` and `last`, ever wider outside."""
    fine = np.linspace(first, last, 1 + max(1, round((last - first) / step)))
    below, above = (
        distance * np.cumsum(_RATIO ** np.arange(count)) / np.sum(_RATIO ** np.arange(count))
        for distance in (first - low, high - last)
        for count in [1 + int(np.log1p(distance / step * (_RATIO - 1.0)) / np.log(_RATIO))]
    )
    return np.concatenate([first - below[::-1], fine, last + above])


def _edge_length(device: Device, meshing: ActuatorMeshing, points: Floats) -> Floats:
    """Edge length (mm) wanted at points (n, 3): least where the field is steep."""
    r, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    lengths = np.full(r.shape, np.inf)
    for wanted, (inner, outer), (bottom, top) in _steep(device):
        across = np.maximum(np.maximum(inner - r, r - outer), 0.0)
        along = np.maximum(np.maximum(bottom - z, z - top), 0.0)
        growing = wanted + meshing.growth * np.hypot(across, along)
        lengths = np.minimum(lengths, growing)
    return meshing.size * lengths


_Span = tuple[float, float]


def _steep(device: Device) -> Iterable[tuple[float, _Span, _Span]]:
    """Yield edge length, radii and heights (mm) of places that want it.

    The working gap, the flange's clearance in the sleeve, and the iron's edges, the finer
    the nearer the other part.
    """
    parts = layout(device, "rod", ("rod", "sleeve"))
    up = (device.rod.head_thickness + device.gap) * MM
    rod, sleeve = (
        np.array(part.body.outline) + np.array((0.0, up))
        for part in parts.values()
        if isinstance(part.body, Turned)
    )
    gap, clearance = device.gap * MM, (device.sleeve.inner_radius - device.rod.flange_radius) * MM
    yield _IN_GAP * gap, (sleeve[:, 0].min(), sleeve[:, 0].max()), (0.0, gap)
    flange = rod[rod[:, 0] == device.rod.flange_radius * MM, 1]
    bore = device.rod.flange_radius * MM, device.sleeve.inner_radius * MM
    yield _IN_CLEARANCE * clearance, bore, (flange.min(), flange.max())
    for corners, other in ((rod, sleeve), (sleeve, rod)):
        for corner in corners[corners[:, 0] > 0.0]:
            wanted = max(_AT_EDGE * _distance(corner, other), _FINEST * min(gap, clearance))
            yield wanted, (corner[0], corner[0]), (corner[1], corner[1])


def _distance(point: Floats, outline: Floats) -> float:
    """Distance of a point (r, z) from a closed outline (n, 2) of straight edges."""
    edges = np.roll(outline, -1, axis=0) - outline
    along = np.sum((point - outline) * edges, axis=1) / np.sum(edges**2, axis=1)
    nearest = outline + np.clip(along, 0.0, 1.0)[:, None] * edges
    return float(np.linalg.norm(nearest - point, axis=1).min())


def _with_air_divided(mesh: Mesh, device: Device) -> Mesh:
    """Mesh at z = 0 on the sleeve's top, its air divided into near, air and far.

    The shells that this makes are bounded by faces of cells, no surface of the CAD's.
    """
    names = np.array([REGIONS.index(name.split("-")[0]) for name in mesh.regions])
    labels = names[mesh.region_of_cell]
    corners = mesh.points[mesh.cells[:, :4]]
    centre = corners.mean(axis=1)
    air = labels == REGIONS.index("air")
    sleeve, gap = device.sleeve, device.gap
    near = np.hypot(*centre[:, :2].T) < sleeve.outer_radius + gap
    near &= (centre[:, 2] > -sleeve.length - gap) & (centre[:, 2] < gap)
    labels[air & near] = REGIONS.index("near")
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    outer = (corners > high - _ON_WALL).any(axis=2) | (corners[:, :, 2] < low[2] + _ON_WALL)
    labels[air & outer.any(axis=1)] = REGIONS.index("far")
    return replace(mesh, region_of_cell=labels, regions=REGIONS)
