"""tactgen: models of a tactile generator, verified against each other.

The packages lie beside the project file; this folder gives them their common name.  What a
script needs most is here; it is imported when it is first used.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tactgen.geometry.errors import InputError
    from tactgen.validation.engine.solve import solve
    from tactgen.validation.scene.load import load_scene
    from tactgen.validation.show.view import show

__all__ = ["InputError", "__version__", "load_scene", "show", "solve"]

_HOMES = {
    "InputError": "tactgen.geometry.errors",
    "load_scene": "tactgen.validation.scene.load",
    "show": "tactgen.validation.show.view",
    "solve": "tactgen.validation.engine.solve",
}

_HERE = Path(__file__).parent
if not (_HERE / "geometry").is_dir():
    # a checkout whose links are plain files, as git makes them where the system has no links
    __path__.append(str(_HERE.parent.parent))


def __getattr__(name: str) -> Any:
    """Return one of the public names from where it is defined."""
    if name == "__version__":
        from importlib.metadata import version

        return version("tactgen")
    if name not in _HOMES:
        raise AttributeError(f"module 'tactgen' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)
