"""What the ends of the bimorph are worth, and what remains when all is taken into account.

The clamp keeps the width from contracting and the section plane, the tip is free of stress;
both reach into the bimorph by lengths of their own, whatever its length L.  So relative to
the beam with the solid's own section far from the ends, their effect is a/L + b/L², and what
would remain of an endless bimorph is not theirs.  Three lengths tell one from the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.models.bimorph.beam_values import Steps, beam_values
from tactgen.validation.models.bimorph.bridge.solid_values import (
    SolidCase,
    far_section,
    solve_solid,
)
from tactgen.validation.scene.scene import Scene

#: Lengths in terms of the scene's.
_SHARES = (1.0, 0.75, 0.5)


@dataclass(frozen=True)
class EndEffect:
    """Solid against the beam model with the solid's own section, both clamped (relative).

    Attributes
    ----------
    effect : Steps
        The whole difference at the scene's length.
    rest : Steps
        What would be left at any length: unexplained.
    """

    effect: Steps
    rest: Steps

    @property
    def ends(self) -> Steps:
        """What falls with the length: the work of the ends."""
        return Steps(*(whole - left for whole, left in zip(self.effect, self.rest, strict=True)))


def end_effect(scene: Scene, *, level: int = 1) -> EndEffect:
    """Return what the ends of the scene's bimorph do when its lower end is clamped."""
    support = scene.support.model_copy(update={"kind": "clamped"})
    case = SolidCase(scene.model_copy(update={"support": support}), level=level)
    cases = [case.shortened(share) for share in _SHARES]
    solved = [solve_solid(one) for one in cases]
    own = far_section(case, solved[0].static)
    effects = [
        found.values.step_from(beam_values(one.scene, own))
        for one, found in zip(cases, solved, strict=True)
    ]
    # the parabola in 1/L through the three, at 1/L = 0
    weights = _at_zero([1.0 / share for share in _SHARES])
    return EndEffect(effects[0], Steps(*(float(weights @ steps) for steps in np.array(effects).T)))


def _at_zero(points: list[float]) -> Floats:
    """Return the weights of values at `points` in the polynomial through them, at 0."""
    return np.linalg.solve(np.vander(points, increasing=True).T, np.eye(len(points))[0])
