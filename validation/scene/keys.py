"""Keys of a scene: which there are, what each is, and refusals of unknown ones."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

from pydantic.fields import FieldInfo

from tactgen.geometry.device import parameters as p
from tactgen.geometry.device.laminate import SIZES, is_size
from tactgen.geometry.errors import InputError
from tactgen.geometry.synonyms import nearest
from tactgen.geometry.units import quoted
from tactgen.validation.scene.scene import Scene


@lru_cache
def scene_keys() -> tuple[str, ...]:
    """Every key that a scene may set."""
    keys = []
    for name, info in Scene.model_fields.items():
        group = info.annotation
        if isinstance(group, type) and issubclass(group, p.Parameters):
            keys += [f"{name}.{inner}" for inner in group.model_fields]
        else:
            keys.append(name)
    return tuple(keys)


@lru_cache
def groups() -> set[str]:
    """Groups of keys."""
    return {key.split(".", 1)[0] for key in scene_keys() if "." in key}


def is_scene_key(key: str) -> bool:
    """Whether a scene may set a key, that of a listed layer's size among them."""
    group, _, name = key.partition(".")
    return key in scene_keys() or (group == "bimorph" and is_size(name))


def declaration(key: str) -> FieldInfo:
    """Declaration of a scene key."""
    group, _, name = key.partition(".")
    info = Scene.model_fields[group]
    of: Any = info.annotation
    return of.declaration(name) if name else info


def read_as(key: str) -> str:
    """Key that models read: of a layer's size that of all layers."""
    group, _, name = key.partition(".")
    return "bimorph.layers" if group == "bimorph" and is_size(name) else key


def number_keys(scene: Scene) -> tuple[str, ...]:
    """Every key of a scene, and those of its layers' sizes."""
    return (*scene_keys(), *(f"bimorph.{name}" for name in scene.bimorph.layers.sizes))


def check_key(key: str, also: Iterable[str] = ()) -> None:
    """Refuse a key that no scene has, with the nearest one or other name; InputError."""
    if is_scene_key(key):
        return
    known = scene_keys()
    group = key.split(".", maxsplit=1)[0]
    inside = [k for k in known if k.startswith(f"{group}.")]
    if "." not in key and inside:
        raise InputError(
            f'scene key "{key}" is a group, not a value; set one of {", ".join(inside)}'
        )
    if key.startswith("bimorph.layers."):
        raise InputError(
            f"scene key {quoted(key)} is unknown; a layer's sizes are bimorph.layers.NUMBER.SIZE, "
            f"the number from 1 at -x and the size {', '.join(SIZES)}"
        )
    plain = key.replace('"', "")
    close = nearest(plain, (*known, *sorted(groups()), *also))
    raise InputError(
        f"scene key {quoted(plain)} is unknown{close}; "
        "tactgen init FILE.toml writes a scene with every key"
    )
