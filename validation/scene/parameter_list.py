"""Every scalar of a scene with unit, source, meaning and range."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from pydantic.fields import FieldInfo

from tactgen.geometry.device.laminate import Laminate, is_size, single_sizes
from tactgen.geometry.device.materials import Spread
from tactgen.geometry.device.parameter_group import RECONSTRUCTED
from tactgen.geometry.device.parameters import Bimorph, Parameters, sources, spreads
from tactgen.geometry.units import Unit
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.tolerances import Tolerance
from tactgen.validation.scene.variation import is_papers_actuator, value_of

#: Source of a size that a scene with an actuator of its own leaves out.
_NOT_STATED = "assumed: not stated, that of the built-in actuator"
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
    """All scalar keys of a scene in order; `origins` names what the scene sets itself.

    A value that a built-in scene repeats from the paper keeps the paper as its source.
    """
    rows = list(_rows(scene, "", origins, scene.tolerances))
    if is_papers_actuator(scene):
        return rows
    return [
        replace(row, source=origins.get(row.key, _NOT_STATED))
        if row.source == RECONSTRUCTED
        else row
        for row in rows
    ]


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
        if key in origins and (changed or not source or not is_built_in(origins[key])):
            source = origins[key]
        if isinstance(value, Laminate):
            words = {of.removeprefix(prefix): stated.words for of, stated in tolerances.items()}
            text = written = value.written(words)
        else:
            spread = f" {tolerances[key].words}" if key in tolerances else ""
            text, written = (shown(value, info) + spread for shown in (show, _written))
        yield ParameterRow(key, text, info.description or "", source, written)


def is_built_in(origin: str) -> bool:
    """Whether a built-in scene states a value, and neither a file nor the command line."""
    return origin.startswith("scene ") and not origin.startswith("scene file ")


def show(value: Any, info: FieldInfo) -> str:
    """Value as a scene would write it, less the digits of a number that was derived."""
    unit = _unit(info)
    per_si = unit.per_si if unit is not None else 1.0
    return _written(_readable(value * per_si) / per_si if isinstance(value, float) else value, info)


def _unit(info: FieldInfo) -> Unit | None:
    return next((m for m in info.metadata if isinstance(m, Unit)), None)


def _written(value: Any, info: FieldInfo) -> str:
    """Value as a scene would write it, without quotes."""
    unit = _unit(info)
    if value is None:
        return "derived"
    if unit is not None:
        return unit.show(float(value))
    if type(value) is tuple:  # a profile is one too, and knows how it is written
        return ", ".join(map(str, value))
    return str(value)


def _readable(value: float) -> float:
    """Number without the digits that nobody has written, such as those of 5/6."""
    written = float(f"{value:.{_WRITTEN}g}")
    # 0.26 mm is 2.6e-4 m, and 45 deg so many rad, but for rounding
    return value if abs(written - value) <= 1e-14 * abs(value) else float(f"{value:.{_SHOWN}g}")


def ranges(scene: Scene) -> dict[str, Spread]:
    """Range of every number of the device that has one, by key in the scene's order.

    What the scene states comes first; the reason of any other says whose it is, or that it is
    assumed.  A value that was changed since takes its tolerance along.
    """
    return dict(_ranges(scene))


def _ranges(scene: Scene) -> Iterator[tuple[str, Spread]]:
    for name in type(scene).model_fields:
        group = getattr(scene, name)
        usual = spreads(group) if isinstance(group, Parameters) else {}
        fields = (*type(group).model_fields,) if isinstance(group, Parameters) else (name,)
        if isinstance(group, Bimorph):
            named = (key.removeprefix(f"{name}.") for key in scene.tolerances)
            fields = tuple(dict.fromkeys((*fields, *group.layers.sizes, *filter(is_size, named))))
        for field in fields:
            key = f"{name}.{field}" if isinstance(group, Parameters) else name
            # layers that end together may lie as far off as the first says that states it
            whose = (key, *(f"{name}.{of}" for of in single_sizes(field)))
            stated = next(filter(None, map(scene.tolerances.get, whose)), None)
            if stated is not None:
                yield key, stated.spread.moved(stated.value, value_of(scene, key))
            elif field in usual:
                yield key, usual[field]
