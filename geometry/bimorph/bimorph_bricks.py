"""How the bimorph is divided into bricks: fine where the solution is singular.

Layers, shim tab and electrodes are resolved exactly.  Bricks shrink geometrically towards
the held end, the ceramic's and the electrodes' ends and the side edges; elsewhere a few
long ones of high degree carry the smooth rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Axis, Bricks, Held, Slab
from tactgen.geometry.device.checks import check_bonded, check_constant_section
from tactgen.geometry.device.parameters import Bimorph, Device

#: Ratio of neighbouring intervals towards a side edge.
_GROWTH = 4.0
#: What is left in the middle is one interval if it is no more than so many of the next: none is
#: then much narrower than its neighbour.
_LAST = 1.5
#: Longest brick across the width, in thicknesses of the bimorph, or this share of half the
#: width if that is more: in a thin plate what is far from the edges varies with the width.
_WIDEST = 3.0
_WIDEST_SHARE = 0.5
#: Share of half the width that counts as a layer's thickness if that is more.
_SIDE_SHARE = 0.5
#: Half a shim up to this many piezo layers thick is one interval: polynomials across it
#: have more to give than the layers' have.
_THIN_CORE = 0.6
#: Share of the thickness that a layer counts with if it is thinner.
_LEAST_GRAIN = 0.1


@dataclass(frozen=True)
class BrickMeshing:
    """How finely the bimorph is divided."""

    degree: tuple[int, int, int]  #: (int, int, int) Degree of the polynomials along x, y and z
    #: Intervals of a piezo layer from its inner to its outer face, as shares of it
    layer: tuple[float, ...] = (1.0,)
    #: Intervals of half the shim where that is no thin part of the whole; otherwise it is one
    core: int = 1
    #: Interval at the side edge, as a share of the thinnest layer, or of a quarter of the width if
    #: that is less (0: no grading)
    side: float = 0.0
    #: Length of the bricks at the held end and at the ceramic's lower end, as a share of the
    #: thinnest layer
    smallest: float = 0.2
    tip: float = 0.2  #: The same at the upper end, where the singularity is weak
    longest: float = 6.0  #: Longest brick along z, in thicknesses of the bimorph
    #: (float, float) Fewest and most pieces of the length that the longest brick may be all the
    #: same: modes of a stout bimorph, and what is far from the ends of a slender one, vary with it
    pieces: tuple[float, float] = (6.0, 10.0)
    growth: float = 6.0  #: Ratio of neighbouring lengths along z
    #: Polynomials in a hierarchy, of which these products are there
    #: (:class:`geometry.bimorph.bricks.Bricks`); without it those of nodes, all products
    richness: float | None = None


#: A family of divisions for refinement studies; from one to the next errors fall by two to
#: four (about 2, 3, 8, 14 and 27 thousand unknowns for a plain bimorph).  What is coarse in
#: one must be finer in the next (degree or length, each axis, edges and ends), or their
#: difference would not tell what is missing.
LEVELS = (
    BrickMeshing(
        (2, 2, 3), side=0.4, smallest=0.4, tip=1.0, longest=8.0, pieces=(4.0, 10.0), richness=2.0
    ),
    BrickMeshing((4, 4, 4), side=0.65, smallest=0.2, tip=1.0, pieces=(4.0, 10.0), richness=1.25),
    BrickMeshing(
        (4, 4, 5), (0.35, 0.65), 2, 0.25, 0.07, tip=0.5, pieces=(4.0, 10.0), richness=1.25
    ),
    BrickMeshing((4, 4, 5), (0.15, 0.85), 3, 0.15, 0.03, longest=5.0, pieces=(5.0, 10.0),
                 richness=1.5),
    BrickMeshing((4, 4, 5), (0.15, 0.7, 0.15), 4, 0.1, 0.015, tip=0.1, longest=5.0, growth=5.0,
                 richness=1.5),
)  # fmt: skip


def bimorph_bricks(device: Device, meshing: BrickMeshing, held: Held = "layers") -> Bricks:
    """Divide a quarter of the bimorph, z = 0 at the lower end of the tab (or of the ceramic).

    Raises InputError if the cross-section changes along the ceramic, or glue lets the layers slide.
    """
    check_constant_section(device)
    check_bonded(device)
    bimorph = device.bimorph
    half, glue = 0.5 * bimorph.shim_thickness, bimorph.glue_thickness
    piezo = bimorph.piezo_thickness
    ends_inside = bimorph.bare_below > 0.0 or bimorph.bare_above > 0.0
    # the field is singular at the end of an electrode, on the outer face
    shares = sorted(meshing.layer, reverse=True) if ends_inside else meshing.layer
    core = meshing.core if half > _THIN_CORE * piezo else 1
    steps = [half / core] * core + ([glue] if glue > 0.0 else []) + [s * piezo for s in shares]
    x = np.concatenate([[0.0], np.cumsum(steps)])
    x[-1] = half + glue + piezo
    y = _across(bimorph, meshing)
    z, ceramic, electrode = _along(device, meshing)
    n, first = z.size - 1, core + (glue > 0.0)
    slabs = [Slab("shim", (0, core), (0, n)), Slab("piezo", (first, x.size - 1), (ceramic, n))]
    if glue > 0.0:
        slabs.insert(1, Slab("glue", (core, first), (ceramic, n)))
    ax, ay, az = (
        Axis(breaks, degree, hierarchic=meshing.richness is not None)
        for breaks, degree in zip((x, y, z), meshing.degree, strict=True)
    )
    bricks = Bricks(ax, ay, az, slabs=tuple(slabs), electrode=electrode, held=held)
    return bricks if meshing.richness is None else replace(bricks, richness=meshing.richness)


def _grain(bimorph: Bimorph) -> float:
    """Length (m) on which the solution varies at edges and ends.

    That is the thinnest layer; of a foil a tenth of the whole, of which ever flatter bricks
    would only cost digits.
    """
    thin = min(bimorph.piezo_thickness, bimorph.shim_thickness)
    return float(max(thin, _LEAST_GRAIN * bimorph.thickness))


def _across(bimorph: Bimorph, meshing: BrickMeshing) -> Floats:
    """Divide the half width, intervals growing from the side edge inwards."""
    half_width = 0.5 * bimorph.width
    widest = max(_WIDEST * bimorph.thickness, _WIDEST_SHARE * half_width)
    if meshing.side == 0.0:
        return np.linspace(0.0, half_width, int(np.ceil(half_width / widest)) + 1)
    steps = [meshing.side * min(_grain(bimorph), _SIDE_SHARE * half_width)]
    while (rest := half_width - sum(steps)) > _LAST * (step := min(_GROWTH * steps[-1], widest)):
        steps.append(step)
    steps.append(rest)
    return np.concatenate([[0.0], np.cumsum(steps[::-1])[:-1], [half_width]])


def _along(device: Device, meshing: BrickMeshing) -> tuple[Floats, int, tuple[int, int]]:
    """Divide the length; also return where the ceramic starts and its electrode reaches."""
    bimorph = device.bimorph
    thin = _grain(bimorph)
    length = bimorph.tab_length + bimorph.length
    at_most, at_least = (length / pieces for pieces in meshing.pieces)
    longest = min(max(meshing.longest * bimorph.thickness, at_least), at_most)
    first, last = meshing.smallest * thin, max(meshing.smallest, meshing.tip) * thin
    below, above = bimorph.bare_below, bimorph.bare_above
    stretches = [(bimorph.tab_length, first, first), (below, first, first)]
    end = last if above == 0.0 else first
    stretches.append((bimorph.length - below - above, first, end))
    stretches.append((above, first, last))
    z, marks = np.zeros(1), []
    for length, lower, upper in stretches:
        marks.append(z.size - 1)
        if length > 0.0:
            part = _graded(length, lower, upper, meshing.growth, longest)
            z = np.concatenate([z, z[-1] + part[1:]])
    z[-1] = bimorph.tab_length + bimorph.length
    return z, marks[1], (marks[2], marks[3])


def _graded(length: float, first: float, last: float, growth: float, longest: float) -> Floats:
    """Divide [0, length], intervals growing from `first` below and `last` above."""
    lower, upper = [first], [last]
    while sum(lower) + sum(upper) < length:
        side = lower if lower[-1] <= upper[-1] else upper
        side.append(min(side[-1] * growth, longest))
    steps = np.array(lower + upper[::-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) * float(length / steps.sum())
