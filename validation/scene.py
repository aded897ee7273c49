"""A scene: what is studied, how it is held, loaded and driven, and what is wanted.

A small TOML file states only what differs from the paper's device.  Units are written
there and nowhere else; unknown keys are refused with the nearest valid name.
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError, field_validator

from geometry import parameters as p
from geometry import units as u
from geometry.errors import InputError
from validation.frequencies import parse_frequencies
from validation.quantities import MODELS, QUANTITIES

#: Groups of device parameters, in the order in which reports list them.
GROUPS = ("bimorph", "piezo", "shim", "glue", "rod", "coil", "sleeve", "support", "load")


class MeshSettings(p.Parameters):
    """How the solid model is meshed."""

    kind: Literal["auto", "structured", "tetwild"] = Field(
        default="auto",
        description="structured boxes for the bimorph alone, tetwild for anything else",
    )
    level: int = Field(
        default=0,
        ge=0,
        le=5,
        description="1 (coarse) to 5 (finest); 0 follows from the accuracy wanted",
    )
    time_limit: u.Duration = Field(
        default=u.SI(600.0), description="time that one tetwild mesh may take"
    )


class Scene(p.Device):
    """A complete, checked scene in SI units."""

    name: str = ""
    description: str = ""
    support: p.Support = p.Support()
    load: p.Load = p.Load()
    drive: p.Drive = p.Drive()
    beam: p.Beam = p.Beam()
    mesh: MeshSettings = MeshSettings()
    accuracy: u.RelativeError = Field(
        default=1e-3, description="relative numerical error wanted of the solid model"
    )
    modes: int = Field(default=4, ge=1, le=20, description="how many natural modes")
    frequency: tuple[float, ...] = Field(
        default="10 Hz:1000 Hz:100:log",
        validate_default=True,
        description="list of frequencies, or START:STOP:N[:log]",
    )
    models: tuple[str, ...] = Field(default=tuple(MODELS), description="models asked for")
    quantities: tuple[str, ...] = Field(
        default=tuple(QUANTITIES), description="quantities asked for"
    )

    @property
    def device(self) -> p.Device:
        """The device alone."""
        return p.Device(**{name: getattr(self, name) for name in p.Device.model_fields})

    @field_validator("frequency", mode="before")
    @classmethod
    def _frequencies(cls, value: Any) -> Any:
        return parse_frequencies(value) if isinstance(value, str) else value

    @field_validator("models", mode="before")
    @classmethod
    def _models(cls, value: Any) -> Any:
        return choices(value, tuple(MODELS), "model")

    @field_validator("quantities", mode="before")
    @classmethod
    def _quantities(cls, value: Any) -> Any:
        return choices(value, tuple(QUANTITIES), "quantity")


def choices(value: Any, known: tuple[str, ...], kind: str) -> tuple[str, ...]:
    """Return `value` (a name, "a,b" or a list) as known names; ``all`` is every one.

    Raises
    ------
    InputError
        For an unknown name, with the nearest known one.
    """
    names = [v.strip() for v in value.split(",")] if isinstance(value, str) else list(value)
    if "all" in names:
        return known
    for name in names:
        if name not in known:
            raise InputError(
                f'{kind} "{name}" is unknown{_nearest(str(name), known)}; known are '
                f"{', '.join(known)}"
            )
    return tuple(dict.fromkeys(names))


def built_in_scenes() -> dict[str, str]:
    """Return the names of the built-in scenes with their descriptions."""
    folder = resources.files("validation") / "scenes"
    found = {}
    for entry in sorted(folder.iterdir(), key=lambda e: e.name):
        if entry.name.endswith(".toml"):
            text = tomllib.loads(entry.read_text(encoding="utf-8"))
            found[entry.name.removesuffix(".toml")] = str(text.get("description", ""))
    return found


def load_scene(name: str = "paper", overrides: Sequence[str] = ()) -> tuple[Scene, dict[str, str]]:
    """Read a scene by file or built-in name and apply ``KEY=VALUE`` overrides.

    Returns
    -------
    scene : Scene
        Checked and in SI units.
    origins : dict of str to str
        For each key that the scene or an override sets, where it was set.

    Raises
    ------
    InputError
        In one sentence, for anything that cannot be used.
    """
    values, where = _read(name)
    origins = {key: where for key, _ in _leaves(values)}
    for override in overrides:
        key, text = _split_override(override)
        _check_key(key)
        _assign(values, key, text)
        origins[key] = "set on the command line"
    for key, _ in _leaves(values):
        _check_key(key)
    values.setdefault("name", Path(name).stem)
    try:
        scene = Scene.model_validate(values, context={"units_required": True})
    except ValidationError as error:
        raise InputError(_sentence(error)) from None
    p.check_fit(scene.device, scene.support)
    _check_mesh(scene)
    return scene, origins


def scene_keys() -> list[str]:
    """Return every key that a scene may set."""
    keys = []
    for name, info in Scene.model_fields.items():
        group = info.annotation
        if isinstance(group, type) and issubclass(group, p.Parameters):
            keys += [f"{name}.{inner}" for inner in group.model_fields]
        else:
            keys.append(name)
    return keys


def _read(name: str) -> tuple[dict[str, Any], str]:
    known = built_in_scenes()
    if name in known:
        text = (resources.files("validation") / "scenes" / f"{name}.toml").read_text("utf-8")
        return tomllib.loads(text), f"scene {name}"
    path = Path(name)
    if not path.is_file():
        raise InputError(
            f'scene "{name}" is neither a readable file nor a built-in scene'
            f"{_nearest(name, tuple(known))}; built in are {', '.join(known)}"
        )
    try:
        return tomllib.loads(path.read_text(encoding="utf-8")), f"scene file {path.name}"
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f'scene file "{name}" cannot be read ({_reason(error)}); give a readable TOML file'
        ) from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            f'scene file "{name}" is not valid TOML ({error}); correct that place, or start '
            "from the file that tactgen init writes"
        ) from None


def _reason(error: Exception) -> str:
    return "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else str(error.args[-1])


def _split_override(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals or not key.strip() or not value.strip():
        raise InputError(
            f"--set {text} is not of the form KEY=VALUE; write for example "
            "--set bimorph.length=25mm"
        )
    return key.strip(), value.strip()


def _assign(values: dict[str, Any], key: str, value: str) -> None:
    *groups, last = key.split(".")
    for group in groups:
        values = values.setdefault(group, {})
    values[last] = value


def _leaves(values: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _check_key(key: str) -> None:
    known = scene_keys()
    if key in known:
        return
    group = key.split(".", maxsplit=1)[0]
    inside = [k for k in known if k.startswith(f"{group}.")]
    if "." not in key and inside:
        raise InputError(
            f'scene key "{key}" is a group, not a value; set one of {", ".join(inside)}'
        )
    raise InputError(
        f'scene key "{key}" is unknown{_nearest(key, tuple(known))}; '
        "tactgen init FILE.toml writes a scene with every key"
    )


def _nearest(name: str, known: tuple[str, ...]) -> str:
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    if not close and "." in name:
        tails = {k.rsplit(".", 1)[-1]: k for k in known}
        close = [tails[t] for t in difflib.get_close_matches(name.rsplit(".", 1)[-1], tails, n=1)]
    return f', did you mean "{close[0]}"?' if close else ""


def _sentence(error: ValidationError) -> str:
    """Turn pydantic's first complaint into one sentence."""
    first = error.errors()[0]
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return str(cause)
    key = ".".join(str(part) for part in first["loc"])
    value = first["input"]
    message = str(cause) if cause is not None else _plain(first["msg"])
    shown = f'"{value}"' if isinstance(value, str) else str(value)
    return f"{key} = {shown} {message}"


def _plain(message: str) -> str:
    if message.startswith("Input should be"):
        return "should be" + message.removeprefix("Input should be")
    return f"is refused: {message}"


def _check_mesh(scene: Scene) -> None:
    if scene.mesh.kind == "structured" and scene.support.kind == "rod":
        raise InputError(
            'mesh.kind = "structured" cannot mesh the round rod of support.kind = "rod"; '
            'use mesh.kind = "tetwild" or "auto"'
        )
