"""Plain values as bytes and back, and fingerprints of them.

Frozen dataclasses declared :func:`storable`, tuples, lists, dicts, text, numbers and numpy
arrays.  Reading builds these and runs nothing that a file names.
"""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Class = TypeVar("Class", bound=type)

#: Dataclasses that may be read back, by name.
_STORABLE: dict[str, type] = {}
#: Kinds of numbers whose bytes mean the same on every machine of a kind: long double's do not.
_KINDS = "biufcU"
#: Bytes of the length that precedes the description of a value.
_LENGTH = 8


def storable(kind: Class) -> Class:
    """Declare that values of a frozen dataclass may be stored: read back by its name."""
    if not is_dataclass(kind) or kind.__name__ in _STORABLE:
        raise TypeError(f"{kind.__name__} is no dataclass, or a second one of this name")
    _STORABLE[kind.__name__] = kind
    return kind


def to_bytes(value: object) -> bytes:
    """Value as bytes: a description (JSON), then the raw arrays.

    Raises TypeError if something in it is not storable: a defect of the program.
    """
    return _as_bytes(value, any_class=False)


def fingerprint(*values: object) -> str:
    """Hash of the content of values: of all that can be stored, any dataclass or named tuple.

    Raises TypeError if something in them is of another kind, whose content cannot be told.
    """
    return hashlib.sha256(_as_bytes(values, any_class=True)).hexdigest()[:32]


def _as_bytes(value: object, *, any_class: bool) -> bytes:
    arrays: list[NDArray[Any]] = []
    tree = _described(value, arrays, any_class=any_class)
    kinds = [[array.dtype.str, list(array.shape)] for array in arrays]
    text = json.dumps([tree, kinds]).encode()
    return b"".join([len(text).to_bytes(_LENGTH, "little"), text, *(a.tobytes() for a in arrays)])


def from_bytes(content: bytes) -> Any:
    """Value that :func:`to_bytes` made the bytes of.

    Raises ValueError if they are not such bytes, or hold a dataclass that is unknown or has other
    fields.
    """
    end = _LENGTH + int.from_bytes(content[:_LENGTH], "little")
    try:
        tree, kinds = json.loads(content[_LENGTH:end])
        arrays = []
        for name, shape in kinds:
            kind, count = np.dtype(name), int(np.prod(shape))
            if kind.kind not in _KINDS:
                raise ValueError(f"arrays of {name}")
            flat = np.frombuffer(content, kind, count, offset=end) if count else np.zeros(0, kind)
            arrays.append(flat.reshape(shape).copy())
            end += count * kind.itemsize
        if end != len(content):
            raise ValueError("bytes left over")
        return _built(tree, arrays)
    except (TypeError, LookupError, AttributeError, OverflowError, RecursionError) as error:
        raise ValueError(str(error)) from error


def _described(value: Any, arrays: list[NDArray[Any]], *, any_class: bool) -> Any:
    """JSON values: plain ones as they are, all others as [kind, ...]."""

    def described(part: Any) -> Any:
        return _described(part, arrays, any_class=any_class)

    kind = type(value)
    if value is None or kind in (bool, int, float, str):
        return value
    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.kind not in _KINDS or value.dtype in (np.longdouble, np.clongdouble):
            raise TypeError(f"an array of {value.dtype} cannot be stored")
        arrays.append(np.asarray(value))
        return ["array" if isinstance(value, np.ndarray) else "number", len(arrays) - 1]
    if kind is complex:
        return ["complex", value.real, value.imag]
    if kind in (tuple, list) or (any_class and isinstance(value, tuple)):
        return [kind.__name__, *map(described, value)]
    if kind is dict:
        return ["dict", *(list(map(described, item)) for item in value.items())]
    if not (is_dataclass(kind) if any_class else _STORABLE.get(kind.__name__) is kind):
        raise TypeError(f"{kind.__name__} cannot be stored, nor be part of a key")
    parts = {f.name: described(getattr(value, f.name)) for f in fields(kind) if f.init}
    return ["object", kind.__name__, parts]


def _built(tree: Any, arrays: list[NDArray[Any]]) -> Any:
    if not isinstance(tree, list):
        return tree
    what, *parts = tree
    if what == "array":
        return arrays[parts[0]]
    if what == "number":
        return arrays[parts[0]][()]
    if what == "complex":
        return complex(*parts)
    if what in ("tuple", "list"):
        items = [_built(item, arrays) for item in parts]
        return items if what == "list" else tuple(items)
    if what == "dict":
        return {_built(key, arrays): _built(item, arrays) for key, item in parts}
    if what == "object":
        name, held = parts
        kind = _STORABLE[name]
        if set(held) != {f.name for f in fields(kind) if f.init}:
            raise ValueError(f"{name} has other fields")
        return kind(**{field: _built(item, arrays) for field, item in held.items()})
    raise ValueError(f"unknown kind of value {what}")


#: Folder of the package, by whose name all imports of its modules begin.
_ROOT = Path(__file__).parents[2]
_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(tactgen[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)"
    r"|import[ \t]+(tactgen[\w.]*))",
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
    for package, members, module in _IMPORT.findall(content.decode()):
        # of `from a import b` both a and a.b
        inner = re.findall(r"(\w+)(?:[ \t]+as[ \t]+\w+)?", re.sub(r"#.*", "", members))
        names |= {module} if module else {f"{package}.{name}" for name in inner}
    files = {each for name in names for each in _imported(name)}
    return hashlib.sha256(content).hexdigest(), tuple(sorted(files))


@cache
def _source(name: str) -> Path | None:
    """File of one of the project's modules or packages, None of any other name."""
    above, _, own = name.rpartition(".")
    if not above:
        return _ROOT / "__init__.py" if own == "tactgen" else None
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
    above = (".".join(parts[: n + 1]) for n in range(1, len(parts)))
    return tuple(file for each in above if (file := _source(each)) is not None)
