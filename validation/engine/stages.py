"""Stages of a study: run once, timed, keyed by exactly the inputs they read.

A stage that the plan does not contain is refused, so the plan shown to the user is the
plan that runs.  Results of expensive stages are kept in the store, for the next run.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from tactgen.geometry.store.store import kept
from tactgen.validation.catalogue.models import stage_code

T = TypeVar("T")


@dataclass
class Stages:
    """Runs stages lazily and remembers their results and costs."""

    keys: dict[str, str]  #: Stages of the plan with the key of each
    #: Told the name of each stage as it is computed
    announce: Callable[[str], None] = lambda _: None
    #: Wall-clock cost of each stage that ran
    seconds: dict[str, float] = field(default_factory=dict)
    #: Stages that were computed, not recalled or taken over
    computed: set[str] = field(default_factory=set)
    keeps: bool = True  #: Whether results are looked for in the store, and kept there
    _results: dict[str, Any] = field(default_factory=dict)

    def run(self, name: str, work: Callable[[], T]) -> T:
        """Stage's result: of this run, from the store, or computed now.

        Raises RuntimeError if the stage is not part of the plan: a defect of the plan, not of the
        input.
        """
        if name not in self._results:
            if name not in self.keys:
                raise RuntimeError(f"stage {name} ran although the plan skips it")
            start, inner = time.perf_counter(), sum(self.seconds.values())

            def announced() -> T:
                self.announce(name)
                self.computed.add(name)
                return work()

            code = stage_code().get(name)
            if self.keeps and code is not None:
                self._results[name] = kept(
                    name, (self.keys[name],), code, announced, announce=self.announce
                )
            else:
                self._results[name] = announced()
            spent_inside = sum(self.seconds.values()) - inner
            self.seconds[name] = time.perf_counter() - start - spent_inside
        result: T = self._results[name]
        return result

    def adopt(self, other: Stages) -> None:
        """Take over the results of another study whose inputs, by key, were the same."""
        for name, key in self.keys.items():
            if other.keys.get(name) == key and name in other.seconds:
                self.seconds[name] = other.seconds[name]
                if name in other._results:
                    self._results[name] = other._results[name]

    def to_travel(self) -> Stages:
        """Transferable part for another process: costs and storable results."""
        stored = stage_code()
        results = {name: result for name, result in self._results.items() if name in stored}
        return Stages(self.keys, _unheard, self.seconds, self.computed, self.keeps, results)


def _unheard(_: str) -> None:
    """Take an announcement, as a process does that nobody listens to."""
