"""Standard streams that take what is written: closed ones, and those of few characters."""

from __future__ import annotations

import codecs
import contextlib
import io
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tactgen.geometry.errors import InputError

#: What stands for characters of ours where a stream has only those of ASCII or Latin-1.
_PLAIN = {
    "µ": "u", "μ": "u", "∠": "phase ", "°": " deg", "±": "+/-", "×": "x", "·": "*", "…": "...",
    "–": "-", "—": "-", "−": "-", "²": "^2", "³": "^3", "Ω": "ohm", "ψ": "psi", "τ": "tau",
    "√": "sqrt", "→": "->", "≥": ">=", "≤": "<=", "“": '"', "”": '"', "’": "'",
}  # fmt: skip
_NAME = "tactgen.plain"


def say(text: str) -> None:
    """Print one line to stderr, if that can be written."""
    from tactgen.validation.scene.files import one_line

    with contextlib.suppress(OSError):
        print(f"tactgen: {one_line(text)}", file=sys.stderr)


def print_json(value: Any) -> None:
    """Print a record in one line, alone on standard output."""
    import json

    from tactgen.validation.engine.answers import plain

    print(json.dumps(plain(value), allow_nan=False))


def name_files(paths: Iterable[Path]) -> None:
    """Print where files were written, to stderr: standard output holds what was asked for."""
    for path in paths:
        print(path, file=sys.stderr)


def drop_output() -> None:
    """Send what is left of stdout nowhere, so that Python does not complain at exit."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def usable_streams() -> None:
    """Let both streams be there and take every character.

    Raises InputError if standard output is closed.
    """
    if sys.stderr is None:  # closed: words and progress go nowhere, not to stdout
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    if sys.stdout is None:
        raise InputError("standard output is closed; leave it open or send it to a file")
    codecs.register_error(_NAME, _plainly)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            with contextlib.suppress(OSError, ValueError):
                stream.reconfigure(errors=_NAME)


def _plainly(error: UnicodeError) -> tuple[str, int]:
    """Plain text for what a stream cannot encode, and where to go on."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    refused = error.object[error.start : error.end]
    plain = "".join(_PLAIN.get(c, c.encode("ascii", "backslashreplace").decode()) for c in refused)
    return plain, error.end
