"""Files of the store: a value under its name, with a checksum over all of it.

A file is what was written, or it is :class:`Damaged`; there is nothing between.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

from tactgen.geometry.files import special, written_whole
from tactgen.geometry.store.values import from_bytes, to_bytes

#: First bytes of every file: what it is, and the version of the format.
MAGIC = b"tactgen kept 1\n"
#: Ending of every file.
SUFFIX = ".kept"
_CHECKSUM = hashlib.sha256().digest_size


class Damaged(Exception):
    """A file that is not what was written under its name; says why."""


def write_entry(path: Path, content: bytes) -> None:
    """Write what :func:`sealed` gave, whole or not at all.

    Raises
    ------
    InputError, OSError
        If it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    if special(path) and not path.is_dir():  # a pipe under a name of ours is nobody's
        path.unlink()
    with written_whole(path) as draft:
        draft.write_bytes(content)


def sealed(name: str, value: object) -> bytes:
    """Return a file's content: what it is, the checksum of the rest, name and value."""
    content = to_bytes((name, value))
    return MAGIC + hashlib.sha256(content).digest() + content


def read_entry(path: Path) -> Any:
    """Return the value of a file, whose name without suffix is also written in it.

    Raises
    ------
    FileNotFoundError
        If there is none.
    Damaged
        If it cannot be read or is not what was written under this name.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe would wait for a writer
        with os.fdopen(descriptor, "rb") as file:
            content = file.read()
    except (FileNotFoundError, NotADirectoryError):
        raise FileNotFoundError(path) from None
    except OSError as error:
        raise Damaged((error.strerror or str(error)).lower()) from error
    head, rest = content[: len(MAGIC)], content[len(MAGIC) :]
    if head != MAGIC:
        raise Damaged("no file of this version of the store")
    if hashlib.sha256(rest[_CHECKSUM:]).digest() != rest[:_CHECKSUM]:
        raise Damaged("its checksum is another")
    try:
        name, value = from_bytes(rest[_CHECKSUM:])
    except (ValueError, TypeError) as error:
        raise Damaged(f"not what is stored here: {error}") from error
    if name != path.name.removesuffix(SUFFIX):
        raise Damaged("written under another name")
    return value
