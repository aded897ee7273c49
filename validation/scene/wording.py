"""How refusals speak of names and values: one sentence, on one line, with a remedy."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

from tactgen.geometry.errors import InputError
from tactgen.geometry.names import nearest
from tactgen.geometry.units import OutOfRange, quoted


def one_line(text: str) -> str:
    """Return text without line breaks or other characters that do not print."""
    return "".join(c if c.isprintable() else " " for c in " ".join(text.split()))


def choices(value: Any, known: tuple[str, ...], kind: str, key: str) -> tuple[str, ...]:
    """Return `value` (a name, "a,b" or a list) as known names; ``all`` is every one.

    Raises
    ------
    InputError
        For an unknown name, with the nearest known one or else all, and for anything but names.
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
