"""What the rows without a case of their own are about: the problem behind each family of rows.

A family is what stands before the last dash of its rows' ids.
"""

from __future__ import annotations

from typing import NamedTuple


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
