"""Bars of tapered beams by the transfer matrix: against many times as many segments."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.beam.modes import bending_frequencies
from tactgen.tmm.beam.transfer_matrix import SEGMENTS, sections
from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.scenes import drawn_bimorph
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import Scene, load_scene

#: How many times as many segments the reference has: its own error is 1/256 of the one judged.
_FINER = 4
_NAME = "short_circuit_frequencies"


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the frequencies of one tapered device, drawn by `rng`."""
    length = rng.uniform(8.0, 40.0)
    width, share = rng.uniform(0.5, 3.0), rng.uniform(0.1, 0.9)
    step, layer = rng.uniform(0.2, 0.8) * length, rng.uniform(0.1, 0.4)
    points = ((0.0, width), (step, width), (length, share * width))
    profile = ", ".join(f"{z:.6g} mm: {w:.4g} mm" for z, w in points)
    overrides = [
        *drawn_bimorph(rng, length=length, layer=layer), f"bimorph.width_profile={profile}",
    ]  # fmt: skip
    scene, _ = load_scene("prototype", overrides)
    quantity = solve(scene, ["tmm"], [_NAME]).quantities[0]
    right = _reference(scene, quantity.value.size)
    where = " ".join(overrides)
    return [
        Judged(where, f"{_NAME} {i + 1}", abs(value / exact - 1.0), bar / exact)
        for i, (value, bar, exact) in enumerate(
            zip(quantity.value, quantity.error, right, strict=True)
        )
    ]


def _reference(scene: Scene, count: int) -> Floats:
    row = sections(scene.device, scene.support, scene.beam, lossy=False, segments=_FINER * SEGMENTS)
    return bending_frequencies(row, scene.ends.lossless, count, open_circuit=False)
