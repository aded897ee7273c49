"""Why a beam's number is not the solid's: named causes whose shares add up to the difference.

A share is what a cause adds to (beam / solid − 1).  On a clamp the causes are the rungs of the
bridge; in the rod those same ones and, besides, what each step from the clamp to the rod does to
the solid otherwise than to the beam.  None replaces another.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from tactgen.validation.catalogue.bimorph import (
    CAPACITANCE_BLOCKED,
    CAPACITANCE_FREE,
    COUPLING_FACTOR,
    OPEN_CIRCUIT_FREQUENCIES,
    SHORT_CIRCUIT_FREQUENCIES,
    STATIC_TIP_DISPLACEMENT,
)
from tactgen.validation.models.bimorph.beam_values import Steps, Values
from tactgen.validation.models.bimorph.bridge.assumptions import bridge
from tactgen.validation.models.bimorph.bridge.generator import GeneratorChain
from tactgen.validation.models.bimorph.bridge.rung import Rung

#: The quantities that the bridge follows, by the name of its value.
BRIDGED = {
    STATIC_TIP_DISPLACEMENT.name: "deflection",
    SHORT_CIRCUIT_FREQUENCIES.name: "first_frequency",
    CAPACITANCE_FREE.name: "capacitance",
    OPEN_CIRCUIT_FREQUENCIES.name: "open_frequency",
    COUPLING_FACTOR.name: "coupling",
    CAPACITANCE_BLOCKED.name: "blocked_capacitance",
}


@dataclass(frozen=True)
class Cause:
    """One reason, and what it adds to (beam / solid − 1) of each value that a bridge follows."""

    name: str
    share: Steps

    @property
    def of(self) -> Mapping[str, float]:
        """The shares by quantity."""
        return {quantity: getattr(self.share, value) for quantity, value in BRIDGED.items()}


def on_a_clamp(rungs: Sequence[Rung]) -> list[Cause]:
    """Return the causes that a bridge from the beam to the solid names, in its order."""
    last = rungs[-1].values
    return [
        Cause(
            rung.name,
            Steps(*((a - b) / c for a, b, c in zip(before.values, rung.values, last, strict=True))),
        )
        for before, rung in pairwise(rungs)
    ]


def in_the_rod(chain: GeneratorChain, announce: Callable[[str], None]) -> list[Cause]:
    """Return the causes for a bimorph in its rod: those on a clamp, and those of what holds it.

    Parameters
    ----------
    chain : GeneratorChain
        From the clamped bimorph to the one in the rod.
    """
    rungs = bridge(chain.clamped_scene, announce, sections=False)
    found = on_a_clamp(rungs)
    ratio = _ratio(rungs[0].values, rungs[-1].values)
    for name, by_beam, by_solid in chain.pairs():
        now = _ratio(by_beam, by_solid)
        share = Steps(*(a - b for a, b in zip(now, ratio, strict=True)))
        # the first pair is the clamped bimorph again, on the chain's finer bricks
        found.append(Cause("finer bricks" if by_solid == chain.clamped.values else name, share))
        ratio = now
    return found


def _ratio(by_beam: Values, by_solid: Values) -> Steps:
    return Steps(*(a / b for a, b in zip(by_beam, by_solid, strict=True)))


def total(causes: Sequence[Cause]) -> Steps:
    """Return what all causes together say of (beam / solid − 1)."""
    return Steps(*(sum(shares) for shares in zip(*(c.share for c in causes), strict=True)))
