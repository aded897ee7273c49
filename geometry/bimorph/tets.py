"""Tetrahedral meshes of the device: from CAD solids to checked regions and named faces.

Straight elements where every face is plane, curved ones (ten nodes) where not.  The
mesher itself is fTetWild; structured meshes of bricks are made elsewhere.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.cad.solids import cut_open, fuse, solid_of, thinnest_feature
from tactgen.geometry.cad.system_libraries import require_cad_kernel
from tactgen.geometry.cad.tessellation import Plane, Tessellation, tessellate
from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.device.parts import (
    BIMORPH,
    MM,
    Box,
    Part,
    Standing,
    Tapered,
    ceramic_base,
    layout,
    rod_base,
    shim_base,
)
from tactgen.geometry.errors import InputError, MeshError
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import MIRRORS, MirrorAxes
from tactgen.geometry.meshing.tetwild.conform import NamedFace, conform
from tactgen.geometry.meshing.tetwild.mesher import (
    UNSTRETCHED,
    Mesher,
    Sizing,
    SizingField,
    Stretching,
    run_ftetwild,
    sizing_along_z,
    sizing_at_points,
)
from tactgen.geometry.store.store import cached_result

if TYPE_CHECKING:
    import cadquery as cq

#: What makes a mesh; the mesher's own process is started by its file.
_MADE_OF = ("tactgen.geometry.bimorph.tets", "tactgen.geometry.meshing.tetwild")

#: How far the mesher may stray from the surface, as a share of the thinnest feature, since
#: its vertices are put back afterwards; …
_ENVELOPE = 0.2

#: … and as a share of the edge length, since putting back bends the elements, …
_ENVELOPE_PER_EDGE = 0.05

#: … of the shortest one where sizes are given point by point.
_ENVELOPE_PER_SHORTEST = 0.25

#: A mesh that fails its checks is tried again with a tighter envelope, then with smaller elements
#: besides, and so is one on which the mesher got stuck.  Of each attempt: its share of the time
#: that is left, its envelope and its sizes relative to the first.
_ATTEMPTS = (
    (0.25, 1.0, 1.0), (0.35, 0.7, 1.0), (0.5, 0.49, 1.0), (0.7, 0.7, 0.85), (1.0, 0.49, 0.7)
)  # fmt: skip

#: Share of the time below which none is left: what rounding leaves of the last attempt's.
_NO_TIME = 1e-9

#: Distance of the triangulated from the true cylinders, as a share of the thinnest feature.
#: A closer triangulation has narrower triangles, on which the mesher gets stuck.
_DEFLECTION = 0.125

#: Elements along the ceramic are up to this many times longer than wide, …
_SLENDER = 3.0

#: … and become so by this much per thickness of the bimorph from the ceramic's ends.
_SLENDER_GROWTH = 1.0

#: Thinnest feature (relative to the device's diagonal) below which meshing takes hours.
_THINNEST = 2e-4


@dataclass(frozen=True)
class TetMeshing:
    """Mesh settings.

    Raises InputError if a value is out of range.
    """

    edge_length: float = 0.3e-3  #: Target edge length (m)
    #: Target edge length from the tab's lower end to the ceramic's lower edge (m); the same
    #: everywhere by default
    root_edge_length: float | None = None
    grading: float = 0.1  #: Growth of the edge length per distance from there (m/m)
    #: Give curved boundaries curved elements (ten nodes).  If False, elements are straight and the
    #: regions lose what lies between chord and arc
    curved: bool = True
    #: Axes along which the mesh is to be mirrored: (0, 1) meshes what lies at x ≥ 0 and y ≥ 0, (1,)
    #: what lies at y ≥ 0; the cuts are named as :data:`geometry.meshing.structured_tets.MIRRORS`
    mirrors: MirrorAxes = ()
    time_limit: float = 300.0  #: Processor time for the mesher, all attempts together (s)

    def __post_init__(self) -> None:
        """Refuse values out of range."""
        for name in ("edge_length", "grading", "time_limit"):
            if not 0.0 < getattr(self, name) < float("inf"):
                raise InputError(f"{name} = {getattr(self, name):g} must be a positive number")
        root = self.root_edge_length
        if root is not None and not 0.0 < root <= self.edge_length:
            raise InputError(
                f"root_edge_length = {root * MM:g} mm must be positive and at most "
                f"edge_length = {self.edge_length * MM:g} mm; make it smaller"
            )


def tetrahedralise(
    device: Device,
    standing: Standing = "rod",
    regions: tuple[str, ...] | None = None,
    options: TetMeshing = TetMeshing(),
    sizing: Sizing | None = None,
    mesher: Mesher | None = None,
) -> Mesh:
    """Mesh chosen solids of the device with tetrahedra and check the mesh against CAD.

    A mesh made before from the same geometry and options is read from the store: the mesher has no
    seed, so only a kept mesh makes results repeatable.  By default all solids are meshed: of the
    generator with the bimorph glued into the rod, or of the bimorph alone.  `sizing` has edge
    lengths in place of those of the options, as the mesher sees the device (:func:`squeezed`);
    `mesher` is the mesher's process, if another mesh has had or will have one too.

    Returns the mesh in metres, with the named faces ``base`` (the rod's bottom face; without rod
    the lowest face of ceramic and shim), ``tip`` and ``electrode_top_outer``, ``…_top_inner``,
    ``…_bottom_inner``, ``…_bottom_outer`` as far as their regions are chosen; electrode triangles
    are seen from outside the ceramic.

    Raises InputError if the device cannot be built, MeshError if no mesh passes its checks, or the
    time is up.
    """
    parts = layout(device, standing, regions)
    named = _named_faces(device, standing, parts)
    of_part = {name: name for name in parts}
    if device.bimorph.profiles:
        parts, of_part = _in_blocks(parts)
        named = {name: _of_blocks(face, of_part) for name, face in named.items()}
    if 0 in options.mirrors:
        named = {name: face for name, face in named.items() if "bottom" not in name}
    named |= {MIRRORS[i]: _face(i, 0.0, tuple(parts)) for i in options.mirrors}
    # from the tab's lower end to the ceramic's lower edge: where the bending begins
    root = (shim_base(device, standing) * MM, ceramic_base(device, standing) * MM)
    shape: tuple[object, ...] = (
        (sizing, options.curved)
        if sizing
        else (options.edge_length, options.root_edge_length, options.grading, options.curved)
    )

    def made() -> Mesh:
        with ExitStack() as stack:
            process = mesher or stack.enter_context(Mesher())
            process.start()  # loads its libraries while the CAD kernel loads here
            require_cad_kernel()
            built = {name: solid_of(part) for name, part in parts.items()}
            solids = fuse(cut_open(built, options.mirrors) if options.mirrors else built)
            stretching = _stretching(device, standing)
            mesh = _first_good_mesh(solids, named, root, options, sizing, stretching, process)
            return _merged(mesh, of_part)

    return cached_result("mesh", (parts, named, shape, options.mirrors, root), _MADE_OF, made)


def _in_blocks(parts: dict[str, Part]) -> tuple[dict[str, Part], dict[str, str]]:
    """Each block of tapers as a part of its own, and the part that it belongs to.

    The mesher rounds off an edge between two planes that hardly differ; the section between two
    blocks it keeps.
    """
    blocks, of_part = {}, {}
    for name, part in parts.items():
        assert isinstance(part.body, Tapered)
        for number, ends in enumerate(part.body.blocks, start=1):
            blocks[f"{name} {number}"] = Part(Tapered(ends))
            of_part[f"{name} {number}"] = name
    return blocks, of_part


def _of_blocks(face: NamedFace, of_part: dict[str, str]) -> NamedFace:
    return replace(face, regions=tuple(b for b, part in of_part.items() if part in face.regions))


def _merged(mesh: Mesh, of_part: dict[str, str]) -> Mesh:
    """Mesh with the parts in place of their blocks as regions."""
    names = tuple(dict.fromkeys(of_part[region] for region in mesh.regions))
    part_of = np.array([names.index(of_part[region]) for region in mesh.regions])
    return replace(mesh, regions=names, region_of_cell=part_of[mesh.region_of_cell])


def _named_faces(
    device: Device, standing: Standing, parts: dict[str, Part]
) -> dict[str, NamedFace]:
    """Where the named faces of the chosen parts are."""
    b, regions = device.bimorph, tuple(parts)
    if b.layers:
        return _faces_of_layers(b, regions)
    named = {}
    for region, side, kinds in (
        ("piezo_top", "top", {"outer": "high", "inner": "low"}),
        ("piezo_bottom", "bottom", {"outer": "low", "inner": "high"}),
    ):
        if region in parts:
            for kind, end in kinds.items():
                planes = _across_x(parts[region], end)
                named[f"electrode_{side}_{kind}"] = NamedFace(planes, (region,))
    layers = tuple(name for name in regions if name in BIMORPH)
    ceramic = ceramic_base(device, standing)
    if layers:
        named["tip"] = _face(2, (ceramic + b.length + b.tip_extension) * MM, layers)
        lowest = shim_base(device, standing) if "shim" in layers else ceramic
        named["base"] = _face(2, lowest * MM, layers)
    if "rod" in regions:
        named["base"] = _face(2, rod_base(device) * MM, ("rod",))
    return named


def _across_x(part: Part, end: str) -> tuple[Plane, ...]:
    """Planes of a layer's face at its low or high end along x; of tapers one for each block."""
    if isinstance(part.body, Tapered):
        return tuple(
            _through((getattr(low, end), low.z), (getattr(high, end), high.z))
            for low, high in part.body.blocks
        )
    assert isinstance(part.body, Box)
    return (Plane((1.0, 0.0, 0.0), getattr(part.body, end)[0]),)


def _faces_of_layers(bimorph: Bimorph, regions: tuple[str, ...]) -> dict[str, NamedFace]:
    """The same of a bimorph alone whose layers are listed; those at the voltage are outer."""
    layers, x = bimorph.layers, -0.5 * bimorph.thickness
    named = {"base": _face(2, 0.0, regions), "tip": _face(2, bimorph.height * MM, regions)}
    for number, layer in enumerate(layers):
        region = layers.region(number)
        for side, sign, at in (("lower", -1, x), ("upper", 1, x + layer.thickness)):
            if layer.is_ceramic and sign in layers.faces(number) and region in regions:
                kind = "outer" if layers.hot(number) == sign else "inner"
                face = _face(0, at * MM, (region,))
                named[f"electrode_{region}_{side}_{kind}"] = face
        x += layer.thickness
    return named


def _face(axis: int, offset: float, regions: tuple[str, ...]) -> NamedFace:
    """Face of some regions on a plane across an axis (mm)."""
    normal = (float(axis == 0), float(axis == 1), float(axis == 2))
    return NamedFace((Plane(normal, offset),), regions)


def _through(low: tuple[float, float], high: tuple[float, float]) -> Plane:
    """Plane along y through two points (x, z), turned as those that CAD finds."""
    normal = np.array([high[1] - low[1], 0.0, low[0] - high[0]])
    normal /= np.linalg.norm(normal) * np.sign(normal[np.argmax(np.abs(normal))])
    return Plane((float(normal[0]), 0.0, float(normal[2])), float(normal @ [low[0], 0.0, low[1]]))


def squeezed(device: Device, standing: Standing, points: Floats) -> Floats:
    """Points (n, 3) in m as the mesher sees them: sizes are lengths there.

    Elements along the ceramic are meshed shorter than they will be.
    """
    return _stretching(device, standing).squeezed(points * MM) / MM


def _stretching(device: Device, standing: Standing) -> Stretching:
    """Map under which the ceramic-covered length is meshed; it would bend what tapers."""
    if device.bimorph.profiles:
        return UNSTRETCHED
    low = ceramic_base(device, standing)
    b = device.bimorph
    return Stretching(
        low * MM, (low + b.length) * MM, _SLENDER, _SLENDER_GROWTH / (b.thickness * MM)
    )


def _first_good_mesh(
    solids: dict[str, cq.Solid],
    named: dict[str, NamedFace],
    root: tuple[float, float],
    options: TetMeshing,
    sizing: Sizing | None,
    stretching: Stretching,
    mesher: Mesher,
) -> Mesh:
    """First mesh that passes all checks, in the order of :data:`_ATTEMPTS`."""
    left = options.time_limit
    thinnest = thinnest_feature(solids)
    deflection = _DEFLECTION * thinnest
    tessellation = tessellate(solids, deflection)
    _refuse_too_thin(tessellation, thinnest)
    surface = stretching.squeezed(tessellation.points)
    length, field = _edge_lengths(surface, root, options, sizing)
    widest = min(_ENVELOPE * thinnest, _ENVELOPE_PER_EDGE * length)
    if sizing is not None:
        widest = min(widest, _ENVELOPE_PER_SHORTEST * float(sizing.lengths.min()) * MM)
    for number, (share, tighter, smaller) in enumerate(_ATTEMPTS, 1):
        envelope = widest * tighter
        before = mesher.spent
        try:
            raw, tets = run_ftetwild(
                surface,
                tessellation.triangles,
                edge_length=smaller * length,
                envelope=envelope,
                sizing=field and field.scaled(smaller),
                time_limit=share * left,
                mesher=mesher,
            )
            return conform(
                stretching.restored(raw),
                tets,
                solids,
                tessellation,
                envelope + deflection,
                named,
                options.curved,
                stretching,
            )
        except MeshError as error:
            left -= mesher.spent - before
            if left <= _NO_TIME * options.time_limit:
                raise MeshError(
                    f"no mesh was done and passed its checks within {options.time_limit:g} s of "
                    "processor time; raise the time limit or the edge length"
                ) from error
            if number == len(_ATTEMPTS):
                raise
    raise AssertionError("unreachable: the last attempt returns or raises")


def _refuse_too_thin(tessellation: Tessellation, thinnest: float) -> None:
    size = float(np.linalg.norm(np.ptp(tessellation.points, axis=0)))
    if thinnest < _THINNEST * size:
        raise MeshError(
            f"the thinnest feature, {thinnest * 1e3:.3g} um, is too thin to mesh in a device of "
            f"{size:.3g} mm; make it at least {_THINNEST * size * 1e3:.2g} um or close it"
        )


def _edge_lengths(
    surface: Floats, root: tuple[float, float], options: TetMeshing, sizing: Sizing | None
) -> tuple[float, SizingField | None]:
    """Edge length (mm) far from everything fine, and the field if it varies."""
    if sizing is not None:
        lengths = sizing.lengths * MM
        return float(np.median(lengths)), sizing_at_points(surface, sizing.points * MM, lengths)
    edge_length = options.edge_length * MM
    if options.root_edge_length is None:
        return edge_length, None
    finest = options.root_edge_length * MM
    field = sizing_along_z(
        surface,
        lambda z: np.minimum(edge_length, finest + options.grading * np.abs(z - np.clip(z, *root))),
    )
    return edge_length, field
