"""The magnetic circuit of the normal actuator, laid out as a ladder from its dimensions.

Going round the flux: shaft, head, working gap, sleeve, parasitic gap, flange.  Leakage
between shaft and sleeve, and the parasitic gap, are distributed along the sleeve.
Rod, flange, head and coil move with the gap, the sleeve does not, so the leakage changes
with the gap as well.

Not modelled: the field outside the sleeve but for the tubes that start on the head, the
field below the flange, the slot in the head, the shaft between collar and head as a source
of leakage, hysteresis, eddy currents.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.device.checks import check_gap
from tactgen.geometry.device.magnetisation import MU0, MagnetisationCurve, linear
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.flux_ladder import Ladder

#: Roters' half cylinder between two flush edges, its permeance over µ0 and length.
_HALF_CYLINDER = 0.26


@dataclass(frozen=True)
class GapPermeance:
    """Permeance at m gaps, and how much of the collar's bore its tubes take."""

    #: (m,) P (H) and dP/dg (H/m)
    permeance: Floats
    d_permeance: Floats
    #: (m,) Height of the collar's bore that the tubes from the head take (m), and its slope
    covered: Floats
    d_covered: Floats


def pole_radii(device: Device) -> tuple[float, float]:
    """Inner and outer radius (m) where the head's underside faces the sleeve's top.

    Raises InputError if they do not face each other, or the collar touches the shaft.
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
    """Area in which head and sleeve face each other (m²)."""
    inner, outer = pole_radii(device)
    return math.pi * (outer**2 - inner**2)


def straight(device: Device, gaps: Floats) -> GapPermeance:
    """P = µ0 A/g: no field beside the pole faces."""
    p = MU0 * pole_area(device) / gaps
    none = np.zeros_like(gaps)
    return GapPermeance(p, -p / gaps, none, none)


def with_fringing(device: Device, gaps: Floats) -> GapPermeance:
    """Pole faces' permeance with the tubes beside them.

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


#: Cells in each of the ladder's zones; the error falls with their square.
CELLS = 24

#: Added to every rung of leakage (H), 1e-9 m of vacuum: a zone of no length stays finite.
_LEAST_PERMEANCE = 1e-9 * MU0

#: Rings in which the head's radial field is integrated (Gauss points).
_RINGS = 4


@dataclass(frozen=True)
class Refinements:
    """Refinements of the network over the one-gap formula."""

    #: No reluctance, the curve's highest permeability, or the curve itself
    iron: Literal["perfect", "linear", "saturating"] = "saturating"
    #: The gap between flange and sleeve; the field across the coil from shaft to sleeve; the field
    #: beside the pole faces
    parasitic_gap: bool = True
    leakage: bool = True
    fringing: bool = True


#: Everything on.
FULL = Refinements()
#: Everything off: the textbook's formula.
ONE_GAP = Refinements("perfect", parasitic_gap=False, leakage=False, fringing=False)


@dataclass(frozen=True)
class _Path:
    """The path below the gap in k cells, from the flange up; arrays (m, k) unless said."""

    #: Axial length of each cell (m) and its derivative by the gap
    length: Floats
    d_length: Floats
    #: What lies there
    in_flange: Bools
    in_coil: Bools
    in_collar: Bools


def circuit(device: Device, gaps: Floats, refinements: Refinements, cells: int = CELLS) -> Ladder:
    """Circuit of the device at all `gaps` (m,).

    The cells follow the path upward; the last one is the head with the working gap.
    Half of a cell's leakage leaves at each of its ends.  Cells with no rung between them
    carry one flux and become one.

    Raises InputError if the parts cannot form the circuit at one of the gaps.
    """
    path = _path(device, gaps, cells, parasitic_gap=refinements.parasitic_gap)
    gap = (with_fringing if refinements.fringing else straight)(device, gaps)
    flange = path.in_flange[0]
    between = refinements.leakage | flange | np.append(flange[1:], False)
    group = np.concatenate([[0], np.cumsum(between)])

    permeance, d_permeance = _rung_permeance(device, path, gap, refinements)
    there = np.concatenate([[refinements.parasitic_gap], between])
    reluctance = np.where(there, 1.0 / permeance, 0.0)
    rungs = np.concatenate([[True], between])
    top = 1.0 / gap.permeance[:, None]
    area, length, d_length, cell = _iron(device, gaps, path)
    density = device.coil.turns / device.coil.length
    coil = path.in_coil * density
    above, d_above = _coil_above_sleeve(device, gaps)
    last = np.eye(int(group[-1]) + 1)[-1]
    return Ladder(
        curve=_curve(device, refinements),
        area=area,
        length=length,
        d_length=d_length,
        cell=group[cell],
        reluctance=np.concatenate([reluctance[:, rungs], top], axis=1),
        d_reluctance=np.concatenate(
            [(-d_permeance * reluctance**2)[:, rungs], -gap.d_permeance[:, None] * top**2], axis=1
        ),
        turns=_grouped(coil * path.length, group) + density * above[:, None] * last,
        d_turns=_grouped(coil * path.d_length, group) + density * d_above[:, None] * last,
    )


def _path(device: Device, gaps: Floats, cells: int, *, parasitic_gap: bool) -> _Path:
    """Divide the path into zones of equal kind, each into equal cells.

    Depths are measured in the rod's frame, downward from where the sleeve's top is at the
    nominal gap: the sleeve moves in it, by as much as the gap changes.
    """
    rod, coil, sleeve = device.rod, device.coil, device.sleeve
    top = gaps - NOMINAL_GAP
    collar = top + sleeve.collar_thickness
    fixed, moving = np.zeros_like(gaps), np.ones_like(gaps)

    def below_top(position: float) -> tuple[Floats, Floats]:
        return np.maximum(position, top), np.where(position < top, moving, fixed)

    check_circuit(device, gaps)
    lowest = np.minimum(rod.flange_position + rod.flange_thickness, top + sleeve.length)
    ends = {
        "flange": (np.full_like(gaps, rod.flange_position), fixed),
        "coil_bottom": below_top(coil.position + coil.length),
        "coil_top": below_top(coil.position),
        "collar": (collar, moving),
        "top": (top, moving),
    }
    if parasitic_gap:
        ends["lowest"] = (lowest, np.where(lowest == top + sleeve.length, moving, fixed))
    depth, d_depth = (np.stack(part, axis=1) for part in zip(*ends.values(), strict=True))
    order = np.argsort(-depth, axis=1, kind="stable")
    depth, d_depth = (np.take_along_axis(part, order, axis=1) for part in (depth, d_depth))
    # by rank, not by depth: a zone of no length still has a kind, and may be about to grow
    rank = dict(zip(ends, np.argsort(order, axis=1).T[..., None], strict=True))
    zone = np.arange(depth.shape[1] - 1)

    def each(values: Floats | Bools) -> Any:
        return np.repeat(values, cells, axis=1)

    return _Path(
        length=each((depth[:, :-1] - depth[:, 1:]) / cells),
        d_length=each((d_depth[:, :-1] - d_depth[:, 1:]) / cells),
        in_flange=each(zone < rank["flange"]),
        in_coil=each((zone >= rank["coil_bottom"]) & (zone < rank["coil_top"])),
        in_collar=each(zone >= rank["collar"]),
    )


def check_circuit(device: Device, gaps: Floats) -> None:
    """Refuse gaps (m) at which the parts, moved, do not form this circuit.

    Raises InputError with the first of them, or what is too long at any.
    """
    rod, sleeve = device.rod, device.sleeve
    check_gap(device, float(gaps.max()))
    top, widest = gaps - NOMINAL_GAP, widest_circuit(device)
    smaller = "the gap smaller or " if widest > 0.0 else ""
    reach = (
        f"sleeve.collar_thickness = {sleeve.collar_thickness * 1e3:g} mm to the flange at "
        f"rod.flange_position = {rod.flange_position * 1e3:g} mm, of which the network knows no "
        f"circuit; make {smaller}the collar thinner"
    )
    for wrong, words in (
        (gaps <= 0.0, "leaves no gap; use a positive one"),
        (gaps >= widest, f"brings {reach}"),
        (top + sleeve.length <= rod.flange_position, "lifts the flange below the sleeve's end"),
    ):
        if wrong.any():
            gap = float(gaps[np.argmax(wrong)])
            raise InputError(f"gap = {gap * 1e3:g} mm {words}")


def _coil_above_sleeve(device: Device, gaps: Floats) -> tuple[Floats, Floats]:
    """Length of coil above the sleeve (m,) and its slope; its turns link the gap."""
    coil = device.coil
    top = gaps - NOMINAL_GAP
    length = np.clip(top - coil.position, 0.0, coil.length)
    return length, ((length > 0.0) & (length < coil.length)).astype(float)


def widest_circuit(device: Device) -> float:
    """Widest gap (m) at which the parts form this circuit: the flange at the collar."""
    rod, sleeve = device.rod, device.sleeve
    return float(NOMINAL_GAP + rod.flange_position - sleeve.collar_thickness)


def _rung_permeance(
    device: Device, path: _Path, gap: GapPermeance, refinements: Refinements
) -> tuple[Floats, Floats]:
    """Permeance of the rungs (m, k + 1) below each cell and above the last, dP/dg.

    Coaxial cylinders, 2π µ0/ln(r2/r1) per length; the collar's bore only as far as the tubes
    of the gap's fringing leave it.
    """
    rod, sleeve = device.rod, device.sleeve

    def coaxial(inner: float, outer: float) -> float:
        return 2.0 * math.pi * MU0 / math.log(outer / inner)

    leaking = 1.0 if refinements.leakage else 0.0
    bore = np.where(
        path.in_flange,
        coaxial(rod.flange_radius, sleeve.inner_radius),
        leaking * coaxial(rod.radius, sleeve.inner_radius),
    )
    collar = leaking * coaxial(rod.radius, sleeve.collar_radius) / sleeve.collar_thickness
    free = sleeve.collar_thickness - gap.covered
    per_length = np.where(path.in_collar, collar * free[:, None], bore)
    slope = np.where(path.in_collar, -collar * gap.d_covered[:, None], 0.0)
    half = 0.5 * per_length * path.length
    d_half = 0.5 * (slope * path.length + per_length * path.d_length)
    p, d_p = (
        np.pad(part, ((0, 0), (0, 1))) + np.pad(part, ((0, 0), (1, 0))) for part in (half, d_half)
    )
    return p + _LEAST_PERMEANCE, d_p


def _iron(device: Device, gaps: Floats, path: _Path) -> tuple[Floats, Floats, Floats, Ints]:
    """Areas, lengths, their slopes (m, E) and the cells (E,) of the iron elements.

    Rod and sleeve beside every cell; in the last cell the shaft up to the middle of the
    head, and rings of the head from the shaft to the middle of the pole.
    """
    rod, sleeve = device.rod, device.sleeve
    m, k = path.length.shape

    def disc(outer: float, inner: float = 0.0) -> float:
        return math.pi * (outer**2 - inner**2)

    rod_area = np.where(path.in_flange, disc(rod.flange_radius), disc(rod.radius))
    sleeve_area = np.where(
        path.in_collar,
        disc(sleeve.outer_radius, sleeve.collar_radius),
        disc(sleeve.outer_radius, sleeve.inner_radius),
    )
    points, weights = np.polynomial.legendre.leggauss(_RINGS)
    half_width = 0.5 * (0.5 * sum(pole_radii(device)) - rod.radius)
    radius = rod.radius + half_width * (1.0 + points)
    head_area = np.append(disc(rod.radius), 2.0 * math.pi * rod.head_thickness * radius)
    shaft = gaps[:, None] + 0.5 * rod.head_thickness
    rings = np.broadcast_to(half_width * weights, (m, _RINGS))
    along = np.arange(k)
    return (
        np.concatenate([rod_area, sleeve_area, np.broadcast_to(head_area, (m, _RINGS + 1))], 1),
        np.concatenate([path.length, path.length, shaft, rings], axis=1),
        np.concatenate(
            [path.d_length, path.d_length, np.ones((m, 1)), np.zeros((m, _RINGS))], axis=1
        ),
        np.concatenate([along, along, np.full(_RINGS + 1, k)]),
    )


def _curve(device: Device, refinements: Refinements) -> MagnetisationCurve | None:
    if refinements.iron == "perfect":
        return None
    curve = magnetisation_curve(device.steel)
    if refinements.iron == "saturating":
        return curve
    return linear(curve.highest_permeability)


def _grouped(values: Floats, group: Ints) -> Floats:
    """Sum `values` (m, k) of the cells that became one; the gap's cell has none."""
    return np.asarray(values @ np.eye(int(group[-1]) + 1)[group[:-1]])
