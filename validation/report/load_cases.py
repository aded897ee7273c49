"""The response under the scene's own load and under another, by all models."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    pass
from collections.abc import Callable
from dataclasses import dataclass

from tactgen.geometry.arrays import Complex
from tactgen.tmm.ports.elements import outside_known_range
from tactgen.validation.catalogue.quantities import TIP_DISPLACEMENT
from tactgen.validation.engine.solve import Solution, solve

#: What a figure says of each load.
_TITLES = {
    "finger": "under the finger",
    "none": "free tip",
    "mass": "with the tip mass",
    "spring_damper": "on spring and damper",
    "table": "under the measured load",
    "pad": "under imitation skin and its weight",
}


@dataclass(frozen=True)
class LoadCase:
    """A load under which all models' responses are plotted."""

    name: str
    title: str
    solution: Solution

    @property
    def models(self) -> tuple[str, ...]:
        """Models that give the response."""
        return tuple(self.solution.by_model(TIP_DISPLACEMENT.name))

    def curve(self, model: str) -> Complex:
        """Tip displacement (n,); nan where the load model does not reach."""
        values = self.solution.get(TIP_DISPLACEMENT.name, model).value
        outside = outside_known_range(
            self.solution.scene.load, np.asarray(self.solution.scene.frequency)
        )
        return np.where(outside, np.nan, values)

    def summary(self, model: str) -> dict[str, float]:
        """Largest and first displacement (m), where (Hz), and the widest bar."""
        q = self.solution.get(TIP_DISPLACEMENT.name, model)
        size = np.abs(self.curve(model))
        at = int(np.nanargmax(size))
        known = np.isfinite(size) & (size > 0.0)
        first = int(np.flatnonzero(known)[0]) if known.any() else 0
        frequency = np.asarray(self.solution.scene.frequency)
        return {
            "largest": float(size[at]),
            "at": float(frequency[at]),
            "first": float(size[first]),
            "first_at": float(frequency[first]),
            "bar": float(np.max(q.error[known] / size[known], initial=0.0)),
        }


def load_cases(solution: Solution, announce: Callable[[str], None]) -> list[LoadCase]:
    """Solution's response and, without new field solutions, that of another load."""
    scene = solution.scene
    kind = scene.load.kind
    other = "none" if kind != "none" else "finger"
    announce(f"response: {_TITLES[other]}")
    load = scene.load.model_copy(update={"kind": other})
    changed = scene.model_copy(update={"load": load})
    again = solve(changed, quantities=(TIP_DISPLACEMENT.name,), reuse=solution)
    return [LoadCase(kind, _TITLES[kind], solution), LoadCase(other, _TITLES[other], again)]
