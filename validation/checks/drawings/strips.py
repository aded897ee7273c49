"""Beams and layered strips from the side, their ends and their loads."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from tactgen.validation.checks.drawings.drawing import Area, Drawing, Line, Mark, rectangle

Root = Literal["held", "hinge", "springs", "turning spring"]
#: Points along a tapered edge.
_ALONG = 33
_DOWN = -90.0


def strip(
    length: float,
    layers: Sequence[tuple[str, float]],
    *,
    root: Root = "held",
    tip: Sequence[Mark] = (),
    unit: str = "mm",
    height: str = "x",
) -> Drawing:
    """Return a strip along z, its layers (name, thickness) from below."""
    edges = np.concatenate([[0.0], np.cumsum([thickness for _, thickness in layers])]).tolist()
    areas = tuple(
        rectangle((0.0, low), (length, high), name)
        for (name, _), low, high in zip(layers, edges[:-1], edges[1:], strict=True)
    )
    lines, ends = _ends(root, edges[-1])
    return Drawing(areas, lines, (*ends, *tip), _named(unit, height), equal=False)


def tapered(
    length: float,
    size: float,
    at: Callable[[float], float],
    *,
    tip: Sequence[Mark] = (),
    unit: str = "mm",
    height: str = "x",
    body: str = "beam",
) -> Drawing:
    """Return a strip held at its root whose size there is multiplied by `at` a share of it."""
    shares = np.linspace(0.0, 1.0, _ALONG)
    half = [0.5 * size * at(float(share)) for share in shares]
    upper = [(float(s) * length, h) for s, h in zip(shares, half, strict=True)]
    lower = [(z, -h) for z, h in reversed(upper)]
    held = Line(((0.0, -0.5 * size), (0.0, 0.5 * size)), "held")
    area = Area((*upper, *lower), body)
    return Drawing((area,), (held,), tuple(tip), _named(unit, height), equal=False)


def at_tip(length: float, height: float, kind: Literal["mass", "hinge"], text: str = "") -> Mark:
    """Return a mass or hinge at the tip of a strip."""
    return Mark(kind, (length, 0.0 if kind == "hinge" else 0.5 * height), text=text)


def pushed(length: float, height: float, text: str) -> Mark:
    """Return a force across the tip of a strip."""
    return Mark("force", (length, height), _DOWN, text)


def root_of_share(share: float) -> float:
    """Return the height of a beam of parabolic height over that at its root."""
    return math.sqrt(1.0 - share)


def _ends(root: Root, height: float) -> tuple[tuple[Line, ...], tuple[Mark, ...]]:
    middle = (0.0, 0.5 * height)
    if root == "held":
        return (Line(((0.0, 0.0), (0.0, height)), "held"),), ()
    if root == "hinge":
        return (), (Mark("hinge", (0.0, 0.0)),)
    if root == "turning spring":
        return (), (Mark("hinge", (0.0, 0.0)), Mark("turning spring", middle, text="k"))
    return (), (Mark("hinge", (0.0, 0.0), text="$c_{sl}$"),
                Mark("turning spring", middle, text="$c_s$, $d_s$"))  # fmt: skip


def _named(unit: str, height: str) -> tuple[str, str]:
    return (f"z ({unit})", f"{height} ({unit})") if unit else ("z", height)
