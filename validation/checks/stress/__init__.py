"""Where the models' numerics are driven to their limits: the runs behind ``tactgen stress``.

One module per part, each with a function ``run(quick, announce) -> Stress``.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable

from tactgen.validation.checks.stress.result import Stress

#: Name of each part and the module that runs it.
PARTS = {
    "tmm": "tactgen.validation.checks.stress.beam",
    "lateral": "tactgen.validation.checks.stress.driven.lateral",
    "solid": "tactgen.validation.checks.stress.solid",
    "magnetics": "tactgen.validation.checks.stress.magnetics",
    "machine": "tactgen.validation.checks.stress.driven.machine",
    "random": "tactgen.validation.checks.stress.driven.at_random",
    "faults": "tactgen.validation.checks.stress.faults.run",
}


def run_parts(names: Iterable[str], quick: bool, announce: Callable[[str], None]) -> list[Stress]:
    """Run the named parts (keys of :data:`PARTS`) in order."""
    return [importlib.import_module(PARTS[name]).run(quick, announce) for name in names]
