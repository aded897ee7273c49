"""The store: what is expensive is computed once, by whichever process needs it first.

A value goes by the hash of what it is computed from: its inputs, the code, the versions of
the numerical libraries.  Nothing here is a reason to fail: what cannot be trusted is computed
anew, what cannot be written is not kept, and each is said once.
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TypeVar

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import NotWritten
from tactgen.geometry.store.claim import claimed, sweep_claims
from tactgen.geometry.store.entry import SUFFIX, Damaged, read_entry, sealed, write_entry
from tactgen.geometry.store.sources import source_digest
from tactgen.geometry.store.values import fingerprint

T = TypeVar("T")

#: Libraries whose other version may give other numbers.
_LIBRARIES = ("numpy", "scipy", "scikit-fem", "pytetwild", "cadquery", "mkl")
#: Ending of claims.
_CLAIM = ".claim"
#: Most bytes in the store if nothing else is said.
_LIMIT = 5_000_000_000
_UNITS = {"B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}
#: Age (s) from which on a draft was left behind by a process that was killed.
_ABANDONED = 3600.0

_said: set[str] = set()


def kept(
    kind: str,
    inputs: tuple[object, ...],
    made_of: tuple[str, ...],
    work: Callable[[], T],
    *,
    serves: Callable[[T], bool] = lambda _: True,
    announce: Callable[[str], None] = lambda _: None,
) -> T:
    """Return what `work` gives, from the store if it is there.

    Parameters
    ----------
    kind : str
        What it is, for people: the store is listed by it.
    inputs : tuple
        All that the value depends on, plain values (:func:`fingerprint`).
    made_of : tuple of str
        Modules and packages that compute it; what they import counts as well.
    work : callable
        Gives a storable value (:mod:`geometry.store.values`).
    serves : callable
        Whether a stored value will do; one that will not is replaced.
    announce : callable
        Told when another process is at it and this one waits.

    Raises
    ------
    LookupError
        If a module named has no source.
    """
    path = _place(kind, inputs, made_of)
    found = _recalled(path, serves)
    if found is not None:
        return found[0]
    with claimed(path.with_suffix(_CLAIM), lambda: announce(f"{kind}: waiting for another run")):
        found = _recalled(path, serves)
        if found is not None:
            return found[0]
        value = work()
        _keep(path, sealed(path.name.removesuffix(SUFFIX), value))
    return value


def recalled(
    kind: str,
    inputs: tuple[object, ...],
    made_of: tuple[str, ...],
    serves: Callable[[T], bool] = lambda _: True,
) -> T | None:
    """Return what :func:`kept` would find in the store, None if it would have to be computed."""
    found = _recalled(_place(kind, inputs, made_of), serves)
    return found[0] if found is not None else None


def is_kept(kind: str, inputs: tuple[object, ...], made_of: tuple[str, ...]) -> bool:
    """Return whether the store has a file for a value, whole or not."""
    return _place(kind, inputs, made_of).is_file()


def _place(kind: str, inputs: tuple[object, ...], made_of: tuple[str, ...]) -> Path:
    """Return the file of a value."""
    folder = store_folder()
    code = source_digest(made_of, folder)
    return folder / f"{kind}-{fingerprint(kind, inputs, code, library_versions())}{SUFFIX}"


def store_folder() -> Path:
    """Return the folder of the store: ``$TACTGEN_CACHE``, or ``~/.cache/tactgen``.

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
    """Return the most bytes that the store may hold: ``$TACTGEN_CACHE_LIMIT``, or 5 GB.

    Raises
    ------
    InputError
        If that is not a size with its unit.
    """
    text = os.environ.get("TACTGEN_CACHE_LIMIT", "").strip()
    if not text:
        return _LIMIT
    found = re.fullmatch(r"([0-9]{1,9}(?:\.[0-9]{1,9})?) *([kMGT]?B)", text)
    if found is None:
        raise InputError(
            f"TACTGEN_CACHE_LIMIT = {text[:40]} is no size; write a number with one of the units "
            f"{', '.join(_UNITS)}, such as 5 GB"
        )
    return int(float(found[1]) * _UNITS[found[2]])


@dataclass(frozen=True)
class Holding:
    """How many entries of a kind the store holds, and their bytes."""

    entries: int
    size: int


def holdings() -> dict[str, Holding]:
    """Return what the store holds, by kind."""
    found: dict[str, Holding] = {}
    for path, state in _entries():
        kind = path.name.rpartition("-")[0] or path.name.removesuffix(SUFFIX)
        last = found.get(kind, Holding(0, 0))
        found[kind] = Holding(last.entries + 1, last.size + state.st_size)
    return dict(sorted(found.items()))


def clear() -> Holding:
    """Remove every entry, and what killed processes left; return how many entries and bytes.

    Work that is in progress may then be done twice.
    """
    entries = _entries()
    for path in (*(path for path, _ in entries), *store_folder().glob(f"*{_CLAIM}")):
        _remove(path)
    _remove_drafts(0.0)
    return Holding(len(entries), sum(state.st_size for _, state in entries))


@cache
def library_versions() -> tuple[str, ...]:
    """Return the versions of the libraries that may give other numbers."""
    installed = _installed()
    return tuple(
        f"{library} {installed[library]}" if library in installed else f"no {library}"
        for library in _LIBRARIES
    )


def _installed() -> dict[str, str]:
    """Return versions of what is installed, by name, the first found on the path.

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
    return found


def _recalled(path: Path, serves: Callable[[T], bool]) -> tuple[T] | None:
    """Return the stored value, None if there is none that can be trusted and will do."""
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


def _keep(path: Path, content: bytes) -> None:
    try:
        limit = size_limit()
        if len(content) > limit:
            _say_once("results larger than TACTGEN_CACHE_LIMIT are not kept for the next run")
            return
        _make_room(limit, len(content), path)
        write_entry(path, content)
    except (OSError, InputError) as error:
        if isinstance(error, NotWritten):
            reason = error.reason
        else:
            reason = getattr(error, "strerror", None) or str(error)
        _say_once(
            f"results are not kept for the next run ({reason}); set TACTGEN_CACHE to a folder that "
            "can be written and has room",
            about="keep",
        )


@dataclass
class _Size:
    """What the store held when it was last looked through, and what was added since."""

    size: int
    writes: int = 0


#: By folder.  To look through ten thousand files for each new one would take longer than most
#: of what is kept.
_sizes: dict[Path, _Size] = {}
#: Writes after which the store is looked through again, for what other processes added.
_WRITES = 200
#: Share of the limit below which the store is far from full.
_FAR = 0.8


def _make_room(limit: int, content: int, new: Path) -> None:
    """Remove what was not used for longest until all takes at most `limit` bytes."""
    last = _sizes.get(new.parent)
    if last is not None and last.writes < _WRITES and last.size + content < _FAR * limit:
        last.size, last.writes = last.size + content, last.writes + 1
        return
    _sizes[new.parent] = _Size(_shrink(limit - content, new) + content)


def _shrink(limit: int, new: Path) -> int:
    """Remove what was not used for longest until the others take at most `limit` bytes.

    Returns the bytes that are left, without those of `new`.
    """
    entries = [entry for entry in _entries() if entry[0] != new]
    size = sum(state.st_size for _, state in entries)
    for path, state in sorted(entries, key=lambda entry: entry[1].st_mtime_ns):
        if size <= limit:
            break
        _remove(path)
        size -= state.st_size
    _remove_drafts(_ABANDONED)
    sweep_claims(store_folder(), _CLAIM)
    return size


def _entries() -> list[tuple[Path, os.stat_result]]:
    found = []
    with contextlib.suppress(OSError):
        for path in store_folder().glob(f"[!.]*{SUFFIX}"):
            with contextlib.suppress(OSError):  # another process may have removed it
                found.append((path, path.stat()))
    return found


def _remove_drafts(age: float) -> None:
    """Remove what a killed process was writing."""
    with contextlib.suppress(OSError):
        for path in store_folder().glob(f".*{SUFFIX}"):
            with contextlib.suppress(OSError):
                if path.stat().st_mtime <= time.time() - age:
                    path.unlink()


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()


def _say_once(text: str, *, about: str = "") -> None:
    if (about or text) not in _said:
        _said.add(about or text)
        with contextlib.suppress(OSError):
            print(f"tactgen: warning: {text}", file=sys.stderr)
