"""Permeance of the working gap by Roters' flux tubes, and how it changes with the gap.

H. C. Roters, Electromagnetic Devices (Wiley 1941), ch. 5: the field beside two pole faces
is replaced by straight and circular tubes.  Between two flush edges a half cylinder
(0.26 µ0 per length) and around it a half annulus; between an edge and a plane, by
symmetry, twice a quarter of them.  Edges are taken as straight, their length as that of
the circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_law import MU0
from tactgen.geometry.errors import InputError

#: Roters' half cylinder between two flush edges, its permeance over µ0 and length.
_HALF_CYLINDER = 0.26


@dataclass(frozen=True)
class GapPermeance:
    """Permeance at m gaps, and how much of the collar's bore its tubes take.

    Attributes
    ----------
    permeance, d_permeance : (m,) float
        P (H) and dP/dg (H/m).
    covered, d_covered : (m,) float
        Height of the collar's bore that the tubes from the head take (m), and its slope.
    """

    permeance: Floats
    d_permeance: Floats
    covered: Floats
    d_covered: Floats


def pole_radii(device: Device) -> tuple[float, float]:
    """Return inner and outer radius (m) where the head's underside faces the sleeve's top.

    Raises
    ------
    InputError
        If they do not face each other, or the collar touches the shaft.
    """
    inner = device.sleeve.collar_radius
    if not inner > device.rod.radius:
        raise InputError(
            f"sleeve.collar_radius = {inner * 1e3:g} mm must be more than rod.radius = "
            f"{device.rod.radius * 1e3:g} mm"
        )
    outer = min(device.rod.head_radius, device.sleeve.outer_radius)
    if not outer > inner:
        raise InputError(
            f"rod.head_radius = {device.rod.head_radius * 1e3:g} mm does not reach over "
            f"sleeve.collar_radius = {device.sleeve.collar_radius * 1e3:g} mm, so there is no "
            "working gap; make the head larger or the collar's bore smaller"
        )
    return inner, outer


def pole_area(device: Device) -> float:
    """Return the area in which head and sleeve face each other (m²)."""
    inner, outer = pole_radii(device)
    return math.pi * (outer**2 - inner**2)


def straight(device: Device, gaps: Floats) -> GapPermeance:
    """Return P = µ0 A/g: no field beside the pole faces."""
    p = MU0 * pole_area(device) / gaps
    none = np.zeros_like(gaps)
    return GapPermeance(p, -p / gaps, none, none)


def with_fringing(device: Device, gaps: Floats) -> GapPermeance:
    """Return the pole faces' permeance with the tubes beside them.

    Outside, head and sleeve are taken as flush.  Inside, the collar's edge faces the plane
    of the head.  From depth d down the bore a quarter circle to the head is s π/2 long,
    s = g + d, and the way to the shaft is w: the head gets the share 1/(1 + (s/c)²),
    c = 2w/π, half where both ways are equal.  w = r ln(r/r_shaft), so that its permeance per
    area is that of coaxial cylinders.
    """
    inner, outer = pole_radii(device)
    flat = straight(device, gaps)
    outside, inside = MU0 * 2.0 * math.pi * outer, MU0 * 2.0 * math.pi * inner

    # the half annulus starts all over the head, rim and top, and ends along the sleeve
    depth = min(device.rod.head_thickness + device.rod.head_radius, device.sleeve.length)
    annulus = np.log1p(2.0 * depth / gaps) / math.pi
    d_annulus = -2.0 * depth / (gaps * (gaps + 2.0 * depth)) / math.pi

    c = 2.0 * inner * math.log(inner / device.rod.radius) / math.pi
    end = gaps + device.sleeve.collar_thickness

    def share(s: Floats) -> Floats:
        return 1.0 / (1.0 + (s / c) ** 2)

    # ∫ 2 share/(π s) ds and ∫ share ds from g to g + collar, and their derivatives by g
    bore = (2.0 * np.log(end / gaps) + np.log(share(end) / share(gaps))) / math.pi
    d_bore = 2.0 / math.pi * (share(end) / end - share(gaps) / gaps)
    covered = c * (np.arctan(end / c) - np.arctan(gaps / c))

    return GapPermeance(
        permeance=flat.permeance
        + outside * (_HALF_CYLINDER + annulus)
        + inside * (2.0 * _HALF_CYLINDER + bore),
        d_permeance=flat.d_permeance + outside * d_annulus + inside * d_bore,
        covered=covered,
        d_covered=share(end) - share(gaps),
    )
