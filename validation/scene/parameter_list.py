"""Every scalar of a scene with its unit, source and meaning, for people to read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic.fields import FieldInfo

from tactgen.geometry.device.parameters import Parameters, sources
from tactgen.geometry.units import Unit
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.tolerances import Tolerance

#: Digits of a number that somebody has written, at most; more come from a calculation, of which
#: so many are shown.
_WRITTEN, _SHOWN = 8, 6


@dataclass(frozen=True)
class ParameterRow:
    """One scene key as shown in a report or a template.

    `text` is the value as people read it, `written` as a scene writes it.  `source` starts with
    "assumed" where the paper does not give the value.
    """

    key: str
    text: str
    meaning: str
    source: str
    written: str = ""

    @property
    def assumed(self) -> bool:
        """Whether nobody but this project vouches for the value."""
        return self.source.startswith("assumed")


def parameter_rows(scene: Scene, origins: dict[str, str]) -> list[ParameterRow]:
    """Return all scalar keys of a scene in order; `origins` names what the scene sets itself.

    A value that a built-in scene repeats from the paper keeps the paper as its source.
    """
    return list(_rows(scene, "", origins, scene.tolerances))


def _rows(
    group: Parameters, prefix: str, origins: dict[str, str], tolerances: Mapping[str, Tolerance]
) -> Iterator[ParameterRow]:
    default = type(group)() if prefix else None
    source_of = sources(group)
    for name, info in type(group).model_fields.items():
        value, key = getattr(group, name), f"{prefix}{name}"
        if isinstance(value, Parameters):
            yield from _rows(value, f"{key}.", origins, tolerances)
            continue
        source = source_of.get(name, "")
        changed = default is None or getattr(default, name) != value
        if key in origins and (changed or not source):
            source = origins[key]
        spread = f" {tolerances[key].words}" if key in tolerances else ""
        text, written = (shown(value, info) + spread for shown in (show, _written))
        yield ParameterRow(key, text, info.description or "", source, written)


def show(value: Any, info: FieldInfo) -> str:
    """Return a value as a scene would write it, less the digits of a number that was derived."""
    return _written(_readable(value) if isinstance(value, float) else value, info)


def _written(value: Any, info: FieldInfo) -> str:
    """Return a value as a scene would write it, without quotes."""
    unit = next((m for m in info.metadata if isinstance(m, Unit)), None)
    if value is None:
        return "derived"
    if unit is not None:
        return unit.show(float(value))
    if type(value) is tuple:  # a profile is one too, and knows how it is written
        return ", ".join(map(str, value))
    return str(value)


def _readable(value: float) -> float:
    """Return a number without the digits that nobody has written, such as those of 5/6."""
    written = float(f"{value:.{_WRITTEN}g}")
    # of SI units: 0.26 mm is 2.6e-4 but for rounding
    return value if abs(written - value) <= 1e-14 * abs(value) else float(f"{value:.{_SHOWN}g}")
