"""Scene files and ``KEY=VALUE`` overrides as plain nested values, and the words of refusals."""

from __future__ import annotations

import copy
import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tactgen.geometry.device.laminate import is_size
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import read_text
from tactgen.geometry.synonyms import nearest
from tactgen.geometry.units import FREQUENCY, OutOfRange, quoted

#: Longest name that a scene may have.
LONGEST_NAME = 100
#: Conditions of ``start_from = "neutral"``.
NEUTRAL = {
    "support.kind": "clamped",
    "load.kind": "none",
    "bimorph.wiring": "parallel",
    "drive.voltage": "1 V",
}
#: Conditions of the normal actuator.
OF_THE_COIL = ("gap", "coil.current")
#: Most names that a refusal lists.
_LISTED = 20
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
    path, listed = Path(name), f"built in are {', '.join(known)}"
    if not (name and _is_there(path)):
        raise InputError(
            f"scene {quoted(name)} is neither a readable file nor a built-in scene"
            f"{nearest(name, known)}; {listed}"
        )
    if path.is_dir():
        raise InputError(f"scene {quoted(name)} is a folder; name a scene file in it; {listed}")
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


def scene_name(text: str) -> str:
    """Text such as a file's name as a scene's name: printable and not too long."""
    return "".join(c if c.isprintable() else "?" for c in text)[:LONGEST_NAME]


def split_override(text: str) -> tuple[str, str]:
    """Key and value of ``KEY=VALUE``.

    Raises InputError if one of them is missing.
    """
    key, _, value = text.partition("=")
    if not key.strip() or not value.strip():
        raise InputError(
            f"--set {quoted(text)} is not of the form KEY=VALUE; write for example "
            "--set bimorph.length=25mm, or --set bimorph.width_profile=uniform"
        )
    return key.strip(), value.strip()


def assign(values: dict[str, Any], key: str, value: Any) -> None:
    """Set the value of a dotted key in nested values: of a group's parameter inside the group."""
    group, _, name = key.partition(".")
    if name:
        values.setdefault(group, {})[name] = value
    else:
        values[key] = value


def leaves(values: dict[str, Any], prefix: str = "", depth: int = 1) -> Iterator[tuple[str, Any]]:
    """Yield every dotted key with its value; an empty table inside counts as a value.

    So does one deeper than any scene's: a file may nest them by the thousand.
    """
    for key, value in values.items():
        name = f'{prefix}"{key}"' if "." in key and not is_size(key) else f"{prefix}{key}"
        if isinstance(value, dict) and value and depth < _DEEPEST:
            yield from leaves(value, f"{name}.", depth + 1)
        else:
            yield name, value


def with_start(values: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Scene's values with the conditions of its start, and the keys that it does not state."""
    stated = {key for key, _ in leaves(dict(values))}
    missing = tuple(key for key in (*NEUTRAL, *OF_THE_COIL) if key not in stated)
    complete = copy.deepcopy(dict(values))
    if values.get("start_from") == "neutral":
        for key in NEUTRAL.keys() & set(missing):
            if isinstance(complete.get(key.partition(".")[0], {}), dict):
                assign(complete, key, NEUTRAL[key])
    return complete, missing


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
    if len(known) > _LISTED:
        listed = "tactgen solve --help lists all"
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


#: Largest sweep that one request may ask for.
_MOST = 1_000_000
#: Highest frequency that can be meant (Hz).
_HIGHEST = FREQUENCY.limits[1] if FREQUENCY.limits else math.inf
_REMEDY = 'write for example "500", "0.5 kHz" or "10:2000:200"'


def parse_frequencies(given: Any, stated: str = "") -> tuple[float, ...]:
    """Frequencies in Hz from whatever a scene or a caller states; bare numbers are Hz.

    Parameters
    ----------
    given : number, str, or list of numbers and str
        Text is ``LIST`` or ``START:STOP:N[:log]``; in a list each stands for one frequency.
    stated : str
        How messages repeat what was written, if not as the key ``frequency``.

    Raises InputError if a number, the count or the spacing cannot be used.
    """
    stated = stated or f"frequency = {quoted(given)}"
    if isinstance(given, str) and ":" in given:
        return _sweep(given, stated)
    parts = given.split(",") if isinstance(given, str) else given
    if not isinstance(parts, list | tuple):
        parts = [parts]
    if not parts or parts == [""]:
        raise InputError(f"{stated} holds no frequency; {_REMEDY}")
    if len(parts) > _MOST:
        raise InputError(f"frequency has {len(parts)} values; give at most {_MOST}")
    return tuple(_one(part, stated) for part in parts)


def _sweep(text: str, stated: str) -> tuple[float, ...]:
    first, last, *rest = (part.strip() for part in text.split(":"))
    if len(rest) not in (1, 2) or rest[1:] not in ([], ["log"], ["lin"]):
        raise InputError(
            f'{stated} is not START:STOP:N or START:STOP:N:log; write for example "10:2000:200"'
        )
    start, stop, logarithmic = _one(first, stated), _one(last, stated), rest[1:] == ["log"]
    count = int(rest[0]) if re.fullmatch(r"\d{1,9}", rest[0], re.ASCII) else 0
    if not 1 <= count <= _MOST:
        raise InputError(
            f"{stated} asks for {quoted(rest[0])} points; give a whole number from 1 to {_MOST}"
        )
    if logarithmic and (start <= 0.0 or stop <= 0.0):
        raise InputError(
            f"{stated} cannot be spaced logarithmically from {start:g} Hz to "
            f"{stop:g} Hz; keep both above 0 Hz"
        )
    if count == 1:
        if start != stop:
            raise InputError(
                f"{stated} asks for 1 point between two ends; write one frequency, such as "
                f'"{start:g}", or at least 2 points'
            )
        return (start,)
    if logarithmic:
        ratio = math.log(stop / start) / (count - 1)
        inner = [start * math.exp(ratio * i) for i in range(1, count - 1)]
    else:
        step = (stop - start) / (count - 1)
        inner = [start + step * i for i in range(1, count - 1)]
    return (start, *inner, stop)


def _one(part: Any, stated: str) -> float:
    """One frequency."""
    try:
        if isinstance(part, int | float) and not isinstance(part, bool):
            value = float(part)
        else:
            # "mHz" is not meant as a thousandth of a hertz
            text = part.strip(" \t").replace("hz", "Hz")
            value = math.nan if text.endswith("mHz") else FREQUENCY.parse(text, bare=True)
    except OverflowError:
        value = math.inf
    except (ValueError, AttributeError):
        raise InputError(
            f"{stated} has {quoted(part)}, which is not a frequency; {_REMEDY}"
        ) from None
    if not 0.0 <= value <= _HIGHEST:
        raise InputError(
            f"{stated} has {quoted(part)}; frequencies must be finite, not negative and at most "
            f"{_HIGHEST * 1e-6:g} MHz; {_REMEDY}"
        )
    return value
