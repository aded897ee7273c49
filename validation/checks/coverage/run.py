"""The parts of a coverage run, and the run behind ``tactgen coverage``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from tactgen.validation.checks.coverage.result import Judged, Part, judged_once

#: By name how many devices a part has by default, and what it holds against what.
PARTS: dict[str, tuple[int, str]] = {
    "tmm": (60, "the transfer matrix against 80 digits; its bars are of rounding and wide"),
    "beam": (60, "beam elements against exact spans"),
    "taper": (40, "tapers by the transfer matrix against four times as many segments"),
    "solid": (16, "bricks against bricks two levels finer"),
    "cad": (4, "tetrahedra of the CAD solids against much finer bricks"),
    "reduced": (12, "a member of a family by its reduced basis against bricks two levels finer"),
    "axisymmetric": (20, "the magnetic field against a finer grid, higher order and farther walls"),
    "magnetic3d": (20, "the magnetic field on coarse tetrahedra against the half section's"),
    "map": (60, "the co-energy map against the network itself"),
    "switching": (30, "switching currents against balances of a network four times as fine"),
    "generator": (30, "small motions of the machine against those by a network four times as fine"),
    "time": (30, "runs in time against runs in much finer steps"),
}  # fmt: skip


def _judge(name: str) -> Callable[[np.random.Generator], list[Judged]]:
    """Return what judges one random device of a part; only its own models are imported."""
    if name in ("tmm", "beam", "taper"):
        from tactgen.validation.checks.coverage import beam

        return {"tmm": beam.judge_tmm, "beam": beam.judge, "taper": beam.judge_taper}[name]
    if name in ("solid", "cad", "reduced"):
        from tactgen.validation.checks.coverage import beam, solid

        return {"solid": solid.judge, "cad": beam.judge_cad, "reduced": solid.judge_reduced}[name]
    from tactgen.validation.checks.coverage import axisymmetric as machine

    return {
        "axisymmetric": machine.judge, "magnetic3d": machine.judge_magnetic3d,
        "map": machine.judge_map, "switching": machine.judge_switching,
        "generator": machine.judge_motions, "time": machine.judge_in_time,
    }[name]  # fmt: skip


def run_parts(
    names: Sequence[str], devices: int | None, seed: int, announce: Callable[[str], None]
) -> list[Part]:
    """Judge as many random devices for each part; each device has a stream of its own.

    So more devices of a seed are the same ones and others besides.
    """

    def judged(name: str, number: int) -> tuple[Judged, ...]:
        return tuple(_judge(name)(np.random.default_rng([seed, number])))

    found = []
    for name in names:
        usual, what = PARTS[name]
        count = usual if devices is None else devices
        module = _judge(name).__module__
        answers: list[Judged] = []
        for number in range(count):
            announce(f"{name}: device {number + 1} of {count}")
            work = partial(judged, name, number)
            answers += judged_once("coverage", (name, seed, number), module, work)
        found.append(Part(name, what, seed, count, tuple(answers)))
    return found
