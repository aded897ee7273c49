"""Which code a stored number was made by: modules and all that they import from this project.

Found in the sources, which are read and never imported.  Imports inside functions count;
those for type checking only do not.  What is loaded by its name in a string must be named.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import importlib.util
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.entry import SUFFIX, Damaged, read_entry, sealed, write_entry

#: The project's packages, and the package that holds them, if any.
_PACKAGES = frozenset({"geometry", "tmm", "fem", "validation"})
_HOLDER = __name__.removesuffix("geometry.store.sources")
#: File in which hashes and imports of the sources are kept, since parsing takes a second.
_INDEX = "sources" + SUFFIX
#: Hashes that this process found, by the names.
_digests: dict[tuple[str, ...], str] = {}


@dataclass
class Sources:
    """The project's sources, each read once as long as time and size of its file are the same.

    Attributes
    ----------
    folder : Path
        Where hashes and imports are kept between runs.
    known : dict
        By file: its time and size, and (hash, names imported).
    seen : dict
        By file what is known of it, once it is sure to be what the file says now.
    """

    folder: Path
    known: dict[str, tuple[tuple[int, int], tuple[str, tuple[str, ...]]]] = field(
        default_factory=dict
    )
    seen: dict[Path, tuple[str, tuple[str, ...]]] = field(default_factory=dict)

    def digest(self, names: Iterable[str]) -> str:
        """Return a hash of the named modules and packages with all that they import.

        Raises
        ------
        LookupError
            If a name has no source: a hash of nothing would call everything up to date.
        """
        if not self.seen:
            with contextlib.suppress(FileNotFoundError, Damaged):
                self.known = read_entry(self.folder / _INDEX)
        before = dict(self.known)
        found: dict[Path, str] = {}
        open_ends = [f for name in names for f in (*_imported(name), *_files_of(name))]
        while open_ends:
            file = open_ends.pop()
            if file not in found:
                found[file], imports = self._read(file)
                open_ends += [f for name in imports for f in _imported(name)]
        if self.known != before:
            with contextlib.suppress(InputError, OSError):
                write_entry(self.folder / _INDEX, sealed("sources", self.known))
        # the place does not matter, what is in the files does
        return hashlib.sha256("".join(sorted(found.values())).encode()).hexdigest()

    def _read(self, file: Path) -> tuple[str, tuple[str, ...]]:
        if file in self.seen:
            return self.seen[file]
        state = file.stat()
        stamp = (state.st_mtime_ns, state.st_size)
        kept = self.known.get(str(file))
        if kept is None or kept[0] != stamp:
            kept = stamp, _parsed(file, stamp)
            self.known[str(file)] = kept
        self.seen[file] = kept[1]
        return kept[1]


@cache
def _parsed(file: Path, _: tuple[int, int]) -> tuple[str, tuple[str, ...]]:
    """Return hash and imports of a file of this time and size, once a process for all stores."""
    content = file.read_bytes()
    names = tuple(sorted(set(_imports(ast.parse(content).body))))
    return hashlib.sha256(content).hexdigest(), names


#: What this process knows of the sources, by the folder with their index.
_indexes: dict[Path, Sources] = {}


def source_digest(names: tuple[str, ...], folder: Path) -> str:
    """Return :meth:`Sources.digest`, once a process: code that runs does not change.

    Each folder gets its index of the sources when it is first asked for.
    """
    if names not in _digests or folder not in _indexes:
        _digests[names] = _indexes.setdefault(folder, Sources(folder)).digest(names)
    return _digests[names]


@cache
def _place(package: str) -> Path:
    """Return the folder of one of the project's packages."""
    spec = importlib.util.find_spec(_HOLDER + package)
    if spec is None or not spec.submodule_search_locations:
        raise LookupError(f"package {package} has no folder")
    return Path(next(iter(spec.submodule_search_locations)))


@cache
def _source(name: str) -> Path | None:
    """Return the file of a module or package, None if it is not one of the project's."""
    above, _, own = name.removeprefix(_HOLDER).rpartition(".")
    if not above:
        return _place(own) / "__init__.py" if own in _PACKAGES else None
    package = _source(above)
    if package is None or package.name != "__init__.py":  # a name in a module: most are
        return None
    places = (package.with_name(own) / "__init__.py", package.with_name(own + ".py"))
    return next((place for place in places if place.is_file()), None)


def _files_of(name: str) -> list[Path]:
    """Return the files of a module, or of a package with all that is in it."""
    file = _source(name)
    if file is None:
        raise LookupError(f"no source of {name}: a key must name the code that it stands for")
    return sorted(file.parent.rglob("*.py")) if file.name == "__init__.py" else [file]


@cache
def _imported(name: str) -> tuple[Path, ...]:
    """Return the files that an import of a dotted name runs: itself, and packages above it."""
    parts = name.split(".")
    above = (".".join(parts[: n + 1]) for n in range(len(parts)))
    return tuple(file for each in above if (file := _source(each)) is not None)


def _imports(statements: Iterable[Any]) -> Iterator[str]:
    """Yield the dotted names that statements import; of `from a import b` both a and a.b.

    Expressions, most of a module, hold no imports and are not looked into.
    """
    for one in statements:
        if isinstance(one, ast.Import):
            yield from (alias.name for alias in one.names)
        elif isinstance(one, ast.ImportFrom) and one.module:
            yield from (f"{one.module}.{alias.name}" for alias in one.names)
        elif isinstance(one, ast.If) and _for_types_only(one.test):
            yield from _imports(one.orelse)
        else:
            for block in ("body", "orelse", "finalbody"):
                yield from _imports(getattr(one, block, ()))
            for inner in (*getattr(one, "handlers", ()), *getattr(one, "cases", ())):
                yield from _imports(inner.body)


def _for_types_only(test: Any) -> bool:
    return isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"
