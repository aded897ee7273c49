"""A model's bimorph over a range of lengths, as a value: what the page's slider shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.show.fields.result import Circuit

#: A mode: its circuit, its class of motion, and its place among those of this class.
ModeKey = tuple[Circuit, str, int]


@dataclass(frozen=True)
class ModeOverLength:
    """One mode over the length.

    Attributes
    ----------
    frequency, bar : (n,) array
        Hz; nan where it is not among the lowest that the scene asks for.
    """

    #: Which it is: the place counts modes of one class of motion, from 0
    circuit: Circuit
    motion: str
    place: int
    frequency: Floats
    error: Floats
    shapes: Floats  #: (k, points, 3) Displacements at the solved lengths (m)


@dataclass(frozen=True)
class LengthRange:
    """A model's bimorph over a range of lengths."""

    model: str  #: Its name
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


def lagrange_weights(nodes: Floats, at: float) -> Floats:
    """What values at nodes (k,) count with in their polynomial at a place, (k,)."""
    apart = nodes[:, None] - nodes[None, :] + np.eye(nodes.size)
    ratios = (at - nodes[None, :]) / apart
    np.fill_diagonal(ratios, 1.0)
    return np.asarray(ratios.prod(axis=1))
