"""Metals, composites and polymers that a shim is chosen from by name."""

from __future__ import annotations

from dataclasses import dataclass

from tactgen.geometry.device.materials import Spread
from tactgen.geometry.synonyms import folded


@dataclass(frozen=True)
class ShimMaterial:
    """A metal, isotropic, or a composite with fibres along the shim (SI units).

    Attributes
    ----------
    youngs_modulus, density : float
        Along the shim (Pa), and mass density (kg/m³).
    """

    name: str
    youngs_modulus: float
    poisson_ratio: float
    density: float
    #: (float, float) What the source, or several of one material, allow
    modulus_range: tuple[float, float]
    density_range: tuple[float, float]
    origin: str
    shear_modulus: float | None = None  #: Of a composite (Pa); a metal's follows from the other two
    transverse_modulus: float | None = None  #: Of a composite, across the fibres (Pa)

    def values(self) -> dict[str, float]:
        """Constants by their key in a scene, the shear modulus only of a composite."""
        found = {
            "youngs_modulus": self.youngs_modulus,
            "poisson_ratio": self.poisson_ratio,
            "density": self.density,
            "shear_modulus": self.shear_modulus,
            "transverse_modulus": self.transverse_modulus,
        }
        return {name: value for name, value in found.items() if value is not None}

    def spreads(self) -> dict[str, Spread]:
        """Ranges from the tables; a metal's shear follows its modulus."""
        low, high = (isotropic_shear(end, self.poisson_ratio) for end in self.modulus_range)
        found = {
            "youngs_modulus": Spread(*self.modulus_range, f"data sheets of {self.name}"),
            "density": Spread(*self.density_range, f"data sheets of {self.name}"),
        }
        if self.shear_modulus is None:
            found["shear_modulus"] = Spread(
                low, high, f"data sheets of {self.name}: E / 2 (1 + nu)"
            )
        return found


def isotropic_shear(youngs_modulus: float, poisson_ratio: float) -> float:
    """Shear modulus of an isotropic material (Pa)."""
    return youngs_modulus / (2.0 * (1.0 + poisson_ratio))


#: The paper's composite, whose constants are the defaults.
PAPERS = "CFRP"
#: By name.  The metals' moduli at room temperature, rolled sheet; ranges over the tempers.
SHIMS: dict[str, ShimMaterial] = {
    m.name: m
    for m in (
        ShimMaterial(
            "brass", 110e9, 0.34, 8530.0, (103e9, 117e9), (8440.0, 8530.0),
            "cartridge brass CuZn30, UNS C26000: Copper Development Association's data sheet",
        ),
        ShimMaterial(
            "stainless steel", 193e9, 0.29, 8000.0, (190e9, 200e9), (7900.0, 8030.0),
            "AISI 301 and 304: ASM Metals Handbook, vol 1 (1990)",
        ),
        ShimMaterial(
            "spring steel", 206e9, 0.29, 7850.0, (200e9, 212e9), (7800.0, 7870.0),
            "carbon spring strip, C75S and AISI 1074 to 1095: ASM Metals Handbook, vol 1 (1990)",
        ),
        ShimMaterial(
            "titanium", 114e9, 0.34, 4430.0, (105e9, 120e9), (4420.0, 4510.0),
            "Ti-6Al-4V, grade 5: ASM Metals Handbook, vol 2 (1990)",
        ),
        ShimMaterial(
            "nickel silver", 125e9, 0.33, 8700.0, (120e9, 130e9), (8690.0, 8730.0),
            "CuNi18Zn27, UNS C77000: Copper Development Association's data sheet",
        ),
        ShimMaterial(
            "phosphor bronze", 110e9, 0.34, 8860.0, (103e9, 117e9), (8800.0, 8860.0),
            "CuSn5, UNS C51000: Copper Development Association's data sheet",
        ),
        ShimMaterial(
            "aluminium", 70e9, 0.33, 2700.0, (68e9, 73e9), (2660.0, 2810.0),
            "wrought alloys, 5052 to 7075: ASM Metals Handbook, vol 2 (1990)",
        ),
        ShimMaterial(
            "AS4 CFRP", 147e9, 0.27, 1600.0, (135e9, 150e9), (1550.0, 1620.0),
            "AS4/3501-6, unidirectional, 63 % fibres: Daniel and Ishai, Engineering Mechanics of "
            "Composite Materials (2006), table A.4",
            shear_modulus=7.0e9, transverse_modulus=10.3e9,
        ),
    )
}  # fmt: skip
#: Other words for them.
_ALSO = {
    "stainless": "stainless steel", "304": "stainless steel", "301": "stainless steel",
    "C260": "brass", "CuZn30": "brass", "Ti6Al4V": "titanium", "aluminum": "aluminium",
    "carbon fibre": PAPERS, "carbon fiber": PAPERS,
}  # fmt: skip


def shim_name(text: str) -> str | None:
    """Library's name of a shim written in any case, with or without - and space."""
    names = {folded(name): name for name in (PAPERS, *SHIMS)}
    names.update({folded(other): name for other, name in _ALSO.items()})
    return names.get(folded(text))
