"""Stand-ins for what takes long: each says what it is given, and hands out what it was told to."""

import dataclasses
from collections import Counter
from types import SimpleNamespace

import numpy as np
from pydantic import BaseModel

from tactgen.validation.scene.scene import Scene

PACKAGE = "tactgen."
#: Rows of more than this are told by their number.
LONG = 20


def told(value):
    """Return what is handed over in a few words: a scene by its name, a function by a dot."""
    if isinstance(value, Scene):
        return f"scene {value.name} by {','.join(value.models)}"
    if isinstance(value, dict):
        return f"{{{' '.join(f'{told(key)}:{told(one)}' for key, one in value.items())}}}"
    if dataclasses.is_dataclass(value):
        parts = [f"{f.name}={told(getattr(value, f.name))}" for f in dataclasses.fields(value)]
        return f"{type(value).__name__}({' '.join(parts)})"
    if isinstance(value, list | tuple | np.ndarray) and len(value) > LONG:
        return f"{len(value)} of them"
    if isinstance(value, list | tuple) and any(map(dataclasses.is_dataclass, value)):
        return " ".join(
            f"{n} {name}" for name, n in Counter(type(v).__name__ for v in value).items()
        )
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(told, value))}]"
    if isinstance(value, BaseModel):
        return type(value).__name__
    if isinstance(value, SimpleNamespace):
        return "what was made up"
    return "·" if callable(value) else str(value)


class StandIns:
    """Put into places, given a monkeypatch; `say` takes a line of each call."""

    def __init__(self, patch, say, told=told):
        self._patch, self._say, self._told = patch, say, told

    def __call__(self, place, answer=None):
        """Put one at ``room.module:name``; an answer that is an error is raised."""
        module, _, name = f"{PACKAGE}{place}".partition(":")

        def called(*given, **options):
            shown = [*map(self._told, given), *(f"{k}={self._told(v)}" for k, v in options.items())]
            self._say(f"> {name} {', '.join(shown)}".rstrip())
            if isinstance(answer, Exception):
                raise answer
            return answer

        self._patch.setattr(f"{module}.{name}", called)
