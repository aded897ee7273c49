"""The list of checksums beside a report, as ``sha256sum --check`` reads it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import read_text, write_text

#: Name of the list.
FILE = "SHA256SUMS"


def checksum(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_checksums(folder: Path, names: tuple[str, ...]) -> Path:
    """Write the list of these files of a folder."""
    lines = [f"{checksum(folder / name)}  {name}\n" for name in names]
    return write_text(folder / FILE, "".join(lines))


def check(folder: Path) -> None:
    """Make sure that every file of a folder's list is what was written.

    Raises
    ------
    InputError
        If there is no list, or a file is missing or was altered.
    """
    path = folder / FILE
    try:
        lines = read_text(path).splitlines()
    except (OSError, ValueError):
        raise InputError(
            f"{folder} has no list of checksums ({FILE}), so nothing in it can be trusted; name a "
            "folder that tactgen report has written whole"
        ) from None
    listed = [line.partition("  ") for line in lines]
    if not listed or not all(len(digest) == 64 and name for digest, _, name in listed):
        raise InputError(f"{path} is no list of checksums; write the report again")
    for digest, _, name in listed:
        try:
            same = checksum(folder / Path(name).name) == digest
        except OSError:
            raise InputError(
                f"{folder / name} is missing, though {FILE} lists it; write the report again"
            ) from None
        if not same:
            raise InputError(
                f"{folder / name} was altered after the report was written (its SHA-256 is not "
                f"that of {FILE}); take the original, or write the report again"
            )
