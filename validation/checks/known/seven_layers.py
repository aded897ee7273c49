"""NAFEMS' seven-layer strip in three-point bending, on the bricks of the model solid."""

from __future__ import annotations

import numpy as np

from tactgen.fem.piezo.system import Material
from tactgen.geometry.bimorph.bricks import Slab
from tactgen.validation.checks.case import Answer, Case, case
from tactgen.validation.checks.cases.boxes import (
    Box,
    Held,
    Load,
    State,
    Where,
    even,
    graded,
    stacked,
    statics,
)
from tactgen.validation.checks.cases.fineness import cached
from tactgen.validation.checks.drawings.sections import section

_LAYERS = (1e-4, 1e-4, 1e-4, 4e-4, 1e-4, 1e-4, 1e-4)
_FIBRES = ("fibres along z", "fibres along y")


def _ply(*, along: bool) -> Material:
    """Return a ply with its fibres along z or along y; Voigt's order xx, yy, zz, yz, xz, xy.

    E 100, 5, 5 GPa; ν12 0.4, ν13 = ν23 0.3; G12 3, G13 = G23 2 GPa; axis 3 is the thickness, x.
    """
    s = np.zeros((6, 6))
    # in the order 1 (fibre), 2, 3
    first = np.array([[1 / 100, -0.4 / 100, -0.3 / 100], [-0.4 / 100, 1 / 5, -0.3 / 5],
                      [-0.3 / 100, -0.3 / 5, 1 / 5]]) * 1e-9  # fmt: skip
    order = [2, 1, 0] if along else [2, 0, 1]
    s[:3, :3] = first[np.ix_(order, order)]
    s[3, 3], s[4, 4], s[5, 5] = 1 / 3e9, 1 / 2e9, 1 / 2e9
    return Material(np.linalg.inv(s), 1.0)


def _quarter() -> Box:
    """Return a quarter of the strip, 30 mm between its supports, under 10 N/mm in the middle."""
    parts = tuple(
        (Slab(f"{_FIBRES[i % 2]} {i}", (i, i + 1), (0, 4)), _ply(along=i % 2 == 0))
        for i in range(len(_LAYERS))
    )
    top = sum(_LAYERS)
    return Box(
        x=stacked(_LAYERS, 2),
        y=even(5e-3, 1, 3),
        z=graded([0.0, 1e-3, 4e-3, 15e-3, 25e-3], 4),
        parts=parts,
        held=(
            Held(Where(z=0.0), ("z",)),
            Held(Where(y=0.0), ("y",)),
            Held(Where(x=0.0, z=15e-3), ("x",)),
        ),
        loads=(Load(Where(x=top, z=0.0), "x", -5e3),),
    )


@cached
def _strip() -> State:
    return statics(_quarter())


def _deflection() -> float:
    return float(_strip().mean(Where(x=0.0, y=0.0, z=0.0), "x").real)


CASES: tuple[Case, ...] = (
    case(
        "R0031",
        "Seven-layer strip in three-point bending (NAFEMS R0031/1)",
        "0/90/0/90/0/90/0, layers of 0.1 mm, the middle one of 0.4 mm, 10 mm wide, 30 mm between "
        "line supports and 10 mm beyond each, 10 N/mm across the middle; E1 = 100, E2 = E3 = 5 "
        "GPa, ν12 = 0.4, ν13 = ν23 = 0.3, G12 = 3, G13 = G23 = 2 GPa.",
        model="bricks of the model solid, a layer of bricks for each of the strip",
        source="NAFEMS R0031, test 1",
        tolerance=7e-3,
        reason="half a unit of the last printed digit, and lines that load and hold a solid: what "
        "they press in grows without limit on ever finer bricks",
        answers=[
            Answer("The lower side moves by −1.06 mm below the load.", -1.06e-3, "m", _deflection)
        ],
        setup=section(_quarter),
    ),
)
