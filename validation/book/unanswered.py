"""Published answers without a case here, each with the reason: nobody need look twice."""

from __future__ import annotations

from typing import NamedTuple


class Unanswered(NamedTuple):
    """A problem with a known answer, and why nothing here is held against it."""

    problem: str
    why: str


UNANSWERED: tuple[Unanswered, ...] = (
    Unanswered(
        "ANSYS VM190: magnetomotive force round a loop",
        "the current that a loop encloses is put in, into the right side of one potential and the "
        "source field of the other, so that its return tests nothing",
    ),
    Unanswered(
        "ANSYS VM310: electrostatic pull-in",
        "no model here has an electrostatic force; its magnetic twin is the case SNAP",
    ),
    Unanswered(
        "Stresses of NAFEMS tests 5H and R0031/1 and of ANSYS VM231, and VM174's large deflection",
        "boxes give displacements, forces and charges; stresses are read off the model solid's own "
        "bimorph only, and all models are linear",
    ),
)
