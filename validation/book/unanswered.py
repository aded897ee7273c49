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
        "NAFEMS LE1 and LE10; stresses of NAFEMS tests 5H and R0031/1 and of ANSYS VM34 and VM231, "
        "whose field strength, too",
        "boxes give displacements, forces and charges, and have no elliptic edges; stresses and "
        "fields are read off the model solid's own bimorph only",
    ),
    Unanswered(
        "ANSYS VM174: large deflection of a bimetal strip",
        "all models of the bimorph are linear; small deflections are the cases VM35 and VM144",
    ),
    Unanswered(
        "ANSYS VM183: two masses on springs",
        "its answer is the solution of two equations, of which every response here has more",
    ),
    Unanswered(
        "NASA's example of a grid convergence index (0.97050, 0.96854, 0.96178)",
        "error bars here are no grid convergence index: how they are made stands beside each, and "
        "tactgen coverage judges them",
    ),
)
