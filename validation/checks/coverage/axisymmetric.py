"""Bars of the axisymmetric field: random normal actuators on a finer grid with farther walls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS
from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.scenes import accepted, between
from tactgen.validation.scene.scene import load_scene

#: The reference's order, refinement of the grid, and how many times as far its walls are.
_ORDER, _REFINEMENT, _FARTHER = 5, 1.5, 3.0
_VALUES = ("force", "flux_linkage", "coenergy", "incremental_inductance")

#: A field with its error bars, and a better one.
Fields: TypeAlias = tuple[Any, Any]


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`."""
    return judged_fields(rng, _solved)


def _solved(device: Device) -> Fields:
    right = solve_point(
        device, order=_ORDER, refinement=_REFINEMENT, outer_radius=_FARTHER * OUTER_RADIUS
    )
    return solve_point(device), right


def judged_fields(rng: np.random.Generator, solved: Callable[[Device], Fields]) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`; dimensions that do not fit are redrawn."""

    def attempt() -> list[Judged]:
        overrides = drawn_actuator(rng)
        scene, _ = load_scene("reluctance", overrides)
        found, right = solved(scene.device)
        return [_one(" ".join(overrides), name, found, right) for name in _VALUES]

    return accepted(attempt)


def drawn_actuator(rng: np.random.Generator) -> list[str]:
    """Return the overrides of a random normal actuator; they may not fit together."""
    turns = int(between(rng, 200, 2000))
    return [
        f"gap={between(rng, 20.0, 400.0):.4g}um",
        f"coil.current={between(rng, 2.0, 300.0):.4g}mA",
        f"coil.turns={turns}",
        f"rod.head_thickness={between(rng, 0.3, 0.8):.4g}mm",
        f"sleeve.collar_thickness={between(rng, 0.1, 0.4):.4g}mm",
        f"steel.curve={rng.choice(['team20', 'linear'])}",
    ]


def _one(where: str, name: str, found: Any, right: Any) -> Judged:
    value, exact = getattr(found, name), getattr(right, name)
    bar = getattr(found.errors, name)
    return Judged(where, name, abs(value / exact - 1.0), bar / abs(exact))
