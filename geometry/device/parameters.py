"""Every parameter of the device and of its operating conditions, with its source.

Frozen pydantic models in SI units.  The defaults are the paper's lateral actuator
(20 mm long) on the reconstructed normal actuator.  ``Field(description=...)`` says
what a number means, :func:`sources` where it comes from.  Nothing is computed here
but what the geometry itself implies.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tactgen.geometry import units as u
from tactgen.geometry.device.materials import PRINTED, Piezoceramic, Spread
from tactgen.geometry.device.piezo_library import LIBRARY
from tactgen.geometry.device.profile import UNIFORM, LengthProfile, Profile
from tactgen.geometry.errors import InputError

#: Gap at which the reconstructed normal actuator's axial positions are stated (m).
NOMINAL_GAP = 0.2e-3

_PAPER_2 = "paper table 2"
_PAPER_4 = "paper section 4"
_PAPER_5 = "paper section 5.1"
_RECONSTRUCTED = "assumed: reconstructed normal actuator (the paper gives only 2.3 mm and the gap)"


def _field(
    default: Any,
    source: str,
    description: str,
    spread: tuple[float, float, str] | Spread | None = None,
) -> Any:
    """Declare a parameter; `spread` is (low, high, reason), a tenth for a reconstructed size."""
    if spread is None and source == _RECONSTRUCTED:
        spread = (0.9 * default, 1.1 * default, "assumed: a reconstruction, a tenth either way")
    extra: dict[str, Any] = {"source": source, "spread": list(spread) if spread else None}
    return Field(default, description=description, json_schema_extra=extra)


def _printed(default: float, source: str, description: str, half_a_unit: float) -> Any:
    """Declare a parameter that is known to the digits printed, trailing zeros not counted."""
    spread = Spread(default - half_a_unit, default + half_a_unit, PRINTED, absolute=True)
    return _field(default, source, description, spread)


class Parameters(BaseModel):
    """Base of all parameter groups: immutable, no unknown keys, finite numbers only."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Bimorph(Parameters):
    """The lateral actuator: piezo / shim / piezo, the shim's tab below the ceramic."""

    length: u.Length = _field(
        20e-3,
        _PAPER_4,
        "active (ceramic) length",
        Spread(19.9e-3, 20.1e-3, "chosen by design; assumed: cut to 0.1 mm", absolute=True),
    )
    width: u.SmallLength = _printed(2.1e-3, _PAPER_2, "width b", 0.05e-3)
    piezo_thickness: u.SmallLength = _printed(
        0.26e-3, _PAPER_2, "thickness of one piezo layer h_p", 0.005e-3
    )
    shim_thickness: u.SmallLength = _printed(
        0.25e-3, _PAPER_2, "thickness of the shim h_s", 0.005e-3
    )
    tab_length: u.LengthOrZero = _field(
        0.0, "assumed: no bare shim below the ceramic", "length of the bare shim below the ceramic"
    )
    width_profile: LengthProfile = _field(
        UNIFORM,
        "assumed: uniform",
        "width along the ceramic: uniform, or such as 0 mm: 2.1 mm, 20 mm: 1 mm; then width is "
        "that of the tab",
    )
    piezo_thickness_profile: LengthProfile = _field(
        UNIFORM, "assumed: uniform", "thickness of one piezo layer along the ceramic"
    )
    shim_thickness_profile: LengthProfile = _field(
        UNIFORM,
        "assumed: uniform",
        "thickness of the shim along the ceramic; then shim_thickness is that of the tab",
    )
    bare_below: u.LengthOrZero = _field(
        0.0, "assumed: electrodes on the whole ceramic", "ceramic without electrode, lower end"
    )
    bare_above: u.LengthOrZero = _field(
        0.0, "assumed: electrodes on the whole ceramic", "ceramic without electrode, upper end"
    )
    glue_thickness: u.LayerThickness = _field(
        0.0, "assumed: no glue between the layers", "glue between the shim and each piezo layer"
    )
    wiring: Literal["parallel", "series"] = _field(
        "parallel",
        "assumed: the paper does not say (its 50 V start near the parallel model's value)",
        "parallel: the voltage lies across each layer; series: across both in a row",
    )
    poling: Literal["-x", "+x"] = _field(
        "-x",
        "assumed: gives the signs of the paper's matrix A (positive U bends towards +x)",
        "direction in which both layers are poled; U is outer electrodes minus shim",
    )

    @property
    def thickness(self) -> float:
        """Total thickness (m)."""
        return float(2.0 * (self.piezo_thickness + self.glue_thickness) + self.shim_thickness)

    @property
    def profiles(self) -> dict[str, Profile]:
        """The dimensions that vary along the ceramic, by their key."""
        names = ("width_profile", "piezo_thickness_profile", "shim_thickness_profile")
        return {name: getattr(self, name) for name in names if getattr(self, name)}

    @property
    def poling_sign(self) -> float:
        """+1 for poling along +x, −1 along −x."""
        return 1.0 if self.poling == "+x" else -1.0


class Piezo(Parameters):
    """The piezoceramic: a library material, any of whose values may be replaced."""

    material: str = _field("M1876", _PAPER_2, "name of a library material")
    s11: u.Compliance = _field(None, "", "elastic compliance s11 at constant field")
    s55: u.Compliance = _field(None, "", "shear compliance s55 at constant field")
    d31: u.PiezoConstant = _field(None, "", "transverse piezoelectric constant")
    eps33: u.RelativePermittivity = _field(None, "", "relative permittivity at constant stress")
    density: u.Density = _field(None, "", "mass density")
    quality_factor: u.QualityFactor = _field(None, "", "mechanical quality factor Q")
    loss_tangent: u.LossTangent = _field(None, "", "dielectric loss tangent")

    @model_validator(mode="before")
    @classmethod
    def _fill_from_library(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        name = given.get("material", "M1876")
        if not isinstance(name, str) or name not in LIBRARY:
            raise InputError(
                f"piezo.material = {u.quoted(name)} is not in the library; "
                f"use one of {', '.join(LIBRARY)} and replace single values, such as piezo.s11"
            )
        library = {key: u.SI(value) for key, value in LIBRARY[name].reduced().items()}
        return {**library, **given, "material": name}

    def ceramic(self) -> Piezoceramic:
        """Return the full material that these values stand for."""
        values = self.model_dump(exclude={"material"})
        return LIBRARY[self.material].with_values(**values)


class Shim(Parameters):
    """The middle layer: elastic, electrically conducting, fibres along z."""

    youngs_modulus: u.Modulus = _printed(140e9, _PAPER_2, "modulus along the actuator E_s", 5e9)
    shear_modulus: u.Modulus = _field(
        5e9,
        "assumed: unidirectional carbon fibre composite",
        "longitudinal shear modulus G_s",
        (4e9, 6e9, "such composites with usual fibre contents"),
    )
    transverse_modulus: u.Modulus | None = _field(
        None,
        "assumed: 2 (1 + nu) G_s, exact for an isotropic shim",
        "modulus across the fibres (solid model only)",
    )
    poisson_ratio: u.PoissonRatio = _field(
        0.3,
        "assumed: typical of the composite",
        "Poisson ratio (solid model only)",
        (0.25, 0.35, "such composites"),
    )
    density: u.Density = _printed(1500.0, _PAPER_2, "mass density", 50.0)


class Glue(Parameters):
    """The adhesive between the shim's tab and the slot in the rod's head, and between layers."""

    thickness: u.SmallLength = _field(
        50e-6,
        "assumed: typical bond line",
        "bond line around the tab",
        (30e-6, 80e-6, "bond lines of paste epoxies"),
    )
    youngs_modulus: u.Modulus = _field(
        3e9, "assumed: epoxy", "modulus", (2e9, 5e9, "unfilled to filled epoxies")
    )
    poisson_ratio: u.PoissonRatio = _field(
        0.35, "assumed: epoxy", "Poisson ratio", (0.3, 0.4, "epoxies")
    )
    density: u.Density = _field(
        1200.0, "assumed: epoxy", "mass density", (1100.0, 1400.0, "unfilled to filled epoxies")
    )


class Rod(Parameters):
    """The moving iron: shaft, head (the pole above the gap), flange, slot for the tab."""

    radius: u.SmallLength = _field(0.62e-3, _RECONSTRUCTED, "shaft radius")
    head_radius: u.SmallLength = _printed(
        1.15e-3, _PAPER_5, "head radius (outer diameter 2.3 mm)", 0.025e-3
    )
    head_thickness: u.SmallLength = _field(0.5e-3, _RECONSTRUCTED, "head thickness")
    flange_radius: u.SmallLength = _field(0.91e-3, _RECONSTRUCTED, "flange radius")
    flange_thickness: u.SmallLength = _field(0.9e-3, _RECONSTRUCTED, "flange thickness")
    flange_position: u.Position = _field(
        2.4e-3, _RECONSTRUCTED, "flange's top below the sleeve's top at the 200 um gap"
    )
    length: u.SmallLength = _field(
        3.3e-3, _RECONSTRUCTED, "shaft's end below the sleeve's top at the 200 um gap"
    )
    slot_depth: u.SmallLength = _field(
        0.45e-3,
        "assumed: slot stays inside the head",
        "depth of the slot that takes the tab",
        (0.4e-3, 0.49e-3, "at least a bond, at most the head's thickness"),
    )
    youngs_modulus: u.Modulus = _field(
        205e9, "assumed: low-carbon steel", "modulus", (200e9, 212e9, "steels")
    )
    poisson_ratio: u.PoissonRatio = _field(
        0.29, "assumed: low-carbon steel", "Poisson ratio", (0.27, 0.3, "steels")
    )
    density: u.Density = _field(
        7850.0, "assumed: low-carbon steel", "mass density", (7800.0, 7900.0, "low-carbon steels")
    )


class Coil(Parameters):
    """The winding on the rod's shaft."""

    inner_radius: u.SmallLength = _field(0.62e-3, _RECONSTRUCTED, "inner radius")
    outer_radius: u.SmallLength = _field(0.88e-3, _RECONSTRUCTED, "outer radius")
    length: u.SmallLength = _field(2.0e-3, _RECONSTRUCTED, "axial length")
    position: u.Position = _field(
        0.3e-3, _RECONSTRUCTED, "coil's top below the sleeve's top at the 200 um gap"
    )
    turns: u.Turns = _field(
        849.0,
        "assumed: gives the paper's 110 mN (section 5.1) at its 130 mA",
        "number of turns",
        (764.0, 934.0, "assumed: a reconstruction, a tenth either way"),
    )
    current: u.Current = _field(130e-3, _PAPER_5, "direct current in the winding")
    fill_factor: u.FillFactor = _field(
        0.5,
        "assumed: fine enamelled wire",
        "bare copper's share of the winding's window",
        (0.35, 0.65, "assumed: thin wires, wound wild to in layers"),
    )
    resistivity: u.Resistivity = _field(
        1.7241e-8,
        "assumed: annealed copper at 20 degC (IEC 60028)",
        "the wire's resistivity at 20 degC",
        (1.7241e-8, 1.777e-8, "annealed to hard-drawn copper, 97 % of its conductivity"),
    )
    temperature: u.Temperature = _field(
        293.15,
        "assumed: 20 degC, a cold coil",
        "the wire's temperature",
        (293.15, 393.15, "assumed: from cold to the limit of common enamel"),
    )


class Sleeve(Parameters):
    """The fixed iron around the coil, its collar at the upper end."""

    inner_radius: u.SmallLength = _field(0.96e-3, _RECONSTRUCTED, "bore radius")
    outer_radius: u.SmallLength = _printed(
        1.15e-3, _PAPER_5, "outer radius (outer diameter 2.3 mm)", 0.025e-3
    )
    length: u.SmallLength = _field(3.6e-3, _RECONSTRUCTED, "axial length")
    collar_radius: u.SmallLength = _field(0.9e-3, _RECONSTRUCTED, "bore radius of the collar")
    collar_thickness: u.SmallLength = _field(0.2e-3, _RECONSTRUCTED, "axial length of the collar")


class Spring(Parameters):
    """The return spring below the rod, and the two stops between which the rod moves.

    The upper stop leaves the working gap `gap`, the lower one `stop_gap`.
    """

    preload: u.Force = _field(
        110e-3,
        "assumed: the paper's 110 mN on the finger (section 5.1), without current",
        "spring force at the upper stop",
        (99e-3, 121e-3, "assumed: set by grub screws, a tenth either way"),
    )
    stiffness: u.LateralStiffness = _field(
        100.0,
        "assumed: reconstructed; soft beside the magnetic pull, so that the rod snaps",
        "stiffness",
        (20.0, 500.0, "assumed: the force over the stroke grows by 3 to 80 percent"),
    )
    stop_gap: u.SmallLength = _field(
        20e-6,
        "assumed: reconstructed; coating and burrs keep the head off the sleeve",
        "gap left at the lower stop",
        (5e-6, 50e-6, "assumed: from a coating to a foil"),
    )


class Steel(Parameters):
    """The magnetic behaviour of rod and sleeve, one material."""

    curve: str = _field(
        "team20",
        "assumed: steel of TEAM Workshop problem 20",
        "team20, linear, or the path of a CSV file with the columns B (T) and H (A/m)",
    )
    relative_permeability: u.RelativePermeability = _field(
        1000.0,
        "assumed: typical of low-carbon steel",
        "used by the curve linear",
        (500.0, 2000.0, "low-carbon steels, by annealing and field"),
    )


class Device(Parameters):
    """One tactile generator: what is built, and of what."""

    bimorph: Bimorph = Bimorph()
    piezo: Piezo = Piezo()
    shim: Shim = Shim()
    glue: Glue = Glue()
    rod: Rod = Rod()
    coil: Coil = Coil()
    sleeve: Sleeve = Sleeve()
    spring: Spring = Spring()
    steel: Steel = Steel()
    gap: u.SmallLength = _field(0.2e-3, _PAPER_5, "working air gap")

    @property
    def ceramic_base(self) -> float:
        """Height z of the ceramic's lower edge when the bimorph stands in the rod (m).

        z = 0 is the rod's top face; the tab reaches to one bond line above the slot's floor.
        """
        return float(self.bimorph.tab_length - (self.rod.slot_depth - self.glue.thickness))


class Support(Parameters):
    """What holds the lower end of the lateral actuator (paper eqs 6-8)."""

    kind: Literal["spring", "clamped", "rod"] = _field(
        "spring", _PAPER_4, "the paper's springs, a rigid clamp, or the glued joint in the real rod"
    )
    rotational_stiffness: u.RotationalStiffness = _printed(0.24, _PAPER_4, "c_s", 0.005)
    lateral_stiffness: u.LateralStiffness = _printed(
        3e6, f"{_PAPER_4} (printed with the unit Nm, meant N/m)", "c_sl", 0.5e6
    )
    rotational_damping: u.RotationalDamping = _printed(4.46e-6, _PAPER_4, "d_s", 0.005e-6)
    rotational_inertia: u.RotationalInertia = _printed(1e-12, _PAPER_4, "theta", 0.5e-12)


class Load(Parameters):
    """What the tip pushes against."""

    kind: Literal["none", "finger", "mass", "spring_damper"] = _field(
        "finger", "paper section 3", "free tip, the paper's finger (eqs 1-5), or lumped elements"
    )
    mass: u.Mass = _field(0.0, "not in the paper", "tip mass, used by kind mass")
    stiffness: u.LateralStiffness = _field(0.0, "not in the paper", "used by kind spring_damper")
    damping: u.LateralDamping = _field(0.0, "not in the paper", "used by kind spring_damper")


class Drive(Parameters):
    """The electrical source."""

    voltage: u.Voltage = _field(50.0, _PAPER_4, "amplitude (peak) of the drive voltage")


class Beam(Parameters):
    """What only the one-dimensional models need."""

    shear_correction: u.PositiveNumber = _field(
        5.0 / 6.0,
        "assumed: rectangular section",
        "Timoshenko's shear correction factor",
        (0.4, 0.9, "0.425 by the shear energy of the paper's layers, 0.88 with a stiff shim"),
    )


def sources(group: Parameters) -> dict[str, str]:
    """Return the source of each scalar of a group, as ``{field: source}``."""
    found: dict[str, str] = {}
    for name, info in type(group).model_fields.items():
        extra = info.json_schema_extra
        if isinstance(extra, dict):
            found[name] = str(extra["source"])
    if isinstance(group, Piezo):
        found.update(LIBRARY[group.material].sources())
    return found


def spreads(group: Parameters) -> dict[str, Spread]:
    """Return the range of each scalar of a group that has one stated, as ``{field: range}``.

    For a value other than the default the range moves along: :meth:`Spread.moved`.
    """
    stated: dict[str, tuple[float, Spread]] = {}
    for name, info in type(group).model_fields.items():
        extra = info.json_schema_extra
        if isinstance(extra, dict) and isinstance(extra.get("spread"), list):
            stated[name] = (float(info.default), Spread(*extra["spread"]))  # type: ignore[misc]
    if isinstance(group, Piezo):
        ceramic = LIBRARY[group.material]
        usual = ceramic.reduced()
        stated.update({name: (usual[name], spread) for name, spread in ceramic.spreads.items()})
    return {
        name: spread.moved(usual, getattr(group, name)) for name, (usual, spread) in stated.items()
    }
