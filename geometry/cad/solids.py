"""CAD solids of the device, their fusion into touching neighbours, STEP and GLB files.

Lengths are in millimetres, as CAD files have them.  Nothing here meshes.  The CAD
kernel takes more than a second to import, so every function imports it when called.
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.cad.system_libraries import require_cad_kernel
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.parts import (
    MM,
    Box,
    Part,
    Rectangle,
    Standing,
    Tapered,
    Turned,
    layout,
)
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import NotWritten, written_whole

if TYPE_CHECKING:
    import cadquery as cq

#: Colour of each region (red, green, blue; 0 to 1), for models and pictures.
COLOURS: dict[str, tuple[float, float, float]] = {
    "piezo_top": (0.93, 0.80, 0.48),
    "piezo_bottom": (0.85, 0.69, 0.36),
    "shim": (0.22, 0.24, 0.27),
    "glue": (0.36, 0.68, 0.85),
    "rod": (0.62, 0.65, 0.70),
    "coil": (0.80, 0.45, 0.20),
    "sleeve": (0.45, 0.50, 0.56),
}


def colour_of(region: str) -> tuple[float, float, float]:
    """Colour of a region; layers that are numbered have that of their kind."""
    kind = region.partition("_")[0]
    return COLOURS.get(region) or COLOURS.get("piezo_top" if kind == "piezo" else kind, _GREY)


_GREY = (0.7, 0.7, 0.7)

#: Distance (mm) up to which two faces count as touching.
_CONTACT = 1e-7

#: Largest distance (mm) between a curved face and its triangles in a glTF file.
_DEFLECTION = 2e-3

#: Overlap of two solids (mm³) up to which they count as touching.
_TOUCHING = 1e-9


def build_solids(
    device: Device, names: tuple[str, ...] | None = None, standing: Standing = "rod"
) -> dict[str, cq.Solid]:
    """Build the solids of the device (mm), all or some by name, each by itself.

    Standing on the rod it is the whole generator (z = 0 at the rod's top face), alone the bimorph
    (z = 0 at its lowest edge).

    Raises InputError if a name is unknown, the parts cannot be put together, or the CAD kernel's
    system library is missing.
    """
    require_cad_kernel()
    return {name: solid_of(part) for name, part in layout(device, standing, names).items()}


def solid_of(part: Part) -> cq.Solid:
    """Solid of a part (mm)."""
    if isinstance(part.body, Box):
        body = _box(part.body)
    elif isinstance(part.body, Tapered):
        body = _tapered(part.body)
    else:
        body = _turned(part.body)
    if part.cut is None:
        return body
    return _only_solid(body.cut(_box(part.cut)))


def _box(box: Box) -> cq.Solid:
    import cadquery as cq

    dx, dy, dz = (high - low for low, high in zip(box.low, box.high, strict=True))
    return cq.Solid.makeBox(dx, dy, dz, cq.Vector(*box.low))


def _tapered(tapered: Tapered) -> cq.Solid:
    first, *others = (_block(low, high) for low, high in tapered.blocks)
    return _only_solid(first.fuse(*others).clean()) if others else first


def _block(low: Rectangle, high: Rectangle) -> cq.Solid:
    """Solid between two rectangles; all six faces are plane."""
    import cadquery as cq

    corners = [
        [cq.Vector(x, 0.5 * side * at.width, at.z)
         for x, side in ((at.low, -1), (at.high, -1), (at.high, 1), (at.low, 1))]
        for at in (low, high)
    ]  # fmt: skip
    below, above = corners
    sides = [[below[i - 1], below[i], above[i], above[i - 1]] for i in range(4)]
    wires = [cq.Wire.makePolygon(side, close=True) for side in (below, above, *sides)]
    faces = [cq.Face.makeFromWires(wire) for wire in wires]
    solid = cq.Solid.makeSolid(cq.Shell.makeShell(faces))
    assert isinstance(solid, cq.Solid)
    return solid


def _turned(turned: Turned) -> cq.Solid:
    import cadquery as cq

    corners = [cq.Vector(r, 0.0, z) for r, z in turned.outline]
    outline = cq.Wire.makePolygon(corners, close=True)
    return cq.Solid.revolve(outline, [], 360.0, cq.Vector(0, 0, 0), cq.Vector(0, 0, 1))


def _only_solid(shape: cq.Shape) -> cq.Solid:
    solids = shape.Solids()
    if len(solids) != 1:
        raise InputError(
            f"a part falls into {len(solids)} pieces; make the slot in the rod's head smaller"
        )
    return solids[0]


def fuse(solids: dict[str, cq.Solid]) -> dict[str, cq.Solid]:
    """Fuse solids, which may touch but not overlap, so that neighbours share the very same faces.

    Raises InputError if two solids overlap.
    """
    import cadquery as cq
    from OCP.BOPAlgo import BOPAlgo_Builder

    _refuse_overlap(solids)
    if len(solids) < 2:
        return dict(solids)  # the kernel refuses to fuse a solid with nothing
    builder = BOPAlgo_Builder()
    for solid in solids.values():
        builder.AddArgument(solid.wrapped)
    builder.Perform()
    if builder.HasErrors():
        raise InputError(
            f"the solids {', '.join(solids)} cannot be put together; change a dimension slightly"
        )
    fused = {}
    for name, solid in solids.items():
        images = list(builder.Modified(solid.wrapped)) or [solid.wrapped]
        fused[name] = _only_solid(cq.Compound.makeCompound([cq.Shape.cast(i) for i in images]))
    return fused


def cut_open(solids: dict[str, cq.Solid], axes: tuple[int, ...]) -> dict[str, cq.Solid]:
    """Part of each solid at x ≥ 0 and y ≥ 0, or on one of these; empty ones are left out."""
    import cadquery as cq

    boxes = [solid.BoundingBox() for solid in solids.values()]
    low = min(box.zmin for box in boxes)
    size = 2.0 * max(box.DiagonalLength for box in boxes)
    x, y = (0.0 if axis in axes else -size for axis in range(2))
    kept = cq.Solid.makeBox(size - x, size - y, 2.0 * size, cq.Vector(x, y, low - 0.5 * size))
    cut = {name: solid.intersect(kept) for name, solid in solids.items()}
    return {name: _only_solid(shape) for name, shape in cut.items() if shape.Solids()}


def _refuse_overlap(solids: dict[str, cq.Solid]) -> None:
    for first, second in combinations(solids, 2):
        common = solids[first].intersect(solids[second])
        volume = sum(solid.Volume() for solid in common.Solids())
        if volume > _TOUCHING:
            raise InputError(
                f"{first} and {second} overlap by {volume:.3g} mm^3; "
                "change the dimensions or positions that bring them together"
            )


def solids_assembly(solids: dict[str, cq.Solid]) -> cq.Assembly:
    """Named solids (mm), each in its colour."""
    import cadquery as cq

    assembly = cq.Assembly(name="tactile_generator")
    for name, solid in solids.items():
        assembly.add(solid, name=name, color=cq.Color(*colour_of(name), 1.0))
    return assembly


def write_step(assembly: cq.Assembly, path: str | Path) -> None:
    """Write an assembly to a STEP file; repeated parts are in it once.

    Raises InputError if the file cannot be written.
    """
    from cadquery.occ_impl.exporters.assembly import exportAssembly

    with written_whole(path) as temporary:
        if not exportAssembly(assembly, str(temporary)):
            raise NotWritten(path, "the CAD kernel does not say why")


def write_glb(assembly: cq.Assembly, path: str | Path) -> None:
    """Write an assembly (mm) to a binary glTF file (metres, y up, as glTF has it).

    Each part becomes a node of its name; copies of a part share its triangles.

    Raises InputError if the file cannot be written.
    """
    from cadquery.occ_impl.assembly import toCAF
    from OCP.Message import Message_ProgressRange
    from OCP.RWGltf import RWGltf_CafWriter
    from OCP.RWMesh import RWMesh_CoordinateSystem
    from OCP.TCollection import TCollection_AsciiString
    from OCP.TColStd import TColStd_IndexedDataMapOfStringString

    _, document = toCAF(assembly, mesh=True, tolerance=_DEFLECTION, angularTolerance=0.2)
    with written_whole(path) as temporary:
        # cadquery's own writer would call our millimetres metres
        writer = RWGltf_CafWriter(TCollection_AsciiString(str(temporary)), True)
        frame = writer.ChangeCoordinateSystemConverter()
        frame.SetInputLengthUnit(1.0 / MM)
        frame.SetInputCoordinateSystem(RWMesh_CoordinateSystem.RWMesh_CoordinateSystem_Zup)
        no_comments = TColStd_IndexedDataMapOfStringString()
        if not writer.Perform(document, no_comments, Message_ProgressRange()):
            raise NotWritten(path, "the CAD kernel does not say why")


def thinnest_feature(solids: dict[str, cq.Solid]) -> float:
    """Smallest distance (mm) between two faces of fused solids that do not touch each other.

    It is the thickness of the thinnest layer, wall, step or gap between the solids.
    """
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

    faces = list({face for solid in solids.values() for face in solid.Faces()})
    boxes = [face.BoundingBox() for face in faces]
    low = np.array([(b.xmin, b.ymin, b.zmin) for b in boxes])
    high = np.array([(b.xmax, b.ymax, b.zmax) for b in boxes])
    first, second = np.triu_indices(len(faces), k=1)
    apart = np.maximum(low[first] - high[second], low[second] - high[first])
    at_least = np.linalg.norm(np.maximum(apart, 0.0), axis=1)
    thinnest = float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    for k in np.argsort(at_least):
        if at_least[k] > thinnest:
            break
        i, j = first[k], second[k]
        distance = BRepExtrema_DistShapeShape(faces[i].wrapped, faces[j].wrapped).Value()
        if _CONTACT < distance < thinnest:
            thinnest = distance
    return thinnest
