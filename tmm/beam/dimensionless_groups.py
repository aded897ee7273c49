"""Dimensionless groups of a bimorph, by which the difference of solid and theories is known.

Bimorphs of any size whose groups are alike differ alike from them.  The bimorph of
piezo, shim and piezo has a group for each of its ratios; listed layers are described by their
section.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import bimorph_stack
from tactgen.geometry.device.laminate import Laminate
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Beam, Device, Piezo
from tactgen.geometry.device.profile import UNIFORM
from tactgen.tmm.beam.cross_section import section_constants, sheet_of
from tactgen.tmm.beam.laminate import laminate_section, stretching
from tactgen.tmm.beam.layerwise import layerwise_beam
from tactgen.tmm.beam.sections import Section

#: Largest relative change of the coupling that counts: that of ceramics that hardly bend has none.
_MOST_CHANGE = 10.0

COUPLING = "coupling k31^2"
#: Names of the groups in order, for people.
GROUPS = (
    "width/thickness", "ceramic/shim thickness", "shim/ceramic modulus", "end zone/length",
    "Poisson's ratio of the shim", "shear modulus of the shim", COUPLING,
    "shear compliance of the ceramic", "Poisson's ratio of the ceramic", "core shear",
)  # fmt: skip
#: The same of listed layers.
LISTED_GROUPS = (
    "width/thickness", "end zone/length", "shear beside bending", "lever of the ceramics",
    "stiffness towards the faces", "eccentricity",
)  # fmt: skip


def plain(device: Device, *, glue: bool = False) -> Device:
    """Device with the mean layers all along, nothing below or above, electrodes all over.

    It is as wide as its widest layer.

    Glue that is not in the list of layers is left out, unless it is asked for.
    """
    own = device.bimorph
    simple: dict[str, Any] = dict.fromkeys(
        ("tab_length", "tip_extension", "bare_below", "bare_above"), 0.0
    )
    if not glue:
        simple["glue_thickness"] = 0.0
    if any(layer.width for layer in own.layers) and not own.width_profile:
        simple["width"] = max(own.widths)
        each = zip(own.layers, own.widths, strict=True)
        simple["layers"] = Laminate(layer._replace(width=wide) for layer, wide in each)
    for name, profile in own.profiles.items():
        z, size = np.array(profile).T
        mean = float(np.trapezoid(size, z) / z[-1])
        simple |= {name: UNIFORM, name.removesuffix("_profile"): mean}
    return device.model_copy(update={"bimorph": own.model_copy(update=simple)})


def groups(device: Device) -> Floats:
    """Ratios (g,) on which solid and laminate differ; see :func:`group_names`."""
    bimorph, piezo, shim = device.bimorph, device.piezo, device.shim
    if bimorph.layers:
        return _listed_groups(device)
    tp, ts, h, length = (
        bimorph.piezo_thickness, bimorph.shim_thickness, bimorph.thickness, bimorph.length
    )  # fmt: skip
    ceramic = piezo.ceramic()
    return np.array([
        np.log(bimorph.width / h), np.log(tp / ts), np.log(shim.youngs_modulus * piezo.s11),
        np.sqrt((0.5 * bimorph.width + h) / length), shim.poisson_ratio,
        np.log(2.0 * (1.0 + shim.poisson_ratio) * shim.shear_modulus / shim.youngs_modulus),
        piezo.d31**2 / (piezo.s11 * piezo.eps33 * EPS0), piezo.s55 / piezo.s11,
        -ceramic.s[0, 1] / ceramic.s[0, 0], np.log(core_shear(device)),
    ])  # fmt: skip


def group_names(device: Device) -> tuple[str, ...]:
    """Names of the groups in order, for people."""
    return LISTED_GROUPS if device.bimorph.layers else GROUPS


def _listed_groups(device: Device) -> Floats:
    """The same (6,) of listed layers, from their section alone."""
    bimorph, h = device.bimorph, device.bimorph.thickness
    own = laminate(device)
    stretch, offset = stretching(device)
    return np.array([
        np.log(bimorph.width / h), np.sqrt((0.5 * bimorph.width + h) / bimorph.length),
        np.log(own.EI / (own.GA * h**2)), lever(device), np.log(12.0 * own.EI / (stretch * h**2)),
        np.abs(offset) / h,
    ])  # fmt: skip


def lever(device: Device) -> float:
    """Mean lever of the driven ceramics about the neutral axis, over half the thickness."""
    layers = bimorph_stack(device)
    force = sum(
        np.abs(layer.share * layer.hot * of.d31 / of.s11)
        for layer in layers
        if isinstance(of := layer.material, Piezo)
    )
    half = 0.5 * device.bimorph.width * device.bimorph.thickness
    return float(np.abs(laminate(device).K) / (force * half)) if force else 1.0


def clamp_sizes(device: Device) -> Floats:
    """Sizes (2,) of what a clamp does to the bending, which holds the layers' thickness, too.

    Thickness over length, and the same times the relative change of the curvature per voltage, from
    a plate that is held across its width to one that is held through its thickness as well.
    """
    (held, k_held), (full, k_full) = (_held(device, follows) for follows in ([0], []))
    change = 1.0 - k_full / full / (k_held / held) if k_held else 0.0
    share = device.bimorph.thickness / device.bimorph.length
    return np.array([share, share * np.clip(change, -_MOST_CHANGE, _MOST_CHANGE)])


def _held(device: Device, follows: list[int]) -> tuple[float, float]:
    """EI and K per width of layers whose other strains are 0 but those that follow (Voigt)."""
    sums = np.zeros(5)
    for layer in bimorph_stack(device):
        c, e, _ = sheet_of(layer)
        given = np.array([c[2, 2], e[0, 2]])
        if follows:
            freed = np.linalg.solve(c[np.ix_(follows, follows)], c[follows, 2])
            given = given - [c[2, follows] @ freed, e[0, follows] @ freed]
        t, middle = layer.thickness, 0.5 * (layer.low + layer.high)
        stretch, volt = given * layer.share * [t, layer.hot if layer.electrodes else 0.0]
        sums += [
            stretch, stretch * middle, stretch * (middle**2 + t**2 / 12.0), volt, volt * middle,
        ]  # fmt: skip
    axis = sums[1] / sums[0]
    return float(sums[2] - axis * sums[1]), float(sums[4] - axis * sums[3])


def core_shear(device: Device) -> float:
    """E_p t_p (t_s + t_p) / (G_s L²): shear of the core beside bending.

    Of listed layers 2 EI / (GA L²), which is about the same of a soft core between thin ceramics.
    """
    bimorph = device.bimorph
    if bimorph.layers:
        own = laminate(device)
        return float(2.0 * own.EI / (own.GA * bimorph.length**2))
    tp, ts = bimorph.piezo_thickness, bimorph.shim_thickness
    sliding = device.piezo.s11 * device.shim.shear_modulus * bimorph.length**2
    return float(tp * (ts + tp) / sliding)


def root_length(device: Device) -> float:
    """Length (m) of the zone next to the clamp: part of the width, and where a soft core slides."""
    bimorph = device.bimorph
    if bimorph.layers:
        own = laminate(device)
        slides = np.sqrt(own.EI / own.GA)
    else:
        slides = np.sqrt(
            bimorph.piezo_thickness * bimorph.shim_thickness
            / (device.piezo.s11 * device.shim.shear_modulus)
        )  # fmt: skip
    return float(min(0.4 * bimorph.width + bimorph.thickness + slides, 0.5 * bimorph.length))


def laminate(device: Device) -> Section:
    """Section of laminate theory with the shear stiffness of layerwise theory."""
    correction = layerwise_beam(device).shear_correction
    return laminate_section(device, Beam(shear_correction=correction))


def ceramics(device: Device) -> list[Piezo]:
    """Ceramics of a bimorph's layers."""
    layers = bimorph_stack(device)
    return [layer.material for layer in layers if isinstance(layer.material, Piezo)]


def interior(device: Device) -> Section:
    """Section far from the ends, solved over its width, with the shear of layerwise theory."""
    stiffness, coupling, capacitance = section_constants(device)
    return replace(laminate(device), EI=stiffness, K=coupling, C=capacitance)


def free_capacitance(active: Section) -> Any:
    """Capacitance per length (F/m) of a section that bends freely."""
    return active.C + active.K**2 / active.EI
