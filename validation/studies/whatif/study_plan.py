"""The plan of a study: which points are kept, come from a reduced basis, or are solved alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.families import (
    Box,
    family_prospect,
    family_ranges,
    find_families,
)
from tactgen.validation.engine.plan import check_models, make_plan
from tactgen.validation.engine.prospects import Prospect, stage_prospects, total
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.whatif.answers import Question, recall, refuse_if_no_scene
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.by_walk import routes
from tactgen.validation.studies.whatif.questions import questions, scenes_nearby
from tactgen.validation.studies.whatif.sweep import parts


@dataclass(frozen=True)
class PlannedBasis:
    """A reduced basis that points would be read off: why, how many, and what it costs.

    `kept` says whether it is built already; `seconds` what one over as many keys took here.
    """

    reason: str
    points: int
    kept: bool
    seconds: float | None

    @property
    def sentence(self) -> str:
        """For the reader."""
        if self.kept:
            cost = "which is kept"
        elif self.seconds is None:
            cost = "which is not built yet; what it costs is not recorded yet"
        else:
            cost = f"which is not built yet: about {self.seconds:.2g} s, once"
        return f"{self.reason}, {cost}"


@dataclass(frozen=True)
class PlannedWalk:
    """Points solved each from those before: how many, what a point and what they share cost.

    Attributes
    ----------
    reason : str
        Which points.
    points : int
        How many.
    seconds : float or None
        What a point took where the like was last walked through here.
    shared : str
        What all of them share and compute once, in words; empty if there is nothing.
    kept : bool
        Whether that is there.
    shared_seconds : float or None
        What it took when the like was last computed here.
    """

    reason: str
    points: int
    seconds: float | None
    shared: str
    kept: bool
    shared_seconds: float | None

    @property
    def sentences(self) -> tuple[str, ...]:
        """For the reader."""
        each = "their cost is not recorded yet"
        if self.seconds is not None:
            each = f"about {self.seconds:.2g} s each"
        first = f"{self.reason}: {each}"
        if not self.shared:
            return (first,)
        cost = "it is kept"
        if not self.kept:
            cost = "its cost is not recorded yet"
            if self.shared_seconds is not None:
                cost = f"about {self.shared_seconds:.2g} s, once"
        return first, f"  they share {self.shared}: {cost}"


@dataclass(frozen=True)
class PlannedModel:
    """What a model would do in a study.

    Attributes
    ----------
    model : str
        Its name.
    points, refused, kept, alone : int
        Points; of them such as make no scene, answers that are kept, and answers solved alone.
    bases : tuple of PlannedBasis
        Where the others come from.
    walks : tuple of PlannedWalk
        What is solved each from those before.
    seconds : float or None
        At most what those solved alone take, as their stages did when they last ran here.
    """

    model: str
    points: int
    refused: int
    kept: int
    alone: int
    bases: tuple[PlannedBasis, ...]
    walks: tuple[PlannedWalk, ...]
    seconds: float | None

    @property
    def sentences(self) -> tuple[str, ...]:
        """For the reader."""
        counts = [f"{self.model}: {self.points} point{'s' if self.points > 1 else ''}"]
        counts += [f"{self.refused} refused"] if self.refused else []
        counts += [f"{self.kept} answers kept from before"] if self.kept else []
        if self.alone:
            cost = "cost not recorded yet"
            if MODELS[self.model].quick:
                cost = "a fraction of a second each"
            elif self.seconds is not None:
                cost = f"at most about {self.seconds:.2g} s"
            counts.append(f"{self.alone} solved one by one, {cost}")
        walks = (f"  {sentence}" for walk in self.walks for sentence in walk.sentences)
        return (", ".join(counts), *(f"  {basis.sentence}" for basis in self.bases), *walks)


def plan_study(
    statement: Statement, announce: Callable[[str], None] = lambda _: None
) -> tuple[PlannedModel, ...]:
    """Return what each model of a study would do, without computing anything.

    Raises
    ------
    InputError
        If the axes cannot be used, no point of them makes a scene, or a quantity has no model.
    """
    check_models(statement.models, statement.quantities)
    points = tuple(statement.points())
    nearby = scenes_nearby(statement)
    in_blocks: dict[str, list[PlannedBasis]] = {model: [] for model in statement.models}
    covered: set[tuple[int, str]] = set()
    for model in statement.models:
        for part in parts(model, statement.quantities, points, nearby[model]):
            try:
                basis = _basis(part.reason, len(part.numbers), model, part.scene, part.ranges(),
                               part.quantities)  # fmt: skip
            except InputError:  # then they are answered alone
                continue
            in_blocks[model].append(basis)
            covered |= {(number, model) for number in part.numbers}
    asked = questions(statement, points, nearby, covered, announce)
    refusals = [given for given in asked.at.values() if isinstance(given, Answer)]
    if len(refusals) == len(points) * len(statement.models):
        refuse_if_no_scene(len(points), refusals)
    found = []
    for model in statement.models:
        own = {n: q for n, q in asked.different.items() if q.model == model}
        kept = {n for n, q in own.items() if recall(q) is not None}
        new = [n for n in own if n not in kept]
        bases, together = _families(own, new, asked.scenes)
        walks, walked = _walks({n: (own[n], asked.scenes[n]) for n in new
                                if n in asked.scenes and n not in together})  # fmt: skip
        alone = [n for n in new if n not in together and n not in walked]
        refused = sum(
            isinstance(given, Answer) for (_, name), given in asked.at.items() if name == model
        )
        seconds = None
        if alone and not MODELS[model].quick:
            scene = nearby[model].scene(asked.first[alone[0]])
            wanted = own[alone[0]].quantities
            each = total(stage_prospects(make_plan(scene, (model,), wanted)))
            seconds = each * len(alone) if each else None
        found.append(PlannedModel(
            model, len(points), refused, len(kept), len(alone), (*in_blocks[model], *bases),
            tuple(walks), seconds,
        ))  # fmt: skip
    return tuple(found)


def _families(
    own: dict[int, Question], new: Sequence[int], scenes: dict[int, Scene]
) -> tuple[list[PlannedBasis], set[int]]:
    """Return the bases that new questions would be answered by, and these questions."""
    chosen = [n for n in new if n in scenes]
    if not chosen:
        return [], set()
    model, quantities = own[chosen[0]].model, own[chosen[0]].quantities
    bases, together = [], set()
    members = [scenes[n] for n in chosen]
    for family in find_families(model, members, quantities):
        try:
            bases.append(_basis(
                family.reason, len(family.numbers), model, members[family.numbers[0]],
                family_ranges(family, members), quantities,
            ))  # fmt: skip
        except InputError:
            continue
        together |= {chosen[number] for number in family.numbers}
    return bases, together


def _walks(asked: dict[int, tuple[Question, Scene]]) -> tuple[list[PlannedWalk], set[int]]:
    """Return the walks that questions would be answered by, and these questions."""
    walks, walked = [], set()
    for numbers, route in routes(asked):
        quantities = asked[numbers[0]][0].quantities
        shared, prospect = route.shares(quantities) or ("", Prospect(kept=True, seconds=None))
        walks.append(PlannedWalk(
            route.reason, len(route.numbers), route.seconds(quantities), shared, prospect.kept,
            prospect.seconds,
        ))  # fmt: skip
        walked |= {numbers[n] for n in route.numbers}
    return walks, walked


def _basis(
    reason: str, points: int, model: str, scene: Scene, ranges: Box, quantities: Sequence[str]
) -> PlannedBasis:
    prospect: Prospect = family_prospect(model, scene, ranges, quantities)
    return PlannedBasis(reason, points, prospect.kept, prospect.seconds)
