"""Whether the parts of a device can be put together, before anything is built from them."""

from __future__ import annotations

import math
from itertools import pairwise

from tactgen.geometry.device.bimorph import GROWTHS
from tactgen.geometry.device.laminate import Laminate, Layer
from tactgen.geometry.device.parameters import NOMINAL_GAP, Bimorph, Device, Piezo, Support
from tactgen.geometry.errors import InputError

#: Rounding of sums of dimensions (m).
_ROUNDING = 1e-12
#: Least part of the length that a layer covers.
_SHORTEST = 1e-6

#: Softest glue between layers (Pa) with which the bricks' error bars were found to hold.
_LEAST_GLUE = 1e7


def check_fit(device: Device, support: Support) -> None:
    """Refuse a device whose parts cannot be put together.

    Raises InputError in one sentence, with the values in millimetres.
    """
    check_bimorph(device, support)
    check_actuator(device)


def check_bimorph(device: Device, support: Support) -> None:
    """Refuse a bimorph that is not whole, or does not go into the rod that holds it.

    Raises InputError in one sentence, with the values in millimetres.
    """
    _check_ceramic(device.bimorph)
    _check_layers(device.bimorph, support)
    _check_place(device, support)
    if support.kind == "rod":
        _check_joint(device)


def check_actuator(device: Device) -> None:
    """Refuse a rod, coil and sleeve that do not go into each other.

    Raises InputError in one sentence, with the values in millimetres.
    """
    rod, sleeve, coil = device.rod, device.sleeve, device.coil
    mm = 1e3
    if not rod.radius <= coil.inner_radius < coil.outer_radius < sleeve.inner_radius:
        raise InputError(
            f"coil.inner_radius = {coil.inner_radius * mm:g} mm and coil.outer_radius = "
            f"{coil.outer_radius * mm:g} mm must lie between rod.radius = {rod.radius * mm:g} mm "
            f"and sleeve.inner_radius = {sleeve.inner_radius * mm:g} mm, in that order"
        )
    if not sleeve.collar_radius <= sleeve.inner_radius < sleeve.outer_radius:
        raise InputError(
            f"sleeve.inner_radius = {sleeve.inner_radius * mm:g} mm must lie between "
            f"sleeve.collar_radius = {sleeve.collar_radius * mm:g} mm and "
            f"sleeve.outer_radius = {sleeve.outer_radius * mm:g} mm"
        )
    if not rod.radius < rod.flange_radius < sleeve.inner_radius:
        raise InputError(
            f"rod.flange_radius = {rod.flange_radius * mm:g} mm must lie between rod.radius = "
            f"{rod.radius * mm:g} mm and sleeve.inner_radius = {sleeve.inner_radius * mm:g} mm"
        )
    if rod.flange_position + rod.flange_thickness > rod.length + _ROUNDING:
        raise InputError(
            f"rod.length = {rod.length * mm:g} mm ends above the flange's lower face at "
            f"{(rod.flange_position + rod.flange_thickness) * mm:g} mm; make the rod longer"
        )
    if coil.position + coil.length > rod.flange_position + _ROUNDING:
        raise InputError(
            f"coil.length = {coil.length * mm:g} mm from coil.position = {coil.position * mm:g} mm "
            f"runs into the flange at rod.flange_position = {rod.flange_position * mm:g} mm; "
            "shorten the coil"
        )
    if coil.position + NOMINAL_GAP < -_ROUNDING:
        raise InputError(
            f"coil.position = {coil.position * mm:g} mm puts the coil's top into the rod's head, "
            f"whose underside is at {-NOMINAL_GAP * mm:g} mm; move the coil down"
        )
    check_gap(device, device.gap)


def widest_gap(device: Device) -> float:
    """Gap (m) at which flange or coil meets the collar; inf if both go through it."""
    rod, coil, sleeve = device.rod, device.coil, device.sleeve
    tops = ((rod.flange_radius, rod.flange_position), (coil.outer_radius, coil.position))
    caught = [top for radius, top in tops if radius >= sleeve.collar_radius]
    return float(NOMINAL_GAP + min(caught, default=math.inf) - sleeve.collar_thickness)


def check_gap(device: Device, gap: float) -> None:
    """Refuse a working gap (m) at which the flange has met the collar, which it cannot pass.

    Raises InputError with the gap at which they meet.
    """
    rod, sleeve = device.rod, device.sleeve
    mm = 1e3
    meeting = NOMINAL_GAP + rod.flange_position - sleeve.collar_thickness
    if rod.flange_radius >= sleeve.collar_radius and meeting <= _ROUNDING:
        raise InputError(
            f"sleeve.collar_thickness = {sleeve.collar_thickness * mm:g} mm reaches down to the "
            f"flange at rod.flange_position = {rod.flange_position * mm:g} mm even with the gap "
            "closed; make the collar thinner"
        )
    if rod.flange_radius >= sleeve.collar_radius and gap >= meeting - _ROUNDING:
        raise InputError(
            f"gap = {gap * mm:g} mm needs the flange (rod.flange_radius = "
            f"{rod.flange_radius * mm:g} mm) to pass the collar (sleeve.collar_radius = "
            f"{sleeve.collar_radius * mm:g} mm), which it meets at a gap of {meeting * mm:g} mm; "
            "use a smaller gap or a wider collar"
        )


def _check_ceramic(bimorph: Bimorph) -> None:
    """Refuse profiles that end elsewhere than the ceramic, and ceramic without electrodes."""
    mm = 1e3
    for name, profile in bimorph.profiles.items():
        if not math.isclose(profile.end, bimorph.length, rel_tol=1e-9):
            raise InputError(
                f"bimorph.{name} ends at {profile.end * mm:.10g} mm but bimorph.length = "
                f"{bimorph.length * mm:.10g} mm; let the profile end at the ceramic's upper edge"
            )
    if bimorph.bare_below + bimorph.bare_above >= bimorph.length:
        raise InputError(
            f"bimorph.bare_below = {bimorph.bare_below * mm:g} mm and bimorph.bare_above = "
            f"{bimorph.bare_above * mm:g} mm leave no electrode on bimorph.length = "
            f"{bimorph.length * mm:g} mm; make them shorter"
        )


def _check_place(device: Device, support: Support) -> None:
    """Refuse a place of measurement that is not on the bimorph above what holds it."""
    inside = device.bimorph.tab_length - device.ceramic_base if support.kind == "rod" else 0.0
    free, below = device.bimorph.height - inside, device.measurement.below_tip
    if below >= free - _ROUNDING:
        raise InputError(
            f"measurement.below_tip = {below * 1e3:g} mm is not on the bimorph, whose tip is "
            f"{free * 1e3:g} mm above what holds it; measure less far below the tip"
        )


def check_read_at_tip(device: Device) -> None:
    """Refuse a place of measurement other than the tip.

    Raises InputError in one sentence that names the models that know one.
    """
    if below := device.measurement.below_tip:
        raise InputError(
            f"measurement.below_tip = {below * 1e3:g} mm is unknown to the model lumped, which has "
            "no shape between base and tip; ask for models=tmm,beam,solid, or set 0 mm"
        )


def _check_layers(bimorph: Bimorph, support: Support) -> None:
    """Refuse listed layers that cannot be wired or held, and lengths without a layer."""
    layers = bimorph.layers
    if not layers:
        return
    text = f'bimorph.layers = "{layers}"'
    driven = [number for number in range(len(layers)) if layers.hot(number)]
    if not driven:
        raise InputError(
            f"{text} has no ceramic at the drive voltage; add one with its poling, such as PZT-5A "
            "0.26 mm +x"
        )
    _check_extents(bimorph)
    _check_contacts(layers)
    along = [layer for layer in layers if layer.pitch]
    for layer in along:
        covered = (layer.end or bimorph.length) - layer.start
        if not layer.thickness <= layer.pitch <= covered:
            raise InputError(
                f"bimorph.layers has {layer}, whose pitch must lie between its thickness, as the "
                f"field of closer fingers does not fill it, and its length, {covered * 1e3:g} mm; "
                "change the pitch"
            )
        if bimorph.wiring == "series":
            raise InputError(
                f'bimorph.wiring = "series" is not known for {layer} with interdigitated '
                "electrodes; use parallel"
            )
    for name in ("bare_below", "bare_above"):
        if getattr(bimorph, name) and along:
            raise InputError(
                f"bimorph.{name} = {getattr(bimorph, name) * 1e3:g} mm is not known with a ceramic "
                f"poled along in {text}; set 0 mm, with bimorph.length up to the last electrode"
            )
        if getattr(bimorph, name) and any(of.is_patch and of.is_ceramic for of in layers):
            raise InputError(
                f"bimorph.{name} = {getattr(bimorph, name) * 1e3:g} mm is not known with ceramics "
                f"of their own place in {text}, whose electrodes cover them; set 0 mm"
            )
    for name in ("tab_length", "tip_extension"):
        if getattr(bimorph, name) > 0.0 and not any(layers.continues):
            raise InputError(
                f"bimorph.{name} = {getattr(bimorph, name) * 1e3:g} mm has no layer that goes on "
                f"beyond the ceramic in {text}; add one of metal, or set bimorph.{name} = 0 mm"
            )
    if support.kind in ("rod", "contact"):
        raise InputError(
            f'bimorph.layers is not known with support.kind = "{support.kind}", whose rod holds a '
            "shim; use clamped or spring"
        )
    if bimorph.wiring == "series":
        if not _mirrored(layers):
            raise InputError(
                'bimorph.wiring = "series" is known for layers that mirror each other in size, two '
                f"ceramics of them driven, and not for {text}; use parallel, with both poled alike"
            )
        if any(layer.hot for layer in layers):
            raise InputError(
                f'bimorph.wiring = "series" has its terminals on the outer faces, and {text} names '
                "others; leave out hot"
            )


def _check_contacts(layers: Laminate) -> None:
    """Refuse ceramics whose faces touch, or are joined by metal, at different voltages.

    Interdigitated electrodes are insulated from metal and touch no other ceramic.
    """
    for number, pair in enumerate(pairwise(layers)):
        if all(layer.is_ceramic for layer in pair) and any(layer.pitch for layer in pair):
            raise InputError(
                f"bimorph.layers joins layer {number + 1} ({pair[0]}) and layer {number + 2} "
                f"({pair[1]}), and interdigitated electrodes cannot touch another ceramic; put "
                "glue between them"
            )
    below: Layer | None = None
    before, at_voltage = 0, False
    for number, layer in enumerate(layers):
        hot = layers.hot(number)
        if layer.material == "glue" or layer.electrodes == "bare" or layer.pitch:
            below = None  # insulates
        elif layer.is_ceramic:
            if below is not None and at_voltage != (hot < 0):
                raise InputError(
                    f"bimorph.layers joins layer {before} ({below}) and layer {number + 1} "
                    f"({layer}) by faces of which one is at the "
                    'drive voltage and the other is not; say which faces are, as in "PZT-5A 0.2 mm '
                    '+x hot -x", or put glue between them'
                )
            below, before, at_voltage = layer, number + 1, hot > 0


def _check_extents(bimorph: Bimorph) -> None:
    """Refuse layers beyond the length, no layer all along, and a gap between layers."""
    layers, length = bimorph.layers, bimorph.length
    extents = layers.extents(length)
    for number, (layer, (_, end)) in enumerate(zip(layers, extents, strict=True)):
        if layer.start >= length or end > (1.0 + _ROUNDING) * length:
            raise InputError(
                f"bimorph.layers has layer {number + 1} ({layer}) beyond bimorph.length = "
                f"{length * 1e3:g} mm; let it end there, or make the bimorph longer"
            )
        if end <= layer.start:
            raise InputError(
                f"bimorph.layers has layer {number + 1} ({layer}), which ends at {end * 1e3:g} mm, "
                f"not above its beginning at {layer.start * 1e3:g} mm; change one of the two"
            )
        if end - layer.start < _SHORTEST * length:
            raise InputError(
                f"bimorph.layers has layer {number + 1} ({layer}), which covers next to nothing of "
                f"bimorph.length = {length * 1e3:g} mm; make it longer, or leave it out"
            )
    if all(layer.is_patch for layer in layers):
        raise InputError(
            f'bimorph.layers = "{layers}" has no layer all along bimorph.length, which would carry '
            "the others; leave out the place of one"
        )
    ends = sorted({end for extent in extents for end in extent})
    for low, high in pairwise(ends):
        there = [n for n, (start, end) in enumerate(extents) if start <= low and high <= end]
        for below, above in pairwise(there):
            if above > below + 1 and high - low > _ROUNDING:
                raise InputError(
                    f"bimorph.layers has nothing between layer {below + 1} ({layers[below]}) and "
                    f"layer {above + 1} ({layers[above]}) from {low * 1e3:g} to {high * 1e3:g} mm; "
                    "let the outer one cover no more than what carries it, and give patches beside "
                    "each other one layer"
                )


def _mirrored(layers: Laminate) -> bool:
    """Whether layers and voltages are the same seen from both sides, with two driven ceramics."""
    hot = [layers.hot(number) for number in range(len(layers))]
    sizes = [layer._replace(poling=0, hot=0, of=None) for layer in layers]
    alike = sizes == sizes[::-1] and hot == [-sign for sign in hot[::-1]]
    return alike and len([sign for sign in hot if sign]) == 2


def beyond_plain_layers(bimorph: Bimorph, *, any_parts: bool = False) -> str:
    """Key that makes a bimorph more than three fully electroded boxes, or "".

    With `any_parts`, more than any fully electroded parts.
    """
    others, profiles = ["bare_below", "bare_above", "glue_thickness"], [*bimorph.profiles]
    if not any_parts:  # three, as the rod holds them
        others = ["layers", *others, "tip_extension"]
    elif not bimorph.layers:
        profiles = [name for name in profiles if _steps(bimorph, name)]
    found = [*profiles, *(name for name in others if getattr(bimorph, name))]
    return found[0] if found else ""


def _steps(bimorph: Bimorph, name: str) -> bool:
    """Whether a thickness jumps, at whose shoulder a ceramic's electrode would be in doubt."""
    heights = [z for z, _ in bimorph.profiles[name]]
    return name != "width_profile" and len(set(heights)) < len(heights)


def check_boxes(device: Device, *, on_rod: bool) -> None:
    """Refuse a bimorph that the CAD parts do not know.

    Raises InputError in one sentence that names the models that can.
    """
    key = beyond_plain_layers(device.bimorph, any_parts=not on_rod)
    if key in device.bimorph.profiles:
        of = f'bimorph.{key} = "{device.bimorph.profiles[key]}"'
        what = (
            f'{of} with support.kind = "rod"' if on_rod
            else f"{of} with bimorph.layers" if device.bimorph.layers
            else f"{of}, whose thickness has a step,"
        )  # fmt: skip
        raise InputError(
            f"{what} is not in the CAD parts and so not in the model cad; ask for "
            f"models=lumped,tmm,beam, or leave out bimorph.{key}"
        )
    if key:
        also = "" if on_rod or device.bimorph.profiles else ",solid"
        raise InputError(
            f"bimorph.{key} is not in the CAD parts and their tetrahedra (layers with electrodes "
            f"all over) and so not in the model cad; ask for models=lumped,tmm,beam{also}, or "
            f"leave bimorph.{key} out"
        )


def check_bonded(device: Device) -> None:
    """Refuse layers that slide on their glue.

    What is left of the tip's motion is then what the clamped corners leave, some 30 pm per
    volt, which the solid's bricks do not resolve to their own error bar.

    Raises InputError in one sentence that says how stiff the glue must be.
    """
    modulus = device.glue.youngs_modulus
    if "glue" in device.bimorph.own_materials and modulus < _LEAST_GLUE:
        raise InputError(
            f"glue.youngs_modulus = {modulus:.4g} Pa is so soft that the layers slide, and the "
            f"solid model cannot resolve the tip's motion; set at least "
            f"{1e-6 * _LEAST_GLUE:g} MPa, or leave the glue between the layers out"
        )


def check_constant_section(device: Device) -> None:
    """Refuse a bimorph whose layers' sizes change along it.

    Raises InputError in one sentence that names the models that can.
    """
    also = "" if any(layer.pitch for layer in device.bimorph.layers) else ",cad"
    if device.bimorph.profiles:
        key = next(iter(device.bimorph.profiles))
        raise InputError(
            f'bimorph.{key} = "{device.bimorph.profiles[key]}" is not known to the model solid, '
            "whose bricks are of constant size; "
            f"ask for models=lumped,tmm,beam{also} or leave out bimorph.{key}"
        )


def _check_joint(device: Device) -> None:
    """Refuse a tab that does not go into the slot, or a slot that leaves the head."""
    bimorph, rod, glue = device.bimorph, device.rod, device.glue
    mm = 1e3
    slot_diagonal = math.hypot(
        bimorph.width + 2 * glue.thickness, bimorph.shim_thickness + 2 * glue.thickness
    )
    if slot_diagonal >= 2.0 * rod.head_radius:
        raise InputError(
            f"bimorph.width = {bimorph.width * mm:g} mm is wider than the rod allows: with its "
            f"bond line the tab needs a slot of {slot_diagonal * mm:.3g} mm across the head of "
            f"diameter {2 * rod.head_radius * mm:g} mm; make the bimorph narrower"
        )
    if rod.slot_depth >= rod.head_thickness:
        raise InputError(
            f"rod.slot_depth = {rod.slot_depth * mm:g} mm must stay inside the head of thickness "
            f"rod.head_thickness = {rod.head_thickness * mm:g} mm; make the slot shallower"
        )
    if glue.thickness >= rod.slot_depth:
        raise InputError(
            f"glue.thickness = {glue.thickness * mm:g} mm fills the whole slot of depth "
            f"rod.slot_depth = {rod.slot_depth * mm:g} mm; make the bond line thinner"
        )
    if device.ceramic_base < 0.0:
        raise InputError(
            f"bimorph.tab_length = {bimorph.tab_length * mm:g} mm is too short for the rod's slot; "
            f"it must be at least {(rod.slot_depth - glue.thickness) * mm:g} mm"
        )


def check_one_plane(device: Device, purpose: str) -> None:
    """Refuse a rod that rocks in both planes together, and say what does not know it."""
    spring = device.spring
    if spring.tilts_both_planes:
        raise InputError(
            f"spring.eccentricity_angle = {math.degrees(spring.eccentricity_angle):g} deg has no "
            f"{purpose} yet; set 0 deg"
        )


def check_linear_ceramic(piezo: Piezo, purpose: str) -> None:
    """Refuse a ceramic whose constants grow with the field, and say what does not know it."""
    for name in GROWTHS:
        if growth := getattr(piezo, name):
            raise InputError(
                f"piezo.{name} = {1e6 * growth:g} mm/kV has no {purpose} yet; set 0 mm/kV"
            )
