"""Moving modes and fields as binary glTF: morph targets that any glTF viewer plays.

One mesh with a primitive for each region; each state is an animation that swings the weights
of its own targets: a mode one, the cosine; a harmonic state two, so that its phase is true:
u(t) = Re(û) cos Ωt − Im(û) sin Ωt.  One period lasts two seconds.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.files import written_whole
from tactgen.geometry.meshing.mesh import surface_of
from tactgen.validation.fields.result import FieldResult, State

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

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    states = [state for state in result.states if state.kind != "static"]
    targets = [part for state in states for part in _parts(result, state)]
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
                "extras": {"targetNames": _target_names(states)},
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


def drawn_scale(result: FieldResult, state: State) -> float:
    """Return by how much displacements are enlarged, so that the largest is well seen."""
    height = float(np.ptp(result.mesh.points[:, 2]))
    size = float(np.abs(np.linalg.norm(np.abs(state.fields["displacement"]), axis=1)).max())
    return _DRAWN * height / size


def _parts(result: FieldResult, state: State) -> list[Floats]:
    moved = drawn_scale(result, state) * np.asarray(state.fields["displacement"])
    if state.kind == "mode":
        return [np.real(moved)]
    return [np.real(moved), np.imag(moved)]


def _target_names(states: list[State]) -> list[str]:
    names: list[str] = []
    for state in states:
        parts = ("",) if state.kind == "mode" else (", real part", ", imaginary part")
        names += [state.name + part for part in parts]
    return names


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
    """Return an animation of each state; in each all other states' weights are nought."""
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
    """Return a binary glTF: header, JSON padded with blanks, data in numbers of four bytes."""
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
