"""Scene files and ``KEY=VALUE`` overrides as plain nested values, and the words of refusals."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import read_text
from tactgen.geometry.names import nearest
from tactgen.geometry.units import OutOfRange, quoted

#: Longest name that a scene may have.
_LONGEST_NAME = 100
#: Parts of a dotted key beyond which none is looked at: a scene's have two.
_DEEPEST = 4


@cache
def built_in_texts() -> dict[str, str]:
    """Names of the built-in scenes with their files' texts."""
    folder = resources.files("tactgen.validation.scene") / "scenes"
    return {
        entry.name.removesuffix(".toml"): entry.read_text(encoding="utf-8")
        for entry in sorted(folder.iterdir(), key=lambda e: e.name)
        if entry.name.endswith(".toml")
    }


def built_in_scenes() -> dict[str, str]:
    """Names of the built-in scenes with their descriptions."""
    texts = built_in_texts().items()
    return {name: str(tomllib.loads(text).get("description", "")) for name, text in texts}


def read_scene(name: str) -> tuple[dict[str, Any], str]:
    """Values of a file or built-in scene, and words for where they come from.

    Raises InputError if there is no such scene or it is not TOML.
    """
    known = built_in_texts()
    if name in known:
        return tomllib.loads(known[name]), f"scene {name}"
    path = Path(name)
    if name and _is_there(path) and path.is_dir():
        raise InputError(
            f"scene {quoted(name)} is a folder; name a scene file in it, for example "
            f"{quoted(str(path / 'mine.toml'))}, or a built-in scene: {', '.join(known)}"
        )
    if not (name and _is_there(path)):
        raise InputError(
            f"scene {quoted(name)} is neither a readable file nor a built-in scene"
            f"{nearest(name, known)}; built in are {', '.join(known)}"
        )
    try:
        return tomllib.loads(read_text(path)), f"scene file {scene_name(path.name)}"
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise InputError(
            f"scene file {quoted(name)} cannot be read ({reason}); give a readable TOML file"
        ) from None
    except (ValueError, RecursionError) as error:
        # besides its own error, tomllib lets those of too long numbers and too deep lists pass
        reason = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError(
            f"scene file {quoted(name)} is not valid TOML ({reason}); correct that place, or "
            "start from the file that tactgen init writes"
        ) from None


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # a name too long, or with a zero byte
        return False


def beside_scene(name: str, file: str) -> str:
    """Path of a file that a scene file names: relative to the scene, not to here."""
    return str(Path(name).parent / file)


def scene_name(text: str) -> str:
    """Text such as a file's name as a scene's name: printable and not too long."""
    return "".join(c if c.isprintable() else "?" for c in text)[:_LONGEST_NAME]


def checked_name(value: Any) -> Any:
    """Refuse a scene's name that is more than one short line.

    Raises InputError with the remedy.
    """
    if isinstance(value, str) and scene_name(value) != value:
        raise InputError(
            f"name = {quoted(value)} is not one line of at most {_LONGEST_NAME} printable "
            "characters; shorten it, and use description for more"
        )
    return value


def split_override(text: str) -> tuple[str, str]:
    """Key and value of ``KEY=VALUE``.

    Raises InputError if one of them is missing.
    """
    key, equals, value = text.partition("=")
    if not equals or not key.strip() or not value.strip():
        unset = (
            f"; to take the profile away write --set {key.strip()}=uniform"
            if equals and key.strip().endswith("_profile")
            else ""
        )
        raise InputError(
            f"--set {quoted(text)} is not of the form KEY=VALUE; write for example "
            f"--set bimorph.length=25mm{unset}"
        )
    return key.strip(), value.strip()


def assign(values: dict[str, Any], key: str, value: Any) -> None:
    """Set the value of a dotted key in nested values."""
    *groups, last = key.split(".")
    for group in groups:
        values = values.setdefault(group, {})
    values[last] = value


def leaves(values: dict[str, Any], prefix: str = "", depth: int = 1) -> Iterator[tuple[str, Any]]:
    """Yield every dotted key with its value; an empty table inside counts as a value.

    So does one deeper than any scene's: a file may nest them by the thousand.
    """
    for key, value in values.items():
        name = f'{prefix}"{key}"' if "." in key else f"{prefix}{key}"
        if isinstance(value, dict) and value and depth < _DEEPEST:
            yield from leaves(value, f"{name}.", depth + 1)
        else:
            yield name, value


def one_line(text: str) -> str:
    """Text without line breaks or other characters that do not print."""
    return "".join(c if c.isprintable() else " " for c in " ".join(text.split()))


def choices(value: Any, known: tuple[str, ...], kind: str, key: str) -> tuple[str, ...]:
    """`value` (a name, "a,b" or a list) as known names; ``all`` is every one.

    Raises InputError for an unknown name, with the nearest known one or else all, and for anything
    but names.
    """
    names = [v.strip() for v in value.split(",")] if isinstance(value, str) else value
    listed = f"known are {', '.join(known)}"
    if not isinstance(names, list | tuple) or not all(isinstance(n, str) for n in names):
        raise InputError(
            f'{key} = {quoted(value)} is not a list of names; write for example ["{known[0]}"] '
            'or "all"'
        )
    if not names or names == [""]:
        raise InputError(f"{key} = {quoted(value)} names nothing; {listed}, or write all")
    for name in names:
        if name not in known and name != "all":
            raise InputError(
                f"{kind} {quoted(name)} is unknown{nearest(name, known) or f'; {listed}'}"
            )
    return known if "all" in names else tuple(dict.fromkeys(names))


def sentence(error: ValidationError) -> str:
    """Turn pydantic's first complaint into one sentence."""
    first = error.errors()[0]
    context = first.get("ctx", {})
    cause = context.get("error")
    if isinstance(cause, InputError):
        return one_line(str(cause))
    key, value = ".".join(str(part) for part in first["loc"]), first["input"]
    if cause is not None:
        message = str(cause)
    elif first["type"] == "literal_error":
        names = str(context["expected"])
        known = [name.strip("'") for name in names.replace(" or ", ", ").split(", ")]
        message = f"is not a valid choice{nearest(str(value), known)}; write {names}"
    elif first["type"] == "string_type":
        message = f'is not text; write it in quotes, for example {key} = "text"'
    else:
        message = f"cannot be used ({first['msg']}); see the file that tactgen init writes"
    shown = cause.shown if isinstance(cause, OutOfRange) else quoted(value)
    return one_line(f"{key} = {shown} {message}")
