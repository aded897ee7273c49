"""Fields of a scene as files for ParaView: .vtu, .vtkhdf, and .pvd in time."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.files import NotWritten, writable_folder, write_text, written_whole
from tactgen.geometry.meshing.mesh import Mesh, surface_of
from tactgen.geometry.meshing.mesh_files import write_mesh
from tactgen.validation.show.field import FIELDS, Array, FieldResult, State, at_phase
from tactgen.validation.show.pictures import as_grid

#: Steps of one period in a .pvd.
STEPS = 24
#: Of HDF's deflate, 0 to 9.
_COMPRESSION = 4
#: Where VTK's xx, yy, zz, xy, yz, xz are in Voigt's order.
_VTK_ORDER = [0, 1, 2, 5, 3, 4]


def write_fields(path: Path, result: FieldResult, name: str | None = None) -> None:
    """Write the states of a result to a file, as its suffix says.

    A .vtu or .vtkhdf holds every field of every state at the mesh's points, named
    ``STATE: FIELD (UNIT)``; complex amplitudes (peak, e^{+jΩt}) are two fields, real and imaginary
    part.  Tensors have VTK's order xx, yy, zz, xy, yz, xz, strains as tensor components.  In a
    .vtkhdf names have _ for a decimal point.  A .pvd holds one period of the first harmonic
    state, else of the first mode, as time steps in s, in the folder ``NAME_steps`` beside it.

    Parameters
    ----------
    name : str, optional
        For that folder; that of the file by default.

    Raises InputError if the file cannot be written.
    """
    if path.suffix == ".pvd":
        _write_pvd(path, result, name or path.stem)
        return
    data: dict[str, Array] = {}
    for state in result.states:
        data |= _all_fields(state)
    if path.suffix == ".vtu":
        write_mesh(result.mesh, path, data)
        return
    grid = as_grid(result.mesh)
    for name, values in data.items():
        grid.point_data[name.replace(".", "_")] = values  # HDF knows no dots in names
    with written_whole(path) as temporary:
        if not _write_hdf(grid, temporary):
            remedy = "make room there, choose a folder on a local disk, or write .vtu"
            raise NotWritten(path, "VTK's HDF5 writer failed", remedy)


def field_name(state: str, field: str, part: str = "") -> str:
    """Name of an array: state, field, part of a complex amplitude, unit."""
    kind = FIELDS[field]
    of = f", {part} part" if part else ""
    return f"{state}: {kind.title}{of} ({kind.unit})"


def _all_fields(state: State) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for name, values in state.fields.items():
        values = _for_vtk(name, np.asarray(values))
        if state.kind == "harmonic":
            found[field_name(state.name, name, "real")] = np.real(values).copy()
            found[field_name(state.name, name, "imaginary")] = np.imag(values).copy()
        else:
            found[field_name(state.name, name)] = np.real(values).copy()
    return found


def _for_vtk(name: str, values: Array) -> Array:
    """Field with the components that ParaView's labels mean."""
    if name not in ("strain", "stress"):
        return values
    shear = 0.5 if name == "strain" else 1.0
    return np.asarray((values * np.array([1.0, 1.0, 1.0, shear, shear, shear]))[:, _VTK_ORDER])


def _write_hdf(grid: Any, path: Path) -> bool:
    from vtkmodules.vtkIOHDF import vtkHDFWriter

    writer = vtkHDFWriter()
    writer.SetInputData(grid)
    writer.SetFileName(str(path))
    writer.SetCompressionLevel(_COMPRESSION)
    return bool(writer.Write())


def moving_state(result: FieldResult) -> State:
    """State that a film is of: the first harmonic one, else the first."""
    return next((s for s in result.states if s.kind == "harmonic"), result.states[0])


def _write_pvd(path: Path, result: FieldResult, name: str) -> None:
    state = moving_state(result)

    def at(step: int) -> tuple[float, dict[str, Array]]:
        phase = 2.0 * np.pi * step / STEPS
        return step / STEPS / state.frequency, {
            field_name(state.name, field): at_phase(_for_vtk(field, np.asarray(values)), phase)
            for field, values in state.fields.items()
        }

    write_steps(path, name, result.mesh, map(at, range(STEPS)))


def write_steps(
    path: Path, name: str, mesh: Mesh, steps: Iterable[tuple[float, dict[str, Array]]]
) -> None:
    """Write time steps as a .pvd, with each step in the folder ``NAME_steps`` beside it.

    Parameters
    ----------
    steps : iterable of (float, dict)
        Time (s), and data at the mesh's points by name.

    Raises InputError if a file cannot be written.
    """
    folder = writable_folder(path.parent / f"{name}_steps")
    lines = []
    for step, (time, data) in enumerate(steps):
        piece = folder / f"{step:03d}.vtu"
        write_mesh(mesh, piece, data)
        lines.append(
            f'    <DataSet timestep="{time:.9e}" part="0" file="{folder.name}/{piece.name}"/>'
        )
    write_text(
        path,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        + "\n".join(lines)
        + "\n  </Collection>\n</VTKFile>\n",
    )


#: Seconds that a period takes, and its steps.
_PERIOD, _STEPS = 2.0, 32
#: Largest displacement drawn, as a share of the device's height.
_DRAWN = 0.1
_FLOAT, _UNSIGNED = 5126, 5125
_ARRAY, _ELEMENTS = 34962, 34963


@dataclass
class _Buffer:
    """The binary part as it grows, with its views and accessors."""

    data: bytearray = field(default_factory=bytearray)
    views: list[dict[str, int]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)

    def add(self, values: Floats | Ints, target: int | None = None) -> int:
        """Append an array and return its accessor's number."""
        integers = np.issubdtype(values.dtype, np.integer)
        packed = np.ascontiguousarray(values, dtype="<u4" if integers else "<f4")
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": packed.nbytes}
        self.views.append(view if target is None else view | {"target": target})
        self.data += packed.tobytes()
        vector = packed.ndim == 2
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": _UNSIGNED if integers else _FLOAT,
                "count": len(packed),
                "type": "VEC3" if vector else "SCALAR",
                "min": np.atleast_1d(packed.min(axis=0)).tolist(),
                "max": np.atleast_1d(packed.max(axis=0)).tolist(),
            }
        )
        return len(self.accessors) - 1


def write_animated_glb(
    path: Path, result: FieldResult, colours: Mapping[str, tuple[float, float, float]]
) -> None:
    """Write the modes and harmonic states of a result as animations.

    Parameters
    ----------
    colours : mapping of str to (red, green, blue)
        Of the regions, 0 to 1.

    Raises InputError if the file cannot be written.
    """
    states = [state for state in result.states if state.kind != "static"]
    names, targets = zip(*(part for s in states for part in _parts(result, s)), strict=True)
    buffer, surface = _Buffer(), surface_of(result.mesh)
    primitives = []
    for number, _ in enumerate(result.mesh.regions):
        triangles = surface.triangles[surface.region_of_triangle == number]
        used, local = np.unique(triangles, return_inverse=True)
        morphs = [{"POSITION": buffer.add(values[used], _ARRAY)} for values in targets]
        primitives.append(
            {
                "attributes": {"POSITION": buffer.add(result.mesh.points[used], _ARRAY)},
                "indices": buffer.add(local.ravel(), _ELEMENTS),
                "material": number,
                "targets": morphs,
            }
        )
    content = {
        "asset": {"version": "2.0", "generator": "tactgen"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        # z is up here, y is up in glTF
        "nodes": [{"mesh": 0, "rotation": [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]}],
        "meshes": [
            {
                "primitives": primitives,
                "weights": [0.0] * len(targets),
                "extras": {"targetNames": names},
            }
        ],
        "materials": [_material(name, colours) for name in result.mesh.regions],
        "animations": _animations(buffer, states),
        "buffers": [{"byteLength": len(buffer.data)}],
        "bufferViews": buffer.views,
        "accessors": buffer.accessors,
    }
    with written_whole(path) as temporary:
        temporary.write_bytes(_packed(content, bytes(buffer.data)))


def _parts(result: FieldResult, state: State) -> list[tuple[str, Floats]]:
    """Names and drawn displacements of a state's morph targets."""
    moved = np.asarray(state.fields["displacement"])
    largest = float(np.linalg.norm(np.abs(moved), axis=1).max())
    moved = _DRAWN * float(np.ptp(result.mesh.points[:, 2])) / largest * moved
    if state.kind == "mode":
        return [(state.name, np.real(moved))]
    name = state.name
    return [(f"{name}, real part", np.real(moved)), (f"{name}, imaginary part", np.imag(moved))]


def _material(name: str, colours: Mapping[str, tuple[float, float, float]]) -> dict[str, Any]:
    red, green, blue = colours.get(name, (0.7, 0.7, 0.7))
    return {
        "name": name,
        "doubleSided": True,
        "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, 1.0],
            "metallicFactor": 0.1,
            "roughnessFactor": 0.6,
        },
    }


def _animations(buffer: _Buffer, states: list[State]) -> list[dict[str, Any]]:
    """Animation of each state; in each all other states' weights are nought."""
    widths = [1 if state.kind == "mode" else 2 for state in states]
    time = buffer.add(np.linspace(0.0, _PERIOD, _STEPS + 1))
    phase = 2.0 * np.pi * np.arange(_STEPS + 1) / _STEPS
    found = []
    for number, state in enumerate(states):
        weights = np.zeros((_STEPS + 1, sum(widths)))
        first = sum(widths[:number])
        weights[:, first] = np.cos(phase)
        if widths[number] == 2:
            weights[:, first + 1] = -np.sin(phase)
        sampler = {"input": time, "output": buffer.add(weights.ravel()), "interpolation": "LINEAR"}
        found.append(
            {
                "name": f"{state.name}, {state.frequency:.6g} Hz",
                "samplers": [sampler],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            }
        )
    return found


def _packed(content: dict[str, Any], data: bytes) -> bytes:
    """Binary glTF: header, JSON padded with blanks, data in numbers of four bytes."""
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
