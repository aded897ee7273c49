"""The parts of a coverage run: estimated errors against much better answers, for random devices."""

from __future__ import annotations

from tactgen.validation.evidence.judgement import PartRow, Rule

#: Bars that keep their promise are called too narrow once in a hundred; above a median of five
#: errors they say too little to be of use.
RULE = Rule(chance=0.01, wide=5.0)

#: By name; only the modules of those that are run are imported.
PARTS: dict[str, PartRow] = {
    "tmm": PartRow(
        "the transfer matrix against 80 digits; its bars are of rounding and wide",
        "coverage_bimorph.judge_tmm", 60,
    ),
    "beam": PartRow("beam elements against exact spans", "coverage_bimorph.judge_beam", 60),
    "taper": PartRow(
        "tapers by the transfer matrix against four times as many segments",
        "coverage_bimorph.judge_taper", 40,
    ),
    "solid": PartRow("bricks against bricks two levels finer", "coverage_bimorph.judge_solid", 16),
    "cad": PartRow(
        "tetrahedra of the CAD solids against much finer bricks",
        "coverage_bimorph.judge_cad", 4,
    ),
    "surrogate": PartRow(
        "a fresh length by a surrogate against bricks two levels finer",
        "coverage_bimorph.judge_surrogate", 12,
    ),
    "calibrated": PartRow(
        "modelling errors of the transfer matrix against bricks",
        "coverage_bimorph.judge_calibrated", 40,
    ),
    "pieces": PartRow(
        "modelling errors of bimorphs with a tab, patches, own widths, glue, or beyond the fit",
        "coverage_bimorph.judge_pieces", 40,
    ),
    "harvester": PartRow(
        "modelling errors of a harvester's peaks against bricks",
        "coverage_bimorph.judge_harvester", 16,
    ),
    "network": PartRow(
        "modelling errors of the network against the magnetic field",
        "coverage_actuator.judge_network", 60,
    ),
    "axisymmetric": PartRow(
        "the magnetic field against a finer grid, higher order and farther walls",
        "coverage_actuator.judge_axisymmetric", 20,
    ),
    "magnetic3d": PartRow(
        "the magnetic field on coarse tetrahedra against the half section's",
        "coverage_actuator.judge_magnetic3d", 20,
    ),
    "map": PartRow(
        "the co-energy map against the network itself",
        "coverage_actuator.judge_map", 60,
    ),
    "switching": PartRow(
        "switching currents against balances of a network four times as fine",
        "coverage_actuator.judge_switching", 30,
    ),
    "generator": PartRow(
        "small motions of the machine against those by a network four times as fine",
        "coverage_actuator.judge_motions", 30,
    ),
    "time": PartRow(
        "runs in time against runs in much finer steps",
        "coverage_actuator.judge_in_time", 30,
    ),
}  # fmt: skip
