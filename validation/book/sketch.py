"""The set-up of a case as a drawing: boxes by material with what holds them, or windings."""

from __future__ import annotations

from typing import Any

from tactgen.geometry.reluctance.section_grid import Region
from tactgen.validation.checks.case import Case
from tactgen.validation.checks.cases.boxes import Box, Held, Where
from tactgen.validation.view.figures import (
    AMBER,
    BLUE,
    DARK,
    GREEN,
    GREY,
    ORANGE,
    SKY,
    new_figure,
    svg,
)

_FILLS = (SKY, AMBER, GREY, GREEN)


def sketched(case: Case) -> str:
    """Return the drawing of a case's set-up as SVG; empty where it has none."""
    if case.setup is None:
        return ""
    setup = case.setup()
    return _boxes(setup) if isinstance(setup, Box) else _windings(setup)


def _boxes(box: Box) -> str:
    """Draw the section through x and z: materials, supports, electrodes, the division."""
    from matplotlib.patches import Patch, Rectangle

    figure = new_figure(6.4, 2.6)
    axis = figure.add_subplot()
    regions = list(dict.fromkeys(slab.region for slab, _ in box.parts))
    x, z = box.x.breaks * 1e3, box.z.breaks * 1e3
    for slab, _ in box.parts:
        low, high = x[slab.x[0]], x[slab.x[1]]
        start, end = z[slab.z[0]], z[slab.z[1]]
        fill = _FILLS[regions.index(slab.region) % len(_FILLS)]
        axis.add_patch(Rectangle((start, low), end - start, high - low, facecolor=fill, alpha=0.5))
    for at in x:
        axis.plot([z[0], z[-1]], [at, at], color=DARK, linewidth=0.4)
    for at in z:
        axis.plot([at, at], [x[0], x[-1]], color=DARK, linewidth=0.4)
    for hold in box.held:
        _mark(axis, hold, x, z)
    handles = [
        Patch(facecolor=_FILLS[i % len(_FILLS)], alpha=0.5, label=name)
        for i, name in enumerate(regions)
    ]
    handles += [Patch(color=BLUE, label="held"), Patch(color=ORANGE, label="potential given")]
    axis.legend(handles=handles, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axis.set_xlabel("z (mm)" if z[-1] < 1e4 else "z (mm, or the case's own unit times 1000)")
    axis.set_ylabel("x (mm)")
    axis.margins(0.06)
    return svg(figure)


def _mark(axis: Any, hold: Held, x: Any, z: Any) -> None:
    """Draw a support or electrode on a plane of the section as a thick line."""
    where: Where = hold.where
    colour = ORANGE if hold.components == ("phi",) else BLUE
    if isinstance(where.z, float) and where.x is None:
        axis.plot([where.z * 1e3] * 2, [x[0], x[-1]], color=colour, linewidth=3.0, alpha=0.8)
    elif isinstance(where.x, float) and where.z is None:
        axis.plot([z[0], z[-1]], [where.x * 1e3] * 2, color=colour, linewidth=3.0, alpha=0.8)


def _windings(windings: tuple[Region, ...]) -> str:
    """Draw the half section of windings, the axis at the left."""
    from matplotlib.patches import Rectangle

    figure = new_figure(4.2, 3.4)
    axis = figure.add_subplot()
    for winding in windings:
        (r0, r1), (z0, z1) = winding.radii, winding.heights
        axis.add_patch(
            Rectangle((r0, z0), r1 - r0, z1 - z0, facecolor=AMBER, edgecolor=DARK, linewidth=1.5)
        )
    axis.axvline(0.0, color=GREY, linestyle="-.", linewidth=1.0)
    axis.autoscale_view()
    axis.set_xlabel("r (m)")
    axis.set_ylabel("z (m)")
    axis.margins(0.15)
    return svg(figure)
