"""What the models cost: the measurements behind ``tactgen bench``.

One module per part, each with a function ``run(quick, announce) -> Bench``.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable

from tactgen.validation.bench.result import Bench

#: Name of each part and the module that measures it.
PARTS = {
    "tmm": "tactgen.validation.bench.bimorph.beam",
    "magnetics": "tactgen.validation.bench.reluctance",
    "piezo": "tactgen.validation.bench.bimorph.solid",
    "solver": "tactgen.validation.bench.solver",
    "skip": "tactgen.validation.bench.skip",
}


def run_parts(names: Iterable[str], quick: bool, announce: Callable[[str], None]) -> list[Bench]:
    """Measure the named parts (keys of :data:`PARTS`) in order."""
    return [importlib.import_module(PARTS[name]).run(quick, announce) for name in names]
