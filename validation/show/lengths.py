"""A bimorph's modes at any length of a range: frequencies with bars, shapes between solved ones.

Frequencies are known at many lengths: by a surrogate of the solid, by a beam model at each.
Shapes are solved at a few lengths, on a coarser division, and between these are the polynomials
in the length through them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BarycentricInterpolator, make_interp_spline

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.solve import solve
from tactgen.validation.engine.surrogate import build_surrogate, design_size
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.field import Circuit, FieldResult
from tactgen.validation.show.gather import CIRCUITS, gather

#: A mode: its circuit, its class of motion, and its place among those of this class.
ModeKey = tuple[Circuit, str, int]


@dataclass(frozen=True)
class ModeOverLength:
    """One mode over the length."""

    #: Which it is: the place counts modes of one class of motion, from 0
    circuit: Circuit
    motion: str
    place: int
    #: (n,) Hz, with error bars; nan where it is not among the lowest that the scene asks for
    frequency: Floats
    error: Floats
    shapes: Floats  #: (k, points, 3) Displacements at the solved lengths (m)


@dataclass(frozen=True)
class LengthRange:
    """A model's bimorph over a range of lengths."""

    here: float  #: The scene's own length (m)
    mesh: Mesh  #: Points and cells at the length in the middle
    lengths: Floats  #: (n,) Where frequencies are known, ascending (m)
    solved: Floats  #: (k,) Where shapes are (m)
    points: Floats  #: (k, points, 3) The points at the solved lengths (m)
    modes: tuple[ModeOverLength, ...]  #: Those with a shape everywhere in the range
    #: Largest part of a displacement by which an interpolated shape was off at a length that was
    #: solved to judge it
    missed: float
    method: str  #: How the frequencies' bars come about


#: Lengths at which frequencies are known, and at which shapes are solved.
KNOWN, _SOLVED = 31, 5
#: Accuracy of shapes: what is drawn is not read to more than a percent.
_SHAPES = 1e-2
#: Modes more than the scene asks for that are solved, since their order changes with the length.
_MORE = 2


def length_range(
    scene: Scene,
    model: str,
    ends: tuple[float, float],
    announce: Callable[[str], None] = lambda _: None,
    known: int = KNOWN,
) -> LengthRange | None:
    """Modes over a range of lengths (m); None of a model that has no fast way to them.

    `known` is the number of lengths at which frequencies are worked out.

    Raises InputError if the range is empty or reversed, or the model cannot take a length in it.
    """
    low, high = ends
    if not low < high:
        raise InputError(
            f"--lengths runs from {1e3 * low:g} mm to {1e3 * high:g} mm; begin below where it ends"
        )
    lengths = np.linspace(low, high, known)
    tables = _tables(scene, model, lengths, announce)
    if tables is None:
        return None
    solved = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(
        np.pi * (np.arange(_SOLVED) + 0.5) / _SOLVED
    )
    # beside the middle node, where such a polynomial strays about as far as anywhere
    judge = 0.5 * (solved[_SOLVED // 2] + solved[_SOLVED // 2 + 1])
    asked = {
        "accuracy": max(scene.accuracy, _SHAPES), "modes": scene.modes + _MORE, "models": (model,),
    }  # fmt: skip
    results = []
    for number, length in enumerate((*solved, judge), start=1):
        announce(f"shapes of {model}: length {number} of {_SOLVED + 1}")
        coarse = _at(scene, float(length)).model_copy(update=asked)
        results += gather(coarse, [model], (), "edges")
    base = results[_SOLVED // 2]
    carried = [carrier(base.mesh, result.mesh) for result in results]
    points = np.stack([to(of.mesh.points) for to, of in zip(carried, results, strict=True)])
    by_key = [_shapes(result, to) for result, to in zip(results, carried, strict=True)]
    modes, missed = [], 0.0
    for key, first in by_key[0].items():
        if key in tables and all(key in found for found in by_key):
            shapes = np.stack([_turned_like(first, found[key]) for found in by_key])
            apart = np.abs(BarycentricInterpolator(solved, shapes[:-1])(judge) - shapes[-1]).max()
            missed = max(missed, float(apart / np.abs(shapes[-1]).max()))
            modes.append(ModeOverLength(*key, *tables[key], shapes[:-1]))
    method = "closed form at each length"
    if not MODELS[model].quick:
        method = (
            f"interpolated between {design_size(1)} lengths, accuracy {100 * scene.accuracy:g} %; "
            "the bar holds what left-out lengths are missed by"
        )
    return LengthRange(
        scene.bimorph.length, base.mesh, lengths, solved, points[:-1], tuple(modes), missed, method
    )


def _at(scene: Scene, length: float) -> Scene:
    bimorph = scene.bimorph.model_copy(update={"length": length})
    return scene.model_copy(update={"bimorph": bimorph})


def _tables(
    scene: Scene, model: str, lengths: Floats, announce: Callable[[str], None]
) -> dict[ModeKey, tuple[Floats, Floats]] | None:
    """Frequency and bar (n,) of each mode over the lengths."""
    scenes = [_at(scene, float(length)) for length in lengths]
    names = tuple(name for _, name in CIRCUITS)
    answers: Sequence[Sequence[Quantity]]
    if MODELS[model].quick:
        announce(f"frequencies of {model} at {lengths.size} lengths")
        answers = [solve(one, (model,), names).quantities for one in scenes]
    elif model == "solid":  # meshes of the others do not correspond
        ranges = {"bimorph.length": (float(lengths[0]), float(lengths[-1]))}
        surrogate = build_surrogate(scene, model, names, ranges, announce)
        answers = surrogate.answers({"bimorph.length": lengths})
    else:
        return None
    tables: dict[ModeKey, tuple[Floats, Floats]] = {}
    for n, found in enumerate(answers):
        by_name = {q.name: q for q in found}
        for circuit, name in CIRCUITS:
            for key, place in _keys(circuit, by_name[name].classes or ()):
                if key not in tables:
                    tables[key] = np.full(lengths.size, np.nan), np.full(lengths.size, np.nan)
                tables[key][0][n] = by_name[name].value[place]
                tables[key][1][n] = by_name[name].error[place]
    return tables


def _keys(circuit: Circuit, classes: Sequence[str]) -> list[tuple[ModeKey, int]]:
    """Modes of a list of classes, each with its place in the list."""
    return [
        ((circuit, motion, classes[:place].count(motion)), place)
        for place, motion in enumerate(classes)
    ]


def _shapes(result: FieldResult, carry: Callable[[Floats], Floats]) -> dict[ModeKey, Floats]:
    found: dict[ModeKey, Floats] = {}
    for circuit, _ in CIRCUITS:
        states = [s for s in result.states if s.kind == "mode" and s.circuit == circuit]
        for key, place in _keys(circuit, [s.motion for s in states]):
            found[key] = carry(np.real(states[place].fields["displacement"]))
    return found


def _turned_like(first: Floats, shape: Floats) -> Floats:
    """Shape with the sign that makes it most like another."""
    return shape if float(np.vdot(first, shape)) >= 0.0 else -shape


def carrier(base: Mesh, mesh: Mesh) -> Callable[[Floats], Floats]:
    """Map of values (n, 3) from the points of one length to those (m, 3) of the base's.

    Points of one part that lie above each other form a column; columns of both meshes are the
    same, and stations along them correspond by their share of the column's height.  Meshes of
    the same cells correspond point by point.
    """
    if np.array_equal(base.cells, mesh.cells):
        return np.asarray
    own = _columns(mesh)

    def carry(values: Floats) -> Floats:
        out = np.empty((len(base.points), 3))
        for region, (at, z_base) in _columns(base).items():
            here, z = own[region]
            wanted = z[0] + (z_base - z_base[0]) / (z_base[-1] - z_base[0]) * np.ptp(z)
            spline = make_interp_spline(z, values[here], k=min(3, z.size - 1), axis=1)
            out[at] = spline(wanted)
        return out

    return carry


def _columns(mesh: Mesh) -> dict[int, tuple[Ints, Floats]]:
    """By region its points as columns (c, nz), ascending, and their heights (nz,)."""
    region = np.zeros(len(mesh.points), dtype=np.int64)
    region[mesh.cells] = mesh.region_of_cell[:, None]
    found: dict[int, tuple[Ints, Floats]] = {}
    for number in range(len(mesh.regions)):
        chosen = np.flatnonzero(region == number)
        x, y, z = (np.round(mesh.points[chosen, k] / 1e-12) for k in range(3))
        ordered = chosen[np.lexsort((z, y, x))]
        heights = np.unique(z).size
        columns = ordered.reshape(-1, heights)
        found[number] = columns, mesh.points[columns[0], 2]
    return found
