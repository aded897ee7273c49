"""Every parameter of the device and of its operating conditions, with its source.

Frozen pydantic models in SI units.  The defaults are the paper's lateral actuator
(20 mm long) on the reconstructed normal actuator.  ``Field(description=...)`` says
what a number means, :func:`sources` where it comes from.  Nothing is computed here
but what the geometry itself implies.  The groups are declared in ``groups/``.
"""

from __future__ import annotations

from tactgen.geometry import units as u
from tactgen.geometry.device.groups.declaration import PAPER_5, Parameters, field
from tactgen.geometry.device.groups.holding import Contact, Guide, Spring
from tactgen.geometry.device.groups.lateral import Bimorph, Glue, Piezo, Shim
from tactgen.geometry.device.groups.normal import (
    BUILT_IN_CURVES,
    NOMINAL_GAP,
    Coil,
    Rod,
    Sleeve,
    Steel,
)
from tactgen.geometry.device.groups.operation import Beam, Drive, Limits, Load, Support
from tactgen.geometry.device.materials import Spread
from tactgen.geometry.device.piezo_library import LIBRARY

__all__ = [
    "BUILT_IN_CURVES", "NOMINAL_GAP", "Beam", "Bimorph", "Coil", "Contact", "Device", "Drive",
    "Glue", "Guide", "Limits", "Load", "Parameters", "Piezo", "Rod", "Shim", "Sleeve", "Spring",
    "Steel", "Support", "sources", "spreads",
]  # fmt: skip


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
    contact: Contact = Contact()
    guide: Guide = Guide()
    steel: Steel = Steel()
    gap: u.SmallLength = field(0.2e-3, PAPER_5, "working air gap")

    @property
    def ceramic_base(self) -> float:
        """Height z of the ceramic's lower edge when the bimorph stands in the rod (m).

        z = 0 is the rod's top face; the tab reaches to one bond line above the slot's floor.
        """
        return float(self.bimorph.tab_length - (self.rod.slot_depth - self.glue.thickness))


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
