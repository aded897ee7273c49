"""Answers held against better ones and what was promised: rows, verdicts, table, files, runs.

Coverage and stress runs are of this form: each has a table of parts and a rule by which rows of
answers are judged.
"""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.geometry.arrays import Floats
from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.geometry.store.store import cached_result
from tactgen.geometry.store.values import storable
from tactgen.validation.evidence.verification import ENGINE
from tactgen.validation.scene.files import built_in_texts
from tactgen.validation.show.figures import GREY, panels, svg

#: Share of the errors that an error bar promises to cover.
PROMISED = 0.95
#: Bars that hold for a share of answers are missed by the rest, but by none so many times.
FAR = 3.0
#: Errors below are those of the reference.
_EPS = float(np.finfo(float).eps)
#: Multiples of the bars at which the calibration curve is drawn.
MULTIPLES: Floats = np.geomspace(0.05, 5.0, 41)

#: What is said of a row: all is as promised, or so but for refusals, or the bars are wide; or not.
Verdict: TypeAlias = Literal["holds", "holds or says why not", "wide", "fails"]


@storable
@dataclass(frozen=True)
class Judged:
    """An answer held against a better one, or a refusal."""

    where: str  #: The device or parameters, for people
    quantity: str  #: The row that it belongs to: what was asked, or a family with its range
    #: Error, and what it may be; both relative to the better answer
    error: float
    bar: float
    which: str = ""  #: Which value of those of the row: the number of a mode, or a quantity
    promised: float = PROMISED  #: Share of such answers that is promised to be within the bar
    refusal: str = ""  #: What was said instead of an answer

    @property
    def within(self) -> bool:
        """Whether the bar covers the error."""
        return self.error <= self.bar

    @property
    def share(self) -> float:
        """Error over bar; an error without a bar, or that is no number, is beyond."""
        if self.error == 0.0:
            return 0.0
        known = self.bar > 0.0 and not math.isnan(self.error)
        return self.error / self.bar if known else math.inf


def relative(where: str, name: str, values: object, errors: object, better: object) -> list[Judged]:
    """Entries of a quantity held against better ones.

    Errors are relative to these; where they are 0, to the largest.
    """
    value, bars, right = (np.ravel(np.asarray(of)) for of in (values, errors, better))
    size = np.abs(right)
    size = np.where(size > 0.0, size, max(size.max(initial=0.0), np.finfo(float).tiny))
    return [
        Judged(where, name, float(off), float(bar), f"{i + 1}" if value.size > 1 else "")
        for i, (off, bar) in enumerate(zip(np.abs(value - right) / size, bars / size, strict=True))
    ]


#: What a model may say instead of a number.
REFUSALS = (InputError, SolverError, ArithmeticError)


class Family:
    """Answers of one family of points, collected as they come.

    Seed and announcement are for what draws by itself and takes long.
    """

    def __init__(
        self, title: str, seed: int = 0, announce: Callable[[str], None] = lambda _: None
    ) -> None:
        self.title, self.seed, self.announce = title, seed, announce
        self.answers: list[Judged] = []

    def add(
        self, where: str, error: float, bar: float, *,
        of: str = "", which: str = "", refusal: str = "",
    ) -> None:  # fmt: skip
        """Add an answer with its relative error and bar, to the family's row `of` something."""
        row = f"{of}; {self.title}" if of else self.title
        self.answers.append(Judged(where, row, float(error), float(bar), which, 1.0, refusal))

    def compare(self, where: str, value: float, exact: float, bar: float, *, of: str = "") -> None:
        """Add an answer with its error bar, `bar` and values in one unit."""
        size = abs(exact)
        self.add(where, abs(value - exact) / size, bar / size, of=of)

    def take(self, answers: Sequence[Judged]) -> None:
        """Add answers of any quantities as entries of the family's row."""
        for one in answers:
            which = f"{one.quantity} {one.which}".strip()
            self.answers.append(replace(one, quantity=self.title, which=which))

    def refuse(self, words: str, *, of: str = "") -> None:
        """Add a refusal; one that is not one sentence counts as a wrong answer."""
        if words.strip() and "\n" not in words:
            self.add("", math.nan, math.nan, of=of, refusal=words)
        else:
            self.add(f"refused without a sentence: {words!r}", math.inf, 0.0, of=of)

    @contextmanager
    def attempt(self, *, of: str = "") -> Iterator[None]:
        """Context that adds a refusal in place of its answers."""
        try:
            yield
        except REFUSALS as error:
            self.refuse(str(error), of=of)


class Rule(NamedTuple):
    """How rows are judged."""

    #: A row fails if as many beyond are less likely than this, by the share promised; by default if
    #: they are more than that share leaves
    chance: float | None = None
    far: float = math.inf  #: No error may be more times its bar
    wide: float = math.inf  #: Median of bar over error from which bars say too little


@dataclass(frozen=True)
class Row:
    """All answers of one quantity, or of one family."""

    quantity: str
    places: int  #: At how many devices or parameters these are: of few, the median is a guess
    #: How many lie within their bars, of how many; and how many were refused beside
    inside: int
    count: int
    refused: int
    width: float  #: Median of bar over error
    largest: float  #: Largest error
    worst: Judged  #: The answer whose error is largest beside its bar
    #: "fails" if so many outside are unlikely of what was promised, or one is far off; "wide" if
    #: the median is beyond what the rule allows
    verdict: Verdict

    @property
    def holds(self) -> bool:
        """Whether the bars cover, however wide they are."""
        return self.verdict != "fails"


def rows(found: Sequence[Judged], rule: Rule, *, total: bool = False) -> list[Row]:
    """One row a quantity, and with a `total` last all of them if there are several."""
    by_quantity: dict[str, list[Judged]] = {}
    for one in found:
        by_quantity.setdefault(one.quantity, []).append(one)
    made = [_row(name, of, rule) for name, of in by_quantity.items()]
    return [*made, _row("all", found, rule)] if total and len(made) > 1 else made


def _row(quantity: str, of: Sequence[Judged], rule: Rule) -> Row:
    from scipy.stats import binom

    found = [one for one in of if not one.refusal]
    inside, places = sum(one.within for one in found), len({one.where for one in found})
    refused, width = len(of) - len(found), median_width(found)
    worst = max(found, key=lambda one: one.share, default=of[0])
    verdict: Verdict = "wide" if width > rule.wide else "holds"
    if refused:
        verdict = "holds or says why not"
    promised = max((one.promised for one in found), default=1.0)
    missed = len(found) - inside > (1.0 - promised) * len(found)
    if rule.chance is not None:
        missed = bool(found) and binom.cdf(inside, len(found), promised) < rule.chance
    if missed or (found and worst.share > rule.far):
        verdict = "fails"
    largest = max((one.error for one in found), default=math.nan)
    return Row(quantity, places, inside, len(found), refused, width, largest, worst, verdict)


def median_width(found: Sequence[Judged]) -> float:
    """Median of bar over error; nan of none."""
    return float(np.median([one.bar / max(one.error, _EPS) for one in found])) if found else np.nan


def calibration(found: Sequence[Judged]) -> Floats:
    """Share of errors within each of :data:`MULTIPLES` times the bar."""
    shares = np.array([one.share for one in found if not one.refusal])
    return np.asarray((shares[:, None] <= MULTIPLES).mean(axis=0))


class PartRow(NamedTuple):
    """Part of a run."""

    what: str  #: What is held against what
    #: Module and function that judges one device, given a generator; or, of a part without
    #: devices, module and name of the families by title, each a function that adds its answers
    judge: str
    devices: int = 0


@dataclass(frozen=True)
class Part:
    """All that one part found; its seed draws the same again."""

    name: str
    what: str
    seed: int
    rows: tuple[Row, ...]
    answers: tuple[Judged, ...]

    @property
    def holds(self) -> bool:
        """Whether every row does."""
        return all(row.holds for row in self.rows)


def cached_by_code(kind: str, of: tuple[object, ...], module: str, work: Callable[[], Any]) -> Any:
    """Result of `work`, so that a run that was stopped goes on where it was.

    Cached as of a kind by what is judged, with its seed, by the code of the `module` that judges,
    and by the built-in scenes: all is made of them.
    """
    return cached_result(kind, (*of, built_in_texts()), (module, *ENGINE), work)


def loaded(name: str) -> Any:
    """Object of this room, as module.name; its module is imported only now."""
    module, _, of = name.partition(".")
    return getattr(importlib.import_module(f"{__package__}.{module}"), of)


#: Devices of a quick run.
_QUICK = 16


def run_parts(
    command: str, names: Sequence[str], seed: int, announce: Callable[[str], None], *,
    devices: int | None = None, quick: bool = False,
) -> list[Part]:  # fmt: skip
    """Run parts of the command `coverage` or `stress`.

    Each device and each family is kept in the store: a run that was stopped goes on with its seed
    where it was.  `devices` is how many are drawn instead of the part's own number.
    """
    parts, rule, found = loaded(f"{command}.PARTS"), loaded(f"{command}.RULE"), []
    for name in names:
        part: PartRow = parts[name]
        module = f"{__package__}.{part.judge.partition('.')[0]}"
        count = devices or (min(part.devices, _QUICK) if quick else part.devices)
        units = (
            _drawn(part, count, seed) if part.devices else _families(part, quick, seed, announce)
        )
        answers: list[Judged] = []
        for words, key, work in units:
            announce(f"{name}: {words}")
            answers += cached_by_code(command, (name, *key, seed), module, work)
        made = rows(answers, rule, total=part.devices > 0)
        found.append(Part(name, part.what, seed, tuple(made), tuple(answers)))
    return found


#: Of what is judged and stored at once: what is announced, what it is stored by, what judges it.
Unit: TypeAlias = tuple[str, tuple[object, ...], Callable[[], list[Judged]]]


def _drawn(part: PartRow, count: int, seed: int) -> Iterator[Unit]:
    """Each device has a stream of its own: more of a seed are the same ones and others besides."""
    judge = loaded(part.judge)
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        yield f"device {number + 1} of {count}", (number,), partial(judge, rng)


def _families(
    part: PartRow, quick: bool, seed: int, announce: Callable[[str], None]
) -> Iterator[Unit]:
    def judged(title: str, judge: Callable[[Family, bool], None]) -> list[Judged]:
        family = Family(title, seed, announce)
        judge(family, quick)
        return family.answers

    for title, judge in loaded(part.judge).items():
        yield title.partition(":")[0], (title, quick), partial(judged, title, judge)


#: Answers beyond their bars that are printed of a row that fails; files have all.
_MOST = 10
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


def table(parts: Sequence[Part], rule: Rule) -> str:
    """Parts as lines of text."""
    lines = []
    for part in parts:
        lines.append(f"{part.name}: {part.what}; seed {part.seed}")
        lines.append(
            f"  {'places':>7} {'inside':>12} {'refused':>7} {'bar/error':>9} {'largest':>8} "
            f"{'worst/bar':>9}  {'verdict':21}  of"
        )
        for row in part.rows:
            share = f"{row.inside}/{row.count}"
            lines.append(
                f"  {row.places:>7} {share:>12} {row.refused:>7} {row.width:>9.2g} "
                f"{row.largest:>8.1e} {row.worst.share:>9.2g}  {row.verdict:21}  {row.quantity}"
            )
            if not row.holds:
                all_of = [a for a in part.answers if row.quantity in ("all", a.quantity)]
                beyond = [a for a in all_of if not a.refusal and not a.within]
                lines += [
                    f"    {one.share:.2g} times its bar of {one.bar:.1e} at {one.where} {one.which}"
                    for one in sorted(beyond, key=lambda one: -one.share)[:_MOST]
                ]
        for said in _kinds(part.answers):
            such_as = ", such as" if len(set(said)) > 1 else ""
            lines.append(f"  refused {len(said)} x{such_as}: {said[0]}")
    if any(row.verdict == "wide" for part in parts for row in part.rows):
        lines.append(f"wide: bars that cover, but of a median bar/error beyond {rule.wide:g}")
    return "\n".join(lines)


def _kinds(answers: Sequence[Judged]) -> list[list[str]]:
    """Refusals together that differ in their numbers alone, in the order of the first."""
    found: dict[str, list[str]] = {}
    for words in (one.refusal for one in answers if one.refusal):
        found.setdefault(_NUMBER.sub("", words), []).append(words)
    return list(found.values())


def write(command: str, parts: Sequence[Part], out: Path) -> list[Path]:
    """Write verdicts and all answers as CSV, the calibration curves as SVG; return the files."""
    verdicts = [
        (part.name, part.seed, r.quantity, r.places, r.inside, r.count, r.refused, r.width,
         r.largest, r.worst.error, r.worst.bar, r.worst.where, r.verdict)
        for part in parts for r in part.rows
    ]  # fmt: skip
    answers = [
        (part.name, part.seed, one.where, one.quantity, one.which, one.error, one.bar, one.refusal)
        for part in parts for one in part.answers
    ]  # fmt: skip
    judged = [part for part in parts if any(not one.refusal for one in part.answers)]
    curves = {part.name: calibration(part.answers) for part in judged}
    plot = shares_plot(curves, MULTIPLES, "bar", fontsize=9)
    return [
        write_csv(out / f"{command}-verdicts.csv", (
            "part", "seed", "quantity", "places", "inside", "answers", "refused",
            "median bar/error", "largest error", "worst error", "its bar", "worst at", "verdict",
        ), verdicts),
        write_csv(out / f"{command}-answers.csv", (
            "part", "seed", "where", "quantity", "which", "relative error", "relative bar",
            "refusal",
        ), answers),
        write_text(out / f"{command}-calibration.svg", plot),
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
