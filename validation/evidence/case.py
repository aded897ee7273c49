"""A case: one problem whose answer is known, solved by the suite, with all its rows.

Rows say what must hold; the case says what the problem is, so that the verification book can
give it a page of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple

from tactgen.geometry.arrays import Floats
from tactgen.validation.engine.results import Estimate

Tier = Literal["code verification", "solution verification", "cross-model", "validation"]
Status = Literal["pass", "fail", "explained"]


@dataclass(frozen=True)
class Check:
    """One requirement with its reference and its tolerance."""

    #: The requirement is a sentence
    id: str
    tier: Tier
    requirement: str
    #: Reference value in `unit`, or the range in which the value must lie
    reference: float | tuple[float, float]
    unit: str
    source: str
    tolerance: float  #: Accepted relative deviation from the value, or beyond the range
    reason: str  #: Why the tolerance is what it is
    #: Computes the value, with its error bar where the model that it asks states one
    measure: Callable[[], float | Estimate]
    explained: str = ""  #: Why the row is known to differ; empty where it must pass
    known: float = 0.0  #: The deviation that the explanation was written for; another one fails
    #: What was fitted to the reference; agreement then confirms nothing and is no pass
    fitted: str = ""
    heavy: bool = False  #: Whether it takes more than a few seconds
    #: The built-in scene whose report shows it; empty where it is about the suite alone
    scene: str = ""

    @property
    def explanation(self) -> str:
        """Reason why a comparison says nothing about the models; "" where it does."""
        if self.fitted:
            return f"fitted to this reference, so it is no test: {self.fitted}"
        return self.explained


@dataclass(frozen=True)
class Outcome:
    """Check with its result."""

    check: Check
    measured: float
    deviation: float
    status: Status


#: How far a known deviation may move before its explanation no longer counts: absolutely, and
#: as a share of itself.
_STILL, _STILL_SHARE = 0.02, 0.2


def run_check(check: Check) -> Outcome:
    """Measure one row."""
    return judged(check, value_of(check.measure()))


def value_of(measured: float | Estimate) -> float:
    """Measured value without its bar."""
    return float(measured.value if isinstance(measured, Estimate) else measured)


def judged(check: Check, measured: float) -> Outcome:
    """Verdict on a measured value."""
    deviation = _deviation(measured, check.reference)
    if abs(deviation) <= check.tolerance:
        status: Status = "explained" if check.fitted else "pass"
    else:
        near = min(_STILL, _STILL_SHARE * abs(check.known))
        still = check.explained and abs(deviation - check.known) <= near
        status = "explained" if still else "fail"
    return Outcome(check, measured, deviation, status)


def _deviation(measured: float, reference: float | tuple[float, float]) -> float:
    """Relative distance from a value, or from the nearer end of a range.

    Relative to that end; where it is 0, to the range's other end, and without one infinite.
    """
    ends = reference if isinstance(reference, tuple) else (reference, reference)
    nearest = min(max(measured, ends[0]), ends[1])
    if measured == nearest:
        return 0.0
    if nearest:
        return measured / nearest - 1.0
    size = max(map(abs, ends))
    return math.copysign(abs(measured) / size if size else math.inf, measured)


@dataclass(frozen=True)
class Refinement:
    """The divisions by which a case shows an order, where its rows are errors themselves."""

    levels: tuple[int, ...]  #: Intervals along an edge, from coarse to fine
    error: Callable[[int], float]  #: Gives the relative error on so many
    order: str  #: What theory expects of it, in words


@dataclass(frozen=True)
class Case:
    """A problem with a known answer."""

    #: Rows are called by the id and a number
    id: str
    title: str
    problem: str  #: What is asked, with all dimensions, so that a reader can solve it elsewhere
    model: str  #: What of the suite solves it, and how finely
    rows: tuple[Check, ...]  #: What must hold
    #: What is shown in place of the rows' own coarser levels
    refinement: Refinement | None = None
    #: Gives a drawing as SVG, where a body is hard to say in words
    setup: Callable[[], str] | None = None


@dataclass(frozen=True)
class Answer:
    """Known number of a case; other fields as in :class:`Check`."""

    requirement: str
    reference: float | tuple[float, float]
    unit: str
    measure: Callable[[], float]
    tolerance: float | None = None
    reason: str = ""
    explained: str = ""
    known: float = 0.0
    heavy: bool = False


def nth(values: Callable[..., Floats], index: int, *arguments: object) -> Callable[[], float]:
    """Measurement of one of several values that a function gives at once."""
    return lambda: float(values(*arguments)[index])


def case(
    name: str,
    title: str,
    problem: str,
    *,
    model: str,
    source: str,
    answers: Iterable[Answer],
    tolerance: float = 0.0,
    reason: str = "",
    tier: Tier = "code verification",
    refinement: Refinement | None = None,
    setup: Callable[[], str] | None = None,
) -> Case:
    """Case called `name`; answers without a tolerance or reason have the case's."""
    rows = tuple(
        Check(
            f"{name}-{number}", tier, answer.requirement, answer.reference, answer.unit, source,
            tolerance if answer.tolerance is None else answer.tolerance,
            answer.reason or reason, answer.measure,
            explained=answer.explained, known=answer.known, heavy=answer.heavy,
        )
        for number, answer in enumerate(answers, start=1)
    )  # fmt: skip
    return Case(name, title, problem, model, rows, refinement, setup)


class Problem(NamedTuple):
    """Title, problem and solver of a family, as a case has them."""

    title: str
    problem: str
    model: str


_AXISYMMETRIC = "model axisymmetric: quadrilaterals of order 4 to 6 in the half section"
_EDGE = "second-order edge elements and second-order scalar potential on swept tetrahedra"

#: By group and family.
PROBLEMS = {
    ("bimorph", "TMM"): Problem(
        "The paper's bimorph as an exact beam",
        "The paper's bimorph (two layers of M1876, 0.26 mm, on a shim of 0.25 mm; 2.1 mm wide): "
        "14 mm on its fitted springs with a free tip at 1 V and all losses, and 20 mm clamped "
        "without losses. The reference solves Timoshenko's differential equations with 60 digits.",
        "model tmm",
    ),
    ("bimorph", "FIN"): Problem(
        "The finger's stiffness has a maximum, its damping a minimum",
        "The paper fits rational functions to a finger's impedance (eqs 1 to 5, table 1). Where "
        "is the stiffness largest between 10 and 1000 Hz, and where does it damp least?",
        "the load of all models, searched for its maximum",
    ),
    ("bimorph", "BEA"): Problem(
        "Beam elements against the exact beam",
        "First short-circuit frequency of the clamped 20 mm bimorph.",
        "model beam, 20 elements of order five",
    ),
    ("bimorph", "SOL"): Problem(
        "Job J1: one clamped bimorph by five programs",
        "Two layers of PZT-5H on an elastic shim, clamped at one end, without losses: tip "
        "deflection per volt and four natural frequencies in short circuit (built-in scene j1). "
        "Four public finite-element programs agree on them to 3e-5 on identical meshes.",
        "model solid on its default mesh; the fine mesh is heavy",
    ),
    ("bimorph", "X"): Problem(
        "One bimorph by models of different theory",
        "The paper's 20 mm bimorph, clamped, free tip. Where two models share a theory they must "
        "agree to rounding or to their error bars; where they do not, what one leaves out is "
        "predicted in closed form or from the section, and the prediction must cover the "
        "difference.",
        "models lumped, tmm, solid and cad; the bridge between them",
    ),
    ("bimorph", "PAP"): Problem(
        "The lateral actuator against what the paper reports",
        "The 20 mm bimorph on the paper's fitted springs under its finger: stiffness and damping "
        "of the finger, deflection at 50 V, and the voltage that is felt. What a linear support "
        "cannot give is taken up by the rows ROCK.",
        "model tmm on the linear support",
    ),
    ("bimorph", "PAD"): Problem(
        "The lateral actuator on imitation skin under 50 g, as the paper measured it",
        "The 20 mm bimorph on the rod's contact, linear, pushed up by the spring or held down by "
        "50 mA, driven with 50 V from 10 to 1000 Hz; on its tip a rubber sheet under 50 g, a "
        "sixteenth of which rests on it. No number of the sheet is fitted to the measurement.",
        "model tmm on the contact, load.kind = pad",
    ),
    ("reluctance", "COI"): Problem(
        "Two coaxial ring coils in air",
        "Mutual inductance and axial force of two coils of rectangular section on one axis, no "
        "iron.",
        _AXISYMMETRIC,
    ),
    ("reluctance", "SOL"): Problem(
        "Long solenoids, empty and with a core",
        "An infinite solenoid of 10 mm inner and 20 mm outer radius at 1 A/mm²: B on the axis and"
        " across the winding. Then a long core in it: linear (µr = 1000), and of steel, at the "
        "knee of its curve, saturated, and far beyond its last point.",
        _AXISYMMETRIC,
    ),
    ("reluctance", "VM213"): Problem(
        "Energy and co-energy of a core with B ∝ √H",
        "A transformer core whose flux linkage grows as the root of the current: co-energy and "
        "stored energy at 0.2 A. For this law one is twice the other.",
        "model network, and a co-energy map fitted to its samples",
    ),
    ("reluctance", "BALL"): Problem(
        "A permeable ball in a uniform field",
        "A ball of µr = 1000 in a field that is uniform far away has a uniform field inside. The "
        "outer boundary is a concentric sphere, which the reference takes into account.",
        _EDGE,
    ),
    ("reluctance", "VM188"): Problem(
        "Two long parallel conductors",
        "Two long strips that carry 24 A in opposite directions: force per length.",
        _EDGE,
    ),
    ("reluctance", "ACT"): Problem(
        "An actuator with a collar, solved elsewhere",
        "A reluctance actuator of this kind with a collar on its sleeve, of nonlinear steel: pull"
        " and flux linkage per turn at two currents, by a program that shares nothing with this "
        "one. That solution is not published; the device is stated in full in the source.",
        _AXISYMMETRIC,
    ),
    ("reluctance", "LOOP"): Problem(
        "No work around a closed loop",
        "Force and flux linkage that belong to one co-energy do no net work when current and gap "
        "are taken around a rectangle and back.",
        "model network; the co-energy maps made from network and axisymmetric field",
    ),
    ("reluctance", "EULER"): Problem(
        "Derivatives by all dimensions",
        "If all lengths of a normal actuator grow, and the current with them, H and B stay: the "
        "co-energy grows as the cube of the size, pull and flux linkage as its square. So the "
        "logarithmic derivatives by all lengths and the current, each taken alone, add up to 3, 2 "
        "and 2.",
        "model axisymmetric, differences on grids that move with each dimension",
    ),
    ("reluctance", "FORCE"): Problem(
        "One force by independent routes",
        "The built-in normal actuator at four pairs of current and gap: force by the stress in "
        "the air, by virtual work on one mesh, and as the difference quotient of the co-energy "
        "between gaps that are meshed separately.",
        _AXISYMMETRIC,
    ),
    ("reluctance", "NET"): Problem(
        "The network against the field",
        "Pull and flux linkage of the built-in normal actuator at four pairs of current and gap, "
        "first with straight iron. A network knows flux tubes and no field; what is left is its "
        "model form.",
        "models network and axisymmetric",
    ),
    ("reluctance", "TEAM20"): Problem(
        "TEAM problem 20: a nonlinear plunger in three dimensions",
        "Centre pole, yoke and coil of mild steel with a gap of 1.5 mm, at 1000 to 5000 ampere-"
        "turns; the force on the pole was measured, and flux densities in gap, pole and yoke. The "
        "bare edge elements approach the force from one side, the scalar potential from the other. "
        "ANSYS VM233 and VM241 are this problem at 5000 ampere-turns.",
        _EDGE,
    ),
    ("reluctance", "PAP"): Problem(
        "The normal actuator against what the paper reports",
        "The reconstructed actuator: pull at 130 mA, holding at 50 mA, pull-in at 120 mA, heat, "
        "and height. It was reconstructed from some of these, and such rows say so.",
        "models axisymmetric and network; the CAD layout",
    ),
    ("motion", "MOT"): Problem(
        "Motions that are known, and the machine's own energy",
        "A mass on a hardening spring, a coil on a stepped voltage, a mass that bounces off a "
        "rough surface without loss; then the whole generator: what its sources gave is what it "
        "holds and lost, and when its rod arrives in the run of the paper's Fig 16.",
        "the steps of tactgen simulate; for the pull from the upper stop model axisymmetric",
    ),
    ("amplitude", "HB"): Problem(
        "Oscillators whose large motions are known",
        "Free: a mass on a linear and a cubic spring, and on a spring that is stiffer to one "
        "side. Driven: Duffing's oscillator ẍ + 0.05 ẋ + x + 0.1 x³ = 0.18 cos Ωt (damping ratio "
        "0.025): its peak and the two frequencies at which it jumps.",
        "harmonic balance with as many harmonics as the motion asks for",
    ),
    ("amplitude", "ROCK"): Problem(
        "The bimorph on a head that may rock, against the paper's measurements",
        "The head is pressed on its stop with a force that carries a limited moment. The paper's "
        "Fig 8 (14 mm, free, 1 V), Fig 14 (20 mm, free, 1 V, held or not), Fig 15 (50 V under "
        "load) and Fig 17 (voltage at the threshold) are predicted with the one constant that "
        "small motions fixed. What stays unexplained is named in each row.",
        "harmonic balance on the ports of model tmm",
    ),
    ("display", "ARR"): Problem(
        "Generators on one board under one skin",
        "Each is solved once by model tmm, placed on the upper board and tied at its tip to the "
        "others. What goes in comes out or stays; what one does to another, the other does to it.",
        "ports joined by name; board as a plate on its spacers, skin as a sheet",
    ),
    ("display", "SPR"): Problem(
        "Units as they come out of the shop",
        "Lengths drawn from a narrow scatter; what it does to the first frequencies of four units.",
        "model tmm, each unit on its own contact",
    ),
    ("display", "NEI"): Problem(
        "The field between units, by the network",
        "Permeances between neighbouring heads beside each working gap. Far apart they vanish; one "
        "driven unit among others without current is where one of an endless array is.",
        "model network",
    ),
    ("display", "FIT"): Problem(
        "Sixteen generators in the paper's room",
        "All distances that could close, and the heights of all parts.",
        "closed form, from the sizes of the parts",
    ),
}
