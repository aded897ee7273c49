"""Where the models' numerics are driven to their limits: the runs behind ``tactgen stress``.

One module per part, each with a function ``run(asked) -> Stress``.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from tactgen.validation.checks.coverage.run import judged_once
from tactgen.validation.checks.stress.result import Row, Stress

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

#: By name, what gives the rows of a family, told whether a few points will do.
Families = Mapping[str, Callable[[bool], Row | list[Row]]]


@dataclass(frozen=True)
class Asked:
    """What a part is asked.

    Attributes
    ----------
    quick : bool
        Whether a few points will do.
    seed : int
        Of all that is drawn.
    announce : callable
        Told what is being done.
    keep : callable
        Given what a result is of, and what computes it, returns it.
    """

    quick: bool
    seed: int = 0
    announce: Callable[[str], None] = lambda _: None
    keep: Callable[[tuple[object, ...], Callable[[], Any]], Any] = lambda _, work: work()

    def rows(self, part: str, families: Families) -> tuple[Row, ...]:
        """Return the rows of all families of a part, each announced before."""
        rows: list[Row] = []
        for name, family in families.items():
            self.announce(f"{part}: {name}")
            found = self.keep((name, self.quick), partial(family, self.quick))
            rows += found if isinstance(found, list) else [found]
        return tuple(rows)


def run_parts(
    names: Iterable[str], quick: bool, seed: int, announce: Callable[[str], None]
) -> list[Stress]:
    """Run the named parts (keys of :data:`PARTS`) in order.

    Each family and each random scene is kept in the store: a run that was stopped goes on with its
    seed where it was.
    """
    found = []
    for name in names:
        module = PARTS[name]

        def keep(
            of: tuple[object, ...], work: Callable[[], Any],
            name: str = name, module: str = module,
        ) -> Any:  # fmt: skip
            return judged_once("stress", (name, *of, seed), module, work)

        part = importlib.import_module(module)
        found.append(part.run(Asked(quick, seed, announce, keep)))
    return found
