"""What stages cost when they last ran on this machine, for plans that say how long they take."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import (
    SUFFIX,
    Damaged,
    is_kept,
    read_entry,
    sealed,
    store_folder,
    write_entry,
)
from tactgen.validation.catalogue.models import stage_code
from tactgen.validation.engine.plan import Plan

_NAME = "costs"
#: Stages that take less (s) are not worth a line in a file.
_LEAST = 0.02
#: Change of a cost (as a share) that is worth writing it down again.
_CHANGED = 0.25


def recorded() -> dict[str, float]:
    """Seconds that stages took when they last ran, by name; of none that never did."""
    try:
        found: dict[str, float] = read_entry(store_folder() / (_NAME + SUFFIX))
    except (FileNotFoundError, Damaged):
        return {}
    return found


def record(seconds: Mapping[str, float]) -> None:
    """Write down what stages took that ran now; where nothing can be written nothing is kept.

    Of two processes that write at once one wins: it is an estimate.
    """
    worth = {stage: cost for stage, cost in seconds.items() if cost >= _LEAST}
    before = recorded() if worth else {}
    news = {
        stage: cost
        for stage, cost in worth.items()
        if abs(cost - before.get(stage, 0.0)) > _CHANGED * cost
    }
    if news:
        with contextlib.suppress(OSError, InputError):
            path = store_folder() / (_NAME + SUFFIX)
            write_entry(path, sealed(path, {**before, **news}))


@dataclass(frozen=True)
class Prospect:
    """One stage of a plan: whether its result is kept, and the seconds recorded, if any are."""

    kept: bool
    seconds: float | None


def stage_prospects(plan: Plan) -> dict[str, Prospect]:
    """Prospects of a plan's stages, by name.

    Costs are those of the last run on this machine, of whatever scene: an order of magnitude.
    """
    costs, code = recorded(), stage_code()
    return {
        stage: Prospect(
            stage in code and is_kept(stage, (key,), code[stage]),
            costs.get(stage),
        )
        for stage, key in plan.keys.items()
    }  # fmt: skip


def total(prospects: dict[str, Prospect]) -> float:
    """Seconds of all that is not kept and of which a cost is recorded."""
    return sum(p.seconds for p in prospects.values() if not p.kept and p.seconds is not None)
