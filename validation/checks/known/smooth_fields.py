"""Observed orders on smooth fields, of every way in which a field is divided here."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import Literal

import numpy as np

from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.geometry.device.steel_law import TEAM20, MagnetisationCurve, linear
from tactgen.validation.checks.case import Answer, Case, Refinement, case
from tactgen.validation.checks.cases import manufactured
from tactgen.validation.checks.cases.boxes import Box, block, even
from tactgen.validation.checks.cases.cube_cells import EDGE, Cells
from tactgen.validation.checks.cases.magnetics.manufactured_fields import (
    cube_error,
    cylinder,
    rings_error,
)
from tactgen.validation.checks.drawings.bodies import rings
from tactgen.validation.checks.drawings.sections import section
from tactgen.validation.checks.drawings.strips import strip

_STRANG = "G. Strang, G. J. Fix, An Analysis of the Finite Element Method, ch. 3 and 6"


def _rows(
    what: str,
    theory: int,
    error: Callable[[int], float],
    coarse: int,
    bound: tuple[float, str],
    heavy: bool = False,
) -> Iterator[Answer]:
    """Return two rows: the order from `coarse` divisions to twice as many, and a bound on these."""

    def order() -> float:
        return math.log2(error(coarse) / error(2 * coarse))

    near = (theory - 0.1, theory + 0.1)
    yield Answer(f"{what} converge with order {theory}.", near, "1", order, 0.0,
                 "within 0.1 of theory", heavy=heavy)  # fmt: skip
    yield Answer(f"{what} on {2 * coarse} divisions are off by no more than their bound.",
                 (0.0, bound[0]), "1", lambda: error(2 * coarse), 0.0, bound[1],
                 heavy=heavy)  # fmt: skip


def _halved(error: Callable[[int], float], *levels: int, order: int) -> Refinement:
    """Return the errors on so many divisions."""
    return Refinement(levels, error, f"order {order}")


# --- the piezoelectric solid -------------------------------------------------------------------


def interpolation_error(degree: int, divisions: int) -> float:
    """Return 2 (kh/4)^(p+1)/(p+1)!, the largest error of a wave's interpolation over cells h.

    k is the shortest wave's of the manufactured solution, 1.6 over the edge.
    """
    return 2.0 * (1.6 / divisions / 4.0) ** (degree + 1) / math.factorial(degree + 1)


def _solid(what: str, degree: int, error: Callable[[int], float], coarse: int,
           heavy: bool) -> Iterator[Answer]:  # fmt: skip
    bound = 2.0 * interpolation_error(degree, 2 * coarse)
    reason = "twice the largest error of interpolating its shortest wave"
    return _rows(what, degree + 1, error, coarse, (bound, reason), heavy)


def _bricks(degree: int, driven: bool, intervals: int) -> float:
    return float(manufactured.bricks_error(degree, intervals, driven)[1])


def _cells(cells: Cells, driven: bool, divisions: int) -> float:
    return float(manufactured.solid_error(cells, divisions, driven)[1])


def _slopes(cells: Cells, divisions: int) -> float:
    return float(manufactured.solid_error(cells, divisions, False)[0])


def _cube() -> Box:
    return block((even(EDGE, 4, 2),) * 3, manufactured.ceramic(lossy=False))


_STATES = ((False, "at rest"), (True, "at 0.5 MHz with losses"))
_PROBLEM = (
    "A cube of PZT-5H, 1 mm: displacement and potential are sines of four directions, given on all "
    "walls, and the load is what they need; at rest, and at 0.5 MHz with the ceramic's losses. "
    "Errors are relative, in the mean square."
)
#: Cells with the coarser division at rest.
_CELLS: tuple[tuple[Cells, int], ...] = (("straight", 3), ("curved", 3), ("hexahedra", 5))
_NAMES: dict[Cells, str] = {
    "straight": "straight tetrahedra of any shape",
    "curved": "curved tetrahedra",
    "hexahedra": "rectangular hexahedra",
}

_SOLIDS = (
    case(
        "MMSB",
        "Manufactured solution on bricks",
        _PROBLEM,
        model="bricks of the model solid, degrees 1 to 4",
        source=_STRANG,
        answers=[
            answer
            for degree, coarse in ((1, 8), (2, 4), (3, 2), (4, 2))
            for driven, state in _STATES
            for answer in _solid(
                f"Values on bricks of degree {degree}, {state},", degree,
                partial(_bricks, degree, driven), coarse, degree != 3,
            )
        ],
        refinement=_halved(partial(_bricks, 3, False), 1, 2, 4, order=4),
        setup=section(_cube),
    ),
    case(
        "MMSC",
        "Manufactured solution on cells of ten and twenty nodes",
        _PROBLEM,
        model="the cells of the model cad: quadratic tetrahedra; quadratic hexahedra beside them",
        source=_STRANG,
        answers=[
            answer
            for cells, coarse in _CELLS
            for answer in (
                *(
                    row
                    for driven, state in _STATES
                    for row in _solid(
                        f"Values on {_NAMES[cells]}, {state},", 2,
                        partial(_cells, cells, driven), max(4, coarse) if driven else coarse,
                        driven or cells == "hexahedra",
                    )
                ),
                *_rows(
                    f"Gradients on {_NAMES[cells]}, at rest,", 2, partial(_slopes, cells),
                    coarse, ((1.6 / (2 * coarse)) ** 2 / 12.0, "(kh)²/12 of the shortest wave"),
                    cells == "hexahedra",
                ),
            )
        ],
        refinement=_halved(partial(_cells, "curved", False), 2, 3, 4, 6, order=3),
        setup=section(_cube),
    ),
    case(
        "MMSE",
        "Thickness resonance on cells of ten and twenty nodes",
        "Case TE's plate of PZT-5A at short circuit, 2 mm thick: a column of its upper half, or a "
        "cube where cells are curved.",
        model="as case MMSC",
        source=f"IEEE Std 176-1987, in closed form; {_STRANG}",
        answers=[
            answer
            for cells, _ in _CELLS
            for answer in _rows(
                f"Frequencies on {_NAMES[cells]}", 4,
                partial(manufactured.plate_error, cells), 6,
                (2.0 * manufactured.quarter_wave_error(2, 12), "twice the leading term of a rod's"),
                cells == "curved",
            )
        ],
        refinement=_halved(partial(manufactured.plate_error, "straight"), 3, 6, 12, 24, order=4),
        setup=section(_cube),
    ),
)  # fmt: skip

# --- beam elements -----------------------------------------------------------------------------

#: The mode and the frequency (Hz) whose waves are short enough for errors above rounding.
_MODE, _FAST = 4, 50e3


@cache
def _mode_error(elements: int) -> float:
    from tactgen.fem import beam
    from tactgen.tmm.beam.modes import bending_frequencies
    from tactgen.tmm.beam.transfer_matrix import sections

    device, support = Device(), Support(kind="clamped")
    pieces = sections(device, support, Beam(), lossy=False)
    exact = bending_frequencies(pieces, Ends(), _MODE + 1, open_circuit=False)[_MODE]
    matrices = beam.assemble(device, support, Beam(), elements=elements, lossy=False)
    found = beam.bending_frequencies(matrices, Ends(), _MODE + 1, open_circuit=False)[_MODE]
    return abs(float(found / exact) - 1.0)


@cache
def _port_error(elements: int) -> float:
    """Return the largest error of the five ports' stiffness, by the diagonal's sizes."""
    from tactgen.fem import beam
    from tactgen.tmm.beam import transfer_matrix

    at = np.array([_FAST])
    exact = transfer_matrix.multiport(Device(), Support(), Beam(), at).stiffness[0]
    found = beam.multiport(Device(), Support(), Beam(), at, elements=elements).stiffness[0]
    size = np.sqrt(np.abs(np.diag(exact)))
    return float((np.abs(found - exact) / np.outer(size, size)).max())


_TENTH = "what the checks of beam elements ask of their default"
_BEAMS = case(
    "BEAMO",
    "Orders of beam elements",
    "The paper's 20 mm bimorph: its fifth frequency on a clamp without losses, and its five ports "
    "at 50 kHz with losses. At rest elements of degree five are exact.",
    model="beam elements of degree five",
    source=f"exact spans of the transfer-matrix model; {_STRANG}",
    answers=[
        *_rows("Frequencies by beam elements", 10, _mode_error, 12, (1e-8, _TENTH)),
        *_rows("Ports by beam elements", 10, _port_error, 16, (1e-8, _TENTH)),
    ],
    refinement=_halved(_mode_error, 4, 8, 12, 24, order=10),
    setup=partial(strip, 20.0, (("piezo", 0.21), ("shim", 0.25), ("piezo", 0.21))),
)  # fmt: skip

# --- magnetic fields ---------------------------------------------------------------------------

#: Curves by name, and what bounds the sixth derivative of u: see manufactured_fields.
_CURVES: tuple[tuple[str, MagnetisationCurve], ...] = (
    ("straight", linear(1000.0)), ("saturating", TEAM20),
)  # fmt: skip
_STEEPEST = {2: 24.0, 4: (math.pi / 2.0) ** 5}


def _rings_bound(order: int) -> float:
    """Return the error of a slope by degree p − 1 in Chebyshev points, cells of 1/8."""
    steep = _STEEPEST[order] / (2.0 ** (order - 1) * math.factorial(order))
    return (1.0 / 16.0) ** order * steep


#: Potential, its shortest wave over the edge, cells and the coarser division.
_SPACES: tuple[tuple[Literal["A", "phi"], float, Cells, int], ...] = (
    ("A", 2.0, "straight", 2), ("A", 2.0, "curved", 2),
    ("phi", math.pi, "straight", 4), ("phi", math.pi, "curved", 4),
)  # fmt: skip
_FIELDS = (
    case(
        "AXIO",
        "Manufactured field in a half section",
        "A cylinder of iron, radius 1 m, 2 m high, A_φ = r (1 − r²)² cos(π z/2) Wb/m on it, driven "
        "by its own H.",
        model="axisymmetric field, orders 2 and 4",
        source=_STRANG,
        answers=[
            answer
            for name, curve in _CURVES
            for order in (2, 4)
            for answer in _rows(
                f"Flux densities of order {order} in iron with a {name} curve", order,
                partial(rings_error, curve, order), 4,
                (_rings_bound(order), "interpolation of its steepest derivative"),
            )
        ],
        refinement=_halved(partial(rings_error, TEAM20, 4), 2, 4, 8, order=4),
        setup=lambda: rings([cylinder(TEAM20)], unit="m"),
    ),
    case(
        "MAGO",
        "Manufactured field in three dimensions",
        "A cube of TEAM problem 20's steel, 1 mm, with B of sines along its edges, up to 0.7 T, "
        "driven by its own H and a gradient besides, which only φ sees.",
        model="magnetic3d: second-order edge elements for A, quadratic ones for φ",
        source=_STRANG,
        answers=[
            answer
            for potential, wave, cells, coarse in _SPACES
            for answer in _rows(
                f"Flux densities by {potential} on {_NAMES[cells]}", 2,
                partial(cube_error, potential, cells), coarse,
                ((wave / (2 * coarse)) ** 2 / 12.0, "(kh)²/12 of the shortest wave"),
                potential == "phi",
            )
        ],
        refinement=_halved(partial(cube_error, "A", "curved"), 1, 2, 3, 4, order=2),
        setup=section(_cube),
    ),
)  # fmt: skip

CASES: tuple[Case, ...] = (*_SOLIDS, _BEAMS, *_FIELDS)
