"""Files that appear whole or not at all, and the folders that they go to.

A reader never meets half a file, not even after a power cut: the writer fills a temporary one
in the same folder, which is brought to the disk and then takes the final name in one step.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactgen.geometry.errors import InputError
from tactgen.geometry.operating_system import READ, bring_to_disk, is_running

#: Largest text file that is read (bytes): a hundred thousand rows of ten columns.
_MOST_TEXT = 20_000_000


class NotWritten(InputError):
    """A file that cannot be written, in one sentence; `reason` is why, in a few words of it."""

    def __init__(
        self,
        path: str | Path,
        reason: str,
        remedy: str = "make room there or choose another folder",
    ) -> None:
        super().__init__(f"{path} cannot be written ({reason}); {remedy}")
        self.reason = reason


def read_text(path: str | Path) -> str:
    """Text file's content, UTF-8 with or without a byte order mark.

    Pipes and devices are not read: they may have no end, or nobody at the other one.

    Raises OSError if it cannot be read, is no regular file, or is larger than any table,
    UnicodeDecodeError if it is not UTF-8.
    """
    descriptor = os.open(path, READ)
    try:
        obstacle = _no_file(os.fstat(descriptor).st_mode)
        if obstacle:
            raise OSError(None, obstacle)
        with os.fdopen(descriptor, "rb", closefd=False) as file:
            content = file.read(_MOST_TEXT + 1)
    finally:
        os.close(descriptor)
    if len(content) > _MOST_TEXT:
        raise OSError(None, f"it is larger than {_MOST_TEXT // 10**6} MB")
    return content.decode("utf-8-sig")


def special(path: Path) -> str:
    """Kind of a path that no file may replace, such as a device; "" if none."""
    try:
        return _no_file(path.stat().st_mode)
    except (OSError, ValueError):
        return ""


def _no_file(mode: int) -> str:
    """Name of the kind of something that is no regular file."""
    if stat.S_ISDIR(mode):
        return "it is a folder"
    return "" if stat.S_ISREG(mode) else "it is a pipe or a device, not a file"


@contextmanager
def written_whole(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path to write to; on success it becomes `path`.

    The temporary file has the same suffix, since writers choose the format by it.

    Raises NotWritten if the folder does not exist, is full or cannot be written, or the name is
    that of a folder, pipe or device.
    """
    path = Path(path)
    obstacle = special(path)
    if obstacle:
        raise NotWritten(path, obstacle, "choose another name")
    _sweep_drafts(path.parent)
    try:
        prefix = f"{_own_prefix()}{os.getpid()}-"
        handle, name = tempfile.mkstemp(suffix=path.suffix, prefix=prefix, dir=path.parent)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise NotWritten(path, reason, "choose a folder that exists and is yours") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o644)  # mkstemp makes files for its owner only
        bring_to_disk(temporary)
        temporary.replace(path)
        bring_to_disk(path.parent)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise NotWritten(path, reason) from error
    finally:
        temporary.unlink(missing_ok=True)


def _own_prefix() -> str:
    """Prefix of this machine's draft files."""
    return f".tactgen-{hashlib.sha256(platform.node().encode()).hexdigest()[:8]}-"


def _sweep_drafts(folder: Path) -> None:
    """Remove half-written files of killed processes."""
    prefix = _own_prefix()
    with contextlib.suppress(OSError):
        for left in folder.glob(f"{prefix}*"):
            number = left.name.removeprefix(prefix).partition("-")[0]
            if number.isdecimal() and not is_running(int(number)):
                with contextlib.suppress(OSError):
                    left.unlink()


def writable_folder(path: Path) -> Path:
    """Create a folder if need be and make sure that files can be written there.

    Raises InputError if not.
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
