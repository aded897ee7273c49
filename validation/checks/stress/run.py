"""The parts of a stress run, and the run behind ``tactgen stress``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from tactgen.validation.checks.coverage.result import judged_once
from tactgen.validation.checks.stress.result import Asked, Stress, approach_plot, map_plot

#: The parts of a run, in order.
PARTS = ("tmm", "lateral", "solid", "magnetics", "machine", "random", "faults")


def _part(name: str) -> Callable[[Asked], Stress]:
    """Return what runs a part; only its own models are imported."""
    if name == "tmm":
        from tactgen.validation.checks.stress import beam

        return beam.run
    if name == "lateral":
        from tactgen.validation.checks.stress.driven import lateral

        return lateral.run
    if name == "solid":
        from tactgen.validation.checks.stress import solid

        return solid.run
    if name == "magnetics":
        from tactgen.validation.checks.stress import magnetics

        return magnetics.run
    if name == "machine":
        from tactgen.validation.checks.stress.driven import machine

        return machine.run
    if name == "random":
        from tactgen.validation.checks.stress.driven import sweep

        return sweep.run
    from tactgen.validation.checks.stress.faults import run

    return run.run


def run_parts(
    names: Iterable[str], quick: bool, seed: int, announce: Callable[[str], None]
) -> list[Stress]:
    """Run the named parts of :data:`PARTS` in order.

    Each family and each random scene is kept in the store: a run that was stopped goes on with its
    seed where it was.
    """
    found = []
    for name in names:
        run = _part(name)

        def keep(
            of: tuple[object, ...], work: Callable[[], Any],
            name: str = name, module: str = run.__module__,
        ) -> Any:  # fmt: skip
            return judged_once("stress", (name, *of, seed), module, work)

        found.append(run(Asked(quick, seed, announce, keep)))
    return found


def section(announce: Callable[[str], None]) -> dict[str, Any]:
    """Run the transfer matrix's part on few points: what ``stress.html`` shows."""
    part = _part("tmm")(Asked(quick=True, announce=announce))
    return {
        "stress": [part],
        "stress_maps": [map_plot(table) for table in part.maps],
        "stress_approaches": [approach_plot(part.approaches)],
    }
