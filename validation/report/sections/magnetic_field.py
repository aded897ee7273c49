"""The normal actuator's field in the half section: |B| as shading, flux lines, named parts."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device
from tactgen.validation.show.figures import BLUE, DARK, new_figure, svg
from tactgen.validation.show.magnetic import gauss_columns

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint
    from tactgen.fem.magnetics.axisymmetric_field import MagneticField
    from tactgen.geometry.reluctance.section_grid import Region

#: Flux lines per picture.
_LINES = 16
#: Where |B| is cut off in the shading (T): beyond, the steel is saturated altogether.
_TOP = 2.2
#: Sizes in the picture, in outer radii of the device: its width, the place of the names, room below
#: the rod (if the sleeve goes on) and beside the iron, and the least distance of names.
_WIDTH, _NAMES, _BELOW, _ROOM, _BETWEEN_NAMES = 1.8, 1.23, 0.5, 0.3, 0.21
_MM = 1e3


def field_plot(device: Device, points: Mapping[str, FieldPoint]) -> str:
    """Plot the field of several points, by the titles of their pictures, side by side."""
    figure = new_figure(4.3 * len(points) + 0.7, 8.0)
    figure.dpi = 170.0  # of the shading
    axes = figure.subplots(ncols=len(points), sharey=True, squeeze=False)[0]
    shading: Any = None
    for axis, (title, point) in zip(axes, points.items(), strict=True):
        assert point.solution is not None
        shading = _shade(axis, point.solution, device)
        _flux_lines(axis, point.solution)
        _outline(axis, point.solution.discretisation.grid.regions)
        _names(axis, device, point.gap)
        axis.set(
            title=title,
            xlabel="r (mm)",
            xlim=(0.0, _MM * _WIDTH * _radius(device)),
            ylim=_heights(device),
        )
        axis.set_aspect("equal")
    axes[0].set_ylabel("z (mm), 0 at the sleeve's top face")
    figure.colorbar(shading, ax=list(axes), label="|B| (T)", shrink=0.6, extend="max")
    return svg(figure)


def _radius(device: Device) -> float:
    return float(max(device.rod.head_radius, device.sleeve.outer_radius))


def _heights(device: Device) -> tuple[float, float]:
    """Lower and upper end of the picture (mm)."""
    radius, rod = _radius(device), device.rod
    # a sleeve that goes on below the rod carries little: the picture ends under the rod
    low = max(min(device.sleeve.length, rod.length + _BELOW * radius), rod.length)
    high = device.gap + rod.head_thickness
    return -_MM * (low + _ROOM * radius), _MM * (high + _ROOM * radius)


def _shade(axis: Any, solution: MagneticField, device: Device) -> Any:
    """Shade |B|: one patch around each quadrature point, so that jumps stay sharp."""
    d = solution.discretisation
    magnitude = np.linalg.norm(gauss_columns(solution, solution.flux_density), axis=-1)
    across = magnitude.shape[1]
    nr, nz = d.grid.r.size - 1, d.grid.z.size - 1
    values = magnitude.reshape(nr, nz, across, across).transpose(0, 2, 1, 3)
    near = d.grid.r < 2.0 * _WIDTH * _radius(device)
    r, z = (_patches(x, across) for x in (d.grid.r[near], d.grid.z))
    table = values.reshape(nr * across, nz * across)[: r.size - 1]
    low, high = _heights(device)
    inside = (_MM * z[1:] > low) & (_MM * z[:-1] < high)
    first, last = np.flatnonzero(inside)[[0, -1]]
    return axis.pcolormesh(
        r * _MM,
        z[first : last + 2] * _MM,
        table[:, first : last + 1].T,
        cmap="YlOrRd",
        vmin=0.0,
        vmax=_TOP,
        rasterized=True,
    )


def _patches(lines: Floats, across: int) -> Floats:
    """Edges around `across` Gauss points between every two lines."""
    points = np.polynomial.legendre.leggauss(across)[0]
    edges = np.concatenate([[-1.0], 0.5 * (points[1:] + points[:-1])])
    inner = [0.5 * (a + b) + 0.5 * (b - a) * edges for a, b in pairwise(lines)]
    return np.concatenate([*inner, lines[-1:]])


def _flux_lines(axis: Any, solution: MagneticField) -> None:
    """Draw lines between which the same flux runs."""
    grid, psi = solution.discretisation.grid, solution.flux_function
    largest = psi.flat[np.argmax(np.abs(psi))]  # with its sign
    levels = (np.arange(_LINES) + 0.5) / _LINES * float(largest)
    axis.contour(
        grid.r * _MM,
        grid.z * _MM,
        psi.T,
        levels=np.sort(levels),
        colors="black",
        linewidths=0.7,
        linestyles="solid",
    )


def _outline(axis: Any, regions: tuple[Region, ...]) -> None:
    """Draw the outline of iron and winding; edges inside one piece of iron are left out."""
    for iron in (True, False):
        edges = np.unique([x for p in regions for x in p.radii]) * _MM
        levels = np.unique([x for p in regions for x in p.heights]) * _MM
        r, z = (np.concatenate([[x[0] - 1.0], x, [x[-1] + 1.0]]) for x in (edges, levels))
        middle_r, middle_z = (0.5 * (x[1:] + x[:-1]) for x in (r, z))
        filled = np.zeros((middle_r.size, middle_z.size), dtype=bool)
        for part in regions:
            if (part.curve is not None) == iron:
                (a, b), (low, high) = (np.array(x) * _MM for x in (part.radii, part.heights))
                filled |= np.outer(
                    (middle_r > a) & (middle_r < b), (middle_z > low) & (middle_z < high)
                )
        colour = DARK if iron else BLUE
        for i, j in np.argwhere(filled[1:] != filled[:-1]):
            axis.plot([r[i + 1]] * 2, z[j : j + 2], color=colour, linewidth=1.6)
        for i, j in np.argwhere(filled[:, 1:] != filled[:, :-1]):
            axis.plot(r[i : i + 2], [z[j + 1]] * 2, color=colour, linewidth=1.6)


def _names(axis: Any, device: Device, gap: float) -> None:
    """Name the parts and both gaps beside the section."""
    rod, coil, sleeve = device.rod, device.coil, device.sleeve
    shift = gap - NOMINAL_GAP  # of what moves with the rod
    wall = 0.5 * (sleeve.collar_radius + sleeve.outer_radius)
    flange = shift - rod.flange_position
    named = {
        "head": (0.85 * rod.head_radius, gap + 0.5 * rod.head_thickness),
        "working gap": (wall, 0.5 * gap),
        "collar": (wall, -0.7 * sleeve.collar_thickness),
        "coil": (
            0.5 * (coil.inner_radius + coil.outer_radius),
            shift - coil.position - 0.3 * coil.length,
        ),
        "shaft": (0.6 * rod.radius, shift - coil.position - 0.55 * coil.length),
        "sleeve": (
            0.5 * (sleeve.inner_radius + sleeve.outer_radius),
            -0.55 * min(sleeve.length, rod.length),
        ),
        "flange": (0.85 * rod.flange_radius, flange - 0.4 * rod.flange_thickness),
        "parasitic gap": (
            0.5 * (rod.flange_radius + sleeve.inner_radius),
            flange - 0.7 * rod.flange_thickness,
        ),
    }
    places = np.array([z for _, z in named.values()])
    radius = _radius(device)
    spread = _apart(places, _BETWEEN_NAMES * radius)
    for (name, (r, z)), level in zip(named.items(), spread, strict=True):
        axis.annotate(
            name,
            xy=(r * _MM, z * _MM),
            xytext=(_NAMES * radius * _MM, level * _MM),
            va="center",
            fontsize=9,
            bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.0},
            arrowprops={"arrowstyle": "-|>", "linewidth": 0.8, "color": DARK, "shrinkB": 0},
        )


def _apart(levels: Floats, least: float) -> Floats:
    """Falling levels at least `least` apart, as near to the wanted ones as from the top."""
    found = np.array(levels)
    for k in range(1, found.size):
        found[k] = min(found[k], found[k - 1] - least)
    return found
