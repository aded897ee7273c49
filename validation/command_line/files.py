"""The folder that results go to, checked before any work is done."""

from __future__ import annotations

import tempfile
from pathlib import Path

from geometry.errors import InputError


def writable_folder(path: Path) -> Path:
    """Create a folder if need be and make sure that files can be written there.

    Raises
    ------
    InputError
        If not.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(
            f"output folder {path} cannot be written ({reason}); choose another with --out"
        ) from None
    return path
