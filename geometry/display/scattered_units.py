"""The display's generators as they come out of the shop: each drawn from the scatter."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.device.parameters import Device, Display, Scatter

#: A draw farther out than this many deviations is not mounted.
_SORTED_OUT = 2.5
#: What is drawn of each unit, in this order: a key added at the end leaves the others' draws.
_DRAWN = (
    ("bimorph", "length", "length"),
    ("bimorph", "piezo_thickness", "thickness"),
    ("contact", "decay_length", "roughness"),
    ("spring", "preload", "preload"),
)


def drawn_units(device: Device, display: Display, scatter: Scatter) -> tuple[Device, ...]:
    """Return the device of each unit, row by row; the same seed gives the same units.

    Sizes are normally distributed about the device's; of a scatter of 0 none differs.  A larger
    display keeps the draws of the smaller one's first units.
    """
    found = []
    for number in range(display.rows * display.columns):
        draws = np.random.default_rng([scatter.seed, number]).standard_normal(len(_DRAWN))
        clipped = np.clip(draws, -_SORTED_OUT, _SORTED_OUT)
        unit = device
        for (group, name, deviation), draw in zip(_DRAWN, clipped.tolist(), strict=True):
            inner = getattr(unit, group)
            value = getattr(inner, name) * (1.0 + getattr(scatter, deviation) * draw)
            unit = unit.model_copy(update={group: inner.model_copy(update={name: value})})
        found.append(unit)
    return tuple(found)
