"""Files that appear whole or not at all, and the folders that they go to.

A reader never meets half a file, not even after a power cut: the writer fills a temporary one
in the same folder, which is brought to the disk and then takes the final name in one step.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactgen.geometry.errors import InputError


@contextmanager
def written_whole(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path to write to; on success it becomes `path`.

    The temporary file has the same suffix, since writers choose the format by it.

    Raises
    ------
    InputError
        If the folder does not exist or cannot be written.
    """
    path = Path(path)
    try:
        handle, name = tempfile.mkstemp(suffix=path.suffix, prefix=".", dir=path.parent)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"{path} cannot be written ({reason.lower()}); choose a folder that exists and is yours"
        ) from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o644)  # mkstemp makes files for its owner only
        _bring_to_disk(temporary)
        temporary.replace(path)
        _bring_to_disk(path.parent)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{path} cannot be written ({reason.lower()}); choose another") from error
    finally:
        temporary.unlink(missing_ok=True)


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


def write_text(path: Path, text: str) -> Path:
    """Write a text file whole or not at all, and return its path; refusals as above."""
    with written_whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def _bring_to_disk(path: Path) -> None:
    """Wait until what a file or folder holds is on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
