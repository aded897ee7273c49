"""The grid of observed orders: which row shows each kind of problem in each way of dividing."""

from __future__ import annotations

from typing import NamedTuple

KINDS = ("at rest", "eigenvalue", "driven, with losses")


class Division(NamedTuple):
    """Kind of division with the rows that show its order.

    Where there is no row, the words say why no order can be seen.
    """

    name: str
    rows: tuple[tuple[str, ...] | str, ...]


_STATIC = "magnetostatics has none"
DIVISIONS: tuple[Division, ...] = (
    Division(
        "beam elements of degree five",
        ("exact on uniform pieces: nothing is left that could converge", ("BEAMO-1",),
         ("BEAMO-3",)),
    ),
    *(
        Division(
            f"bricks of degree {p}",
            ((f"MMSB-{4 * p - 3}",), (f"ROD-{p}", *((f"CYLO-{p - 1}",) if p in (2, 3) else ())),
             (f"MMSB-{4 * p - 1}",)),
        )
        for p in (1, 2, 3, 4)
    ),
    *(
        Division(
            name,
            ((f"MMSC-{6 * i + 1}", f"MMSC-{6 * i + 5}"), (f"MMSE-{2 * i + 1}",),
             (f"MMSC-{6 * i + 3}",)),
        )
        for i, name in enumerate((
            "quadratic tetrahedra, straight", "quadratic tetrahedra, curved",
            "quadratic hexahedra, rectangular",
        ))
    ),
    *(
        Division(f"quads of a half section, order {p}", ((f"AXIO-{p - 1}", f"AXIO-{p + 3}"),
                                                         _STATIC, _STATIC))
        for p in (2, 4)
    ),
    *(
        Division(name, ((f"MAGO-{4 * i + 1}", f"MAGO-{4 * i + 3}"), _STATIC, _STATIC))
        for i, name in enumerate((
            "second-order edge elements (A), straight and curved",
            "quadratic scalar potential (φ), straight and curved",
        ))
    ),
)  # fmt: skip
