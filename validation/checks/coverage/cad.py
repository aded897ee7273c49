"""Bars of the model cad: random bimorphs of those that CAD knows, against much finer bricks."""

from __future__ import annotations

import numpy as np

from tactgen.validation.checks.coverage.result import Judged
from tactgen.validation.checks.coverage.solid import cad_cases, judged


def judge(rng: np.random.Generator) -> list[Judged]:
    """Return the answers of one device, drawn by `rng`."""
    (case,) = cad_cases(int(rng.integers(2**31)), 1)
    return judged(case)
