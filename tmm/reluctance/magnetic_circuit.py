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

from tactgen.geometry.arrays import Bools, Complex, Floats, Ints, Numbers
from tactgen.geometry.device.checks import check_gap
from tactgen.geometry.device.magnetisation import MU0, linear
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.flux_ladder import Ladder

#: Roters' half cylinder between two flush edges, its permeance over µ0 and length.
_HALF_CYLINDER = 0.26


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


def straight(device: Device, gaps: Numbers) -> Numbers:
    """Permeance µ0 A/g (m,) in H: no field beside the pole faces."""
    return np.asarray(MU0 * pole_area(device) / gaps)


def with_fringing(device: Device, gaps: Numbers) -> tuple[Numbers, Numbers]:
    """Pole faces' permeance (m,) in H with the tubes beside them, and what these take of the bore.

    The second is the height (m,) of the collar's bore that the tubes from the head take (m).

    Outside, head and sleeve are taken as flush.  Inside, the collar's edge faces the plane
    of the head.  From depth d down the bore a quarter circle to the head is s π/2 long,
    s = g + d, and the way to the shaft is w: the head gets the share 1/(1 + (s/c)²),
    c = 2w/π, half where both ways are equal.  w = r ln(r/r_shaft), so that its permeance per
    area is that of coaxial cylinders.
    """
    inner, outer = pole_radii(device)
    outside, inside = MU0 * 2.0 * math.pi * outer, MU0 * 2.0 * math.pi * inner
    # the half annulus starts all over the head, rim and top, and ends along the sleeve
    depth = min(device.rod.head_thickness + device.rod.head_radius, device.sleeve.length)
    annulus = np.log1p(2.0 * depth / gaps) / math.pi
    c = 2.0 * inner * math.log(inner / device.rod.radius) / math.pi
    end = gaps + device.sleeve.collar_thickness
    # ∫ 2 share/(π s) ds and ∫ share ds from g to g + collar
    shares = (1.0 + (gaps / c) ** 2) / (1.0 + (end / c) ** 2)
    bore = (2.0 * np.log(end / gaps) + np.log(shares)) / math.pi
    covered = c * (np.arctan(end / c) - np.arctan(gaps / c))
    permeance = straight(device, gaps) + outside * (_HALF_CYLINDER + annulus)
    return permeance + inside * (2.0 * _HALF_CYLINDER + bore), covered


#: Cells in each of the ladder's zones; the error falls with their square.
CELLS = 24

#: Added to every rung of leakage (H), 1e-9 m of vacuum: a zone of no length stays finite.
_LEAST_PERMEANCE = 1e-9 * MU0

#: What the gap is moved by along the imaginary axis (m): whatever follows from it has its slope by
#: the gap as imaginary part then, to rounding (Squire and Trapp, SIAM Review 40 (1998) 110).  Its
#: sign decides which of two ends at one place counts, as NumPy orders complex numbers.
_STEP = -1e-30

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
    """The path below the gap in k cells, from the flange up; arrays (m, k)."""

    length: Complex  #: Axial length of each cell (m)
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
    check_circuit(device, gaps)
    moved = gaps + 1j * _STEP
    path = _path(device, moved, cells, parasitic_gap=refinements.parasitic_gap)
    if refinements.fringing:
        gap, covered = with_fringing(device, moved)
    else:
        gap, covered = straight(device, moved), np.zeros_like(moved)
    flange = path.in_flange[0]
    between = refinements.leakage | flange | np.append(flange[1:], False)
    group = np.concatenate([[0], np.cumsum(between)])

    there = np.concatenate([[refinements.parasitic_gap], between])
    rungs = np.where(there, 1.0 / _rung_permeance(device, path, covered, refinements), 0.0)
    kept = np.concatenate([[True], between])
    reluctance = np.concatenate([rungs[:, kept], 1.0 / gap[:, None]], axis=1)
    area, length, cell = _iron(device, moved, path)
    curve = magnetisation_curve(device.steel)
    if refinements.iron == "linear":
        curve = linear(curve.highest_permeability)
    elif refinements.iron == "perfect":
        area, length, cell = area[:, :0], length[:, :0], cell[:0]
    coil = device.coil
    # turns above the sleeve link the gap
    above = np.minimum(np.maximum(moved - NOMINAL_GAP - coil.position, 0.0), coil.length)
    into = np.eye(int(group[-1]) + 1)[group]
    turns = (path.in_coil * path.length) @ into[:-1] + above[:, None] * into[-1]
    turns *= coil.turns / coil.length
    slopes = (part.imag / _STEP for part in (length, reluctance, turns))
    d_length, d_reluctance, d_turns = slopes
    return Ladder(
        curve=curve,
        area=area,
        length=length.real,
        d_length=d_length,
        cell=group[cell],
        reluctance=reluctance.real,
        d_reluctance=d_reluctance,
        turns=turns.real,
        d_turns=d_turns,
    )


def _path(device: Device, gaps: Complex, cells: int, *, parasitic_gap: bool) -> _Path:
    """Divide the path into zones of equal kind, each into equal cells.

    Depths are measured in the rod's frame, downward from where the sleeve's top is at the
    nominal gap: the sleeve moves in it, by as much as the gap changes.
    """
    rod, coil, sleeve = device.rod, device.coil, device.sleeve
    top = gaps - NOMINAL_GAP
    ends = {
        "flange": np.full_like(gaps, rod.flange_position),
        "coil_bottom": np.maximum(coil.position + coil.length, top),
        "coil_top": np.maximum(coil.position, top),
        "collar": top + sleeve.collar_thickness,
        "top": top,
    }
    if parasitic_gap:
        lowest = rod.flange_position + rod.flange_thickness
        ends["lowest"] = np.minimum(lowest, top + sleeve.length)
    depth = np.stack(list(ends.values()), axis=1)
    order = np.argsort(-depth.real, axis=1, kind="stable")
    depth = np.take_along_axis(depth, order, axis=1)
    # by rank, not by depth: a zone of no length still has a kind, and may be about to grow
    rank = dict(zip(ends, np.argsort(order, axis=1).T[..., None], strict=True))
    zone = np.arange(depth.shape[1] - 1)

    def each(values: Complex | Bools) -> Any:
        return np.repeat(values, cells, axis=1)

    return _Path(
        length=each((depth[:, :-1] - depth[:, 1:]) / cells),
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


def widest_circuit(device: Device) -> float:
    """Widest gap (m) at which the parts form this circuit: the flange at the collar."""
    rod, sleeve = device.rod, device.sleeve
    return float(NOMINAL_GAP + rod.flange_position - sleeve.collar_thickness)


def _rung_permeance(
    device: Device, path: _Path, covered: Numbers, refinements: Refinements
) -> Complex:
    """Permeance (m, k + 1) of the rungs below each cell and above the last.

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
    free = sleeve.collar_thickness - covered
    half = 0.5 * np.where(path.in_collar, collar * free[:, None], bore) * path.length
    p: Complex = np.pad(half, ((0, 0), (0, 1))) + np.pad(half, ((0, 0), (1, 0)))
    return p + _LEAST_PERMEANCE


def _iron(device: Device, gaps: Complex, path: _Path) -> tuple[Floats, Complex, Ints]:
    """Areas, lengths (m, E) and the cells (E,) of the iron elements.

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
        np.concatenate([along, along, np.full(_RINGS + 1, k)]),
    )
