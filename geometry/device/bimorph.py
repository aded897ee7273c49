"""The lateral actuator: bimorph, its materials, and the glue that holds it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import pi, sqrt
from typing import Any, Literal, Self

import numpy as np
from pydantic import PrivateAttr, ValidationInfo, model_validator
from pydantic.fields import FieldInfo

from tactgen.geometry import units as u
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.ceramic_constants import (
    NO_CONSTANTS,
    Constants,
    StatedConstants,
    completed,
    read_constants,
)
from tactgen.geometry.device.ceramic_library import LIBRARY, library_name
from tactgen.geometry.device.laminate import (
    OWN,
    PLAIN,
    SCATTER,
    Laminate,
    Layers,
    declaration,
    is_size,
    read_layers,
    read_sizes,
)
from tactgen.geometry.device.materials import (
    Own,
    Piezoceramic,
    Spread,
    isotropic_stiffness,
    orthotropic_stiffness,
)
from tactgen.geometry.device.parameter_group import PAPER_2, PAPER_4, Parameters, field, printed
from tactgen.geometry.device.profile import UNIFORM, LengthProfile, Profile
from tactgen.geometry.device.shim_library import PAPERS, SHIMS, isotropic_shear, shim_name
from tactgen.geometry.errors import InputError
from tactgen.geometry.synonyms import nearest


@dataclass(frozen=True)
class Dimensions:
    """Width and layer thicknesses of the ceramic's cross-section (m)."""

    width: Any
    piezo_thickness: Any
    shim_thickness: Any


class Bimorph(Parameters):
    """The lateral actuator: piezo / shim / piezo, the shim's tab below the ceramic."""

    length: u.Length = field(
        20e-3,
        PAPER_4,
        "active (ceramic) length",
        Spread(19.9e-3, 20.1e-3, "chosen by design; assumed: cut to 0.1 mm", absolute=True),
    )
    width: u.SmallLength = printed(2.1e-3, PAPER_2, "width b", 0.05e-3, own=SCATTER["width"])
    piezo_thickness: u.SmallLength = printed(
        0.26e-3, PAPER_2, "thickness of one piezo layer h_p", 0.005e-3, own=SCATTER["thickness"]
    )
    shim_thickness: u.SmallLength = printed(
        0.25e-3, PAPER_2, "thickness of the shim h_s", 0.005e-3, own=SCATTER["thickness"]
    )
    tab_length: u.LengthOrZero = field(
        0.0, "assumed: no bare shim below the ceramic", "length of the bare shim below the ceramic"
    )
    tip_extension: u.LengthOrZero = field(
        0.0,
        "assumed: the ceramic reaches to the tip",
        "length of the bare shim above the ceramic, at whose end the tip is",
    )
    layers: Layers = field(
        PLAIN,
        "paper table 2: piezo / shim / piezo",
        "layers from -x to +x in place of piezo, shim and piezo, such as brass 0.2 mm; PZT-5A "
        "0.26 mm +x",
    )
    width_profile: LengthProfile = field(
        UNIFORM,
        "assumed: uniform",
        "width along the ceramic: uniform, or 0 mm: 2.1 mm, 20 mm: 1 mm; then width is "
        "that of the tab and of the tip extension",
    )
    piezo_thickness_profile: LengthProfile = field(
        UNIFORM, "assumed: uniform", "thickness of one piezo layer along the ceramic"
    )
    shim_thickness_profile: LengthProfile = field(
        UNIFORM,
        "assumed: uniform",
        "thickness of the shim along the ceramic; then shim_thickness is that of the tab",
    )
    bare_below: u.LengthOrZero = field(
        0.0, "assumed: electrodes on the whole ceramic", "ceramic without electrode, lower end"
    )
    bare_above: u.LengthOrZero = field(
        0.0, "assumed: electrodes on the whole ceramic", "ceramic without electrode, upper end"
    )
    glue_thickness: u.LayerThickness = field(
        0.0, "assumed: no glue between the layers", "glue between the shim and each piezo layer"
    )
    wiring: Literal["parallel", "series"] = field(
        "parallel",
        "assumed: the paper does not say (its 50 V start near the parallel model's value)",
        "parallel: the voltage lies across each layer; series: across both in a row, the lower "
        "ceramic being poled the other way (listed layers state it themselves)",
    )
    poling: Literal["-x", "+x"] = field(
        "-x",
        "assumed: gives the signs of the paper's matrix A (positive U bends towards +x)",
        "direction in which both layers are poled; U is outer electrodes minus shim",
    )

    @model_validator(mode="before")
    @classmethod
    def _put_sizes_in_place(cls, given: Any, info: ValidationInfo) -> Any:
        """Layers with the sizes that keys of their own state; what is no list says so itself."""
        if not isinstance(given, dict) or not any(map(is_size, given)):
            return given
        sizes = {name: value for name, value in given.items() if is_size(name)}
        rest = {name: value for name, value in given.items() if name not in sizes}
        try:
            layers = read_layers(given.get("layers", PLAIN), info)
        except ValueError:
            return rest
        return {**rest, "layers": read_sizes(layers, sizes, info)}

    @classmethod
    def declaration(cls, name: str) -> FieldInfo:
        """Declaration of a parameter, or of a listed layer's size such as ``layers.2.end``."""
        return declaration(name) if is_size(name) else super().declaration(name)

    def value(self, name: str) -> Any:
        """Value of a parameter, or a listed layer's size; InputError if there is no such layer."""
        return self.layers.size(name) if is_size(name) else super().value(name)

    def changed(self, values: Mapping[str, Any]) -> Self:
        """Bimorph with other values, unchecked; of arrays, which faces are driven stays."""
        sizes = {name: value for name, value in values.items() if is_size(name)}
        plain = {name: value for name, value in values.items() if name not in sizes}
        if sizes:
            many = any(not isinstance(value, float) for value in sizes.values())
            layers = self.layers.with_hot_faces() if many else self.layers
            plain["layers"] = layers.with_sizes(sizes)
        return super().changed(plain)

    @property
    def thickness(self) -> float:
        """Total thickness (m)."""
        if self.layers:
            return float(self.layers.thickness)
        return float(2.0 * (self.piezo_thickness + self.glue_thickness) + self.shim_thickness)

    @property
    def own_materials(self) -> frozenset[str]:
        """Groups of the scene, of piezo, shim and glue, that its layers are made of."""
        if self.layers:
            return frozenset(layer.material for layer in self.layers) & frozenset(OWN)
        return frozenset(("piezo", "shim", *(["glue"] if self.glue_thickness else [])))

    @property
    def stepped(self) -> bool:
        """Whether layers are wider or narrower than others."""
        first, *others = self.widths or [self.width]  # of several bimorphs at once arrays
        return any(bool(np.any(other != first)) for other in others)

    @property
    def widths(self) -> list[Any]:
        """Width of each listed layer (m)."""
        return [np.where(layer.width, layer.width, self.width) if np.ndim(layer.width)
                else layer.width or self.width for layer in self.layers]  # fmt: skip

    @property
    def profiles(self) -> dict[str, Profile]:
        """The dimensions that vary along the ceramic, by their key; listed layers have theirs."""
        thicknesses = () if self.layers else ("piezo_thickness_profile", "shim_thickness_profile")
        names = ("width_profile", *thicknesses)
        return {name: getattr(self, name) for name in names if getattr(self, name)}

    def dimensions(self, low: float, high: float) -> tuple[Dimensions, Dimensions]:
        """Cross-sections just above `low` and just below `high` (m), positions on the ceramic.

        No point of a profile may lie between the two.
        """
        ends = [
            profile.between(low, high) if profile else (uniform, uniform)
            for profile, uniform in (
                (self.width_profile, self.width),
                (self.piezo_thickness_profile, self.piezo_thickness),
                (self.shim_thickness_profile, self.shim_thickness),
            )
        ]
        lower, upper = zip(*ends, strict=True)
        return Dimensions(*lower), Dimensions(*upper)

    @property
    def height(self) -> float:
        """Length from the tab's lower end to the tip (m)."""
        return float(self.tab_length + self.length + self.tip_extension)

    @property
    def spans(self) -> list[tuple[float, float]]:
        """Where each listed layer begins and ends (m), from the tab's lower end."""
        extents = self.layers.extents(self.length)
        return [
            (0.0, self.height) if goes_on else (self.tab_length + low, self.tab_length + high)
            for goes_on, (low, high) in zip(self.layers.continues, extents, strict=True)
        ]

    @property
    def electrode_distance(self) -> float:
        """Smallest distance of electrodes that the drive voltage lies across (m)."""
        if not self.layers:
            return float(self.piezo_thickness)
        driven = (layer for n, layer in enumerate(self.layers) if self.layers.hot(n))
        return float(min((of.electrode_distance for of in driven), default=self.thickness))

    def drive_poling(self, number: int) -> int:
        """Direction (along x) in which a listed layer is poled where its hot face has the voltage.

        In series the lower ceramic's outer face is the other terminal, at the opposite voltage,
        which is the same as the opposite poling.  Poled along z, its field has the poling's
        direction at a positive voltage; through the thickness that is from the hot face on.
        """
        layers: Laminate = self.layers
        turned = self.wiring == "series" and layers.hot(number) < 0
        turned |= layers[number].pitch > 0.0
        return -layers[number].poling if turned else layers[number].poling

    @property
    def poling_sign(self) -> float:
        """+1 for poling along +x, −1 along −x."""
        return 1.0 if self.poling == "+x" else -1.0


#: How a constant grows, and the keys that say by how much.
_RAYLEIGH = "per amplitude of the field at drive.voltage, by Rayleigh's law; 0 keeps it"
GROWTHS = ("field_growth_d31", "field_growth_s11", "field_growth_eps33")


class Piezo(Parameters):
    """The piezoceramic: a library material, any of whose values may be replaced."""

    material: str = field("M1876", PAPER_2, "name of a library material")
    s11: u.Compliance = field(None, "", "elastic compliance s11 at constant field")
    s55: u.Compliance = field(None, "", "shear compliance s55 at constant field")
    d31: u.PiezoConstant = field(None, "", "transverse piezoelectric constant")
    eps33: u.RelativePermittivity = field(None, "", "relative permittivity at constant stress")
    constants: StatedConstants = field(
        NO_CONSTANTS,
        "not in the paper: the material's own",
        "other constants of a data sheet, such as d33 374 pC/N; c11 121 GPa; eps33S 830; k33 0.7, "
        "or none",
    )
    density: u.Density = field(None, "", "mass density")
    quality_factor: u.QualityFactor = field(None, "", "mechanical quality factor Q")
    loss_tangent: u.LossTangent = field(None, "", "dielectric loss tangent")
    coupling_loss: u.LossTangent = field(
        0.0, "paper section 4: none", "loss tangent of the piezoelectric constants"
    )
    field_growth_d31: u.FieldGrowth = field(
        0.0, "paper section 4: linear", f"relative growth of d31 and all d {_RAYLEIGH}"
    )
    field_growth_s11: u.FieldGrowth = field(
        0.0, "paper section 4: linear", f"relative growth of all compliances {_RAYLEIGH}"
    )
    field_growth_eps33: u.FieldGrowth = field(
        0.0, "paper section 4: linear", f"relative growth of the permittivity {_RAYLEIGH}"
    )
    #: Of k33 and k15, which no key has
    _coupling_growth: float = PrivateAttr(default=1.0)
    #: Material in place of the library's
    _turned: Piezoceramic | None = PrivateAttr(default=None)

    @model_validator(mode="before")
    @classmethod
    def _fill_from_library(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        asked = given.get("material", "M1876")
        name = library_name(asked) if isinstance(asked, str) else None
        if name is None:
            raise InputError(
                f"piezo.material = {u.quoted(asked)} is not in the library"
                f"{nearest(str(asked), LIBRARY)}; use one of {', '.join(LIBRARY)} and replace "
                "single values, such as piezo.s11"
            )
        stated = cls._constants(given)
        library = {key: u.SI(value) for key, value in _completed(name, stated).reduced().items()}
        return {**library, **given, "material": name}

    @classmethod
    def _constants(cls, given: dict[str, Any]) -> Constants:
        """Stated constants; what cannot be read says so as their own field."""
        try:
            return read_constants(given.get("constants", NO_CONSTANTS))
        except ValueError:
            return NO_CONSTANTS

    @property
    def base(self) -> Piezoceramic:
        """Material before single values are replaced: the library's, with the stated constants."""
        return self._turned or _completed(self.material, self.constants)

    def ceramic(self) -> Piezoceramic:
        """Full material that these values stand for, in small fields."""
        values = self.model_dump(exclude={"material", "constants", *GROWTHS})
        return self.base.with_values(**values, coupling_growth=self._coupling_growth)

    def along(self, share: float) -> Piezo:
        """The ceramic poled along the bimorph, as one poled through its thickness.

        `share` is its thickness over the electrodes' pitch; see :meth:`Piezoceramic.along`.
        """
        turned = self.ceramic().along(share)
        found = self.model_copy(update=turned.reduced())
        found._turned, found._coupling_growth = turned, 1.0
        return found

    @property
    def grows(self) -> bool:
        """Whether any constant depends on the amplitude of the field."""
        return any(getattr(self, name) for name in GROWTHS)

    def at_field(self, amplitude: float) -> Piezo:
        """Linear ceramic that answers a sinusoidal field of an amplitude (V/m) as this one does.

        Rayleigh's law: what a constant c makes of a field E follows the loop
        (c + α E₀) E ± (α/2) (E₀² − E²).  Its first harmonic has c + α E₀ in phase and
        4 α E₀/(3π) lagging, so each constant brings its own loss; the other harmonics are left out.
        """
        d31, s11, eps33 = (amplitude * getattr(self, name) for name in GROWTHS)
        found = self.model_copy(
            update={
                "d31": self.d31 * (1.0 + d31),
                "s11": self.s11 * (1.0 + s11),
                "s55": self.s55 * (1.0 + s11),
                "eps33": self.eps33 * (1.0 + eps33),
                "coupling_loss": _with_loop(self.coupling_loss, d31),
                "quality_factor": 1.0 / _with_loop(1.0 / self.quality_factor, s11),
                "loss_tangent": _with_loop(self.loss_tangent, eps33),
                **dict.fromkeys(GROWTHS, 0.0),
            }
        )
        found._coupling_growth = (1.0 + d31) / sqrt((1.0 + s11) * (1.0 + eps33))
        return found


def _with_loop(loss: float, growth: float) -> float:
    """Loss tangent of a constant that has grown by a share."""
    return (loss + 4.0 / (3.0 * pi) * growth) / (1.0 + growth)


@cache
def _completed(name: str, constants: Constants) -> Piezoceramic:
    return completed(LIBRARY[name], constants)


class Shim(Parameters):
    """The middle layer: elastic, electrically conducting, fibres along z.

    A library material, any of whose values may be replaced; a metal stays isotropic.
    """

    material: str = field(
        PAPERS,
        "assumed: the paper says composite",
        f"{PAPERS}: the paper's composite; or {', '.join(SHIMS)}",
    )
    youngs_modulus: u.Modulus = printed(
        140e9, PAPER_2, "modulus along the actuator E_s", 5e9, own=Own("modulus", 0.05)
    )
    shear_modulus: u.Modulus = field(
        5e9,
        "assumed: unidirectional carbon fibre composite",
        "longitudinal shear modulus G_s",
        (4e9, 6e9, "such composites with usual fibre contents"),
        own=Own("modulus", 0.05),
    )
    transverse_modulus: u.Modulus | None = field(
        None,
        "assumed: 2 (1 + nu) G_s, exact for an isotropic shim",
        "modulus across the fibres (solid model only)",
    )
    poisson_ratio: u.PoissonRatio = field(
        0.3,
        "assumed: typical of the composite",
        "Poisson ratio (solid model only)",
        (0.25, 0.35, "such composites"),
        own=Own("Poisson ratio", 0.1),
    )
    loss_factor: u.LossFactor = field(
        0.0,
        "assumed: none, as in the paper's equations; composites have 0.001 to 0.01 along the "
        "fibres, in shear up to 0.02",
        "structural damping: all moduli times (1 + j loss factor)",
    )
    density: u.Density = printed(1500.0, PAPER_2, "mass density", 50.0, own=Own("density", 0.02))

    @property
    def modulus_across(self) -> float:
        """Modulus across the fibres (Pa); where it is not stated that of an isotropic shim."""
        return float(self.transverse_modulus or 2 * (1 + self.poisson_ratio) * self.shear_modulus)

    def stiffness(self) -> Floats:
        """(6, 6) Stiffness without losses (Pa)."""
        return orthotropic_stiffness(
            self.youngs_modulus, self.modulus_across, self.shear_modulus, self.poisson_ratio
        )

    @model_validator(mode="before")
    @classmethod
    def _fill_from_library(cls, given: Any) -> Any:
        if not isinstance(given, dict) or "material" not in given:
            return given
        asked = given["material"]
        name = shim_name(asked) if isinstance(asked, str) else None
        if name is None:
            raise InputError(
                f"shim.material = {u.quoted(asked)} is not in the library"
                f"{nearest(str(asked), (PAPERS, *SHIMS))}; use one of "
                f"{', '.join((PAPERS, *SHIMS))} and replace single values, such as "
                "shim.youngs_modulus"
            )
        if name == PAPERS:
            return {**given, "material": name}
        library = {key: u.SI(value) for key, value in SHIMS[name].values().items()}
        values = {**library, **given, "material": name}
        if "shear_modulus" not in values:
            values["shear_modulus"] = cls._isotropic_shear(values)
        return values

    @classmethod
    def _isotropic_shear(cls, values: dict[str, Any]) -> float:
        """Metal's shear modulus; where a constant cannot be read it says so itself."""
        read = []
        for name in ("youngs_modulus", "poisson_ratio"):
            unit = next(m for m in cls.model_fields[name].metadata if isinstance(m, u.Unit))
            value = values[name]
            try:
                read.append(unit.parse(value) if isinstance(value, str) else float(value))
            except (TypeError, ValueError):
                return u.SI(1.0e9)
        return u.SI(isotropic_shear(*read))


class Glue(Parameters):
    """The adhesive between the shim's tab and the slot in the rod's head, and between layers."""

    thickness: u.SmallLength = field(
        50e-6,
        "assumed: typical bond line",
        "bond line around the tab",
        (30e-6, 80e-6, "bond lines of paste epoxies"),
    )
    youngs_modulus: u.Modulus = field(
        3e9, "assumed: epoxy", "modulus", (2e9, 5e9, "unfilled to filled epoxies")
    )
    poisson_ratio: u.PoissonRatio = field(
        0.35, "assumed: epoxy", "Poisson ratio", (0.3, 0.4, "epoxies")
    )
    density: u.Density = field(
        1200.0, "assumed: epoxy", "mass density", (1100.0, 1400.0, "unfilled to filled epoxies")
    )
    loss_factor: u.LossFactor = field(
        0.0,
        "assumed: none; epoxies below their glass transition have 0.01 to 0.1",
        "structural damping of the bond lines: all moduli times (1 + j loss factor)",
    )

    def stiffness(self) -> Floats:
        """(6, 6) Stiffness without losses (Pa)."""
        return isotropic_stiffness(self.youngs_modulus, self.poisson_ratio)
