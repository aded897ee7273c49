"""Where every part of the device is: each solid as a plain value, in millimetres.

A solid is a box, a stack of tapered blocks or a body turned about z, less at most one box.  CAD
solids, mesh keys and closed-form volumes start here; no CAD kernel is needed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple

from tactgen.geometry.device.checks import check_boxes, check_fit
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device, Support
from tactgen.geometry.errors import InputError

#: The bimorph by itself, or the whole generator with the bimorph glued into the rod.
Standing = Literal["alone", "rod"]

#: Millimetres in a metre: CAD files are in millimetres, everything else is SI.
MM = 1e3

#: Solids by what the bimorph stands on.
BIMORPH = ("piezo_top", "piezo_bottom", "shim")
GENERATOR = (*BIMORPH, "glue", "rod", "coil", "sleeve")

# Lengths are rounded to 1e-9 mm, far below any tolerance of the CAD kernel, so that
# faces meant to touch (0.4 mm - 0.45 mm + 0.05 mm) do so exactly.
_DIGITS = 9


@dataclass(frozen=True)
class Box:
    """A box between two corners (mm)."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]


class Rectangle(NamedTuple):
    """A section across z: its height, both faces along x, its width about y = 0 (mm)."""

    z: float
    low: float
    high: float
    width: float


@dataclass(frozen=True)
class Tapered:
    """A body whose sections run straight from each to the next; two at one height are a step."""

    sections: tuple[Rectangle, ...]

    @property
    def blocks(self) -> list[tuple[Rectangle, Rectangle]]:
        """Lower and upper section of each block between steps."""
        return [(low, high) for low, high in pairwise(self.sections) if low.z < high.z]


@dataclass(frozen=True)
class Turned:
    """A body of revolution about z: corners (r, z) of its half section, in order (mm)."""

    outline: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Part:
    """A solid: a body less at most one box."""

    body: Box | Tapered | Turned
    cut: Box | None = None


@dataclass(frozen=True)
class Ring:
    """One step of a turned body: a ring between two heights and two radii (mm)."""

    low: float
    high: float
    inner: float
    outer: float


def layout(
    device: Device, standing: Standing = "rod", names: tuple[str, ...] | None = None
) -> dict[str, Part]:
    """Parts of the device by name.

    Parameters
    ----------
    device : Device
        What is built.
    standing : {"alone", "rod"}
        ``alone``: only the bimorph, z = 0 at its lowest edge.  ``rod``: the generator,
        z = 0 at the rod's top face.
    names : tuple of str, optional
        Parts wanted; all by default.

    Raises InputError if a name is unknown or the parts cannot be put together.
    """
    known = bimorph_parts(device) if standing == "alone" else GENERATOR
    wanted = known if names is None else names
    for name in wanted:
        if name not in known:
            raise InputError(
                f'region "{name}" does not exist when the bimorph stands "{standing}"; '
                f"use some of {', '.join(known)}"
            )
    if not wanted:
        raise InputError(f"no region is chosen; use some of {', '.join(known)}")
    check_boxes(device, on_rod=standing == "rod")
    parts = _bimorph(device, standing)
    if standing == "rod":
        check_fit(device, Support(kind="rod"))
        parts |= {
            "glue": _glue(device),
            "rod": _rod(device),
            "coil": _coil(device),
            "sleeve": _sleeve(device),
        }
    return {name: parts[name] for name in known if name in wanted}


def bimorph_parts(device: Device) -> tuple[str, ...]:
    """Names of the bimorph's parts: the layers that it lists, or its three."""
    layers = device.bimorph.layers
    return tuple(layers.region(number) for number in range(len(layers))) or BIMORPH


def shim_base(device: Device, standing: Standing) -> float:
    """Height of the shim's lower end (m)."""
    if standing == "alone":
        return 0.0
    return float(device.glue.thickness - device.rod.slot_depth)


def ceramic_base(device: Device, standing: Standing) -> float:
    """Height of the ceramic's lower edge (m)."""
    return float(device.bimorph.tab_length if standing == "alone" else device.ceramic_base)


def rod_base(device: Device) -> float:
    """Height of the rod's bottom face (m)."""
    return float(_rod_datum(device) - device.rod.length)


def total_height(device: Device) -> float:
    """Height from the bimorph's tip to the lowest end of rod and sleeve (m)."""
    return float(device.ceramic_base + device.bimorph.length + below_head(device))


def below_head(device: Device) -> float:
    """Height from the rod's top face down to the lowest end of rod and sleeve (m)."""
    sleeve = device.rod.head_thickness + device.gap + device.sleeve.length
    return float(max(sleeve, -rod_base(device)))


def _rod_datum(device: Device) -> float:
    """Height from which rod-fixed axial positions are measured downward (m).

    It moves with the rod: the sleeve's top face would be there at the nominal gap.
    """
    return float(-device.rod.head_thickness - NOMINAL_GAP)


def _mm(length: float) -> float:
    return round(length * MM, _DIGITS) + 0.0  # + 0.0 turns -0.0 into 0.0, one key for both


def _box(width_x: tuple[float, float], width_y: float, height: tuple[float, float]) -> Box:
    """Box centred on y = 0, from metres."""
    return Box(
        low=(_mm(width_x[0]), _mm(-width_y / 2), _mm(height[0])),
        high=(_mm(width_x[1]), _mm(width_y / 2), _mm(height[1])),
    )


def _bimorph(device: Device, standing: Standing) -> dict[str, Part]:
    b = device.bimorph
    base = ceramic_base(device, standing)
    top = base + b.length
    lowest, highest = shim_base(device, standing), top + b.tip_extension
    if b.layers:
        parts, x = {}, -b.thickness / 2
        for number, (layer, ends) in enumerate(zip(b.layers, b.spans, strict=True)):
            box = _box((x, x + layer.thickness), layer.width or b.width, ends)
            parts[b.layers.region(number)] = Part(box)
            x += layer.thickness
        return parts
    if b.profiles:
        return _tapered(device, standing)
    inner, outer = b.shim_thickness / 2, b.thickness / 2
    return {
        "piezo_top": Part(_box((inner, outer), b.width, (base, top))),
        "piezo_bottom": Part(_box((-outer, -inner), b.width, (base, top))),
        "shim": Part(_box((-inner, inner), b.width, (lowest, highest))),
    }


def _tapered(device: Device, standing: Standing) -> dict[str, Part]:
    """Three layers whose dimensions vary along the ceramic."""
    b, base = device.bimorph, ceramic_base(device, standing)
    top = base + b.length
    heights = sorted({z for profile in b.profiles.values() for z, _ in profile})
    each: dict[str, list[Rectangle]] = {name: [] for name in BIMORPH}

    def add(name: str, z: float, low: float, high: float, width: float) -> None:
        each[name].append(Rectangle(_mm(z), _mm(low), _mm(high), _mm(width)))

    def bare(low: float, high: float) -> None:
        half = b.shim_thickness / 2
        for z in (low, high) if high > low else ():
            add("shim", z, -half, half, b.width)

    bare(shim_base(device, standing), base)
    for low, high in pairwise(heights):
        for z, at in zip((low, high), b.dimensions(low, high), strict=True):
            half, outer = at.shim_thickness / 2, at.shim_thickness / 2 + at.piezo_thickness
            add("piezo_top", base + z, half, outer, at.width)
            add("piezo_bottom", base + z, -outer, -half, at.width)
            add("shim", base + z, -half, half, at.width)
    bare(top, top + b.tip_extension)
    return {name: Part(Tapered(tuple(dict.fromkeys(found)))) for name, found in each.items()}


def _slot(device: Device) -> Box:
    b, bond = device.bimorph, device.glue.thickness
    half = b.shim_thickness / 2 + bond
    return _box((-half, half), b.width + 2 * bond, (-device.rod.slot_depth, 0.0))


def _glue(device: Device) -> Part:
    b = device.bimorph
    half = b.shim_thickness / 2
    tab = _box((-half, half), b.width, (shim_base(device, "rod"), 0.0))
    return Part(_slot(device), cut=tab)


def _rod(device: Device) -> Part:
    return Part(_turned(_rod_rings(device)), cut=_slot(device))


def _rod_rings(device: Device) -> list[Ring]:
    rod = device.rod
    datum = _rod_datum(device)
    flange_top = datum - rod.flange_position
    flange_bottom = flange_top - rod.flange_thickness
    return [
        _ring(rod_base(device), flange_bottom, 0.0, rod.radius),
        _ring(flange_bottom, flange_top, 0.0, rod.flange_radius),
        _ring(flange_top, -rod.head_thickness, 0.0, rod.radius),
        _ring(-rod.head_thickness, 0.0, 0.0, rod.head_radius),
    ]


def _coil(device: Device) -> Part:
    return Part(_turned([_coil_ring(device)]))


def _coil_ring(device: Device) -> Ring:
    coil = device.coil
    top = _rod_datum(device) - coil.position
    return _ring(top - coil.length, top, coil.inner_radius, coil.outer_radius)


def moving_rings(device: Device) -> dict[str, tuple[Ring, ...]]:
    """Moving bodies as rings: the rod without slot, the coil.

    z = 0 at the rod's top face.  A slot is filled again by glue and tab, lighter than steel.
    """
    return {"rod": tuple(_rod_rings(device)), "coil": (_coil_ring(device),)}


def _sleeve(device: Device) -> Part:
    sleeve = device.sleeve
    if sleeve.collar_thickness > sleeve.length:
        raise InputError(
            f"sleeve.collar_thickness = {sleeve.collar_thickness * MM:g} mm is more than "
            f"sleeve.length = {sleeve.length * MM:g} mm; make the collar thinner"
        )
    top = -device.rod.head_thickness - device.gap
    collar = top - sleeve.collar_thickness
    rings = [
        _ring(top - sleeve.length, collar, sleeve.inner_radius, sleeve.outer_radius),
        _ring(collar, top, sleeve.collar_radius, sleeve.outer_radius),
    ]
    return Part(_turned(rings))


def _ring(low: float, high: float, inner: float, outer: float) -> Ring:
    return Ring(_mm(low), _mm(high), _mm(inner), _mm(outer))


def _turned(rings: list[Ring]) -> Turned:
    """Outline of rings stacked from the bottom up, without needless corners."""
    rings = [ring for ring in rings if ring.high > ring.low]
    outer = [corner for r in rings for corner in ((r.outer, r.low), (r.outer, r.high))]
    inner = [corner for r in rings for corner in ((r.inner, r.low), (r.inner, r.high))]
    return Turned(_without_needless_corners(outer + inner[::-1]))


def _without_needless_corners(
    corners: list[tuple[float, float]],
) -> tuple[tuple[float, float], ...]:
    """Drop repeated corners and corners between two edges in one line.

    They would become CAD faces of no area, or one cylinder in two pieces.
    """
    kept = list(corners)
    for here in range(len(corners) - 1, -1, -1):
        before, corner, after = kept[here - 1], kept[here], kept[(here + 1) % len(kept)]
        along_z = before[0] == corner[0] == after[0]
        along_r = before[1] == corner[1] == after[1]
        if along_z or along_r:
            del kept[here]
    return tuple(kept)


def closed_form_volumes(device: Device, standing: Standing = "rod") -> dict[str, float]:
    """Volume of each solid (m³), worked out by hand from the parameters; profiles by Simpson.

    Raises InputError if the parts cannot be put together.
    """
    names = tuple(layout(device, standing))
    b, rod, coil, sleeve = device.bimorph, device.rod, device.coil, device.sleeve
    if b.layers:
        return {
            name: layer.thickness * (layer.width or b.width) * (high - low)
            for name, layer, (low, high) in zip(names, b.layers, b.spans, strict=True)
        }
    if b.profiles:
        return {name: _volume(part.body) for name, part in layout(device, standing).items()}
    layer = b.length * b.width * b.piezo_thickness
    embedded = rod.slot_depth - device.glue.thickness
    slot = (
        (b.shim_thickness + 2 * device.glue.thickness)
        * (b.width + 2 * device.glue.thickness)
        * rod.slot_depth
    )
    shaft = rod.length + NOMINAL_GAP
    bore = sleeve.length - sleeve.collar_thickness
    volumes = {
        "piezo_top": layer,
        "piezo_bottom": layer,
        "shim": b.height * b.width * b.shim_thickness,
        "glue": slot - embedded * b.width * b.shim_thickness,
        "rod": math.pi
        * (
            rod.radius**2 * shaft
            + (rod.flange_radius**2 - rod.radius**2) * rod.flange_thickness
            + rod.head_radius**2 * rod.head_thickness
        )
        - slot,
        "coil": math.pi * (coil.outer_radius**2 - coil.inner_radius**2) * coil.length,
        "sleeve": math.pi
        * (
            sleeve.outer_radius**2 * sleeve.length
            - sleeve.inner_radius**2 * bore
            - sleeve.collar_radius**2 * sleeve.collar_thickness
        ),
    }
    return {name: volumes[name] for name in names}


def _volume(body: Box | Tapered | Turned) -> float:
    """Volume (m³) of tapered blocks; areas are quadratic between sections, so Simpson is exact."""
    assert isinstance(body, Tapered)

    def area(low: Rectangle, high: Rectangle) -> float:
        return 0.25 * (low.high + high.high - low.low - high.low) * (low.width + high.width)

    whole = sum(
        (high.z - low.z) / 6.0 * (area(low, low) + 4.0 * area(low, high) + area(high, high))
        for low, high in body.blocks
    )
    return whole / MM**3
