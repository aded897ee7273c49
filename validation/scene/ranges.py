"""The ranges in which a scene's numbers may lie: as it states them, or else as assumed."""

from __future__ import annotations

from collections.abc import Iterator

from tactgen.geometry.device.materials import Spread
from tactgen.geometry.device.parameters import Parameters, spreads
from tactgen.validation.scene.scene import Scene


def ranges(scene: Scene) -> dict[str, Spread]:
    """Return the range of every number of the device that has one, by key in the scene's order.

    What the scene states comes first; the reason of any other says whose it is, or that it is
    assumed.  A value that was changed since takes its tolerance along.
    """
    return dict(_ranges(scene))


def _ranges(scene: Scene) -> Iterator[tuple[str, Spread]]:
    for name in type(scene).model_fields:
        group = getattr(scene, name)
        usual = spreads(group) if isinstance(group, Parameters) else {}
        fields = type(group).model_fields if isinstance(group, Parameters) else (name,)
        for field in fields:
            key = f"{name}.{field}" if isinstance(group, Parameters) else name
            stated = scene.tolerances.get(key)
            if stated is not None:
                value = getattr(group, field) if isinstance(group, Parameters) else group
                yield key, stated.spread.moved(stated.value, value)
            elif field in usual:
                yield key, usual[field]
