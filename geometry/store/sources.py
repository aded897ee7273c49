"""Hash of the code that a stored number was made by: modules and all that they import from here.

Found in the text of the sources, which are never run for it; imports inside functions count, and
those for type checking as well.  What is loaded by its name in a string must be named.
"""

from __future__ import annotations

import hashlib
import importlib.util
import re
from functools import cache
from pathlib import Path

#: The project's packages, and the package that holds them, if any.
_PACKAGES = frozenset({"geometry", "tmm", "fem", "validation"})
_HOLDER = __name__.removesuffix("geometry.store.sources")
_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+([^\n]+))",
    re.MULTILINE,
)


@cache
def source_digest(names: tuple[str, ...]) -> str:
    """Hash of the named modules and packages with all that they import.

    Raises LookupError if a name has no source: a hash of nothing would call everything up to date.
    """
    found: dict[Path, str] = {}
    open_ends = [file for name in names for file in (*_imported(name), *_files_of(name))]
    while open_ends:
        file = open_ends.pop()
        if file not in found:
            found[file], imports = _read(file)
            open_ends += imports
    # the place does not matter, what is in the files does
    return hashlib.sha256("".join(sorted(found.values())).encode()).hexdigest()


@cache
def _read(file: Path) -> tuple[str, tuple[Path, ...]]:
    """Hash of a file and the project's files that it imports: code that runs is fixed."""
    content = file.read_bytes()
    names: set[str] = set()
    for package, members, modules in _IMPORT.findall(content.decode()):
        if package.partition(".")[0] in (*_PACKAGES, _HOLDER[:-1]):
            # of `from a import b` both a and a.b
            inner = re.findall(r"(\w+)(?:[ \t]+as[ \t]+\w+)?", re.sub(r"#.*", "", members))
            names |= {f"{package}.{name}" for name in inner}
        names |= set(re.findall(r"[\w.]+", modules))
    files = {each for name in names for each in _imported(name)}
    return hashlib.sha256(content).hexdigest(), tuple(sorted(files))


@cache
def _place(package: str) -> Path:
    """Folder of one of the project's packages."""
    spec = importlib.util.find_spec(_HOLDER + package)
    if spec is None or not spec.submodule_search_locations:
        raise LookupError(f"package {package} has no folder")
    return Path(next(iter(spec.submodule_search_locations)))


@cache
def _source(name: str) -> Path | None:
    """File of a module or package, None if it is not one of the project's."""
    above, _, own = name.removeprefix(_HOLDER).rpartition(".")
    if not above:
        return _place(own) / "__init__.py" if own in _PACKAGES else None
    package = _source(above)
    if package is None or package.name != "__init__.py":  # a name in a module: most are
        return None
    places = (package.with_name(own) / "__init__.py", package.with_name(own + ".py"))
    return next((place for place in places if place.is_file()), None)


def _files_of(name: str) -> list[Path]:
    """Files of a module, or of a package with all that is in it."""
    file = _source(name)
    if file is None:
        raise LookupError(f"no source of {name}: a key must name the code that it stands for")
    return sorted(file.parent.rglob("*.py")) if file.name == "__init__.py" else [file]


@cache
def _imported(name: str) -> tuple[Path, ...]:
    """Files that an import of a dotted name runs: itself, and packages above it."""
    parts = name.split(".")
    above = (".".join(parts[: n + 1]) for n in range(len(parts)))
    return tuple(file for each in above if (file := _source(each)) is not None)
