"""Section of a straight bimorph far from its ends, solved over its width and its thickness.

An infinitely long bimorph that stretches by ε and bends by κ (strain ε + κ x along z) under a
voltage deforms in its cross-section and has a potential there: a plane problem for u_x, u_y and φ.
Its energy per length is a quadratic form of ε, κ and U.  Narrow, it is that of a beam; wide, that
of laminate theory; between the two the layers' unequal contraction across the width is relieved
within about a thickness of the side edges, of each layer's where they have widths of their own.

Polynomials through each layer and across a few stretches of half the width; layer after layer is
eliminated from the lower face on.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.legendre import legder, leggauss, legval, legvander

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.bimorph.segments import StackLayer, bimorph_stack, side_edges
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Device, Glue, Piezo, Shim

#: Degree of the polynomials through a layer and across a stretch of the width.  EI is then within
#: 1e-4 of much finer ones, K and C mostly within 1e-3; C of a ceramic far thinner than the rest,
#: the field at whose edges is not resolved, within 1.5e-2.
_THROUGH, _ACROSS = 5, 5
#: Ends of the stretches of half the width from an edge, in thicknesses of the bimorph; one that
#: takes nearly all is not divided.
_STRETCHES, _NEARLY = (1.0, 3.0), 0.7
#: Units of stress (Pa), and of permittivity for that of the potential.
_STRESS, _PERMITTIVITY = 1e11, 1e3 * EPS0


class Sheet(NamedTuple):
    """Tensors of a layer in the device's axes."""

    c: Floats  #: (6, 6) Stiffness (Pa)
    e: Floats  #: (3, 6) Piezoelectric constants (C/m²), 0 of what has none
    eps: Floats  #: (3, 3) Permittivity at constant strain (F/m), 0 of what has no field


def sheet_of(layer: StackLayer) -> Sheet:
    """Tensors of a layer."""
    found = _tensors(layer.material)
    return found._replace(e=layer.poling * found.e)


@lru_cache(maxsize=64)
def _tensors(of: Piezo | Shim | Glue) -> Sheet:
    """Tensors of a material, poled along +x."""
    if isinstance(of, Piezo):
        tensors = of.ceramic().tensors()
        return Sheet(np.real(tensors.c), np.real(tensors.e), np.real(tensors.eps))
    return Sheet(of.stiffness(), np.zeros((3, 6)), np.zeros((3, 3)))


def section_constants(device: Device) -> tuple[float, float, float]:
    """EI (N m²), K (N m/V) and C (F/m) of the length that the ceramics cover, no axial force."""
    own = device.bimorph
    return _constants(tuple(bimorph_stack(device)), own.thickness, own.width)


@lru_cache(maxsize=64)
def _constants(
    layers: tuple[StackLayer, ...], h: float, width: float
) -> tuple[float, float, float]:
    """The same; a study of anything else than the section asks again and again."""
    form = section_energy(layers, h, width)
    free = form[1:, 1:] - np.outer(form[1:, 0], form[0, 1:]) / form[0, 0]
    unit = _STRESS * h**2
    volt = h * np.sqrt(_STRESS / _PERMITTIVITY)
    bending, coupling, charge = free[0, 0], free[0, 1], free[1, 1]
    return (
        float(unit * h**2 * bending), float(-unit * h / volt * coupling),
        float(-unit / volt**2 * charge),
    )  # fmt: skip


def section_energy(layers: Sequence[StackLayer], h: float, width: float) -> Floats:
    """Quadratic form (3, 3) of ε, κ h and U per length.

    Lengths in thicknesses h of the bimorph, stress and potential in units of their own.
    """
    across = _lines(np.array([0.5 * width * layer.share / h for layer in layers]))
    nodes = [line.mass.shape[0] for line in across]
    potentials, known = _faces(layers, nodes)
    form, last = np.zeros((3, 3)), len(layers) - 1
    carried, moved = np.zeros((0, 0)), np.zeros((0, 3))
    for number, (layer, line, ny) in enumerate(zip(layers, across, nodes, strict=True)):
        matrix, load, own = _layer(layer, h, line)
        held, free = _unknowns(layer, potentials[number : number + 2], known, number, ny)
        load[:, 2] += matrix @ held
        own[2, 2] = held @ matrix @ held
        own[:2, 2] = own[2, :2] = load[:, :2].T @ held
        form += own
        lower, inner, upper = (np.flatnonzero(part) for part in free)
        if number:
            shared = lower[lower % ny < nodes[number - 1]]
            matrix[np.ix_(shared, shared)] += carried
            load[shared] += moved
        of_next = upper % ny < (nodes[number + 1] if number < last else 0)
        gone, kept = np.concatenate([lower, inner, upper[~of_next]]), upper[of_next]
        follows = np.linalg.solve(
            matrix[np.ix_(gone, gone)], np.hstack([matrix[np.ix_(gone, kept)], load[gone]])
        )
        to_kept = matrix[np.ix_(kept, gone)]
        carried = matrix[np.ix_(kept, kept)] - to_kept @ follows[:, : kept.size]
        moved = load[kept] - to_kept @ follows[:, kept.size :]
        form -= load[gone].T @ follows[:, kept.size :]
    return 2.0 * form


def _lines(halves: Floats) -> list[_Line]:
    """Integrals across half of each layer, whose half widths (n,) are in thicknesses.

    All on the same stretches, short ones inwards of each layer's side edge, and outwards of it
    where other layers go on.
    """
    breaks = [0.0]
    for low, high in pairwise(side_edges(halves)):
        near = _NEARLY * (high - low) * (0.5 if low else 1.0)
        short = [one for one in _STRETCHES if one < near]
        breaks += [low + one for one in short if low] + [high - one for one in short[::-1]] + [high]
    at = np.array(breaks)
    ends = [int(np.abs(at - half).argmin()) + 1 for half in halves]
    lines = {end: _line(at[:end], _ACROSS) for end in set(ends)}
    return [lines[end] for end in ends]


def _faces(layers: Sequence[StackLayer], nodes: Sequence[int]) -> tuple[Floats, Ints]:
    """Potential (n + 1,) of each face, 1 at the voltage and nan where it follows.

    And how many nodes from the middle on a ceramic has on that face.  A bare ceramic beside a
    narrower one with electrodes has the voltage on all of its face, not under these alone.
    """
    potentials = np.full(len(layers) + 1, np.nan)
    known = np.zeros(len(layers) + 1, dtype=int)
    for number, (layer, ny) in enumerate(zip(layers, nodes, strict=True)):
        if isinstance(layer.material, Piezo):
            known[number : number + 2] = np.maximum(known[number : number + 2], ny)
            if layer.electrodes:
                potentials[number : number + 2] = [layer.hot < 0.0, layer.hot > 0.0]
    return potentials, known


def _unknowns(
    layer: StackLayer, faces: Floats, known: Ints, number: int, ny: int
) -> tuple[Floats, list[Bools]]:
    """Prescribed values (n,) of a layer, and its free ones: below, inside, and above (n,)."""
    shape = (_THROUGH + 1, 3, ny)
    free, held = np.zeros(shape, dtype=bool), np.zeros(shape)
    free[:, :2] = True
    free[:, 1, 0] = False  # the plane of symmetry
    if number == 0:
        free[0, 0, 0] = False  # and what the body as a whole would do
    ceramic = isinstance(layer.material, Piezo)
    free[1:-1, 2] = ceramic and not (layer.uniform and layer.electrodes)
    for at, side in ((0, 0), (-1, 1)):
        free[at, 2, : known[number + side]] = np.isnan(faces[side])
        held[at, 2] = 0.0 if np.isnan(faces[side]) or not ceramic else faces[side]
    if ceramic and layer.uniform and layer.electrodes:
        held[:, 2] = np.linspace(faces[0], faces[1], _THROUGH + 1)[:, None]
    parts = np.zeros((3, *shape), dtype=bool)
    parts[0, 0], parts[1, 1:-1], parts[2, -1] = free[0], free[1:-1], free[-1]
    return held.ravel(), [part.ravel() for part in parts]


class _Line(NamedTuple):
    """Integrals of polynomials along a line: N N, N N', N' N' and N, N'."""

    mass: Floats
    mixed: Floats
    stiff: Floats


@cache
def _reference(degree: int) -> tuple[Floats, ...]:
    """Integrals over 0 to 1 of polynomials on equidistant points.

    Of N N, N N', N' N', and of N, N x, N', N' x.
    """
    nodes = np.linspace(-1.0, 1.0, degree + 1)
    x, weights = leggauss(degree + 2)
    to_nodes = np.linalg.inv(legvander(nodes, degree))
    values = (legvander(x, degree) @ to_nodes).T
    slopes = 2.0 * (legval(x, legder(np.eye(degree + 1))).T @ to_nodes).T
    x, weights = 0.5 * (x + 1.0), 0.5 * weights
    return (
        (values * weights) @ values.T, (values * weights) @ slopes.T,
        (slopes * weights) @ slopes.T, values @ weights, values @ (weights * x),
        slopes @ weights, slopes @ (weights * x),
    )  # fmt: skip


def _line(breaks: Floats, degree: int) -> _Line:
    """Integrals over several stretches."""
    size = (breaks.size - 1) * degree + 1
    found = _Line(*np.zeros((3, size, size)))
    mass, mixed, stiff, *_ = _reference(degree)
    for number, length in enumerate(np.diff(breaks)):
        at = slice(number * degree, (number + 1) * degree + 1)
        found.mass[at, at] += length * mass
        found.mixed[at, at] += mixed
        found.stiff[at, at] += stiff / length
    return found


def _layer(layer: StackLayer, h: float, y: _Line) -> tuple[Any, Any, Any]:
    """Energy of half a layer.

    Over (u_x, u_y, φ) at its nodes (n, n), of these with ε, κ h and U (n, 3), and of the latter
    alone (3, 3).
    """
    mass, mixed, stiff, one, lever, slope, slope_lever = _reference(_THROUGH)
    t, low = layer.thickness / h, layer.low / h
    mass, stiff = t * mass, stiff / t
    moments = np.array([t * one, t * (low * one + t * lever)])
    slopes = np.array([slope, low * slope + t * slope_lever])
    c, e, eps = sheet_of(layer)
    c, e, eps = c / _STRESS, e / np.sqrt(_STRESS * _PERMITTIVITY), eps / _PERMITTIVITY
    unit = np.array([mass, mixed, mixed.T, stiff])
    own = np.array([y.mass, y.mixed, y.mixed.T, y.stiff])

    def product(*terms: tuple[float, int, int]) -> Any:
        """Sum of integrals along x times integrals along y."""
        return sum(w * unit[i][:, None, :, None] * own[j][None, :, None, :] for w, i, j in terms)

    plain, right, left, both = range(4)  # which of the two factors is differentiated
    blocks = {
        (0, 0): product((c[0, 0], both, plain), (c[5, 5], plain, both)),
        (1, 1): product((c[1, 1], plain, both), (c[5, 5], both, plain)),
        (2, 2): product((-eps[0, 0], both, plain), (-eps[1, 1], plain, both)),
        (0, 1): product((c[0, 1], left, right), (c[5, 5], right, left)),
        (0, 2): product((e[0, 0], both, plain), (e[1, 5], plain, both)),
        (1, 2): product((e[0, 1], right, left), (e[1, 5], left, right)),
    }
    nx, ny = _THROUGH + 1, y.mass.shape[0]
    matrix, load = np.zeros((nx, 3, ny, nx, 3, ny)), np.zeros((nx, 3, ny, 3))
    for (i, j), block in blocks.items():
        matrix[:, i, :, :, j, :] = block
        if i != j:
            matrix[:, j, :, :, i, :] = block.transpose(2, 3, 0, 1)
    along, edge = y.mass.sum(axis=0), y.mixed.sum(axis=0)
    for k in (0, 1):
        load[:, 0, :, k] = c[0, 2] * np.outer(slopes[k], along)
        load[:, 1, :, k] = c[1, 2] * np.outer(moments[k], edge)
        load[:, 2, :, k] = e[0, 2] * np.outer(slopes[k], along)
    middle = low + 0.5 * t
    second_moment = t * (middle**2 + t**2 / 12.0)
    form = np.zeros((3, 3))
    form[:2, :2] = c[2, 2] * along.sum() * np.array([[t, t * middle], [t * middle, second_moment]])
    return matrix.reshape(nx * 3 * ny, -1), load.reshape(-1, 3), form
