"""Random devices and scenes: keys with their ranges, sampled by a seeded generator.

Coverage, the random scenes of the stress run, witnesses and tests all sample here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from itertools import cycle
from typing import TypeAlias, TypeVar

import numpy as np

from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.steel_library import STEELS
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.calibrated_section import BROADEST, STOUTEST
from tactgen.tmm.ports.finger_and_pad import FINGER_RANGE

#: Draws after which no device is looked for any more: at most one in two of those sampled here is
#: refused, so it is the model that refuses all.
MOST_DRAWS = 200
#: Values of a key: from, to and unit, even on a logarithmic scale; or choices.
Values: TypeAlias = tuple[float, float, str] | tuple[str, ...]

_Device = TypeVar("_Device")

CERAMICS = ("M1876", "PZT-5H", "PZT-5A")
_STEELS = ("team20", "linear")

#: The normal actuator alone; the dimensions may not fit together.
ACTUATOR: dict[str, Values] = {
    "gap": (20.0, 400.0, "um"),
    "coil.current": (2.0, 300.0, "mA"),
    "coil.turns": ("200", "300", "400", "560", "800", "1100", "1500", "2000"),
    "rod.head_thickness": (0.3, 0.8, "mm"),
    "sleeve.collar_thickness": (0.1, 0.4, "mm"),
    "steel.curve": _STEELS,
}
#: The whole machine with nothing on its tip.
MACHINE: dict[str, Values] = ACTUATOR | {
    "gap": (80.0, 300.0, "um"),
    "coil.history": ("rising", "falling"),
    "spring.preload": (30.0, 300.0, "mN"),
    "load.kind": ("none",),
}

#: Scenes from foil to block: sizes, of which all are sampled, and keys, of which some are.
SIZES: dict[str, Values] = {
    "bimorph.length": (2.0, 80.0, "mm"),
    "bimorph.piezo_thickness": (0.01, 1.0, "mm"),
    "bimorph.shim_thickness": (0.01, 1.0, "mm"),
}
_BIMORPH: dict[str, Values] = {
    "bimorph.width": (0.2, 10.0, "mm"),
    "bimorph.tab_length": (0.05, 5.0, "mm"),
    "bimorph.bare_below": (0.01, 2.0, "mm"),
    "bimorph.bare_above": (0.01, 2.0, "mm"),
    "bimorph.glue_thickness": (1e-3, 0.1, "mm"),
    "bimorph.wiring": ("parallel", "series"),
    "piezo.material": CERAMICS,
    "piezo.quality_factor": (5.0, 1e3, ""),
    "shim.material": ("brass", "titanium"),
    "load.kind": ("none", "mass", "spring_damper", "finger"),
    "load.mass": (1e-2, 1e4, "mg"),
    "load.stiffness": (1e-1, 1e6, "N/m"),
    "load.damping": (1e-5, 1e1, "N*s/m"),
    "drive.voltage": (1e-3, 50.0, "V"),
    "modes": ("1", "3", "6"),
}
_SUPPORT: dict[str, Values] = {
    "support.kind": ("clamped", "spring"),
    "support.rotational_stiffness": (1e-3, 1e3, "N*m/rad"),
    "support.rotational_damping": (1e-9, 1e-3, "N*m*s/rad"),
}
_ROD: dict[str, Values] = {
    "coil.current": (1e-3, 1e3, "mA"),
    "coil.history": ("rising", "falling"),
    "coil.supply": ("current", "voltage"),
    "coil.source_resistance": (1e-3, 1e6, "ohm"),
    "coil.turns": ("10", "200", "560", "2000"),
    "gap": (60.0, 600.0, "um"),
    "spring.preload": (1e-3, 1e3, "mN"),
    "spring.stiffness": (1.0, 1e6, "N/m"),
    "spring.eccentricity": (1e-3, 1.0, "mm"),
    "spring.stop_gap": (1.0, 100.0, "um"),
    "contact.shape": ("ring", "disc"),
    "contact.decay_length": (1e-3, 100.0, "um"),
    "contact.relaxation_time": (1e-3, 1e3, "us"),
    "contact.lower_decay_ratio": (1e-2, 1e2, ""),
    "contact.tangential_ratio": (1e-1, 1.0, ""),
    "contact.friction": (1e-3, 1.0, ""),
    "guide.axial_damping": (1e-6, 1e2, "N*s/m"),
    "guide.lateral_stiffness": (1.0, 1e9, "N/m"),
    "guide.rotational_stiffness": (1e-6, 1e3, "N*m/rad"),
    "guide.clearance": (1e-3, 1e2, "um"),
    "load.normal_force": (1e-3, 1e3, "mN"),
    "steel.curve": _STEELS,
    "rod.head_thickness": (0.1, 2.0, "mm"),
    "sleeve.collar_thickness": (0.05, 2.0, "mm"),
}
#: Frequencies (Hz) of a scene; share of those that a finger presses which stay within its law.
_FREQUENCIES, _WITHIN = (1.0, 2e4), 0.9
#: Most keys of a scene beside its sizes; share of machines.
_MOST_KEYS, _MACHINES = 6, 0.3


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """Number even on a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def sample(rng: np.random.Generator, values: Values) -> str:
    """One value of a key as a scene has it."""
    low, high, unit = (*values, "", "")[:3]
    if isinstance(low, str):
        return str(rng.choice(values))
    assert isinstance(high, float), values
    return f"{between(rng, low, high):.5g} {unit}".strip()


def overrides(rng: np.random.Generator, keys: Mapping[str, Values]) -> list[str]:
    """One value of each key, as for ``--set``."""
    return [f"{key}={sample(rng, values)}" for key, values in keys.items()]


def three_frequencies(rng: np.random.Generator) -> str:
    """Override of three frequencies from 10 Hz to 3 kHz."""
    frequencies = sorted(between(rng, 10.0, 3000.0) for _ in range(3))
    return "frequency=" + ",".join(f"{f:.5g} Hz" for f in frequencies)


def accepted(attempt: Callable[[], _Device]) -> _Device:
    """First accepted sample of `attempt`.

    Raises InputError if so many are refused that it must be the model's fault.
    """
    refusals = []
    for _ in range(MOST_DRAWS):
        try:
            return attempt()
        except InputError as refusal:
            refusals.append(refusal)
    raise InputError(
        f"all {MOST_DRAWS} random devices were refused; judge another part with --only until the "
        f"model is mended, which says of the last: {refusals[-1]}"
    )


def slender_bimorph(
    rng: np.random.Generator, *, length: float | None = None, layer: float | None = None
) -> list[str]:
    """Overrides of a random bimorph for beam models, by default 5 to 60 mm long."""
    layer = between(rng, 0.05, 0.5) if layer is None else layer
    length = between(rng, 15.0, 120.0) * 3.0 * layer if length is None else length
    frequencies = three_frequencies(rng)
    return [
        f"bimorph.length={length:.6g}mm",
        f"bimorph.width={between(rng, 0.5, 5.0):.4g}mm",
        f"bimorph.piezo_thickness={layer:.4g}mm",
        f"bimorph.shim_thickness={layer * between(rng, 0.3, 2.0):.4g}mm",
        f"piezo.material={rng.choice(CERAMICS)}",
        f"support.kind={rng.choice(['clamped', 'spring'])}",
        frequencies,
    ]


def bimorph_on_rod(rng: np.random.Generator) -> list[str]:
    """Overrides of a random bimorph that is glued into its rod, its tip free."""
    sampled = [one for one in slender_bimorph(rng) if not one.startswith("support.")]
    return [
        *sampled, "load.kind=none",  # the finger's model ends at 1000 Hz
        f"bimorph.tab_length={between(rng, 0.5, 5.0):.4g}mm",
        f"glue.thickness={between(rng, 0.5, 60.0):.4g}um",
    ]  # fmt: skip


def tapered_bimorph(rng: np.random.Generator) -> list[str]:
    """Overrides of a random bimorph whose width has a corner."""
    length = rng.uniform(8.0, 40.0)
    width, share = rng.uniform(0.5, 3.0), rng.uniform(0.1, 0.9)
    step, layer = rng.uniform(0.2, 0.8) * length, rng.uniform(0.1, 0.4)
    points = ((0.0, width), (step, width), (length, share * width))
    profile = ", ".join(f"{z:.6g} mm: {w:.4g} mm" for z, w in points)
    sampled = slender_bimorph(rng, length=length, layer=layer)
    return [*sampled, f"bimorph.width_profile={profile}"]


def solid_bimorph(rng: np.random.Generator) -> list[str] | None:
    """Overrides of a bimorph of all that could be built, and more, for solid models.

    Lengths 3 to 60 mm, widths 0.3 to 10 mm, layers 20 µm to 1 mm; three ceramics, two shims;
    tabs, bare ends, glue, longer shims; masses and springs at the tip; springs and clamps at the
    base.  None if it is too stout, too slender or too wide to be a bimorph.
    """
    limits = ((0.02, 1.0), (0.02, 1.0), (3.0, 60.0), (0.3, 10.0))
    piezo, shim, length, width = (between(rng, *of) for of in limits)
    chance = rng.random(7)
    tab, below, above = rng.uniform(0.5, 3.0), rng.uniform(0.05, 0.15), rng.uniform(0.02, 0.1)
    glue = min(between(rng, 0.005, 0.05), 0.3 * min(piezo, shim))
    mass, stiffness = between(rng, 0.1, 100.0), between(rng, 10.0, 1e4)
    material = rng.choice(CERAMICS)
    thickness = 2.0 * piezo + shim
    if not 4.0 * thickness <= length <= 120.0 * thickness or width > 40.0 * thickness:
        return None
    options = {
        f"bimorph.tab_length={tab:.3g}mm": chance[0] < 0.3,
        f"bimorph.bare_below={below * length:.3g}mm": chance[1] < 0.2,
        f"bimorph.bare_above={above * length:.3g}mm": chance[2] < 0.2,
        f"bimorph.glue_thickness={glue:.3g}mm": chance[3] < 0.25,
        # the springs were fitted to a bimorph of 2.1 mm
        "support.kind=clamped": chance[4] < 0.5 or width > 2.0,
        "shim.shear_modulus=53.846GPa": chance[5] < 0.4,
        "load.kind=mass": chance[6] < 0.2,
        f"load.mass={mass:.3g}mg": chance[6] < 0.2,
        "load.kind=spring_damper": 0.2 <= chance[6] < 0.4,
        f"load.stiffness={stiffness:.3g}N/m": 0.2 <= chance[6] < 0.4,
        f"bimorph.tip_extension={rng.uniform(0.05, 0.5) * length:.3g}mm": rng.random() < 0.2,
    }
    return [
        f"bimorph.length={length:.4g}mm", f"bimorph.width={width:.4g}mm",
        f"bimorph.piezo_thickness={piezo:.4g}mm", f"bimorph.shim_thickness={shim:.4g}mm",
        f"piezo.material={material}", *(key for key, wanted in options.items() if wanted),
    ]  # fmt: skip


#: Ratios of a clamped bimorph: length to thickness, width to thickness, shim to ceramic thickness;
#: modulus of a stiff shim and of a soft one (GPa); share of stiff and of isotropic ones.
_SLENDER, _WIDE, _THICK = (STOUTEST, 100.0), (0.4, 40.0), (0.12, 6.0)
_STIFF, _SOFT, _MOSTLY_STIFF, _ISOTROPIC = (2.0, 400.0), (0.02, 2.0), 0.8, 0.6


#: Length (mm), and what else all have.
_LENGTH, _CLAMPED = 20.0, ("support.kind=clamped", "load.kind=none", "modes=3")
#: Listed layers without their thickness, and thicknesses by kind beside each other; share of the
#: ceramics that are the scene's own.
_LAMINATES = (
    "shim; piezo +x", "shim; glue; piezo +x", "piezo +x; shim; piezo +x",
    "piezo +x; glue; shim; glue; piezo +x", "piezo +x; piezo +x", "piezo +x bare; piezo +x",
    "piezo +x shorted; shim; piezo +x", "piezo +x bare; shim; piezo +x",
    "piezo +x; piezo -x hot +x; shim; piezo -x hot -x; piezo +x",
    "shim; piezo +x hot +x; piezo -x hot -x", "shim; glue; piezo +x; glue; shim",
)  # fmt: skip
_SIZES = {"shim": (0.2, 3.0), "glue": (0.01, 0.1), "piezo": (0.3, 1.5)}
_OWN_CERAMIC = 0.7


#: Ceramics with tensors of their own.
_CERAMICS = (
    "M1876", "PZT-5H", "PZT-5A", "PZT-4", "PZT-8", "PIC255", "Pz26", "Pz27", "Pz29",
)  # fmt: skip


def clamped_bimorph(rng: np.random.Generator) -> list[str]:
    """Overrides of a bimorph 20 mm long, of any ratios, on any core, clamped and free of load.

    Not wider than 1.5 lengths.  d31 and s55 vary about those of the library's ceramics.
    """
    thickness, wide = _proportions(rng)
    ratio = between(rng, *_THICK)
    piezo = thickness / (2.0 + ratio)
    young = between(rng, *(_STIFF if rng.random() < _MOSTLY_STIFF else _SOFT))
    return [
        f"bimorph.length={_LENGTH}mm", f"bimorph.width={wide * thickness:.6g}mm",
        f"bimorph.piezo_thickness={piezo:.6g}mm", f"bimorph.shim_thickness={ratio * piezo:.6g}mm",
        *_materials(rng, young), *_CLAMPED,
    ]  # fmt: skip


def clamped_laminate(rng: np.random.Generator) -> list[str]:
    """The same of listed layers, of which elastic ones have 2 to 400 GPa and glue 1 to 10 GPa."""
    thickness, wide = _proportions(rng)
    layers = [layer.split(maxsplit=1) for layer in str(rng.choice(_LAMINATES)).split("; ")]
    sizes = np.array([between(rng, *_SIZES[kind]) for kind, *_ in layers])
    sizes *= thickness / sizes.sum()
    others = [str(rng.choice(_CERAMICS)) for _ in layers]
    own = rng.random(len(layers)) < _OWN_CERAMIC
    listed = []
    for (kind, *rest), size, other, of_scene in zip(layers, sizes, others, own, strict=True):
        name = other if kind == "piezo" and not of_scene else kind
        listed.append(" ".join([name, f"{size:.6g} mm", *rest]))
    return [
        f"bimorph.length={_LENGTH}mm", f"bimorph.width={wide * thickness:.6g}mm",
        f"bimorph.layers={'; '.join(listed)}",
        f"glue.youngs_modulus={between(rng, 1.0, 10.0):.5g}GPa",
        *_materials(rng, between(rng, *_STIFF)), *_CLAMPED,
    ]  # fmt: skip


def _proportions(rng: np.random.Generator) -> tuple[float, float]:
    """Thickness (mm), and width over thickness."""
    while True:
        slender, wide = between(rng, *_SLENDER), between(rng, *_WIDE)
        if wide <= BROADEST * slender:
            return _LENGTH / slender, wide


def _materials(rng: np.random.Generator, young: float) -> list[str]:
    """Overrides of ceramic and shim, whose modulus is given (GPa)."""
    poisson = rng.uniform(0.15, 0.45)
    shear = young / (2.0 * (1.0 + poisson))
    if rng.random() >= _ISOTROPIC:
        shear *= between(rng, 0.05, 1.0)
    material = str(rng.choice(_CERAMICS))
    own, density = LIBRARY[material].reduced(), rng.uniform(1500.0, 9000.0)
    return [
        f"piezo.material={material}", f"piezo.d31={own['d31'] * rng.uniform(0.3, 1.2):.6g}m/V",
        f"piezo.s55={own['s55'] * rng.uniform(0.8, 1.2):.6g}m^2/N",
        f"shim.youngs_modulus={young:.6g}GPa", f"shim.poisson_ratio={poisson:.4g}",
        f"shim.shear_modulus={shear:.6g}GPa", f"shim.density={density:.5g}kg/m^3",
    ]  # fmt: skip


#: Ratios beyond those of :func:`clamped_bimorph`.
_STOUT, _THIN_SHIM = (2.0, STOUTEST), (0.03, 0.12)
#: Pitch of interdigitated electrodes over the thickness of the layer.
_PITCHES = (1.5, 6.0)


#: Widths of layers over that of the bimorph.
_WIDTHS = (0.2, 1.3)
#: Lengths of tabs and tip extensions over that of the ceramic.
_SHORTEST, _LONGEST = 0.02, 1.5


def unusual_bimorph(rng: np.random.Generator, overrides: Sequence[str], what: str) -> list[str]:
    """The same clamped bimorph with one property more, or beyond the usual ratios."""
    value = dict(one.split("=", 1) for one in overrides)
    length, width, piezo, shim = (
        float(value.get(f"bimorph.{name}", "0 mm").removesuffix("mm"))
        for name in ("length", "width", "piezo_thickness", "shim_thickness")
    )
    listed = value.get("bimorph.layers", "")
    part = rng.random()
    beside = f"{length * _SHORTEST * (_LONGEST / _SHORTEST) ** part:.5g}mm"
    if what == "tab":
        value["bimorph.tab_length"] = beside
    elif what == "tip extension":
        value["bimorph.tip_extension"] = beside
    elif what == "patch":
        value["bimorph.layers"] = _patched(rng, listed, length)
    elif what == "own widths":
        value["bimorph.layers"] = re.sub(
            r" mm", lambda size: f"{size[0]} wide {width * between(rng, *_WIDTHS):.5g} mm", listed
        )
    elif what == "glue":
        glue = min(piezo, shim) * between(rng, 0.03, 0.3)
        value["bimorph.glue_thickness"] = f"{max(glue, 1e-3):.5g}mm"
    elif what == "bare ends":
        bare = length * (0.02 + 0.13 * part)
        value[f"bimorph.bare_{rng.choice(['below', 'above'])}"] = f"{bare:.5g}mm"
    elif what == "poled along":
        signs = cycle("+-")  # as what is poled alike does not bend
        value["bimorph.layers"] = re.sub(
            r"(\S+) mm [+-]x(?: hot [+-]x| bare)?",
            lambda ceramic: (
                f"{ceramic[1]} mm {next(signs)}z pitch "
                f"{float(ceramic[1]) * between(rng, *_PITCHES):.5g} mm"
            ),
            listed,
        )
    elif not listed and rng.random() < 0.5:
        value["bimorph.shim_thickness"] = f"{piezo * between(rng, *_THIN_SHIM):.5g}mm"
    else:
        layers = sum(float(size) for size in re.findall(r"(\S+) mm", listed))
        shorter = (layers or 2.0 * piezo + shim) * between(rng, *_STOUT)
        value["bimorph.length"] = f"{shorter:.5g}mm"
        value["bimorph.width"] = f"{min(width, BROADEST * shorter):.5g}mm"
    return [f"{key}={text}" for key, text in value.items()]


def _patched(rng: np.random.Generator, listed: str, length: float) -> str:
    """Layers of which all but the first elastic one, or the lowest, cover a part of a length (mm).

    Half of them begin at the clamp.
    """
    layers = listed.split("; ")
    core = next((n for n, layer in enumerate(layers) if layer.startswith("shim")), 0)
    start = length * max(rng.uniform(-0.3, 0.3), 0.0)
    place = f"from {start:.5g} mm to {length * rng.uniform(0.4, 1.0):.5g} mm"
    return "; ".join(
        layer if n == core else re.sub(r" mm", f" mm {place}", layer, count=1)
        for n, layer in enumerate(layers)
    )


def sprung(rng: np.random.Generator, overrides: Sequence[str], stiffness: float) -> list[str]:
    """The same bimorph on springs of about its own rotational stiffness (N m/rad)."""
    rotational = stiffness * between(rng, 0.5, 8.0)
    return [
        *(one for one in overrides if not one.startswith("support.")), "support.kind=spring",
        f"support.rotational_stiffness={rotational:.6g}N*m/rad",
        f"support.lateral_stiffness={rotational / 4e-6:.6g}N/m",
    ]  # fmt: skip


def any_actuator(rng: np.random.Generator, wider: float = 1.0) -> list[str]:
    """Overrides of an actuator of any ratios about a head of 1.15 mm, at one current and gap.

    Gaps of 0.5 to 35 % of the head's radius, and 0.3 to 500 ampere turns, which saturate the steel
    up to some 100 kA/m; two in five with a collar above the coil, half with head and sleeve flush;
    all built-in steels, and permeabilities from 10 on.  `wider` is a factor on both ends of the
    ranges of lengths along the axis, gaps, ampere turns and permeabilities; the least permeability
    has its third power.
    """

    def within(low: float, high: float) -> float:
        return between(rng, low / wider, high * wider)

    head, turns = 1.15, 500
    shaft = head * rng.uniform(0.4, 0.7)
    outer = head * (1.0 if rng.random() < 0.5 else rng.uniform(0.92, 1.12))
    inner = min(shaft + head * rng.uniform(0.15, 0.35), outer - 0.08 * head)
    coil, thickness = head * within(0.7, 4.0), head * within(1.0, 4.0)
    plate, collar = head * within(0.2, 0.6), head * within(0.1, 0.4)
    overhangs = rng.random() < 0.4
    bore = inner - (inner - shaft) * rng.uniform(0.1, 0.6) * overhangs
    top = collar + 0.05 if overhangs else 0.05
    flange = top + coil + 0.05
    gap = within(0.006, 0.4)
    current = within(0.3, 500.0) / turns
    if rng.random() < 0.25:
        permeability = within(10.0 / wider**2, 1e4)
        steel = ["steel.curve=linear", f"steel.relative_permeability={permeability:.4g}"]
    else:
        steel = [f"steel.curve={rng.choice([one for one in STEELS if one != 'linear'])}"]
    sizes = {
        "rod.head_radius": head, "rod.radius": shaft, "rod.head_thickness": plate,
        "rod.slot_depth": 0.9 * plate, "rod.flange_position": flange,
        "rod.flange_thickness": thickness, "rod.length": flange + thickness,
        "rod.flange_radius": inner - within(0.02, 0.1) * head,
        "sleeve.outer_radius": outer, "sleeve.inner_radius": inner, "sleeve.collar_radius": bore,
        "sleeve.collar_thickness": collar, "coil.inner_radius": shaft, "coil.length": coil,
        "coil.outer_radius": inner - 0.04 * head, "coil.position": top, "gap": gap,
        "sleeve.length": (flange + thickness) * within(1.02, 5.0),
    }  # fmt: skip
    lengths = [f"{key}={size:.6g}mm" for key, size in sizes.items()]
    return [*lengths, f"coil.turns={turns}", f"coil.current={current:.5g}A", *steel]


def machine(rng: np.random.Generator) -> list[str]:
    """Overrides of a random machine; its dimensions may not fit together."""
    return [*overrides(rng, MACHINE), three_frequencies(rng)]


def any_scene(rng: np.random.Generator) -> tuple[str, list[str]]:
    """Scene's name and random overrides: a bimorph on springs, or the whole machine."""
    whole = rng.random() < _MACHINES
    keys = _BIMORPH | (_ROD if whole else _SUPPORT)
    some = rng.choice(sorted(keys), size=int(rng.integers(_MOST_KEYS + 1)), replace=False)
    values = {} if whole and rng.random() < 0.5 else {k: sample(rng, v) for k, v in SIZES.items()}
    values |= {str(key): sample(rng, keys[str(key)]) for key in some}
    pressed = values.get("load.kind", "finger" if whole else "none") == "finger"
    band = FINGER_RANGE if pressed and rng.random() < _WITHIN else _FREQUENCIES
    count = int(rng.integers(1, 4))
    values["frequency"] = ", ".join(f"{between(rng, *band):.5g} Hz" for _ in range(count))
    return "generator" if whole else "prototype", [f"{k}={v}" for k, v in values.items()]
