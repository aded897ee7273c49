"""The parts of a stress run: models driven to their extremes, and commands under faults."""

from __future__ import annotations

from tactgen.validation.evidence.judgement import FAR, PartRow, Rule

#: No more answers may be beyond their bars than these promise (of 20 one, of 40 two; none where all
#: are promised to be within), and none by so many bars.
RULE = Rule(far=FAR)

_SECOND = (
    "each answer agrees with the second model's within the bars of both, 19 of 20 and none by "
    "three bars, or is refused in one sentence"
)
_OWN = (
    "each answer is within its own error bar (with the finer solution's) or, where the exact "
    "answer is known, within the bound that follows from the method; or it is refused in one "
    "sentence"
)
#: By name; only the modules of those that are run are imported.
PARTS: dict[str, PartRow] = {
    "tmm": PartRow(
        "relative error of every entry, of tip velocity, of tip rotation and of charge at most the "
        "rounding unit times the roundings in the functions (4, or half a one per radian of phase) "
        "times the condition number: size of the terms over size of their sum, 1/distance in "
        "radians of phase to the next pole or zero",
        "stress_beam.FAMILIES",
    ),
    "lateral": PartRow(_SECOND, "stress_driven.FAMILIES"),
    "solid": PartRow(_OWN, "stress_solid.FAMILIES"),
    "magnetics": PartRow(_OWN, "stress_magnetics.FAMILIES"),
    "machine": PartRow(
        "responses by the transfer matrix and by beam elements agree within the bars of both, 19 "
        "of 20 and none by three bars; the slow motion per ampere is the derivative of where the "
        "rod rests; runs in time agree with a hundred times finer ones within their own bars, and "
        "keep their energy; where the rod rests nowhere, or a head is tipped over, that is said",
        "stress_machine.FAMILIES",
    ),
    "random": PartRow(
        f"{_SECOND}; one that ended otherwise, or took too long, names the overrides that repeat "
        "it", "stress_driven.judge_random", 2000,
    ),
    "faults": PartRow(
        "a point is one run of a command, spoilt, and the same run again undisturbed: it counts as "
        "wrong if a file was half-written, if the second run's answer is not that of an "
        "undisturbed one, if words are not ours, or if it never ends; what is refused is quoted",
        "faults.FAMILIES",
    ),
}  # fmt: skip
