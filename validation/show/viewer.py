"""Results as the page gets them: arrays packed into one block, and words for every state."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.solids import colour_of
from tactgen.geometry.formats import share, with_error
from tactgen.geometry.meshing.mesh import Mesh, Surface, surface_of
from tactgen.validation.show.colours import MAGNITUDE, SIGNED, Shade, colour_stops, shades_of
from tactgen.validation.show.field import (
    MODELS,
    Array,
    FieldResult,
    State,
    drawn_size,
    enlargement,
    region_title,
    words_of,
)
from tactgen.validation.show.lengths import LengthRange, ModeOverLength

#: Where regions go when the device is drawn apart, in the unit of the slider's reach; those of
#: `_SIDED` go to the side on which a point lies.
_APART = {
    "piezo_top": (1.0, 0.0, 0.0), "piezo_bottom": (-1.0, 0.0, 0.0), "glue": (0.5, 0.0, 0.0),
    "rod": (0.0, 0.0, -1.0), "sleeve": (0.0, -1.5, 0.0), "coil": (0.0, -0.7, 0.0),
}  # fmt: skip
_SIDED = ("glue",)
#: How the page forms a colour's value: the size, a component, an amplitude that swings, one not.
_SIZE, _COMPONENT, _SWINGING, _STEADY = 1, 2, 3, 4
#: Largest magnitude of a small integer.
_FULL = 32767
#: Most cells that go into a page, to fill the face of a cut.
_MOST_CELLS = 6000
#: Angle (cosine) from which on two faces have an edge that is drawn of the shape at rest.
_SHARP = 0.8


@dataclass
class Block:
    """The binary part as it grows; equal arrays are there once."""

    data: bytearray = field(default_factory=bytearray)
    known: dict[bytes, dict[str, Any]] = field(default_factory=dict)

    def plain(self, values: Floats | Ints) -> dict[str, Any]:
        """Append numbers as they are (single precision) and return where they are."""
        integers = np.issubdtype(np.asarray(values).dtype, np.integer)
        kind = "u4" if integers else "f4"
        return self._put(np.ascontiguousarray(values, dtype="<" + kind), kind, 1.0)

    def small(self, values: Floats, top: float) -> dict[str, Any]:
        """Append numbers up to `top` as integers of 16 bits: good to 1.5e-5 of it."""
        scale = top / _FULL if top > 0.0 else 1.0
        return self._put(np.rint(values / scale).astype("<i2"), "i2", scale)

    def _put(self, values: Array, kind: str, scale: float) -> dict[str, Any]:
        packed = values.tobytes()
        key = packed + kind.encode() + repr(scale).encode()
        if key not in self.known:
            self.data += b"\0" * (-len(self.data) % 4)
            self.known[key] = {
                "offset": len(self.data), "count": int(values.size), "type": kind, "scale": scale,
            }  # fmt: skip
            self.data += packed
        return self.known[key]

    def text(self) -> str:
        """Block, deflated, in base64."""
        deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
        return base64.b64encode(deflate.compress(bytes(self.data)) + deflate.flush()).decode()


def payload(
    results: Sequence[FieldResult], ranges: Sequence[LengthRange | None] = ()
) -> dict[str, Any]:
    """Data of the page, as plain JSON values.

    Parameters
    ----------
    ranges : sequence of LengthRange or None
        Of each result what it is at other lengths; none at all where no length is moved.
    """
    block = Block()
    others = ranges or (None,) * len(results)
    return {
        "scene": results[0].scene,
        "conditions": results[0].conditions,
        "palettes": {"magnitude": colour_stops(MAGNITUDE), "signed": colour_stops(SIGNED)},
        "results": [
            _result(block, result, other) for result, other in zip(results, others, strict=True)
        ],
        "blob": block.text(),
    }


def _result(block: Block, result: FieldResult, other: LengthRange | None) -> dict[str, Any]:
    shades = shades_of(result)
    geometry, used = _geometry(block, result.mesh)
    return {
        "model": result.model,
        "title": MODELS.get(result.model, result.model),
        "regions": [_region(name, name in result.rigid) for name in result.mesh.regions],
        **geometry,
        "lines": None if result.lines is None else block.plain(result.lines.reshape(-1, 3)),
        "fields": [_shade(shade) for shade in shades],
        "states": [_state(block, result, state, shades, used) for state in result.states],
        "lengths": None if other is None else _lengths(block, result, other),
    }


def _geometry(block: Block, mesh: Mesh) -> tuple[dict[str, Any], Ints]:
    """Drawn points and cells, and their points in the mesh."""
    surface = surface_of(mesh)
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    region = np.zeros(len(mesh.points), dtype=np.int64)
    region[mesh.cells] = mesh.region_of_cell[:, None]
    # of a large result the surface alone; a cut through it is hollow
    hollow = len(mesh.cells) > _MOST_CELLS
    used = np.unique(surface.triangles) if hollow else np.arange(len(mesh.points))
    place = np.full(len(mesh.points), -1)
    place[used] = np.arange(used.size)
    return {
        "points": block.plain(mesh.points[used]),
        "regionOfPoint": block.plain(region[used]),
        "triangles": block.plain(place[surface.triangles].ravel()),
        "edges": block.plain(place[surface.edges].ravel()),
        "outline": block.plain(place[outline(mesh, surface)].ravel()),
        "cells": None if hollow else block.plain(mesh.cells.ravel()),
        "cellSize": mesh.cells.shape[1],
        "tip": int(place[tip_point(mesh.points)]),
        "box": {
            "low": low.tolist(), "high": high.tolist(), "centre": (0.5 * (low + high)).tolist(),
            "height": float(high[2] - low[2]), "width": float((high - low)[:2].max()),
        },
    }, used  # fmt: skip


def _lengths(block: Block, result: FieldResult, other: LengthRange) -> dict[str, Any]:
    """Result at other lengths: numbers at each, points and shapes at those solved."""
    geometry, used = _geometry(block, other.mesh)
    names: dict[tuple[str, str, int], str] = {}
    for state in (s for s in result.states if s.kind == "mode"):
        place = sum(key[:2] == (state.circuit, state.motion) for key in names)
        names[state.circuit, state.motion, place] = state.name
    modes = [(names.get((m.circuit, m.motion, m.place)), m) for m in other.modes]
    return {
        **geometry,
        "here": other.here,
        "at": other.lengths.tolist(),
        "solved": other.solved.tolist(),
        "shapes": [block.plain(points[used]) for points in other.points],
        "note": f"Frequencies: {other.method}. Shapes: solved at {other.solved.size} lengths, "
        f"between them off by up to {share(other.missed)}.",
        "modes": [_over_length(block, name, mode, other, used) for name, mode in modes if name],
    }


def _over_length(
    block: Block, name: str, mode: ModeOverLength, other: LengthRange, used: Ints
) -> dict[str, Any]:
    middle = mode.shapes.mean(axis=0)
    top = float(np.abs(mode.shapes).max())
    sizes = np.linalg.norm(mode.shapes, axis=2).max(axis=1)
    drawn = [drawn_size(p, u) for p, u in zip(other.points, mode.shapes, strict=True)]
    return {
        "name": name,
        # of one scale, so that the small differences pack well
        "middle": block.small(middle[used], top),
        "apart": [block.small((shape - middle)[used], top) for shape in mode.shapes],
        "drawn": (np.array(drawn) / sizes).tolist(),
        "texts": [
            with_error(float(f), float(bar), "Hz") if np.isfinite(f) else "not among the lowest"
            for f, bar in zip(mode.frequency, mode.error, strict=True)
        ],
    }


def _region(name: str, rigid: bool) -> dict[str, Any]:
    return {
        "name": name,
        "rigid": rigid,
        "title": region_title(name),
        "colour": colour_of(name),
        "apart": _APART.get(name, (0.0, 0.0, 0.0)),
        "sided": name in _SIDED,
    }


def _shade(shade: Shade) -> dict[str, Any]:
    moved = shade.field == "displacement"
    if moved:
        source = _SIZE if shade.component < 0 else _COMPONENT
    else:
        source = _SWINGING if shade.signed else _STEADY
    return {
        "key": shade.key,
        "title": shade.title,
        "unit": shade.unit,
        "signed": shade.signed,
        "source": source,
        "along": [float(shade.component == k) for k in range(3)] if moved else None,
    }


def _state(
    block: Block, result: FieldResult, state: State, shades: Sequence[Shade], used: Ints
) -> dict[str, Any]:
    words = words_of(result, state)
    arrays = {}
    if "displacement" in state.fields:
        arrays["displacement"] = _amplitude(block, np.asarray(state.fields["displacement"])[used])
    for shade in shades:
        amplitude = shade.amplitude(state)
        if shade.field != "displacement" and amplitude is not None:
            arrays[shade.key] = _amplitude(block, amplitude[used])
    return {
        "name": state.name,
        "kind": state.kind,
        "circuit": state.circuit,
        "motion": state.motion,
        "short": words.short,
        "text": words.number,
        "detail": words.detail,
        "title": words.title,
        "note": words.note,
        "moves": "displacement" in state.fields,
        "drawn": enlargement(result, state),
        "tops": {shade.key: shade.top(state) for shade in shades},
        "arrays": arrays,
    }


def _amplitude(block: Block, values: Array) -> list[dict[str, Any]]:
    """Where real and, if there is one, imaginary part are."""
    real, imaginary = np.real(values).ravel(), np.imag(values).ravel()
    parts = [real, imaginary] if imaginary.any() else [real]
    top = float(max(np.abs(part).max() for part in parts))
    return [block.small(part, top) for part in parts]


def tip_point(points: Floats) -> int:
    """Point in the middle of the highest face."""
    top = points[:, 2] > points[:, 2].max() - 1e-9
    away = np.where(top, np.hypot(points[:, 0], points[:, 1]), np.inf)
    return int(np.argmin(away))


def outline(mesh: Mesh, surface: Surface) -> Ints:
    """Edges (m, 2) at which the surface turns sharply: the shape at rest in lines."""
    corners = mesh.points[surface.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
    pairs = np.sort(surface.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(normals)), 3)
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    pairs, owner = pairs[order], owner[order]
    same = (pairs[1:] == pairs[:-1]).all(axis=1)
    first = np.flatnonzero(same)
    turned = np.einsum("ni,ni->n", normals[owner[first]], normals[owner[first + 1]]) < _SHARP
    return np.asarray(pairs[first[turned]])
