"""Store of expensive results, each computed once by one of all processes.

A value goes by the hash of what it is computed from: its inputs, the code, the versions of the
numerical libraries.  Each is a file with a checksum, written whole; a locked file keeps two
processes from the same work.  Nothing here is a reason to fail: what cannot be trusted is computed
anew, what cannot be written is not kept, and each is said once.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import NotWritten, special, written_whole
from tactgen.geometry.operating_system import READ, lock, unlock
from tactgen.geometry.store.values import fingerprint, from_bytes, source_digest, to_bytes

T = TypeVar("T")

#: First bytes of every file: what it is, and the version of the format.
MAGIC = b"tactgen kept 1\n"
_CHECKSUM = hashlib.sha256().digest_size
#: Endings of entries and of locks.
SUFFIX, LOCK = ".kept", ".claim"
#: Libraries whose other version may give other numbers.
_LIBRARIES = ("numpy", "scipy", "scikit-fem", "pytetwild", "cadquery", "mkl")
#: Most bytes in the store if nothing else is said.
_LIMIT = 5_000_000_000
#: Environment variable with another limit.
LIMIT = "TACTGEN_CACHE_LIMIT"
_UNITS = {"B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}

_said: set[str] = set()


class Damaged(Exception):
    """Damaged file of the store, with the reason."""


# ---- values by what they are computed from ----


def cached_result(
    kind: str,
    inputs: tuple[object, ...],
    made_of: tuple[str, ...],
    work: Callable[[], T],
    *,
    serves: Callable[[T], bool] = lambda _: True,
    announce: Callable[[str], None] = lambda _: None,
) -> T:
    """Result of `work`, a storable value (:mod:`geometry.store.values`), cached in the store.

    `kind` says for people what it is: the store is listed by it.  It goes by all `inputs` that it
    depends on, plain values (:func:`fingerprint`), and by the modules and packages that it is
    `made_of`, with all that they import.  A stored value that does not serve is replaced; when
    another process is at it and this one waits, that is announced.

    Raises LookupError if a module named has no source.
    """
    path = _place(kind, inputs, made_of)
    found = _recalled(path, serves)
    if found is None:
        with locked(path.with_suffix(LOCK), lambda: announce(f"{kind}: waiting for another run")):
            found = _recalled(path, serves)
            if found is None:
                found = (work(),)
                _keep(path, found[0])
    return found[0]


def stored_result(
    kind: str,
    inputs: tuple[object, ...],
    made_of: tuple[str, ...],
    serves: Callable[[T], bool] = lambda _: True,
) -> T | None:
    """Cached result of :func:`cached_result`, or None."""
    found = _recalled(_place(kind, inputs, made_of), serves)
    return found[0] if found is not None else None


def is_cached(kind: str, inputs: tuple[object, ...], made_of: tuple[str, ...]) -> bool:
    """Whether the store has a file for a value, whole or not."""
    return _place(kind, inputs, made_of).is_file()


def _place(kind: str, inputs: tuple[object, ...], made_of: tuple[str, ...]) -> Path:
    """File of a value."""
    digest = fingerprint(kind, inputs, source_digest(made_of), library_versions())
    return store_folder() / f"{kind}-{digest}{SUFFIX}"


def _recalled(path: Path, serves: Callable[[T], bool]) -> tuple[T] | None:
    """Stored value, None if there is none that can be trusted and will do."""
    try:
        value: T = read_entry(path)
    except FileNotFoundError:
        return None
    except Damaged as error:
        _say_once(f"{path} is not used ({error}): what was stored there is computed again")
        return None
    if not serves(value):
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # the time of the last use
    return (value,)


def _keep(path: Path, value: object) -> None:
    content = sealed(path, value)
    try:
        limit = size_limit()
        if len(content) > limit:
            _say_once("results larger than TACTGEN_CACHE_LIMIT are not kept for the next run")
            return
        _make_room(limit, len(content), path)
        write_entry(path, content)
    except (OSError, InputError) as error:
        own = error.reason if isinstance(error, NotWritten) else getattr(error, "strerror", None)
        reason = own or str(error)
        _say_once(
            f"results are not kept for the next run ({reason}); set TACTGEN_CACHE to a folder that "
            "can be written and has room",
            about="keep",
        )


def _say_once(text: str, *, about: str = "") -> None:
    if (about or text) not in _said:
        _said.add(about or text)
        with contextlib.suppress(OSError):
            print(f"tactgen: warning: {text}", file=sys.stderr)


@cache
def library_versions() -> tuple[str, ...]:
    """Versions of the libraries that may give other numbers.

    Read off the folders ``name-version.dist-info`` of the PyPA's specification "Recording installed
    projects": to load importlib.metadata and parse what is in them takes 30 ms of each command.
    """
    found: dict[str, str] = {}
    for place in sys.path:
        with contextlib.suppress(OSError):
            for entry in Path(place).glob("*.dist-info"):
                name, _, version = entry.stem.partition("-")
                if version:
                    found.setdefault(re.sub("[-_.]+", "-", name).lower(), version)
    return tuple(f"{n} {found[n]}" if n in found else f"no {n}" for n in _LIBRARIES)


# ---- files ----


def sealed(path: Path, value: object) -> bytes:
    """Content of a file: format, checksum, name and value."""
    content = to_bytes((path.name.removesuffix(SUFFIX), value))
    return MAGIC + hashlib.sha256(content).digest() + content


def write_entry(path: Path, content: bytes) -> None:
    """Write a sealed content, whole or not at all.

    Raises InputError, OSError if it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    if special(path) and not path.is_dir():  # a pipe under a name of ours is nobody's
        path.unlink()
    with written_whole(path) as draft:
        draft.write_bytes(content)


def read_entry(path: Path) -> Any:
    """Value of a file, whose name without suffix is also written in it.

    Raises FileNotFoundError if there is none, Damaged if it cannot be read or is not what was
    written under this name.
    """
    try:
        descriptor = os.open(path, READ)
        with os.fdopen(descriptor, "rb") as file:
            content = file.read()
    except (FileNotFoundError, NotADirectoryError):
        raise FileNotFoundError(path) from None
    except OSError as error:
        raise Damaged((error.strerror or str(error)).lower()) from error
    if not content.startswith(MAGIC):
        raise Damaged("no file of this version of the store")
    checksum, rest = content[len(MAGIC) :][:_CHECKSUM], content[len(MAGIC) + _CHECKSUM :]
    if hashlib.sha256(rest).digest() != checksum:
        raise Damaged("its checksum is another")
    try:
        name, value = from_bytes(rest)
    except (ValueError, TypeError) as error:
        raise Damaged(f"not what is stored here: {error}") from error
    if name != path.name.removesuffix(SUFFIX):
        raise Damaged("written under another name")
    return value


# ---- locks ----


@contextlib.contextmanager
def locked(path: Path, waiting: Callable[[], None]) -> Iterator[None]:
    """Hold the lock `path`, against threads as well; if another has it, call `waiting` and wait.

    The system takes a lock away from a process that dies, however it dies.  Where no file can be
    made or locked, there is none: work done twice is no harm.
    """
    descriptor = None
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = _acquire(path, waiting)
    try:
        yield
    finally:
        if descriptor is not None:
            with contextlib.suppress(OSError):
                path.unlink()
            # a child that was forked meanwhile shares the lock: closing alone would not end it
            unlock(descriptor)
            os.close(descriptor)


def _acquire(path: Path, waiting: Callable[[], None]) -> int:
    """Descriptor of the locked file."""
    said = False
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            if not lock(descriptor, wait=False):
                if not said:
                    waiting()
                    said = True
                lock(descriptor, wait=True)
            # who had it before may have taken the file away
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), path.stat()):
                    return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


# ---- the folder ----


def store_folder() -> Path:
    """Folder of the store: ``$TACTGEN_CACHE``, or ``~/.cache/tactgen``.

    Without a home it is a place where no folder can be made, so that nothing is kept.
    """
    chosen = os.environ.get("TACTGEN_CACHE")
    if chosen:
        return Path(chosen)
    home = Path(os.devnull)
    with contextlib.suppress(RuntimeError):  # a user that the system does not know
        found = Path.home()
        home = found if found.is_absolute() else home  # HOME= is not where the command runs
    return home / ".cache" / "tactgen"


def size_limit() -> int:
    """Most bytes that the store may hold: ``$TACTGEN_CACHE_LIMIT``, or 5 GB.

    Raises InputError if that is not a size with its unit.
    """
    text = os.environ.get(LIMIT, "").strip()
    if not text:
        return _LIMIT
    found = re.fullmatch(r"([0-9]{1,9}(?:\.[0-9]{1,9})?) *([kMGT]?B)", text)
    if found is None:
        raise InputError(
            f"TACTGEN_CACHE_LIMIT = {text[:40]} is not a size; write a number with one of the "
            f"units {', '.join(_UNITS)}, such as 5 GB"
        )
    return int(float(found[1]) * _UNITS[found[2]])


class Holding(NamedTuple):
    """Number and bytes of stored entries of a kind."""

    entries: int
    size: int


def holdings() -> dict[str, Holding]:
    """Contents of the store by kind."""
    found: dict[str, Holding] = {}
    for path, state in _entries():
        kind = path.name.rpartition("-")[0] or path.name.removesuffix(SUFFIX)
        last = found.get(kind, Holding(0, 0))
        found[kind] = Holding(last.entries + 1, last.size + state.st_size)
    return dict(sorted(found.items()))


def clear() -> Holding:
    """Remove every entry and leftover; return the number of entries and bytes.

    Work that is in progress may then be done twice.
    """
    entries, folder = _entries(), store_folder()
    left = (path for ending in (f".*{SUFFIX}", f"*{LOCK}") for path in folder.glob(ending))
    for path in (*(path for path, _ in entries), *left):
        _remove(path)
    return Holding(len(entries), sum(state.st_size for _, state in entries))


#: Bytes of each folder when it was last looked through and writes since: to look through ten
#: thousand files for each new one would take longer than most of what is kept.
_sizes: dict[Path, tuple[int, int]] = {}
#: Writes after which the store is looked through again, for what other processes added.
_WRITES = 200
#: Share of the limit below which the store is far from full.
_FAR = 0.8


def _make_room(limit: int, content: int, new: Path) -> None:
    """Remove the least recently used entries down to `limit` bytes."""
    size, writes = _sizes.get(new.parent, (0, _WRITES))
    if writes >= _WRITES or size + content >= _FAR * limit:
        entries = [entry for entry in _entries() if entry[0] != new]
        size, writes = sum(state.st_size for _, state in entries), 0
        for path, state in sorted(entries, key=lambda entry: entry[1].st_mtime_ns):
            if size + content <= limit:
                break
            _remove(path)
            size -= state.st_size
    _sizes[new.parent] = size + content, writes + 1


def _entries() -> list[tuple[Path, os.stat_result]]:
    found = []
    with contextlib.suppress(OSError):
        for path in store_folder().glob(f"[!.]*{SUFFIX}"):
            with contextlib.suppress(OSError):  # another process may have removed it
                found.append((path, path.stat()))
    return found


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()
