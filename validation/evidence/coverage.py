"""Estimated errors against much better answers, for random devices."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.files import write_text
from tactgen.geometry.store.store import cached_result
from tactgen.geometry.store.values import storable
from tactgen.validation.scene.files import built_in_texts
from tactgen.validation.show.figures import GREY, panels, svg

#: Share of the errors that a bar promises to cover.
PROMISED = 0.95
#: Errors below are those of the reference.
_EPS = float(np.finfo(float).eps)
#: Median of bar over error from which bars say too little to be of use.
WIDE = 5.0
#: Multiples of the bars at which the calibration curve is drawn.
MULTIPLES: Floats = np.geomspace(0.05, 5.0, 41)
#: Chance at most that bars which keep the promise are called too narrow.
_FALSE_ALARM = 0.01

#: What is said of bars: they cover and are tight, they cover by being wide, they do not cover.
Verdict: TypeAlias = Literal["holds", "wide", "fails"]


@storable
@dataclass(frozen=True)
class Judged:
    """An answer held against its reference; both error and bar relative to the reference."""

    where: str  #: The device, for people: what differs from the scene that it was drawn from
    quantity: str  #: What was asked, with the number of a mode
    error: float
    bar: float

    @property
    def within(self) -> bool:
        """Whether the bar covers the error."""
        return self.error <= self.bar


@dataclass(frozen=True)
class Row:
    """All answers of one quantity."""

    quantity: str
    #: How many lie within their bars, and of how many
    inside: int
    count: int
    devices: int  #: Of how many devices these are: of few, the median is a guess
    width: float  #: Median of bar over error
    worst: Judged  #: The answer whose error is largest beside its bar
    #: "fails" if so many outside are unlikely of bars that keep the promise; "wide" if the median
    #: is beyond :data:`WIDE`
    verdict: Verdict

    @property
    def holds(self) -> bool:
        """Whether the bars cover, however wide they are."""
        return self.verdict != "fails"


def rows(found: Sequence[Judged]) -> list[Row]:
    """One row a quantity, numbers of modes together, and last all of them."""
    by_quantity: dict[str, list[Judged]] = {}
    for one in found:
        by_quantity.setdefault(one.quantity.partition(" ")[0], []).append(one)
    made = [_row(name, of) for name, of in by_quantity.items()]
    return [*made, _row("all", list(found))] if len(made) > 1 else made


def _row(quantity: str, found: list[Judged]) -> Row:
    from scipy.stats import binom

    worst = max(found, key=lambda one: one.error / max(one.bar, 1e-300))
    inside, devices = sum(one.within for one in found), len({one.where for one in found})
    width = median_width(found)
    verdict: Verdict = "wide" if width > WIDE else "holds"
    if binom.cdf(inside, len(found), PROMISED) < _FALSE_ALARM:
        verdict = "fails"
    return Row(quantity, inside, len(found), devices, width, worst, verdict)


def median_width(found: Sequence[Judged]) -> float:
    """Median of bar over error."""
    return float(np.median([one.bar / max(one.error, _EPS) for one in found]))


def calibration(found: Sequence[Judged]) -> Floats:
    """Share of errors within each of :data:`MULTIPLES` times the bar."""
    ratios = np.array([one.error / max(one.bar, 1e-300) for one in found])
    return np.asarray((ratios[:, None] <= MULTIPLES).mean(axis=0))


def relative(where: str, name: str, values: object, errors: object, better: object) -> list[Judged]:
    """Entries of a quantity held against better ones; errors relative to these."""
    value, bars, right = (np.ravel(np.asarray(of)) for of in (values, errors, better))
    size = np.abs(right)
    return [
        Judged(where, f"{name} {i + 1}" if value.size > 1 else name, float(off), float(bar))
        for i, (off, bar) in enumerate(zip(np.abs(value - right) / size, bars / size, strict=True))
    ]


#: What computes answers and is loaded by names in strings.
_CODE = ("tactgen.validation.models", "tactgen.fem", "tactgen.tmm")


@dataclass(frozen=True)
class Part:
    """Coverage of one model's errors: sampled devices and results."""

    #: The part, and what it holds against what
    name: str
    what: str
    #: How to draw the same devices again, and how many
    seed: int
    devices: int
    answers: tuple[Judged, ...]

    @property
    def rows(self) -> list[Row]:
        """One row a quantity, the last of all of them."""
        return rows(self.answers)

    @property
    def holds(self) -> bool:
        """Whether every row does."""
        return all(row.holds for row in self.rows)


def cached_by_code(kind: str, of: tuple[object, ...], module: str, work: Callable[[], Any]) -> Any:
    """Result of `work`, so that a run that was stopped goes on where it was.

    Cached as of a kind by what is judged, with its seed, by the code of the `module` that judges,
    and by the built-in scenes: all is made of them.
    """
    return cached_result(kind, (*of, built_in_texts()), (module, *_CODE), work)


def loaded(name: str) -> Callable[..., Any]:
    """Function of this room, as module.function; its module is imported only now."""
    module, _, function = name.partition(".")
    found: Callable[..., Any] = getattr(
        importlib.import_module(f"{__package__}.{module}"), function
    )
    return found


def table(parts: Sequence[Part]) -> str:
    """Parts as lines of text."""
    lines = []
    for part in parts:
        lines.append(f"{part.name}: {part.what}; {part.devices} devices, seed {part.seed}")
        lines.append(f"  {'quantity':28} {'devices':>7} {'inside':>12} {'bar/error':>10}  verdict")
        for row in part.rows:
            share = f"{row.inside}/{row.count}"
            lines.append(
                f"  {row.quantity:28} {row.devices:>7} {share:>12} {row.width:>10.2g}"
                f"  {row.verdict}"
            )
            if not row.holds:
                worst = row.worst
                lines.append(f"    worst: {worst.error:.1e} beside a bar of {worst.bar:.1e}")
                lines.append(f"    at {worst.where}")
    if any(row.verdict == "wide" for part in parts for row in part.rows):
        lines.append(f"wide: bars that cover, but of a median bar/error beyond {WIDE:g}")
    return "\n".join(lines)


def write(parts: Sequence[Part], out: Path) -> list[Path]:
    """Write verdicts and all answers as CSV, the calibration curves as SVG; return the files."""
    verdicts = [
        (part.name, part.seed, r.quantity, r.devices, r.inside, r.count, r.width, r.verdict)
        for part in parts for r in part.rows
    ]  # fmt: skip
    answers = [
        (part.name, part.seed, one.where, one.quantity, float(one.error), float(one.bar))
        for part in parts for one in part.answers
    ]  # fmt: skip
    curves = {part.name: calibration(part.answers) for part in parts}
    return [
        write_csv(out / "verdicts.csv", ("part", "seed", "quantity", "devices", "inside",
                  "answers", "median bar/error", "verdict"), verdicts),
        write_csv(out / "coverage.csv", ("part", "seed", "device", "quantity", "relative error",
                  "relative bar"), answers),
        write_text(out / "calibration.svg", shares_plot(curves, MULTIPLES, "bar", fontsize=9)),
    ]  # fmt: skip


def shares_plot(
    curves: Mapping[str, object], multiples: Sequence[float] | Floats, of: str, **legend: Any
) -> str:
    """Share of errors within so many times what was stated, a curve for each name."""
    figure, axis = panels(6.4, 4.0)
    for name, shares in curves.items():
        axis.semilogx(multiples, 100.0 * np.asarray(shares), label=name)
    axis.axhline(100.0 * PROMISED, color=GREY, linestyle="--", linewidth=1.0)
    axis.axvline(1.0, color=GREY, linestyle="--", linewidth=1.0)
    axis.set_xlabel(f"multiple of the {of}")
    axis.set_ylabel("errors within it (%)")
    axis.legend(**legend)
    return svg(figure)


class PartRow(NamedTuple):
    """Part of a coverage run."""

    devices: int
    what: str  #: The models compared
    judge: str  #: Module and function that judge one device


#: The parts of a run by name; only the modules of those that are run are imported.
PARTS: dict[str, PartRow] = {
    "tmm": PartRow(60, "the transfer matrix against 80 digits; its bars are of rounding and wide",
                   "coverage_bimorph.judge_tmm"),
    "beam": PartRow(60, "beam elements against exact spans", "coverage_bimorph.judge_beam"),
    "taper": PartRow(40, "tapers by the transfer matrix against four times as many segments",
                     "coverage_bimorph.judge_taper"),
    "solid": PartRow(16, "bricks against bricks two levels finer", "coverage_bimorph.judge_solid"),
    "cad": PartRow(4, "tetrahedra of the CAD solids against much finer bricks",
                   "coverage_bimorph.judge_cad"),
    "surrogate": PartRow(12, "a fresh length by a surrogate against bricks two levels finer",
                       "coverage_bimorph.judge_surrogate"),
    "calibrated": PartRow(40, "modelling errors of the transfer matrix against bricks",
                          "coverage_bimorph.judge_calibrated"),
    "harvester": PartRow(16, "modelling errors of a harvester's peaks against bricks",
                         "coverage_bimorph.judge_harvester"),
    "network": PartRow(60, "modelling errors of the network against the magnetic field",
                       "coverage_actuator.judge_network"),
    "axisymmetric": PartRow(20, "the magnetic field against a finer grid, higher order and farther "
                            "walls", "coverage_actuator.judge_axisymmetric"),
    "magnetic3d": PartRow(20, "the magnetic field on coarse tetrahedra against the half section's",
                          "coverage_actuator.judge_magnetic3d"),
    "map": PartRow(60, "the co-energy map against the network itself",
                   "coverage_actuator.judge_map"),
    "switching": PartRow(30, "switching currents against balances of a network four times as fine",
                         "coverage_actuator.judge_switching"),
    "generator": PartRow(30, "small motions of the machine against those by a network four times "
                         "as fine", "coverage_actuator.judge_motions"),
    "time": PartRow(30, "runs in time against runs in much finer steps",
                    "coverage_actuator.judge_in_time"),
}  # fmt: skip


def run_parts(
    names: Sequence[str], devices: int | None, seed: int, announce: Callable[[str], None]
) -> list[Part]:
    """Judge as many random devices for each part; each device has a stream of its own.

    So more devices of a seed are the same ones and others besides.
    """
    parts = []
    for name in names:
        row = PARTS[name]
        judge = loaded(row.judge)
        count = row.devices if devices is None else devices
        answers: list[Judged] = []
        for number in range(count):
            announce(f"{name}: device {number + 1} of {count}")
            rng = np.random.default_rng([seed, number])
            answers += cached_by_code(
                "coverage",
                (name, seed, number),
                judge.__module__,
                lambda: tuple(judge(rng)),  # noqa: B023
            )
        parts.append(Part(name, row.what, seed, count, tuple(answers)))
    return parts
