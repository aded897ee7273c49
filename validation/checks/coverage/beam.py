"""Bars of the beam elements: random bimorphs against the exact spans of the transfer matrix."""

from __future__ import annotations

import numpy as np

from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.scenes import compared, drawn_bimorph
from tactgen.validation.scene.scene import load_scene

_QUANTITIES = (
    "static_tip_displacement", "capacitance_free", "short_circuit_frequencies",
    "open_circuit_frequencies", "tip_displacement", "admittance",
)  # fmt: skip


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`."""
    overrides = drawn_bimorph(rng)
    scene, _ = load_scene("prototype", overrides)
    return compared((scene, "beam"), (scene, "tmm"), _QUANTITIES, " ".join(overrides))
