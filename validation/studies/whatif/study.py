"""Run of a study: cached answers are recalled, the rest is computed."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS, models_of
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.solve import check_models, make_plan, stage_prospects, total
from tactgen.validation.engine.surrogate import Ranges, Surrogate
from tactgen.validation.scene.files import choices
from tactgen.validation.scene.load import checked_scene
from tactgen.validation.scene.variation import ScenesNearby
from tactgen.validation.scene.warnings import idle
from tactgen.validation.studies.whatif.axes import as_stated, shown_point
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.executor import execute
from tactgen.validation.studies.whatif.interpolation import Part, find_parts
from tactgen.validation.studies.whatif.point_answers import Question, question, reason

#: A point's number with a model's name, and what was asked there: a question's number or a refusal.
_Place = tuple[int, str]
_Asked = int | Answer
#: A sentence, the number of its point, its model.
_Said = tuple[str, int, str]
_COUNTED = ("recalled", "computed", "failed", "refused", "interpolated")
_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")


@dataclass(frozen=True)
class Study:
    """A statement with its answers."""

    statement: Statement
    #: Values of the axes by key, in the order of :meth:`Statement.points`
    points: tuple[dict[str, Any], ...]
    answers: tuple[dict[str, Answer], ...]  #: By model, one for each point
    #: How many answers were recalled, computed, failed, refused and read off surrogates besides
    counts: dict[str, int]

    @property
    def rows(self) -> Iterator[tuple[dict[str, Any], str, Answer]]:
        """Every point with a model and its answer."""
        for point, answers in zip(self.points, self.answers, strict=True):
            for model, found in answers.items():
                yield point, model, found

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the answers, each once with its number of points.

        Sentences that differ in their numbers alone are one: the worst, with its point.
        """
        found: dict[str, list[_Said]] = {}
        for number, answers in enumerate(self.answers):
            for model, each in answers.items():
                failure = [f"{model} has no answer: {each.reason}"] if each.status != "ok" else []
                for text in (*each.warnings, *failure):
                    found.setdefault(_NUMBER.sub("#", text), []).append((text, number, model))
        return tuple(map(self._grouped, found.values()))

    @property
    def without_effect(self) -> Iterator[str]:
        """Sentence on each dimension along which no answer changes at any point."""
        shape = self.statement.shape
        number = np.arange(len(self.points)).reshape(*shape.values())
        for along, name in enumerate(shape):
            first = np.broadcast_to(number.take([0], axis=along), number.shape)
            pairs = zip(number.ravel().tolist(), first.ravel().tolist(), strict=True)
            if shape[name] > 1 and all(_alike(self.answers[i], self.answers[j]) for i, j in pairs):
                of = [key for key, (dim, _) in self.statement.columns.items() if dim == name]
                why = list(filter(None, (self._idle(key) for key in of)))
                yield f"{' and '.join(of)} changed no answer" + (
                    f": {'; '.join(why)}" if why else ""
                )

    def _idle(self, key: str) -> str:
        try:
            return idle(checked_scene(self.statement.scene_at(self.points[0])), key)
        except InputError:
            return ""

    def _grouped(self, said: Sequence[_Said]) -> str:
        """Worst of sentences that differ in their numbers, with how often they are said."""
        points, models = (dict.fromkeys(of) for of in list(zip(*said, strict=True))[1:])
        head = f"at {len(points)} of {len(self.points)} points by {', '.join(models)}"
        if len({text for text, *_ in said}) > 1:
            # the first number of a warning grows with what it warns of
            said = sorted(said, key=lambda each: [float(n) for n in _NUMBER.findall(each[0])])
            head += f", worst by {said[-1][2]} at {shown_point(self.points[said[-1][1]])}"
        return f"{head}: {said[-1][0]}"


def _alike(one: Mapping[str, Answer], other: Mapping[str, Answer]) -> bool:
    """Whether two points have the same answers, all of them values."""
    return all(
        answer.status == other[model].status == "ok"
        and all(
            np.array_equal(q.value, r.value, equal_nan=True)
            for q, r in zip(answer.quantities, other[model].quantities, strict=True)
        )
        for model, answer in one.items()
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

    Who solves, and what `retry` asks again: :func:`validation.studies.whatif.executor.execute`.

    Raises InputError if the axes cannot be used, no point of them makes a scene, or the cluster is
    of no use.
    """
    check_models(statement.models, statement.quantities)
    points = tuple(statement.points())
    solver = StudySolver(statement, processes, scheduler, announce, retry=retry)
    answers = solver.answers(points)
    _refuse_if_no_scene(len(points), [found for each in answers for found in each.values()])
    return Study(statement, points, answers, solver.counts)


class StudySolver:
    """Solver of a study's points by its models.

    `ranges` are those of the keys, if many more points of them will be asked.
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
        self._statement, self._announce, self._ranges = statement, announce, ranges
        self._workers, self._retry = (processes, scheduler), retry
        self._nearby = _scenes_nearby(statement)
        self.questions: dict[int, Question] = {}  #: By number
        self._numbers: dict[str, int] = {}
        self._solved: dict[int, Answer] = {}
        self._surrogates: dict[str, Surrogate | None] = {}
        #: Of answers, as of :class:`Study`
        self.counts = dict.fromkeys(_COUNTED, 0)

    def answers(self, points: Sequence[dict[str, Any]]) -> tuple[dict[str, Answer], ...]:
        """Answers by model at points (values by key), refusals among them."""
        parts, asked = self.ask(points)
        self._solve()
        found: dict[_Place, Answer] = {}
        for part, design in parts:
            found |= self._interpolated(part, design, points)
        left = [(number, part.model) for part, _ in parts for number in part.numbers]
        asked |= self._ask_alone(points, (place for place in left if place not in found))
        self._solve()
        for place, one in asked.items():
            found[place] = one if isinstance(one, Answer) else self._solved[one]
        for status in ("failed", "refused"):
            self.counts[status] += sum(each.status == status for each in found.values())
        models = self._statement.models
        return tuple({m: found[number, m] for m in models} for number in range(len(points)))

    def ask(
        self, points: Sequence[dict[str, Any]]
    ) -> tuple[list[tuple[Part, list[_Asked]]], dict[_Place, _Asked]]:
        """Parts for surrogates with the questions that these are made from, and the others."""
        stated = self._statement
        parts = []
        for model in stated.models:
            nearby = self._nearby[model]
            for part in find_parts(model, stated.quantities, points, nearby, self._ranges):
                design: list[_Asked] = []
                if part.key not in self._surrogates:
                    self._announce(part.reason)
                    try:
                        design = [self._question(at, model) for at in part.design()]
                    except InputError:  # then its points are asked alone
                        continue
                parts.append((part, design))
        covered = {(number, part.model) for part, _ in parts for number in part.numbers}
        every = ((number, m) for number in range(len(points)) for m in stated.models)
        return parts, self._ask_alone(points, (place for place in every if place not in covered))

    def _ask_alone(
        self, points: Sequence[dict[str, Any]], places: Iterable[_Place]
    ) -> dict[_Place, _Asked]:
        found = {}
        for count, (number, model) in enumerate(places):
            if count % 100 == 0:
                self._announce(f"questions checked: {count}")
            found[number, model] = self._question(points[number], model)
        return found

    def _question(self, point: Mapping[str, Any], model: str) -> _Asked:
        """Number of a point's question to a model, or the refusal.

        Of points that differ in nothing that a model reads, one is asked.
        """
        try:
            values = self._nearby[model].values(as_stated(point))
            asked = question(checked_scene(values), model, self._statement.quantities, values)
        except InputError as error:
            return Answer("refused", reason(error))
        number = self._numbers.setdefault(repr((model, asked.inputs)), len(self._numbers))
        self.questions.setdefault(number, asked)
        return number

    def _interpolated(
        self, part: Part, design: Sequence[_Asked], points: Sequence[dict[str, Any]]
    ) -> dict[_Place, Answer]:
        """Answers of a part by point and model; none where no surrogate can be made."""
        if part.key not in self._surrogates:
            given = [self._solved[one] if isinstance(one, int) else one for one in design]
            try:
                self._surrogates[part.key] = part.surrogate(given)
            except InputError as error:
                self._announce(f"{part.model}: one by one, since {error}")
                self._surrogates[part.key] = None
        surrogate = self._surrogates[part.key]
        if surrogate is None:
            return {}
        answers = part.answers(surrogate, points, self._announce)
        self.counts["interpolated"] += sum(each.status == "ok" for each in answers.values())
        return {(number, part.model): answer for number, answer in answers.items()}

    def _solve(self) -> None:
        """Solve all questions that have no answer yet, but those whose answers are kept."""
        new = {n: asked for n, asked in self.questions.items() if n not in self._solved}
        kept = {n: a for n, q in new.items() if (a := q.recall(retry=self._retry))}
        left = {n: asked for n, asked in new.items() if n not in kept}
        self._solved |= kept
        self.counts["recalled"] += len(kept)
        self.counts["computed"] += len(left)
        self._solved.update(execute(left, *self._workers, self._announce, retry=self._retry))


def _scenes_nearby(statement: Statement) -> dict[str, ScenesNearby]:
    """By model the scenes that its points are asked at.

    Beside a model of the bimorph stand those of the normal actuator that the scene names: they
    say whose map pulls at the rod.
    """
    stated = statement.values.get("models")
    named = choices(stated, tuple(MODELS), "model", "models") if stated else ()
    maps = [name for name in models_of("reluctance") if name in named]
    found = {}
    for model in statement.models:
        models = [model, *maps] if MODELS[model].actuator == "bimorph" else [model]
        found[model] = ScenesNearby({**statement.values, "models": models, "quantities": ["all"]})
    return found


def _refuse_if_no_scene(points: int, found: Collection[Answer]) -> None:
    """Refuse a study, with the first reason, if all that its points have found is refusals."""
    if all(each.status == "refused" for each in found):
        said = "the only point makes no scene"
        if points > 1:
            said = f"none of the {points} points makes a scene"
        raise InputError(f"{said}: {next(iter(found)).reason}")


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
    found, refusals = [], list[Answer]()
    for model in statement.models:
        solver = StudySolver(replace(statement, models=(model,)), announce=announce)
        parts, asked = solver.ask(points)
        refused = [given for given in asked.values() if isinstance(given, Answer)]
        refusals += refused
        new = [q for q in solver.questions.values() if q.recall() is None]
        seconds = None
        if new and not MODELS[model].quick:
            plan = make_plan(checked_scene(new[0].values), (model,), new[0].quantities)
            each = total(stage_prospects(plan))
            seconds = each * len(new) if each else None
        found.append(PlannedModel(
            model, len(points), len(refused), len(solver.questions) - len(new), len(new),
            tuple(part.reason for part, _ in parts), seconds,
        ))  # fmt: skip
    if len(refusals) == len(points) * len(statement.models):
        _refuse_if_no_scene(len(points), refusals)
    return tuple(found)
