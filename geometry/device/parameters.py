"""Every parameter of the device and of its operating conditions, with its source.

Frozen pydantic models in SI units.  The defaults are the paper's lateral actuator
(20 mm long) on the reconstructed normal actuator.  ``Field(description=...)`` says
what a number means, :func:`sources` where it comes from.  Nothing is computed here
but what the geometry itself implies.  The groups are declared in ``groups/``.
"""

from __future__ import annotations

from tactgen.geometry import units as u
from tactgen.geometry.device.bimorph import Bimorph, Glue, Piezo, Shim
from tactgen.geometry.device.ceramic_library import CERAMICS
from tactgen.geometry.device.display import Display, Scatter, Skin
from tactgen.geometry.device.materials import Own, Spread
from tactgen.geometry.device.parameter_group import PAPER_5, Parameters, field
from tactgen.geometry.device.reluctance import NOMINAL_GAP, Coil, Rod, Sleeve, Steel
from tactgen.geometry.device.shim_library import SHIMS
from tactgen.geometry.device.spring_contact_guide import Contact, Guide, Spring
from tactgen.geometry.device.support_load_drive import (
    Beam,
    Circuit,
    Drive,
    Limits,
    Load,
    Measurement,
    Support,
    Threshold,
)

__all__ = [
    "NOMINAL_GAP", "Beam", "Bimorph", "Circuit", "Coil", "Contact", "Device", "Display", "Drive",
    "Glue", "Guide", "Limits", "Load", "Measurement", "Parameters", "Piezo", "Rod", "Scatter",
    "Shim", "Skin", "Sleeve", "Spring", "Steel", "Support", "Threshold", "sources", "spreads",
]  # fmt: skip


class Device(Parameters):
    """One tactile generator: dimensions and materials, and where its motion is measured."""

    bimorph: Bimorph = Bimorph()
    measurement: Measurement = Measurement()
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
    """Source of each scalar of a group, as ``{field: source}``."""
    found: dict[str, str] = {}
    for name, info in type(group).model_fields.items():
        extra = info.json_schema_extra
        if isinstance(extra, dict):
            found[name] = str(extra["source"])
    if isinstance(group, Shim) and group.material in SHIMS:
        found.update(dict.fromkeys(found, SHIMS[group.material].origin))
    if isinstance(group, Piezo):
        found.update(group.base.sources())
    return found


def spreads(group: Parameters) -> dict[str, Spread]:
    """Range of each scalar of a group that has one, as ``{field: range}``.

    A value that is not the source's has the range of its kind, or else the default's, moved
    along: :meth:`Spread.moved`.
    """
    found: dict[str, Spread] = {}
    for name, info in type(group).model_fields.items():
        extra, value = info.json_schema_extra, getattr(group, name)
        if not isinstance(extra, dict) or not isinstance(value, float):
            continue
        spread, own = extra.get("spread"), extra.get("own")
        if isinstance(own, list) and value != info.default:
            found[name] = Own(*own).around(value)  # type: ignore[arg-type]
        elif isinstance(spread, list):
            found[name] = Spread(*spread).moved(float(info.default), value)  # type: ignore[arg-type]
    if isinstance(group, Bimorph):
        found.update(group.layers.spreads())
    if isinstance(group, Shim) and group.material in SHIMS:
        tables = SHIMS[group.material].spreads().items()
        found.update({n: r for n, r in tables if r.low <= getattr(group, n) <= r.high})
    if isinstance(group, Piezo):
        ceramic = group.base
        for name, usual in ceramic.reduced().items():
            value = getattr(group, name)
            stated = ceramic.spreads.get(name) if value == usual else None
            found[name] = stated or CERAMICS[name].around(value)
    return found
