"""Soft magnetic steels that scenes choose from by name.

Of all but TEAM 20's steel the polarisation is what the ESRF fitted to measurements for its
undulator code Radia, J(H) = Σ Jₛ tanh(µ0 H k/Jₛ) over three terms (Chubar, Elleaume and
Chavanne, J. Synchrotron Rad. 5 (1998) 481; the constants are in Radia's table of materials).
So each curve rises everywhere and ends at the permeability of vacuum.  Without hysteresis, and
with the largest permeability at no field: fits are made for fields above some 0.1 mT.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from tactgen.geometry.device.steel_law import MU0, TEAM20, MagnetisationCurve
from tactgen.geometry.names import folded

#: Points of a curve's table, where it begins below the fastest term's scale, and how far it goes
#: beyond the slowest one's.
_POINTS = 80
_BELOW, _BEYOND = 0.02, 7.0


@dataclass(frozen=True)
class SoftMagnet:
    """A fitted polarisation: terms (k, Jₛ) with Jₛ in T, and what it is."""

    name: str
    terms: tuple[tuple[float, float], ...]
    what: str

    @property
    def saturation(self) -> float:
        """Polarisation at saturation (T)."""
        return sum(limit for _, limit in self.terms)

    @cache  # noqa: B019  a handful of frozen values that live as long as the program
    def curve(self) -> MagnetisationCurve:
        """Return the curve as a table, dense enough to be read to 1e-4 between its points."""
        scales = [limit / slope for slope, limit in self.terms]
        applied = np.geomspace(_BELOW * min(scales), _BEYOND * max(scales), _POINTS)
        applied = np.concatenate([[0.0], applied])  # µ0 H, T
        b = applied + sum(limit * np.tanh(applied * slope / limit) for slope, limit in self.terms)
        return MagnetisationCurve(b, applied / MU0, name=self.name)


#: By name.
SOFT_MAGNETS: dict[str, SoftMagnet] = {
    m.name: m
    for m in (
        SoftMagnet(
            "armco", ((4236.0, 1.385), (126.2, 0.2649), (34.0, 0.5)), "Armco pure iron, annealed"
        ),
        SoftMagnet(
            "xc06", ((2118.0, 1.362), (63.06, 0.2605), (17.138, 0.4917)),
            "low-carbon steel with less than 0.06 % C, such as AISI 1006",
        ),
        SoftMagnet(
            "steel37", ((1596.3, 1.1488), (133.11, 0.4268), (18.713, 0.4759)),
            "low-carbon steel with less than 0.13 % C, such as St37 or AISI 1010",
        ),
        SoftMagnet(
            "steel42", ((968.66, 1.441), (24.65, 0.2912), (8.3, 0.3316)),
            "steel with less than 0.19 % C, such as St42 or AISI 1018",
        ),
        SoftMagnet(
            "afk1", ((2001.0, 1.704), (38.56, 0.493), (1.24, 0.152)), "iron with 25 % cobalt"
        ),
        SoftMagnet(
            "afk502", ((10485.0, 1.788), (241.5, 0.437), (7.43, 0.115)),
            "iron with 49 % cobalt and 2 % vanadium (vanadium permendur)",
        ),
    )
}  # fmt: skip

#: Other words for them.
_ALSO = {
    "pure iron": "armco", "iron": "armco", "1006": "xc06", "AISI 1006": "xc06", "1010": "steel37",
    "AISI 1010": "steel37", "St37": "steel37", "1018": "steel42", "AISI 1018": "steel42",
    "St42": "steel42", "FeCo49": "afk502", "vanadium permendur": "afk502", "permendur": "afk502",
    "FeCo25": "afk1",
}  # fmt: skip

#: Magnetisation curves that are known by name; other names are files.
STEELS = ("team20", "linear", *SOFT_MAGNETS)


def steel_name(text: str) -> str | None:
    """Return the name of a built-in curve written in any case, with or without - and space."""
    names = {folded(name): name for name in STEELS}
    names.update({folded(other): name for other, name in _ALSO.items()})
    return names.get(folded(text))


def built_in_curve(name: str) -> MagnetisationCurve:
    """Return a built-in curve by its name in :data:`STEELS`, ``linear`` excepted; KeyError."""
    return TEAM20 if name == "team20" else SOFT_MAGNETS[name].curve()
