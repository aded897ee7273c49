"""Bars of the beam elements: random bimorphs against the exact spans of the transfer matrix."""

from __future__ import annotations

import numpy as np

from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.scenes import accepted, between, compared, drawn_bimorph
from tactgen.validation.scene.scene import Scene, load_scene

_QUANTITIES = (
    "static_tip_displacement", "capacitance_free", "short_circuit_frequencies",
    "open_circuit_frequencies", "tip_displacement", "admittance",
)  # fmt: skip


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`: one in three is glued into its rod."""
    on_rod = rng.random() < 1.0 / 3.0
    scene, where = accepted(lambda: _on_rod(rng) if on_rod else _alone(rng))
    return compared((scene, "beam"), (scene, "tmm"), _QUANTITIES, where)


def _alone(rng: np.random.Generator) -> tuple[Scene, str]:
    overrides = drawn_bimorph(rng)
    return load_scene("prototype", overrides)[0], " ".join(overrides)


def _on_rod(rng: np.random.Generator) -> tuple[Scene, str]:
    drawn = drawn_bimorph(rng)
    overrides = [one for one in drawn if not one.startswith("support.")]
    overrides += [
        "load.kind=none",  # the finger's model ends at 1000 Hz
        f"bimorph.tab_length={between(rng, 0.5, 5.0):.4g}mm",
        f"glue.thickness={between(rng, 0.5, 60.0):.4g}um",
    ]
    return load_scene("bimorph_on_rod", overrides)[0], "on its rod, " + " ".join(overrides)
