"""Colours of pictures: of parts, and scales that the colour-blind read too."""

from __future__ import annotations

from typing import cast

import numpy as np

from tactgen.geometry.cad.solids import COLOURS

__all__ = ["COLOURS", "MAGNITUDE", "SIGNED", "magnitude_stops", "signed_stops"]

#: Matplotlib's maps: perceptually even for sizes, ColorBrewer's red and blue for what swings.
MAGNITUDE, SIGNED = "viridis", "RdBu_r"
_STOPS = 33


def magnitude_stops() -> list[list[int]]:
    """Return the scale of sizes as (red, green, blue), 0 to 255, from low to high."""
    return _stops(MAGNITUDE)


def signed_stops() -> list[list[int]]:
    """Return the scale of what swings about zero, from negative to positive."""
    return _stops(SIGNED)


def _stops(name: str) -> list[list[int]]:
    import matplotlib as mpl

    colours = np.rint(255.0 * mpl.colormaps[name](np.linspace(0.0, 1.0, _STOPS))[:, :3])
    return cast("list[list[int]]", colours.astype(int).tolist())
