"""What stages cost when they last ran on this machine, for plans that say how long they take."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import (
    SUFFIX,
    Damaged,
    read_entry,
    sealed,
    store_folder,
    write_entry,
)

_NAME = "costs"
#: Stages that take less (s) are not worth a line in a file.
_LEAST = 0.02
#: Change of a cost (as a share) that is worth writing it down again.
_CHANGED = 0.25


def recorded() -> dict[str, float]:
    """Return the seconds that stages took when they last ran, by name; of none that never did."""
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
