"""Run of a study: cached answers are recalled, the rest is computed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.solve import check_models, make_plan, stage_prospects, total
from tactgen.validation.engine.surrogate import Ranges, Surrogate
from tactgen.validation.scene.scene import checked_scene
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.executor import Job, execute
from tactgen.validation.studies.whatif.interpolation import Part, find_parts
from tactgen.validation.studies.whatif.point_answers import (
    Questions,
    recall,
    refuse_if_no_scene,
    scenes_nearby,
)

_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")
#: Of sentences that differ in their numbers, the first is told.
_OTHERS = " (other numbers at other points)"


@dataclass(frozen=True)
class Counts:
    """Counts of answers recalled, computed, failed and refused.

    `interpolated` points were read off surrogates besides.
    """

    recalled: int
    computed: int
    failed: int
    refused: int
    interpolated: int = 0


@dataclass(frozen=True)
class Study:
    """A statement with its answers."""

    statement: Statement
    #: Values of the axes by key, in the order of :meth:`Statement.points`
    points: tuple[dict[str, Any], ...]
    answers: tuple[dict[str, Answer], ...]  #: By model, one for each point
    counts: Counts

    @property
    def rows(self) -> Iterator[tuple[dict[str, Any], str, Answer]]:
        """Every point with a model and its answer."""
        for point, answers in zip(self.points, self.answers, strict=True):
            for model, found in answers.items():
                yield point, model, found

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the answers, each once with its number of points.

        Sentences that differ in their numbers alone are one.
        """
        found: dict[str, list[str]] = {}
        unbounded = [a.key for a in self.statement.axes if a.drawn and a.drawn.kind == "normal"]
        for _, model, each in self.rows:
            texts = list(each.warnings)
            if each.status != "ok":
                text = f"{model} has no answer: {each.reason}"
                for key in unbounded:
                    if each.reason.startswith(f"{key} = "):
                        text += f", or draw {key} with a smaller deviation"
                texts.append(text)
            for text in texts:
                found.setdefault(_NUMBER.sub("#", text), []).append(text)
        total = len(self.points)
        return tuple(
            f"at {len(texts)} of {total} points{_OTHERS if len(set(texts)) > 1 else ''}: {texts[0]}"
            for texts in found.values()
        )


def run_study(
    statement: Statement,
    processes: int = 0,
    announce: Callable[[str], None] = lambda _: None,
    *,
    retry: bool = False,
    scheduler: str = "",
) -> Study:
    """Study with every answer, failures among them.

    Parameters
    ----------
    processes, scheduler : int, str
        Who solves what is not kept, as of :func:`validation.studies.whatif.executor.execute`.
    retry : bool
        Whether questions that failed earlier are asked again.

    Raises InputError if the axes cannot be used, no point of them makes a scene, or the cluster is
    of no use.
    """
    points = tuple(statement.points())
    solver = StudySolver(statement, processes, scheduler, announce, retry=retry)
    answers = solver.answers(points)
    refuse_if_no_scene(len(points), [found for each in answers for found in each.values()])
    return Study(statement, points, answers, solver.counts(answers))


class StudySolver:
    """Solver of a study's points by its models.

    Parameters
    ----------
    ranges : dict of str to (float, float), optional
        The range of the keys, if many more points of it will be asked.
    """

    def __init__(
        self,
        statement: Statement,
        processes: int = 0,
        scheduler: str = "",
        announce: Callable[[str], None] = lambda _: None,
        *,
        retry: bool = False,
        ranges: Ranges | None = None,
    ) -> None:
        check_models(statement.models, statement.quantities)
        self._statement, self._announce, self._ranges = statement, announce, ranges
        self._workers, self._retry = (processes, scheduler), retry
        self._nearby = scenes_nearby(statement)
        self._questions = Questions(self._nearby, statement.quantities)
        self._solved: dict[int, Answer] = {}
        self._surrogates: dict[str, Surrogate | None] = {}
        self.recalled = self.computed = self.interpolated = 0

    def counts(self, answers: Sequence[dict[str, Answer]]) -> Counts:
        """Where answers came from."""
        every = [found.status for each in answers for found in each.values()]
        return Counts(
            self.recalled, self.computed, every.count("failed"), every.count("refused"),
            self.interpolated,
        )  # fmt: skip

    def answers(self, points: Sequence[dict[str, Any]]) -> tuple[dict[str, Answer], ...]:
        """Answers by model at points (values by key), refusals among them."""
        models, quantities = self._statement.models, self._statement.quantities
        parts = [
            p
            for m in models
            for p in find_parts(m, quantities, points, self._nearby[m], self._ranges)
        ]
        found: dict[tuple[int, str], Answer] = {}
        covered = {(number, part.model) for part in parts for number in part.numbers}
        designs = [self._design(part) for part in parts]
        self._questions.at.clear()
        self._questions.add_points(
            ((n, point, m) for n, point in enumerate(points) for m in models
             if (n, m) not in covered),
            self._announce,
        )  # fmt: skip
        self._solve()
        for part, design in zip(parts, designs, strict=True):
            found |= self._interpolated(part, design, points)
        left = [(n, points[n], m) for n, m in covered if (n, m) not in found]
        self._questions.add_points(left, self._announce)
        self._solve()
        for place, given in self._questions.at.items():
            found[place] = given if isinstance(given, Answer) else self._solved[given]
        return tuple({m: found[number, m] for m in models} for number in range(len(points)))

    def _design(self, part: Part) -> list[int | Answer]:
        """Questions, or refusals, of the points that a surrogate is made from."""
        if part.key in self._surrogates:
            return []
        self._announce(part.reason)
        try:
            points = part.design(self._nearby[part.model])
        except InputError:
            return []
        return [self._questions.add(point, part.model) for point in points]

    def _interpolated(
        self, part: Part, design: Sequence[int | Answer], points: Sequence[dict[str, Any]]
    ) -> dict[tuple[int, str], Answer]:
        """Answers of a part by point and model; none where no surrogate can be made."""
        nearby = self._nearby[part.model]
        if part.key not in self._surrogates:
            given = [self._solved[one] if isinstance(one, int) else one for one in design]
            try:
                self._surrogates[part.key] = part.surrogate(nearby, given)
            except InputError as error:
                self._announce(f"{part.model}: one by one, since {error}")
                self._surrogates[part.key] = None
        surrogate = self._surrogates[part.key]
        if surrogate is None:
            return {}
        answers = part.answers(surrogate, nearby, points, self._announce)
        self.interpolated += sum(each.status == "ok" for each in answers.values())
        return {(number, part.model): answer for number, answer in answers.items()}

    def _solve(self) -> None:
        """Solve all questions that have no answer yet, but those whose answers are kept."""
        new = {n: q for n, q in self._questions.different.items() if n not in self._solved}
        kept = {n: answer for n, q in new.items() if (answer := recall(q, retry=self._retry))}
        jobs = [Job(n, q, self._questions.values[n]) for n, q in new.items() if n not in kept]
        self._solved |= kept
        self.recalled += len(kept)
        self.computed += len(jobs)
        self._solved.update(execute(jobs, *self._workers, self._announce, retry=self._retry))


@dataclass(frozen=True)
class PlannedModel:
    """Planned work of a model in a study."""

    model: str  #: Its name
    #: Points; of them such as make no scene; solutions that are kept, and those to be made
    points: int
    refused: int
    kept: int
    solved: int
    interpolated: tuple[str, ...]  #: Which points come from surrogates, in words
    #: At most what the solutions take, as their stages did when they last ran here
    seconds: float | None

    @property
    def sentences(self) -> tuple[str, ...]:
        """For the reader."""
        counts = [f"{self.model}: {self.points} point{'s' if self.points > 1 else ''}"]
        counts += [f"{self.refused} refused"] if self.refused else []
        counts += [f"{self.kept} answers kept from before"] if self.kept else []
        if self.solved:
            cost = "cost not recorded yet"
            if MODELS[self.model].quick:
                cost = "a fraction of a second each"
            elif self.seconds is not None:
                cost = f"at most about {self.seconds:.2g} s"
            counts.append(f"{self.solved} to be solved, {cost}")
        return (", ".join(counts), *(f"  {sentence}" for sentence in self.interpolated))


def plan_study(
    statement: Statement, announce: Callable[[str], None] = lambda _: None
) -> tuple[PlannedModel, ...]:
    """Planned work of each model, without computing anything.

    Raises InputError if the axes cannot be used, no point of them makes a scene, or a quantity has
    no model.
    """
    check_models(statement.models, statement.quantities)
    points = tuple(statement.points())
    nearby = scenes_nearby(statement)
    found, refusals, covered = [], list[Answer](), 0
    for model in statement.models:
        questions = Questions(nearby, statement.quantities)
        parts = find_parts(model, statement.quantities, points, nearby[model])
        reasons, interpolated = [], set[int]()
        for part in parts:
            try:
                design = part.design(nearby[model])
            except InputError:  # then they are answered alone
                continue
            for point in design:
                questions.add(point, model)
            reasons.append(part.reason)
            interpolated |= set(part.numbers)
        covered += len(interpolated)
        rest = ((n, p, model) for n, p in enumerate(points) if n not in interpolated)
        questions.add_points(rest, announce)
        refused = [given for given in questions.at.values() if isinstance(given, Answer)]
        refusals += refused
        new = [n for n, q in questions.different.items() if recall(q) is None]
        seconds = None
        if new and not MODELS[model].quick:
            scene = checked_scene(questions.values[new[0]])
            wanted = questions.different[new[0]].quantities
            each = total(stage_prospects(make_plan(scene, (model,), wanted)))
            seconds = each * len(new) if each else None
        found.append(PlannedModel(
            model, len(points), len(refused), len(questions.different) - len(new), len(new),
            tuple(reasons), seconds,
        ))  # fmt: skip
    if not covered and len(refusals) == len(points) * len(statement.models):
        refuse_if_no_scene(len(points), refusals)
    return tuple(found)
