"""Where files are to go: what would fail only after minutes of work is refused first."""

from __future__ import annotations

import os
from pathlib import Path

from tactgen.geometry.errors import InputError


def check_place(option: str, path: Path, suffixes: tuple[str, ...]) -> None:
    """Refuse a file with another ending, or in a place that cannot be written.

    Raises
    ------
    InputError
        With the option and the remedy.
    """
    if path.suffix not in suffixes:
        raise InputError(f"{option} {path} must end in {' or '.join(suffixes)}; name the file so")
    reason = _obstacle(path)
    if reason:
        raise InputError(f"{option} {path} cannot be written ({reason}); choose another place")


def _obstacle(path: Path) -> str:
    try:
        if path.is_dir():
            return "it is a folder"
        if not path.parent.is_dir():
            return "its folder does not exist"
    except OSError as error:  # such as a name that is too long
        return (error.strerror or str(error)).lower()
    return "" if os.access(path.parent, os.W_OK | os.X_OK) else "its folder is read-only"
