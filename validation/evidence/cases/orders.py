"""Observed orders of convergence against theory, each with an absolute bound.

On problems whose exact answer is smooth, halving the intervals must divide the error as theory
says; an order without a bound would also be met by a wrong answer, so both are asked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cache, partial
from typing import Literal

import numpy as np

from tactgen.fem import beam
from tactgen.fem.piezo.system import Material
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device.magnetisation import TEAM20, linear
from tactgen.geometry.device.materials import isotropic_stiffness
from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.validation.evidence.boxes import block, even, held, natural_frequencies
from tactgen.validation.evidence.case import Case, Check, Refinement, case
from tactgen.validation.evidence.cases.laminates import bending_bimorph
from tactgen.validation.evidence.cases.manufactured import (
    Cells,
    cube_error,
    plate_error,
    quarter_wave_error,
    rings_error,
    solid_error,
)

Error = Callable[[int], float]
_STRANG = "G. Strang, G. J. Fix, An Analysis of the Finite Element Method, ch. 3 and 6"
_BRICKS = "bricks of the model solid"


def _order(what: str, theory: int, error: Error, coarse: int, heavy: bool = False) -> Check:
    """The order observed from `coarse` divisions to twice as many.

    There the error is far from rounding, and its leading term dominates.
    """
    return Check(f"{what} converge with order {theory}.", (theory - 0.1, theory + 0.1), "1",
                 lambda: math.log2(error(coarse) / error(2 * coarse)), 0.0, "within 0.1 of theory",
                 heavy=heavy)  # fmt: skip


def _bound(
    what: str, error: Error, fine: int, bound: float, reason: str, heavy: bool = False
) -> Check:
    return Check(f"{what} on {fine} divisions are off by no more than their bound.",
                 (0.0, bound), "1", partial(error, fine), 0.0, reason, heavy=heavy)  # fmt: skip


def _rows(
    what: str, theory: int, error: Error, coarse: int, bound: float, reason: str,
    heavy: bool = False,
) -> Iterator[Check]:  # fmt: skip
    """Two rows: the order, and a bound on twice as many divisions."""
    yield _order(what, theory, error, coarse, heavy)
    yield _bound(what, error, 2 * coarse, bound, reason, heavy)


# --- frequencies on bricks of one degree ---------------------------------------------------------


@cache
def _rod_error(degree: int, intervals: int) -> float:
    """Of a quarter wave of a rod without Poisson's ratio: ω = π/2 in units of the rod."""
    unit = even(1.0, 1, 1)
    material = Material(isotropic_stiffness(1.0, 0.0), 1.0)
    rod = block((unit, unit, even(1.0, intervals, degree)), material, held("xy"), held("z", z=0.0))
    return abs(float(natural_frequencies(rod, 1)[0]) / 0.25 - 1.0)


@cache
def _bimorph_error(degree: int, intervals: int) -> float:
    """Of the lowest natural frequency of case CYL2."""
    box = bending_bimorph(1e-3, degree=degree, intervals=intervals)
    return abs(float(natural_frequencies(box, 1)[0]) / 6981.984969234867 - 1.0)


_FREQUENCIES = tuple(
    case(
        name, title, problem,
        [
            *(_order(f"Bricks of degree {p}", 2 * p, partial(error, p), n) for p, n, _ in rows),
            *(_bound(f"Bricks of degree {p}", partial(error, p), 2 * n, bound, reason)
              for p, n, bound in rows),
        ],
        model=_BRICKS + ", one degree along z at a time",
        source="a frequency converges with twice the degree (G. Strang, G. J. Fix, An Analysis of "
        "the Finite Element Method, ch. 6)",
        refinement=Refinement(
            (1, 2, 4, 8), partial(error, rows[-1][0]), f"order {2 * rows[-1][0]}"
        ),
    )
    for name, title, problem, error, rows, reason in (
        ("ROD", "Orders on a rod",
         "A rod without Poisson's ratio, one end held: the lowest axial frequency, 1/4 √(E/ρ)/L.",
         _rod_error, [(p, n, 2.0 * quarter_wave_error(p, 2 * n))
                      for p, n in ((1, 16), (2, 6), (3, 2), (4, 1))],
         "twice the leading term of the error"),
        ("CYLO", "Orders on the bimorph in cylindrical bending",
         ("The bimorph of case CYL2, two PZT-5A layers of 1 mm poled towards each other, one half "
          "wave of 20 mm, both faces at 0 V: first bending frequency on bricks of equal length and "
          "one degree along z."),
         _bimorph_error, [(2, 6, 1e-5), (3, 3, 1e-5)], "below what a report prints"),
    )
)  # fmt: skip

# --- the piezoelectric solid -------------------------------------------------------------------


def _solid(
    what: str, degree: int, kind: Cells | int, driven: bool, coarse: int, heavy: bool
) -> Iterator[Check]:
    """Rows of the values; a wave's interpolation over cells h errs by 2 (kh/4)^(p+1)/(p+1)!.

    k is the shortest wave's of the manufactured solution, 1.6 over the edge.
    """
    bound = 4.0 * (1.6 / (2 * coarse) / 4.0) ** (degree + 1) / math.factorial(degree + 1)
    reason = "twice the largest error of interpolating its shortest wave"
    return _rows(what, degree + 1, _values(kind, driven), coarse, bound, reason, heavy)


def _values(kind: Cells | int, driven: bool = False) -> Error:
    return lambda divisions: float(solid_error(kind, driven, divisions)[1])


_STATES = ((False, "at rest"), (True, "at 0.5 MHz with losses"))
_PROBLEM = (
    "A cube of PZT-5H, 1 mm: displacement and potential are sines of four directions, given on all "
    "walls, and the load is what they need; at rest, and at 0.5 MHz with the ceramic's losses. "
    "Errors are relative, in the mean square."
)
#: Cells with the coarser division at rest.
_CELLS: tuple[tuple[Cells, int, str], ...] = (
    ("straight", 3, "straight tetrahedra of any shape"), ("curved", 3, "curved tetrahedra"),
    ("hexahedra", 5, "rectangular hexahedra"),
)  # fmt: skip
_WAVE = "(kh)²/12 of the shortest wave"


def _cells_rows(cells: Cells, coarse: int, name: str) -> Iterator[Check]:
    costly = cells == "hexahedra"
    for driven, state in _STATES:
        yield from _solid(f"Values on {name}, {state},", 2, cells, driven,
                          max(4, coarse) if driven else coarse, driven or costly)  # fmt: skip
    yield from _rows(f"Gradients on {name}, at rest,", 2,
                     lambda divisions: float(solid_error(cells, False, divisions)[0]), coarse,
                     (1.6 / (2 * coarse)) ** 2 / 12.0, _WAVE, costly)  # fmt: skip


_SOLIDS = (
    case(
        "MMSB", "Manufactured solution on bricks", _PROBLEM,
        [
            row
            for degree, coarse in ((1, 8), (2, 4), (3, 2), (4, 2))
            for driven, state in _STATES
            for row in _solid(f"Values on bricks of degree {degree}, {state},", degree, degree,
                              driven, coarse, degree != 3)
        ],
        model=_BRICKS + ", degrees 1 to 4", source=_STRANG,
        refinement=Refinement((1, 2, 4), _values(3), "order 4"),
    ),
    case(
        "MMSC", "Manufactured solution on cells of ten and twenty nodes", _PROBLEM,
        [row for cells in _CELLS for row in _cells_rows(*cells)],
        model="the cells of the model cad: quadratic tetrahedra; quadratic hexahedra beside them",
        source=_STRANG, refinement=Refinement((2, 3, 4, 6), _values("curved"), "order 3"),
    ),
    case(
        "MMSE", "Thickness resonance on cells of ten and twenty nodes",
        "Case TE's plate of PZT-5A at short circuit, 2 mm thick: a column of its upper half, or a "
        "cube where cells are curved.",
        [
            row
            for cells, _, name in _CELLS
            for row in _rows(f"Frequencies on {name}", 4, partial(plate_error, cells),
                             6, 2.0 * quarter_wave_error(2, 12),
                             "twice the leading term of a rod's", cells == "curved")
        ],
        model="as case MMSC", source=f"IEEE Std 176-1987, in closed form; {_STRANG}",
        refinement=Refinement((3, 6, 12, 24), partial(plate_error, "straight"), "order 4"),
    ),
)  # fmt: skip

# --- beam elements -----------------------------------------------------------------------------

#: The mode and the frequency (Hz) whose waves are short enough for errors above rounding.
_MODE, _FAST = 8, 50e3
#: To tell the order: a mode and a length (m) whose error on 32 elements is a hundred times
#: rounding, of which a slender beam's shear stiffness costs more.
_HIGH, _STOUT = 11, 3e-3


@cache
def _mode_error(elements: int, mode: int = _MODE, length: float = 20e-3) -> float:
    device, support = Device(bimorph=Bimorph(length=length)), Support(kind="clamped")
    pieces = transfer_matrix.sections(device, support, Beam(), lossy=False)
    exact = bending_frequencies(pieces, Ends(), mode + 1, open_circuit=False)[mode]
    matrices = beam.assemble(device, support, Beam(), elements=elements, lossy=False)
    found = beam.bending_frequencies(matrices, Ends(), mode + 1, open_circuit=False)[mode]
    return abs(float(found / exact) - 1.0)


@cache
def _port_error(elements: int) -> float:
    """Largest error of the five ports' stiffness, by the diagonal's sizes."""
    at = np.array([_FAST])
    exact = transfer_matrix.multiport(Device(), Support(), Beam(), at).stiffness[0]
    found = beam.multiport(Device(), Support(), Beam(), at, elements=elements).stiffness[0]
    size = np.sqrt(np.abs(np.diag(exact)))
    return float((np.abs(found - exact) / np.outer(size, size)).max())


_TENTH = "what the checks of beam elements ask of their default"
_BEAMS = case(
    "BEAMO", "Orders of beam elements",
    "The paper's 20 mm bimorph: its ninth frequency on a clamp without losses, and its five ports "
    "at 50 kHz with losses; for the order of frequencies the twelfth of a bimorph of 3 mm, "
    "whose matrices lose fewer digits to shear. At rest elements of degree five are exact.",
    [
        _order("Frequencies by beam elements", 10,
               partial(_mode_error, mode=_HIGH, length=_STOUT), 16),
        _bound("Frequencies by beam elements", _mode_error, 32, 1e-8, _TENTH),
        *_rows("Ports by beam elements", 10, _port_error, 16, 1e-8, _TENTH),
    ],
    model="beam elements of degree five",
    source=f"exact spans of the transfer-matrix model; {_STRANG}",
    refinement=Refinement((8, 12, 16, 32), _mode_error, "order 10"),
)  # fmt: skip

# --- magnetic fields ---------------------------------------------------------------------------

#: Bounds of the derivatives of u by order: see manufactured.
_STEEPEST = {2: 24.0, 4: (math.pi / 2.0) ** 5}


def _rings_bound(order: int) -> float:
    """Error of a slope by degree p − 1 in Chebyshev points, cells of 1/8."""
    steep = _STEEPEST[order] / (2.0 ** (order - 1) * math.factorial(order))
    return (1.0 / 16.0) ** order * steep


#: Potential, its shortest wave over the edge and the coarser division.
_POTENTIALS: tuple[tuple[Literal["A", "phi"], float, int], ...] = (
    ("A", 2.0, 2), ("phi", math.pi, 4),
)  # fmt: skip
_FIELDS = (
    case(
        "AXIO", "Manufactured field in a half section",
        "A cylinder of iron, radius 1 m, 2 m high, A_φ = r (1 − r²)² cos(π z/2) Wb/m on it, driven "
        "by its own H.",
        [
            row
            for name, curve in (("straight", linear(1000.0)), ("saturating", TEAM20))
            for order in (2, 4)
            for row in _rows(f"Flux densities of order {order} in iron with a {name} curve", order,
                             partial(rings_error, curve, order), 4, _rings_bound(order),
                             "interpolation of its steepest derivative")
        ],
        model="axisymmetric field, orders 2 and 4", source=_STRANG,
        refinement=Refinement((2, 4, 8), partial(rings_error, TEAM20, 4), "order 4"),
    ),
    case(
        "MAGO", "Manufactured field in three dimensions",
        "A cube of TEAM problem 20's steel, 1 mm, with B of sines along its edges, up to 0.7 T, "
        "driven by its own H and a gradient besides, which only φ sees.",
        [
            row
            for potential, wave, coarse in _POTENTIALS
            for cells, _, name in _CELLS[:2]
            for row in _rows(f"Flux densities by {potential} on {name}", 2,
                             partial(cube_error, potential, cells), coarse,
                             (wave / (2 * coarse)) ** 2 / 12.0, _WAVE, potential == "phi")
        ],
        model="magnetic3d: second-order edge elements for A, quadratic ones for φ", source=_STRANG,
        refinement=Refinement((1, 2, 3, 4), partial(cube_error, "A", "curved"), "order 2"),
    ),
)  # fmt: skip

CASES: tuple[Case, ...] = (*_FREQUENCIES, *_SOLIDS, _BEAMS, *_FIELDS)
