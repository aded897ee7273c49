"""Soft magnetic steels that scenes choose from by name: fitted curves, and where they come from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from tactgen.geometry.device.magnetisation import MU0, TEAM20, MagnetisationCurve
from tactgen.geometry.synonyms import folded

#: Points of a curve's table, where it begins below the fastest term's scale, and how far it goes
#: beyond the slowest one's.
_POINTS = 80
_BELOW, _BEYOND = 0.02, 7.0


@dataclass(frozen=True)
class SoftMagnet:
    """Fitted polarisation: terms (k, Jₛ) with Jₛ in T, and its name."""

    name: str
    terms: tuple[tuple[float, float], ...]
    what: str

    @property
    def saturation(self) -> float:
        """Polarisation at saturation (T)."""
        return sum(limit for _, limit in self.terms)

    @cache  # noqa: B019  a handful of frozen values that live as long as the program
    def curve(self) -> MagnetisationCurve:
        """Curve as a table, dense enough to be read to 1e-4 between its points."""
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
_STEEL_ALIASES = {
    "pure iron": "armco", "iron": "armco", "1006": "xc06", "AISI 1006": "xc06", "1010": "steel37",
    "AISI 1010": "steel37", "St37": "steel37", "1018": "steel42", "AISI 1018": "steel42",
    "St42": "steel42", "FeCo49": "afk502", "vanadium permendur": "afk502", "permendur": "afk502",
    "FeCo25": "afk1",
}  # fmt: skip
#: Magnetisation curves that are known by name; other names are files.
STEELS = ("team20", "linear", *SOFT_MAGNETS)


def steel_name(text: str) -> str | None:
    """Name of a built-in curve written in any case, with or without - and space."""
    names = {folded(name): name for name in STEELS}
    names.update({folded(other): name for other, name in _STEEL_ALIASES.items()})
    return names.get(folded(text))


#: Curves of steels that are sold as one kind, and a field (A/m) at which they differ.
_LOW_CARBON, _KNEE = ("team20", "xc06", "steel37", "steel42"), 1000.0


def curve_in_words(name: str) -> str:
    """Magnetisation curve that a scene names, for the reader, with the scatter of its kind."""
    words = {
        "team20": "magnetisation curve of TEAM problem 20", "linear": "straight magnetisation curve"
    }.get(name, "magnetisation curve from a file")  # fmt: skip
    if name in SOFT_MAGNETS:
        words = f"magnetisation curve {name}, {SOFT_MAGNETS[name].what}"
    if name not in _LOW_CARBON:
        return words
    at = np.array([_KNEE])
    own, *others = (
        float(built_in_curve(one).flux_density_at(at)[0]) for one in (name, *_LOW_CARBON)
    )
    return (
        f"{words} ({own:.2f} T at {_KNEE / 1e3:g} kA/m, where low-carbon steels scatter from "
        f"{min(others):.2f} to {max(others):.2f} T)"
    )


def built_in_curve(name: str) -> MagnetisationCurve:
    """Built-in curve by its name in :data:`STEELS`, ``linear`` excepted; KeyError."""
    return TEAM20 if name == "team20" else SOFT_MAGNETS[name].curve()
